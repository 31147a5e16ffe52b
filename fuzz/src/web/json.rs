//! JSON: pieces of any size make no difference, and what is taken can be written and is taken again.

use http::Made;
use http::json::{Error, Next, Parser, Parts, Token, Writer};

use super::cut;

/// Pieces that inputs are made of.
pub const PIECES: &[&[u8]] = &[
    b"{\"jsonrpc\":\"2.0\",\"method\":\"server.info\",\"params\":{\"a\":[1,-2.5e3,true,false,null]},\"id\":0}",
    b"{",
    b"}",
    b"[",
    b"]",
    b",",
    b":",
    b"\"a\":",
    b"\"text\"",
    b"\"\\u00e9\\ud834\\udd1e\\n\\/\"",
    b"\"\xE2\x82\xAC\"",
    b"\"",
    b"\\u",
    b"\\ud834",
    b"\\",
    b"true",
    b"false",
    b"null",
    b"0",
    b"-",
    b"1.5",
    b"e+3",
    b"1e-400",
    b"12345678901234567890123",
    b" \t\r\n",
    b"[[[[[[[[[[[[[[[",
    b"]]]]]]]]]]]]]]]",
    b"\xC3",
];

/// Token that owns its text.
#[derive(Clone, Debug, PartialEq)]
enum Read {
    BeginObject,
    EndObject,
    BeginArray,
    EndArray,
    Key(String),
    Text(String),
    /// Whole number, and the nearest one.
    Number(Option<i64>, f64),
    Bool(bool),
    Null,
}

/// Reads the bytes whole and in pieces, and what can be read once more from what is written of it.
///
/// # Panics
/// When a condition of this module does not hold.
pub fn run(bytes: &[u8]) {
    let whole = read(&[bytes]);
    for seed in 1..4 {
        assert_eq!(read(&cut(bytes, seed)), whole, "in pieces of {seed}");
    }
    let Ok(tokens) = whole else { return };
    assert!(std::str::from_utf8(bytes).is_ok(), "text that is none is taken");
    let text = write(&tokens, 48);
    assert_eq!(write(&tokens, 1_000), text, "in other rooms");
    let again = read(&[text.as_slice()]).expect("what was written is read");
    assert_eq!(again.len(), tokens.len());
    for (again, token) in again.iter().zip(&tokens) {
        match (again, token) {
            // Fractions are written with nine decimals at the most.
            (Read::Number(..) | Read::Null, Read::Number(None, _)) => {}
            _ => assert_eq!(again, token),
        }
    }
}

fn read(pieces: &[&[u8]]) -> Result<Vec<Read>, Error> {
    let mut parser = Parser::new();
    let mut all = Vec::new();
    let mut open = String::new();
    for mut piece in pieces.iter().copied() {
        while let Some(token) = parser.next(&mut piece)? {
            all.push(match token {
                Token::BeginObject => Read::BeginObject,
                Token::EndObject => Read::EndObject,
                Token::BeginArray => Read::BeginArray,
                Token::EndArray => Read::EndArray,
                Token::Key(key) => Read::Key(key.to_owned()),
                Token::Text(text, is_last) => {
                    open.push_str(text);
                    if !is_last {
                        continue;
                    }
                    Read::Text(std::mem::take(&mut open))
                }
                Token::Number(number) => {
                    assert!(number.as_f64().is_finite(), "{number:?}");
                    Read::Number(number.as_i64(), number.as_f64())
                }
                Token::Bool(value) => Read::Bool(value),
                Token::Null => Read::Null,
            });
        }
        assert!(piece.is_empty(), "bytes are left");
    }
    let last = parser.finish()?;
    all.extend(last.map(|number| Read::Number(number.as_i64(), number.as_f64())));
    Ok(all)
}

fn write(tokens: &[Read], size: usize) -> Vec<u8> {
    let mut parts = Parts::new();
    let mut text = Vec::new();
    loop {
        let mut room = vec![0; size];
        let made = parts.make(&mut room, |part, json| {
            write_token(&tokens[part as usize], json);
            if part as usize + 1 == tokens.len() { Next::End } else { Next::Part }
        });
        let (Made::Part(count) | Made::Last(count)) = made else { panic!("nothing has changed") };
        text.extend_from_slice(&room[..count]);
        if matches!(made, Made::Last(_)) {
            return text;
        }
        assert!(count > 0, "no way on");
    }
}

fn write_token(token: &Read, json: &mut Writer<'_, '_>) {
    match token {
        Read::BeginObject => json.begin_object(),
        Read::EndObject => json.end_object(),
        Read::BeginArray => json.begin_array(),
        Read::EndArray => json.end_array(),
        Read::Key(key) => json.key(key),
        Read::Text(text) => json.text(text),
        Read::Number(Some(number), _) => json.signed(*number),
        Read::Number(None, number) => json.float(*number, 9),
        Read::Bool(value) => json.bool(*value),
        Read::Null => json.null(),
    }
}

//! Parser and writer against each other, and against `serde_json`.

use proptest::prelude::*;

use super::{Error, Next, Number, Parser, Parts, Token, Writer};
use crate::Made;
use crate::limits::{BODY_ROOM, DEPTH, KEY_BYTES};

/// Token that owns its text.
#[derive(Clone, Debug, PartialEq)]
enum Kept {
    Mark(char),
    Key(String),
    Text(String),
    Number(Number),
    Bool(bool),
    Null,
}

/// Parses a text in pieces of this size.
fn parse(text: &[u8], size: usize) -> Result<Vec<Kept>, Error> {
    let mut parser = Parser::new();
    let mut kept = Vec::new();
    let mut open: Option<String> = None;
    for mut piece in text.chunks(size) {
        while let Some(token) = parser.next(&mut piece)? {
            kept.push(match token {
                Token::BeginObject => Kept::Mark('{'),
                Token::EndObject => Kept::Mark('}'),
                Token::BeginArray => Kept::Mark('['),
                Token::EndArray => Kept::Mark(']'),
                Token::Key(key) => Kept::Key(key.to_owned()),
                Token::Text(text, is_last) => {
                    let whole = open.take().unwrap_or_default() + text;
                    if !is_last {
                        assert!(!text.is_empty() && text.len() <= KEY_BYTES + 4);
                        open = Some(whole);
                        continue;
                    }
                    Kept::Text(whole)
                }
                Token::Number(number) => Kept::Number(number),
                Token::Bool(value) => Kept::Bool(value),
                Token::Null => Kept::Null,
            });
            assert!(parser.depth() <= DEPTH);
        }
        assert!(piece.is_empty());
    }
    kept.extend(parser.finish()?.map(Kept::Number));
    assert!(open.is_none() && parser.depth() == 0);
    Ok(kept)
}

fn text_of(text: &str) -> Result<String, Error> {
    match parse(text.as_bytes(), 3)?.as_slice() {
        [Kept::Text(text)] => Ok(text.clone()),
        other => panic!("{other:?}"),
    }
}

#[test]
fn texts_of_the_rfc_are_taken() {
    // Examples of section 13.
    let text = r#"{ "Image": { "Width": 800, "Title": "View from 15th Floor", "Thumbnail": { "Url":
        "http://www.example.com/image/481989943", "Height": 125 }, "Animated" : false, "IDs": [116, 943, 234, 38793] } }"#;
    let whole = parse(text.as_bytes(), 1_000).unwrap();
    assert_eq!(whole.len(), 25);
    assert_eq!(whole[5], Kept::Key("Title".into()));
    assert_eq!(whole[15], Kept::Bool(false));
    for size in 1..text.len() {
        assert_eq!(parse(text.as_bytes(), size).as_ref(), Ok(&whole), "{size}");
    }
    for (text, count) in
        [(r#""Hello world!""#, 1), ("42", 1), ("true", 1), (" null\r\n\t", 1), ("[]", 2), ("{}", 2), ("[[],{}]", 6)]
    {
        assert_eq!(parse(text.as_bytes(), 1).map(|kept| kept.len()), Ok(count), "{text}");
    }
}

#[test]
fn escapes_are_the_characters_that_they_stand_for() {
    assert_eq!(text_of(r#""\"\\\/\b\f\n\r\t\u0000\u00e9\u20AC\ud834\uDD1Eü""#).unwrap(), "\"\\/\u{8}\u{c}\n\r\t\0é€𝄞ü");
    for text in [
        r#""\ud834""#,
        r#""\ud834x""#,
        r#""\ud834\n""#,
        r#""\ud834\u0041""#,
        r#""\ud834\ud834""#,
        r#""\udd1e""#,
        r#""\u12g4""#,
        r#""\x""#,
        r#""\u123""#,
        "\"\n\"",
        "\"\u{1f}\"",
        "\"a",
        "\"\\",
        "'a'",
    ] {
        assert_eq!(text_of(text), Err(Error::Syntax), "{text}");
    }
    for bytes in [b"\"\xFF\"".as_slice(), b"\"\xC3\"", b"\"\xED\xA0\x80\"", b"\"\xC0\x80\"", b"\"\xC3\\n\""] {
        assert_eq!(parse(bytes, 1), Err(Error::Syntax), "{bytes:x?}");
    }
}

#[test]
fn long_texts_come_in_pieces_between_characters() {
    for start in 0..70 {
        let text = "a".repeat(start) + &"ü€𝄞\\u00e9\\ud834\\udd1e".repeat(30);
        let expected = "a".repeat(start) + &"ü€𝄞é𝄞".repeat(30);
        assert_eq!(text_of(&format!("\"{text}\"")).unwrap(), expected);
    }
}

#[test]
fn what_is_no_json_is_refused() {
    for text in [
        "",
        " ",
        "[",
        "]",
        "{",
        "}",
        "[1",
        "[1,]",
        "[,1]",
        "[1 2]",
        "{1:2}",
        "{\"a\"}",
        "{\"a\":}",
        "{\"a\":1,}",
        "{,}",
        "{\"a\" 1}",
        "[1}",
        "{\"a\":1]",
        "1 2",
        "[] []",
        "nul",
        "nulll",
        "tru e",
        "True",
        "NaN",
        "Infinity",
        "-Infinity",
        "01",
        "1.",
        "-",
        "+1",
        "// a\n1",
        "/**/1",
        "\u{feff}1",
        "\"a\" \"b\"",
        "{\"a\":1 \"b\":2}",
        "[1:2]",
        "{\"a\",1}",
        "\0",
        "a",
        "[-]",
        "[1.e]",
    ] {
        assert_eq!(parse(text.as_bytes(), 1), Err(Error::Syntax), "{text:?}");
    }
}

#[test]
fn limits_hold() {
    let nested = |depth: usize| "[".repeat(depth) + &"]".repeat(depth);
    assert_eq!(parse(nested(DEPTH).as_bytes(), 5).map(|kept| kept.len()), Ok(2 * DEPTH));
    assert_eq!(parse(nested(DEPTH + 1).as_bytes(), 5), Err(Error::Depth));
    assert_eq!(parse("{\"a\":".repeat(DEPTH + 1).as_bytes(), 5), Err(Error::Depth));
    let keyed = |length: usize| format!("{{\"{}\":1}}", "k".repeat(length));
    assert!(parse(keyed(KEY_BYTES).as_bytes(), 7).is_ok());
    assert_eq!(parse(keyed(KEY_BYTES + 1).as_bytes(), 7), Err(Error::Key));
    assert_eq!(parse(keyed(1_000).as_bytes(), 7), Err(Error::Key));
    assert!(parse("1".repeat(40).as_bytes(), 7).is_ok());
    assert_eq!(parse("1".repeat(41).as_bytes(), 7), Err(Error::Number));
    assert_eq!(parse(b"[1e999]", 7), Err(Error::Syntax));
}

#[test]
fn an_error_stays() {
    let mut parser = Parser::new();
    assert_eq!(parser.next(&mut b"]".as_slice()), Err(Error::Syntax));
    assert_eq!(parser.next(&mut b"1".as_slice()), Err(Error::Syntax));
    assert_eq!(parser.finish(), Err(Error::Syntax));
}

/// Makes parts in rooms of this size.
fn made(size: usize, mut write: impl FnMut(u32, &mut Writer<'_, '_>) -> Next) -> String {
    let mut parts = Parts::new();
    let mut whole = Vec::new();
    loop {
        let mut room = vec![0; size];
        let (count, is_over) = match parts.make(&mut room, &mut write) {
            Made::Part(count) => (count, false),
            Made::Last(count) => (count, true),
            Made::Failed => panic!("it did not change"),
        };
        assert!(count > 0 || is_over, "no way on");
        whole.extend_from_slice(&room[..count]);
        if is_over {
            return String::from_utf8(whole).unwrap();
        }
    }
}

fn write_all(part: u32, json: &mut Writer<'_, '_>) -> Next {
    match part {
        0 => json.begin_object(),
        1 => {
            json.key("a\"b");
            json.text("x\\\n\u{1}ü");
        }
        2 => {
            json.key("list");
            json.begin_array();
        }
        3..6 => json.number(u64::from(part)),
        6 => {
            json.begin_array();
            json.end_array();
            json.begin_text();
            json.more_text("one ");
            json.more_text("two");
            json.end_text();
            json.bool(true);
            json.null();
            json.end_array();
        }
        7 => {
            json.key("long");
            json.text(&"y".repeat(300));
        }
        _ => {
            json.end_object();
            return Next::End;
        }
    }
    Next::Part
}

#[test]
fn parts_are_the_same_in_rooms_of_any_size() {
    let long = "y".repeat(300);
    let expected = format!(r#"{{"a\"b":"x\\\n\u0001ü","list":[3,4,5,[],"one two",true,null],"long":"{long}"}}"#);
    for size in 1..500 {
        assert_eq!(made(size, write_all), expected, "{size}");
    }
    assert!(serde_json::from_str::<serde_json::Value>(&expected).is_ok());
}

#[test]
fn numbers_are_written_as_they_are() {
    let numbers = made(1_000, |_, json| {
        json.begin_array();
        for (number, decimals) in
            [(0, 3), (1_500, 3), (-5, 3), (1_234, 0), (i64::MIN, 9), (i64::MAX, 40), (100, 2), (-1_050, 2)]
        {
            json.fixed(number, decimals);
        }
        for number in
            [0.0, -0.0, 1.5, -1.234_56, 0.000_4, 1e15, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -0.0006]
        {
            json.float(number, 3);
        }
        json.signed(-7);
        json.end_array();
        Next::End
    });
    let expected = "[0,1.5,-0.005,1234,-9223372036.854775808,9223372036.854775807,1,-10.5,\
        0,0,1.5,-1.235,0,1000000000000000,null,null,null,null,-0.001,-7]";
    assert_eq!(numbers, expected);
}

#[test]
fn a_small_part_is_never_torn() {
    // The number changes each time that it is asked for.
    for size in BODY_ROOM..120 {
        let mut number = 0_u64;
        let text = made(size, |part, json| {
            number = number.wrapping_add(0x1234_5678_9ABC_DEF1);
            match part {
                0 => json.begin_array(),
                // So many times the same digit.
                1..50 => json.number((number % 9 + 1) * ((10_u64.pow(part % 18 + 1) - 1) / 9)),
                _ => {
                    json.end_array();
                    return Next::End;
                }
            }
            Next::Part
        });
        let numbers: Vec<u64> = serde_json::from_str(&text).unwrap();
        let is_whole = |number: &u64| number.to_string().bytes().all(|digit| digit == number.to_string().as_bytes()[0]);
        assert!(numbers.len() == 49 && numbers.iter().all(is_whole), "{text}");
    }
}

#[test]
fn a_part_that_waits_is_asked_for_again_and_one_that_shrinks_fails() {
    let mut parts = Parts::new();
    let mut room = [0; 20];
    let later = |part: u32, json: &mut Writer<'_, '_>| {
        json.number(u64::from(part));
        if part == 0 { Next::Part } else { Next::Later }
    };
    assert_eq!((parts.make(&mut room, later), room[0]), (Made::Part(1), b'0'));
    assert_eq!(parts.make(&mut room, |_, _| Next::Later), Made::Part(0));
    assert_eq!(parts.make(&mut [], later), Made::Part(0));
    let mut length = 185;
    let mut shrinks = |_: u32, json: &mut Writer<'_, '_>| {
        length -= 85;
        json.text(&"z".repeat(length));
        Next::End
    };
    let mut parts = Parts::new();
    assert_eq!(parts.make(&mut room, &mut shrinks), Made::Part(20));
    assert_eq!(parts.make(&mut room, &mut shrinks), Made::Failed);
}

fn value() -> impl Strategy<Value = serde_json::Value> {
    let leaf = prop_oneof![
        Just(serde_json::Value::Null),
        any::<bool>().prop_map(Into::into),
        any::<i64>().prop_map(Into::into),
        (-1e12..1e12).prop_map(|number: f64| number.into()),
        ".{0,90}".prop_map(Into::into),
    ];
    leaf.prop_recursive(5, 40, 5, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..5).prop_map(Into::into),
            prop::collection::btree_map("\\PC{0,9}", inner, 0..5).prop_map(|map| map.into_iter().collect()),
        ]
    })
}

proptest! {
    #[test]
    fn a_text_cut_anywhere_gives_the_same_tokens(value in value(), size in 1_usize..30) {
        let text = value.to_string();
        let whole = parse(text.as_bytes(), text.len());
        prop_assert!(whole.is_ok(), "{text}");
        prop_assert_eq!(parse(text.as_bytes(), size), whole);
    }

    #[test]
    fn what_is_taken_is_what_serde_takes(value in value(), changes in prop::collection::vec((any::<prop::sample::Index>(), "[\\[\\]{}:,\"\\\\0-9eE.+ntu \u{e9}\u{1}-]"), 0..3)) {
        let mut text = value.to_string();
        for (at, with) in changes {
            let places: Vec<usize> = text.char_indices().map(|(at, _)| at).collect();
            let at = places[at.index(places.len())];
            text.replace_range(at..=at + text[at..].chars().next().map_or(0, char::len_utf8) - 1, &with);
        }
        let theirs = serde_json::from_str::<serde_json::Value>(&text);
        match parse(text.as_bytes(), 7) {
            Ok(_) => prop_assert!(theirs.is_ok(), "{text}: {theirs:?}"),
            Err(Error::Syntax) => prop_assert!(theirs.is_err(), "{text}"),
            Err(Error::Depth | Error::Key | Error::Number) => {}
        }
    }
}

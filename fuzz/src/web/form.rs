//! Forms: pieces of any size make no difference, data is what was sent.

use http::multipart::{Error, Item, Multipart};

use super::cut;

/// Pieces that inputs are made of.
pub const PIECES: &[&[u8]] = &[
    b"--XX\r\nContent-Disposition: form-data; name=\"root\"\r\n\r\ngcodes\r\n",
    b"--XX\r\nContent-Disposition: form-data; name=\"file\"; filename=\"a.gcode\"\r\nContent-Type: x/y\r\n\r\n",
    b"G1 X1\r\nM400\n",
    b"\r\n--XX\r\n",
    b"\r\n--XX--",
    b"\r\n--X",
    b"--XX--\r\n",
    b"Content-Disposition: form-data; name=a",
    b"; filename=\"..\\x/%22\\\".g\"",
    b"; filename=",
    b"\r\n\r\n",
    b"\r\n",
    b"\r",
    b"\n",
    b"--",
    b"\"",
    b"\\",
    b"\xC3",
];

/// Something of a form that owns its bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Read {
    Part(String, Option<String>),
    Data(Vec<u8>),
    EndPart,
    End,
}

/// Reads the bytes whole and in pieces.
///
/// # Panics
/// When a condition of this module does not hold.
pub fn run(bytes: &[u8]) {
    let whole = read(&[bytes], bytes);
    for seed in 1..4 {
        assert_eq!(read(&cut(bytes, seed), bytes), whole, "in pieces of {seed}");
    }
}

fn read(pieces: &[&[u8]], whole: &[u8]) -> (Vec<Read>, Result<(), Error>) {
    let mut reader = Multipart::new("multipart/form-data; boundary=XX").expect("a boundary");
    let mut all: Vec<Read> = Vec::new();
    for mut piece in pieces.iter().copied() {
        loop {
            let read = match reader.next(&mut piece) {
                Err(error) => return (all, Err(error)),
                Ok(None) => break,
                Ok(Some(Item::Part { name, file_name })) => {
                    assert!(!file_name.is_some_and(|name| name.contains(['/', '\\'])), "{file_name:?}");
                    Read::Part(name.to_owned(), file_name.map(str::to_owned))
                }
                Ok(Some(Item::Data(data))) => {
                    assert!(!data.is_empty(), "data without a byte");
                    match all.last_mut() {
                        Some(Read::Data(known)) => {
                            known.extend_from_slice(data);
                            continue;
                        }
                        _ => Read::Data(data.to_vec()),
                    }
                }
                Ok(Some(Item::EndPart)) => Read::EndPart,
                Ok(Some(Item::End)) => Read::End,
            };
            all.push(read);
        }
        assert!(piece.is_empty(), "bytes are left");
    }
    for read in &all {
        if let Read::Data(data) = read {
            assert!(whole.windows(data.len()).any(|place| place == data), "data that was not sent");
            assert!(!data.windows(6).any(|place| place == b"\r\n--XX"), "a boundary among the data");
        }
    }
    (all, reader.finish())
}

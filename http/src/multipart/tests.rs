//! Forms as browsers and slicers send them, cut at every byte.

use proptest::prelude::*;

use super::{Error, Item, Multipart};
use crate::limits::{BOUNDARY_BYTES, PART_LINE_BYTES, PART_LINES, PARTS, PREAMBLE_BYTES};

/// Part that was read: name, file name, data, and whether it is whole.
type Read = (String, Option<String>, Vec<u8>, bool);

/// Reads a form in pieces of this size.
fn read_as(content_type: &str, form: &[u8], size: usize) -> Result<Vec<Read>, Error> {
    let mut reader = Multipart::new(content_type)?;
    let mut parts: Vec<Read> = Vec::new();
    let mut is_over = false;
    for mut piece in form.chunks(size.max(1)) {
        while let Some(item) = reader.next(&mut piece)? {
            assert!(!is_over, "something behind the end");
            match item {
                Item::Part { name, file_name } => {
                    parts.push((name.to_owned(), file_name.map(str::to_owned), Vec::new(), false));
                }
                Item::Data(data) => {
                    let part = parts.last_mut().expect("a part");
                    assert!(!part.3 && !data.is_empty());
                    part.2.extend_from_slice(data);
                }
                Item::EndPart => parts.last_mut().expect("a part").3 = true,
                Item::End => is_over = true,
            }
        }
        assert!(piece.is_empty());
    }
    reader.finish().map(|()| parts)
}

fn read(form: &[u8], size: usize) -> Result<Vec<Read>, Error> {
    read_as("multipart/form-data; boundary=XX", form, size)
}

const FORM: &[u8] = b"--XX\r\nContent-Disposition: form-data; name=\"root\"\r\n\r\ngcodes\r\n--XX\r\n\
    content-type: application/octet-stream\r\nContent-Disposition: form-data; name=\"file\"; filename=\"a.gcode\"\r\n\
    X: y\r\n\r\nG28\r\n\r\n--X\r\r\n--\r\n-- XX\n--XX\r\r\n-G1\r\r\n--XX  \t\r\nContent-Disposition: form-data; name=e\r\n\r\n\r\n--XX--\r\nepilogue";

#[test]
fn a_form_cut_anywhere_has_the_same_parts() {
    let data = b"G28\r\n\r\n--X\r\r\n--\r\n-- XX\n--XX\r\r\n-G1\r".to_vec();
    let parts = vec![
        ("root".to_owned(), None, b"gcodes".to_vec(), true),
        ("file".to_owned(), Some("a.gcode".to_owned()), data, true),
        ("e".to_owned(), None, Vec::new(), true),
    ];
    for size in 1..=FORM.len() {
        assert_eq!(read(FORM, size).as_ref(), Ok(&parts), "{size}");
    }
    for (before, size) in [("", 1), ("preamble\r\n", 3), ("\r\n", 1), ("--X\r\n--X\r\n\r\r\n", 2)] {
        assert_eq!(read(&[before.as_bytes(), FORM].concat(), size).as_ref(), Ok(&parts), "{before:?}");
    }
}

#[test]
fn a_form_that_ends_early_is_not_whole() {
    let end = FORM.len() - "\r\nepilogue".len();
    for length in 0..end {
        assert_eq!(read(&FORM[..length], 7), Err(Error::Short), "{length}");
    }
    assert!(read(&FORM[..end], 7).is_ok());
    assert_eq!(read(b"--XX--", 1), Ok(Vec::new()));
}

#[test]
fn malformed_parts_are_refused() {
    for form in [
        "--XXY\r\n",
        "--XX\n",
        "--XX\r\r",
        "--XX-X",
        "--XX \n",
        "--XX\r\n\r\nx",
        "--XX\r\nContent-Type: x\r\n\r\nx",
        "--XX\r\nContent-Disposition: form-data\r\n",
        "--XX\r\nA: b\n",
        "--XX\r\nA: b\r\r",
        "--XX\r\nA\0: b\r\n",
    ] {
        assert_eq!(read(form.as_bytes(), 1), Err(Error::Part), "{form:?}");
    }
    let mut reader = Multipart::new("multipart/form-data; boundary=XX").unwrap();
    for _ in 0..2 {
        assert_eq!(reader.next(&mut b"--XXY".as_slice()), Err(Error::Part), "an error stays");
    }
    assert_eq!(reader.finish(), Err(Error::Part));
}

#[test]
fn limits_hold() {
    let head = "Content-Disposition: form-data; name=a\r\n";
    let part = format!("--XX\r\n{head}\r\nx\r\n");
    let parts = |count: u8| format!("{}--XX--", part.repeat(count.into()));
    assert_eq!(read(parts(PARTS).as_bytes(), 50).map(|parts| parts.len()), Ok(usize::from(PARTS)));
    assert_eq!(read(parts(PARTS + 1).as_bytes(), 50), Err(Error::TooLong));
    let lines = |count: u8| format!("--XX\r\n{head}{}\r\nx\r\n--XX--", "A: b\r\n".repeat(usize::from(count) - 1));
    assert!(read(lines(PART_LINES).as_bytes(), 50).is_ok());
    assert_eq!(read(lines(PART_LINES + 1).as_bytes(), 50), Err(Error::TooLong));
    let line = |length: usize| format!("--XX\r\n{head}A:{}\r\n\r\nx\r\n--XX--", "b".repeat(length - 2));
    assert!(read(line(PART_LINE_BYTES).as_bytes(), 50).is_ok());
    assert_eq!(read(line(PART_LINE_BYTES + 1).as_bytes(), 50), Err(Error::TooLong));
    let before = |length: usize| format!("{}\r\n{part}--XX--", "b".repeat(length - 2));
    assert!(read(before(PREAMBLE_BYTES.into()).as_bytes(), 50).is_ok());
    // The boundary itself may be as long as any.
    let most = usize::from(PREAMBLE_BYTES) + BOUNDARY_BYTES;
    assert!(read(before(most).as_bytes(), 50).is_ok());
    assert_eq!(read(before(most + 1).as_bytes(), 50), Err(Error::TooLong));
    assert_eq!(read(before(1_000).as_bytes(), 50), Err(Error::TooLong));
    let name = format!(
        "--XX\r\nContent-Disposition: form-data; name=file; filename=\"{}\"\r\n\r\nx\r\n--XX--",
        "n".repeat(255)
    );
    assert_eq!(read(name.as_bytes(), 9).unwrap()[0].1, Some("n".repeat(255)));
}

#[test]
fn boundaries_are_those_that_can_be() {
    let longest = "b".repeat(BOUNDARY_BYTES);
    for (content_type, boundary) in [
        (
            "multipart/form-data; boundary=----WebKitFormBoundary7MA4YWxkTrZu0gW",
            "----WebKitFormBoundary7MA4YWxkTrZu0gW",
        ),
        ("Multipart/Form-Data;charset=utf-8 ; BOUNDARY=\"a b'()+_,-./:=?\"", "a b'()+_,-./:=?"),
        (&format!("multipart/form-data; boundary={longest}"), &longest),
    ] {
        let form = format!("--{boundary}\r\nContent-Disposition: form-data; name=a\r\n\r\nx\r\n--{boundary}--");
        assert_eq!(read_as(content_type, form.as_bytes(), 3).map(|parts| parts.len()), Ok(1), "{content_type}");
    }
    for content_type in [
        "",
        "multipart/form-data",
        "multipart/mixed; boundary=a",
        "multipart/form-data; boundary=",
        "multipart/form-data; boundary=\"a",
        "multipart/form-data; boundary=a\u{fc}",
        "multipart/form-data; boundary=\"a \"",
        "multipart/form-data; boundary=a*",
        &format!("multipart/form-data; boundary={longest}b"),
    ] {
        assert_eq!(Multipart::new(content_type).err(), Some(Error::Boundary), "{content_type}");
    }
}

proptest! {
    #[test]
    fn data_of_any_kind_comes_out_as_it_went_in(
        data in prop::collection::vec(prop::sample::select(b"\r\n-XYa\xFF\0".to_vec()), 0..80),
        size in 1_usize..40,
    ) {
        prop_assume!(!data.windows(6).any(|six| six == b"\r\n--XX"));
        let head = b"--XX\r\nContent-Disposition: form-data; name=a\r\n\r\n".as_slice();
        let form = [head, &data, b"\r\n--XX--"].concat();
        let parts = read(&form, size);
        prop_assert_eq!(parts, Ok(vec![("a".to_owned(), None, data, true)]));
    }
}

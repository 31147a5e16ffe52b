//! The line that says what a part of a form is: `Content-Disposition` (RFC 7578, section 4.2).

use core::ops::Range;

/// Names of a part, as places in its line.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Disposition {
    /// Name of the field.
    pub name: Range<usize>,
    /// Name of the file, where it is one.
    pub file_name: Option<Range<usize>>,
}

/// Name of the line that says what a part is.
const FIELD: &[u8] = b"content-disposition:";

/// Returns whether a header line says what the part is.
pub fn is_disposition(line: &[u8]) -> bool {
    line.get(..FIELD.len()).is_some_and(|name| name.eq_ignore_ascii_case(FIELD))
}

/// Reads the line, and decodes its names in place. None if it is malformed.
pub fn read(line: &mut [u8]) -> Option<Disposition> {
    let mut at = FIELD.len();
    at = skip(line, at, |byte| matches!(byte, b' ' | b'\t'));
    let end = skip(line, at, |byte| !matches!(byte, b';' | b' ' | b'\t'));
    if !line.get(at..end)?.eq_ignore_ascii_case(b"form-data") {
        return None;
    }
    let (mut name, mut file_name) = (None, None);
    at = skip(line, end, |byte| matches!(byte, b' ' | b'\t'));
    while at < line.len() {
        if *line.get(at)? != b';' {
            return None;
        }
        let start = skip(line, at + 1, |byte| matches!(byte, b' ' | b'\t'));
        let equals = skip(line, start, |byte| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'*'));
        if *line.get(equals)? != b'=' {
            return None;
        }
        let is = |known: &[u8]| line.get(start..equals).is_some_and(|key| key.eq_ignore_ascii_case(known));
        let (is_name, is_file) = (is(b"name"), is(b"filename"));
        let (value, end) = value(line, equals + 1)?;
        // A name that is there twice may be read as either.
        if is_name && name.replace(value.clone()).is_some() || is_file && file_name.replace(value).is_some() {
            return None;
        }
        at = skip(line, end, |byte| matches!(byte, b' ' | b'\t'));
    }
    let name = name?;
    core::str::from_utf8(line.get(name.clone())?).ok()?;
    if let Some(file) = &mut file_name {
        let text = core::str::from_utf8(line.get(file.clone())?).ok()?;
        // Some send the path that the file has at home.
        file.start += text.rfind(['/', '\\']).map_or(0, |slash| slash + 1);
    }
    Some(Disposition { name, file_name })
}

fn skip(line: &[u8], from: usize, is: fn(u8) -> bool) -> usize {
    let rest = line.get(from..).unwrap_or_default();
    from + rest.iter().take_while(|byte| is(**byte)).count()
}

/// Decodes a value in place: a word, or text in quotation marks. Returns its place and where it ends.
fn value(line: &mut [u8], from: usize) -> Option<(Range<usize>, usize)> {
    if line.get(from) != Some(&b'"') {
        let end = skip(line, from, |byte| !matches!(byte, b';' | b' ' | b'\t' | b'"'));
        return (end > from).then_some((from..end, end));
    }
    let start = from + 1;
    let (mut read, mut made) = (start, start);
    loop {
        let (byte, length) = match *line.get(read)? {
            b'"' => return Some((start..made, read + 1)),
            // A backslash before anything else is one: that is how browsers of old sent paths.
            b'\\' if matches!(line.get(read + 1), Some(b'"' | b'\\')) => (*line.get(read + 1)?, 2),
            // Browsers encode these three, and nothing else.
            b'%' => match line.get(read + 1..read + 3) {
                Some(b"22") => (b'"', 3),
                Some(b"0D" | b"0d" | b"0A" | b"0a") => (b' ', 3),
                _ => (b'%', 1),
            },
            0..=31 | 127 => return None,
            byte => (byte, 1),
        };
        *line.get_mut(made)? = byte;
        made += 1;
        read += length;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(rest: &str) -> Option<(String, Option<String>)> {
        let mut line = format!("Content-Disposition:{rest}").into_bytes();
        assert!(is_disposition(&line));
        let found = read(&mut line)?;
        let text = |range: Range<usize>| String::from_utf8(line[range].to_vec()).unwrap();
        Some((text(found.name), found.file_name.map(text)))
    }

    #[test]
    fn names_are_those_that_clients_send() {
        for (line, name, file) in [
            (" form-data; name=\"path\"", "path", None),
            ("form-data;name=print", "print", None),
            (" form-data; name=\"file\"; filename=\"a b.gcode\"", "file", Some("a b.gcode")),
            ("\tFORM-DATA ; FileName=\"x;y=z.g\" ; Name=\"f\"", "f", Some("x;y=z.g")),
            (" form-data; name=\"f\"; filename=\"a%22b%0D%0Ac%20.g\"", "f", Some("a\"b  c%20.g")),
            (" form-data; name=\"f\"; filename=\"a\\\"b\\\\c.g\"", "f", Some("c.g")),
            (" form-data; name=\"f\"; filename=\"C:\\tmp\\x.g\"", "f", Some("x.g")),
            (" form-data; name=\"f\"; filename=\"../../config.ini\"", "f", Some("config.ini")),
            (" form-data; name=\"f\"; filename=\"Würfel.g\"; filename*=UTF-8''x", "f", Some("Würfel.g")),
            (" form-data; name=\"\"; filename=\"\"", "", Some("")),
        ] {
            assert_eq!(names(line), Some((name.to_owned(), file.map(str::to_owned))), "{line}");
        }
    }

    #[test]
    fn lines_that_are_none_are_refused() {
        for line in [
            "",
            " attachment; name=\"a\"",
            " form-data",
            " form-data; filename=\"a\"",
            " form-data; name=\"a",
            " form-data; name=",
            " form-data; name",
            " form-data; name=\"a\" x",
            " form-data; name=\"a\";",
            " form-data, name=\"a\"",
            " form-data; name=\"a\"; name=\"b\"",
            " form-data; name=\"a\"; filename=a; filename=b",
            " form-data; name=\"a\0\"",
            " form-data; name=\"\\\"",
        ] {
            assert_eq!(names(line), None, "{line}");
        }
        let mut bytes = b"Content-Disposition: form-data; name=\"\xFF\"".to_vec();
        assert_eq!(read(&mut bytes), None);
        let mut bytes = b"Content-Disposition: form-data; name=\"a\"; filename=\"\xC3\"".to_vec();
        assert_eq!(read(&mut bytes), None);
    }
}

//! Percent-encoding (RFC 3986, section 2.1), decoded once and never again.

/// Decodes `text` in place. `plus` says that a plus sign is a space, as in forms. None where an escape is
/// none, or where the result is not UTF-8.
pub fn decode_in_place(text: &mut [u8], plus: bool) -> Option<&str> {
    let mut made = 0;
    let mut read = 0;
    while let Some(&byte) = text.get(read) {
        let (byte, length) = match byte {
            b'%' => (hex(*text.get(read + 1)?)? << 4 | hex(*text.get(read + 2)?)?, 3),
            b'+' if plus => (b' ', 1),
            byte => (byte, 1),
        };
        *text.get_mut(made)? = byte;
        made += 1;
        read += length;
    }
    core::str::from_utf8(text.get(..made)?).ok()
}

/// Decodes `text` into `out`. None where an escape is none, `out` is too short, or the result is not UTF-8.
pub fn decode<'o>(text: &str, plus: bool, out: &'o mut [u8]) -> Option<&'o str> {
    let place = out.get_mut(..text.len())?;
    for (place, byte) in place.iter_mut().zip(text.bytes()) {
        *place = byte;
    }
    decode_in_place(place, plus)
}

fn hex(digit: u8) -> Option<u8> {
    char::from(digit).to_digit(16).map(|digit| digit as u8)
}

/// Returns whether a byte stands for itself in a segment of a path.
#[must_use]
pub const fn is_plain(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'.' | b'_' | b'~')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(text: &str, plus: bool) -> Option<String> {
        let mut room = [0; 64];
        decode(text, plus, &mut room).map(str::to_owned)
    }

    #[test]
    fn escapes_are_decoded_once() {
        assert_eq!(decoded("a%20b+c%2F%25%32%30", false).as_deref(), Some("a b+c/%20"));
        assert_eq!(decoded("a+b%2B%c3%BC", true).as_deref(), Some("a b+ü"));
        assert_eq!(decoded("", true).as_deref(), Some(""));
    }

    #[test]
    fn broken_escapes_bytes_and_long_texts_are_refused() {
        for text in ["%", "%4", "a%4g", "%G0", "%FF", "%C3", "%+1"] {
            assert_eq!(decoded(text, true), None, "{text}");
        }
        assert_eq!(decoded(&"x".repeat(65), false), None);
        assert!(decoded(&"x".repeat(64), false).is_some());
    }

    #[test]
    fn plain_bytes_are_those_of_the_rfc() {
        let plain: String = (0..=255).filter(|byte| is_plain(*byte)).map(char::from).collect();
        assert_eq!(plain, "-.0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ_abcdefghijklmnopqrstuvwxyz~");
    }
}

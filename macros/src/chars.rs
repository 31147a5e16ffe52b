//! Characters as Python sorts them, and texts searched with little code: the library's search is made for
//! long texts.

/// Whether Python's `str.strip` and `str.split` take the character for a blank.
pub fn is_blank(char: char) -> bool {
    char.is_whitespace() || matches!(char, '\x1c'..='\x1f')
}

/// The character in lower case: ASCII, Latin, Greek and Cyrillic.
pub fn lower(char: char) -> char {
    let code = char as u32;
    let lower = match code {
        0x41..=0x5a | 0xc0..=0xd6 | 0xd8..=0xde | 0x391..=0x3a1 | 0x3a3..=0x3ab | 0x410..=0x42f => code + 32,
        0x400..=0x40f => code + 80,
        0x178 => 0xff,
        0x100..=0x12f | 0x132..=0x137 | 0x14a..=0x177 | 0x460..=0x481 => code | 1,
        0x139..=0x148 | 0x179..=0x17e if code % 2 == 1 => code + 1,
        _ => code,
    };
    char::from_u32(lower).unwrap_or(char)
}

/// The character in upper case: ASCII, Latin, Greek and Cyrillic; `ß` has two.
pub fn upper(char: char) -> char {
    let code = char as u32;
    let upper = match code {
        0x61..=0x7a | 0xe0..=0xf6 | 0xf8..=0xfe | 0x3b1..=0x3c1 | 0x3c3..=0x3cb | 0x430..=0x44f => code - 32,
        0x450..=0x45f => code - 80,
        0xff => 0x178,
        0xb5 => 0x39c,
        0x3c2 => 0x3a3,
        0x131 => 0x49,
        0x100..=0x12f | 0x132..=0x137 | 0x14a..=0x177 | 0x460..=0x481 => code & !1,
        0x13a..=0x148 | 0x17a..=0x17e if code.is_multiple_of(2) => code - 1,
        _ => code,
    };
    char::from_u32(upper).unwrap_or(char)
}

/// Whether a character is a letter or a digit: of those beyond Latin all that are no signs.
pub fn is_word(char: char) -> bool {
    char.is_ascii_alphanumeric()
        || matches!(char, 'ª' | 'µ' | 'º' | 'À'..='Ö' | 'Ø'..='ö' | 'ø'..='\u{1fff}' | '\u{2c00}'..='\u{2fef}')
        || matches!(char, '\u{3040}'..='\u{d7ff}' | '\u{f900}'..='\u{fdff}' | '\u{ff66}'..='\u{ffdc}')
}

/// Number of characters.
#[inline(never)]
pub fn count(text: &str) -> usize {
    text.bytes().filter(|byte| byte & 0xc0 != 0x80).count()
}

/// First place of a part in a text from a place on, in bytes.
#[inline(never)]
pub fn find(text: &str, part: &str, from: usize) -> Option<usize> {
    (from..=text.len()).find(|at| starts_at(text, part, *at))
}

/// Last place of a part in a text, in bytes.
#[inline(never)]
pub fn find_last(text: &str, part: &str) -> Option<usize> {
    (0..=text.len()).rev().find(|at| starts_at(text, part, *at))
}

fn starts_at(text: &str, part: &str, at: usize) -> bool {
    text.is_char_boundary(at) && text.as_bytes().get(at..at + part.len()) == Some(part.as_bytes())
}

/// Value of a digit in a base of up to 36.
#[inline(never)]
pub fn digit(byte: u8, base: u32) -> Option<u32> {
    let value = match byte {
        b'0'..=b'9' => byte - b'0',
        b'a'..=b'z' | b'A'..=b'Z' => (byte | 0x20) - b'a' + 10,
        _ => return None,
    };
    (u32::from(value) < base).then_some(u32::from(value))
}

/// First place of a byte in a text.
#[inline(never)]
pub fn place_of(text: &str, byte: u8) -> Option<usize> {
    text.bytes().position(|known| known == byte)
}

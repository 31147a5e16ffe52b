//! Characters as Python sorts them, and texts searched with little code: the library's search is made for
//! long texts.

/// Changes of the case of characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Case {
    Lower,
    Upper,
    /// The first character in upper case, all others in lower case.
    Capital,
    /// As the filter `title` has it: words begin behind blanks and brackets.
    Words,
    /// As the method `title` has it: words begin behind whatever is no letter.
    Title,
    Swapped,
}

impl Case {
    /// Whether a character gets the upper case, by the character before it, which is 0 for the first one.
    pub fn is_upper(self, before: char, char: char) -> bool {
        match self {
            Self::Lower => false,
            Self::Upper => true,
            Self::Capital => before == '\0',
            Self::Words => before == '\0' || is_blank(before) || matches!(before, '-' | '(' | '{' | '[' | '<'),
            Self::Title => upper(before) == lower(before),
            Self::Swapped => char == lower(char),
        }
    }
}

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

/// Number of characters of a text.
#[inline(never)]
pub fn count(text: &str) -> usize {
    text.bytes().filter(|byte| byte & 0xc0 != 0x80).count()
}

/// Part of a text by its number: parts have a sign behind them.
#[inline(never)]
pub fn nth(text: &'static str, sign: u8, mut number: usize) -> &'static str {
    let mut from = 0;
    for (at, byte) in text.bytes().enumerate() {
        if byte == sign {
            if number == 0 {
                return text.get(from..at).unwrap_or_default();
            }
            number -= 1;
            from = at + 1;
        }
    }
    ""
}

/// First character of a text.
#[inline(never)]
pub fn first(text: &str) -> Option<char> {
    text.chars().next()
}

/// Place of a character by its number, in bytes; that of the end if there are fewer.
#[inline(never)]
pub fn place(text: &str, number: usize) -> usize {
    let mut left = number;
    let starts = |byte: u8| byte & 0xc0 != 0x80;
    for (at, byte) in text.bytes().enumerate() {
        if starts(byte) {
            if left == 0 {
                return at;
            }
            left -= 1;
        }
    }
    text.len()
}

/// Sides of a text that something is taken from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    Left,
    Right,
    Both,
}

/// Begin and end of a text without blanks, or without the characters of a set, at its sides.
#[inline(never)]
pub fn strip(text: &str, set: Option<&str>, sides: Sides) -> (usize, usize) {
    let (mut from, mut to) = (text.len(), 0);
    let mut at = 0;
    while let Some(char) = first(text.get(at..).unwrap_or_default()) {
        let goes = set.map_or_else(|| is_blank(char), |set| has(set, char));
        let end = at + char.len_utf8();
        if !goes {
            from = from.min(at);
            to = end;
        }
        at = end;
    }
    match sides {
        Sides::Left => (from, text.len()),
        Sides::Right => (0, to),
        Sides::Both => (from, to.max(from)),
    }
}

/// A text without blanks at its ends.
pub fn trim(text: &str) -> &str {
    let (from, to) = strip(text, None, Sides::Both);
    text.get(from..to).unwrap_or_default()
}

/// Whether a text has a character.
pub fn has(text: &str, char: char) -> bool {
    find(text, char.encode_utf8(&mut [0; 4]), 0).is_some()
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

#[cfg(test)]
mod tests {
    use super::{Case, Sides, count, lower, nth, place, strip, trim, upper};

    #[test]
    fn cases_of_latin_greek_and_cyrillic_turn_back() {
        for char in "az\u{e9}\u{ff}\u{3b1}\u{436}\u{450}\u{17e}".chars() {
            assert_eq!(lower(upper(char)), char);
            assert_ne!(upper(char), char);
        }
        assert_eq!((upper('1'), lower('-')), ('1', '-'));
    }

    #[test]
    fn words_begin_behind_what_the_case_says() {
        assert!(Case::Words.is_upper('-', 'a') && !Case::Words.is_upper('\'', 'a'));
        assert!(Case::Title.is_upper('\'', 'a') && !Case::Title.is_upper('b', 'a'));
        assert!(Case::Capital.is_upper('\0', 'a') && !Case::Capital.is_upper(' ', 'a'));
    }

    #[test]
    fn sides_are_stripped_of_blanks_or_of_a_set() {
        assert_eq!((strip(" a b ", None, Sides::Left), strip(" a b ", None, Sides::Right)), ((1, 5), (0, 4)));
        assert_eq!((trim("\u{a0}a\t"), trim("  "), trim("")), ("a", "", ""));
        assert_eq!(strip("xxaxé", Some("éx"), Sides::Both), (2, 3));
    }

    #[test]
    fn characters_have_places_in_bytes() {
        assert_eq!((place("aéb", 0), place("aéb", 2), place("aéb", 9), count("aéb")), (0, 3, 4, 3));
    }

    #[test]
    fn parts_of_a_text_have_numbers() {
        assert_eq!(
            (nth("a;bc;;", b';', 0), nth("a;bc;;", b';', 1), nth("a;bc;;", b';', 2), nth("a;", b';', 5)),
            ("a", "bc", "", "")
        );
    }
}

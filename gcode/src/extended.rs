//! Klipper's extended commands: `SET_VELOCITY_LIMIT ACCEL=3000`, a word and `KEY=VALUE` parameters.
//!
//! Values may stand in double or single quotes, which may hold blanks, `;` and quotes of the other kind. `;`
//! and `#` begin a comment (Klipper, "G-Codes", section "G-Code commands"). An apostrophe within a value is
//! part of the value.

/// Whether the line's first word begins a command by name instead of a code: letters, digits and underscores,
/// the second of which is no digit.
pub(crate) fn is_extended(body: &[u8]) -> bool {
    let begins = |byte: &u8| byte.is_ascii_alphabetic() || *byte == b'_';
    match body {
        [first, second, ..] => begins(second) && begins(first) && word_end(body).is_some(),
        _ => false,
    }
}

/// Returns the end of the first word, when nothing but blanks or a comment can follow the word.
fn word_end(body: &[u8]) -> Option<usize> {
    let end = body.iter().position(|byte| !(byte.is_ascii_alphanumeric() || *byte == b'_')).unwrap_or(body.len());
    matches!(body.get(end), None | Some(b' ' | b'\t' | b';' | b'#' | b'\r')).then_some(end)
}

/// A command by name, with its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extended<'a> {
    text: &'a str,
    name: &'a str,
    rest: &'a str,
}

impl<'a> Extended<'a> {
    /// Reads a command from a line without number and checksum, in upper or lower case.
    #[must_use]
    pub fn new(text: &'a str) -> Self {
        let text = text.get(..position_outside(text, [b';', b'#'])).unwrap_or(text).trim();
        let end = word_end(text.as_bytes()).unwrap_or(text.len());
        let (name, rest) = text.split_at(end);
        Self { text, name, rest: rest.trim() }
    }

    /// Returns the command as it is written, without comment.
    #[must_use]
    pub const fn text(&self) -> &'a str {
        self.text
    }

    /// Returns what follows the name.
    #[must_use]
    pub const fn rest(&self) -> &'a str {
        self.rest
    }

    /// Returns the name as it is written.
    #[must_use]
    pub const fn name(&self) -> &'a str {
        self.name
    }

    /// Whether this is its name, in upper or lower case.
    #[must_use]
    pub const fn is(&self, name: &str) -> bool {
        self.name.eq_ignore_ascii_case(name)
    }

    /// The value of a parameter; that of its last writing.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&'a str> {
        self.parameters().filter(|(written, _)| written.eq_ignore_ascii_case(key)).last().map(|(_, value)| value)
    }

    /// Keys and values in order. A word without `=` is a key with an empty value.
    #[must_use]
    pub const fn parameters(&self) -> KeyValues<'a> {
        KeyValues { rest: self.rest }
    }
}

/// Quotes of a text that is gone through byte by byte.
#[derive(Default)]
struct Quotes {
    open: Option<u8>,
    before: u8,
}

impl Quotes {
    /// Takes the next byte. Returns whether it stands in quotes.
    fn hold(&mut self, byte: u8) -> bool {
        let opens = byte == b'"' || byte == b'\'' && self.before == b'=';
        self.open = match self.open {
            Some(quote) if quote == byte => None,
            None if opens => Some(byte),
            open => open,
        };
        self.before = byte;
        self.open.is_some()
    }
}

/// Returns the place of the first of these bytes outside quotes, or the end of the text.
#[inline(never)]
fn position_outside(text: &str, bytes: [u8; 2]) -> usize {
    let mut quotes = Quotes::default();
    text.bytes().position(|byte| !quotes.hold(byte) && bytes.contains(&byte)).unwrap_or(text.len())
}

/// The parameters of a command.
#[derive(Clone, Copy, Debug)]
pub struct KeyValues<'a> {
    rest: &'a str,
}

impl<'a> Iterator for KeyValues<'a> {
    type Item = (&'a str, &'a str);

    fn next(&mut self) -> Option<Self::Item> {
        let text = self.rest.trim_start();
        if text.is_empty() {
            return None;
        }
        let (parameter, rest) = text.split_at(position_outside(text, [b' ', b'\t']));
        self.rest = rest;
        let (key, value) = parameter.split_once('=').unwrap_or((parameter, ""));
        let quote = value.chars().next().filter(|first| matches!(first, '"' | '\''));
        let inner = quote.and_then(|quote| Some((quote, value.strip_prefix(quote)?)));
        Some((key, inner.map_or(value, |(quote, inner)| inner.strip_suffix(quote).unwrap_or(inner))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn commands_are_told_from_codes() {
        for line in
            ["SET_VELOCITY_LIMIT ACCEL=3000", "PAUSE", "T_1 X=2", "M_CODE", "PRINT_START;x", "_NEW_FRAME", "PA_2"]
        {
            assert!(is_extended(line.as_bytes()), "{line}");
        }
        for line in ["", "G", "G1 X2", "X Y", "T0", "M117 HELLO", "Z-5", "O100 SUB", "#1=5", "GX=5", "XY-5", "G(x)"] {
            assert!(!is_extended(line.as_bytes()), "{line}");
        }
    }

    #[test]
    fn single_quotes_hold_double_ones_and_an_apostrophe_is_none() {
        let command = Extended::new("RESPOND TYPE=echo MSG='\"extruder\" is cold; wait' NAME=John's X=1 ; Y=2");
        assert_eq!(command.get("MSG"), Some("\"extruder\" is cold; wait"));
        assert_eq!((command.get("NAME"), command.get("X"), command.get("Y")), (Some("John's"), Some("1"), None));
        assert_eq!(Extended::new("A B=\"it's\" C=3").get("B"), Some("it's"));
        assert_eq!(Extended::new("A B='open c").get("B"), Some("open c"));
    }

    #[test]
    fn parameters_are_keys_and_values() {
        let command = Extended::new("Set_Pressure_Advance  EXTRUDER=extruder\tadvance=0.05 ; more=1");
        assert!(command.is("SET_PRESSURE_ADVANCE") && !command.is("SET_PRESSURE"));
        assert_eq!(command.get("ADVANCE"), Some("0.05"));
        assert_eq!(command.get("EXTRUDER"), Some("extruder"));
        assert_eq!((command.get("MORE"), command.parameters().count()), (None, 2));
    }

    #[test]
    fn values_may_be_quoted() {
        let command = Extended::new("RESPOND TYPE=echo MSG=\"layer 1; of = 20 #\" X= Y # \"no\"");
        assert_eq!(command.get("MSG"), Some("layer 1; of = 20 #"));
        assert_eq!((command.get("X"), command.get("Y"), command.get("NO")), (Some(""), Some(""), None));
        assert_eq!(Extended::new("RESPOND MSG=\"open").get("MSG"), Some("open"));
        assert_eq!(Extended::new("M A=1 A=2").get("a"), Some("2"));
    }

    proptest! {
        #[test]
        fn whatever_is_written_is_read(text in "[A-Za-z_=\"; #0-9\u{e4}]{0,60}") {
            let command = Extended::new(&text);
            prop_assert!(command.parameters().count() <= text.len());
            prop_assert!(command.name().len() <= text.len());
        }
    }
}

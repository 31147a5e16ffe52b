//! Writer of JSON: commas, escapes and numbers.

use crate::window::Window;

/// Greatest number of decimals of a fraction.
const DECIMALS: u8 = 9;

/// Writer of JSON into a window.
#[derive(Debug)]
pub struct Writer<'w, 'o> {
    window: &'w mut Window<'o>,
    /// Whether a value, or the end of one, is the last thing that was written.
    is_behind: bool,
}

impl<'w, 'o> Writer<'w, 'o> {
    /// Goes on behind what was written before: a value, or something else.
    pub(super) const fn new(window: &'w mut Window<'o>, is_behind: bool) -> Self {
        Self { window, is_behind }
    }

    /// Returns whether a value is the last thing that was written.
    pub(super) const fn is_behind(&self) -> bool {
        self.is_behind
    }

    /// Writes the beginning of an object.
    pub fn begin_object(&mut self) {
        self.value("{");
        self.is_behind = false;
    }

    /// Writes the end of an object.
    pub fn end_object(&mut self) {
        self.window.text("}");
        self.is_behind = true;
    }

    /// Writes the beginning of an array.
    pub fn begin_array(&mut self) {
        self.value("[");
        self.is_behind = false;
    }

    /// Writes the end of an array.
    pub fn end_array(&mut self) {
        self.window.text("]");
        self.is_behind = true;
    }

    /// Writes the name of the value that follows.
    pub fn key(&mut self, name: &str) {
        self.text(name);
        self.window.text(":");
        self.is_behind = false;
    }

    /// Writes a string that is whole.
    pub fn text(&mut self, text: &str) {
        self.begin_text();
        self.more_text(text);
        self.end_text();
    }

    /// Begins a string that is written in pieces.
    pub fn begin_text(&mut self) {
        self.value("\"");
    }

    /// Writes a piece of a string.
    pub fn more_text(&mut self, text: &str) {
        for byte in text.bytes() {
            match byte {
                b'"' | b'\\' => self.window.put(&[b'\\', byte]),
                b'\n' => self.window.put(b"\\n"),
                0..=0x1F => {
                    let digit = |value: u8| b"0123456789abcdef".get(usize::from(value)).copied().unwrap_or(b'0');
                    self.window.put(&[b'\\', b'u', b'0', b'0', digit(byte >> 4), digit(byte & 15)]);
                }
                byte => self.window.put(&[byte]),
            }
        }
    }

    /// Writes a number as a piece of a string.
    pub fn more_number(&mut self, number: u64) {
        self.window.number(number);
    }

    /// Ends a string that was written in pieces.
    pub fn end_text(&mut self) {
        self.window.text("\"");
    }

    /// Writes a number without a sign.
    pub fn number(&mut self, number: u64) {
        self.value("");
        self.window.number(number);
    }

    /// Writes a number with a sign.
    pub fn signed(&mut self, number: i64) {
        self.fixed(number, 0);
    }

    /// Writes `number` divided by a power of ten, without needless zeros.
    pub fn fixed(&mut self, number: i64, decimals: u8) {
        self.value(if number < 0 { "-" } else { "" });
        let mut decimals = decimals.min(DECIMALS);
        let mut digits = number.unsigned_abs();
        while decimals > 0 && digits.is_multiple_of(10) {
            digits /= 10;
            decimals -= 1;
        }
        let mut behind = [b'0'; DECIMALS as usize];
        let behind = behind.get_mut(..usize::from(decimals)).unwrap_or_default();
        for place in behind.iter_mut().rev() {
            *place += (digits % 10) as u8;
            digits /= 10;
        }
        self.window.number(digits);
        if decimals > 0 {
            self.window.text(".");
            self.window.put(behind);
        }
    }

    /// Writes a number with so many decimals at the most. What is no number, or is too large to have them, is
    /// written as null.
    pub fn float(&mut self, number: f64, decimals: u8) {
        let decimals = decimals.min(DECIMALS);
        let scaled = number * 10_u64.pow(u32::from(decimals)) as f64;
        if scaled.is_finite() && scaled.abs() < 9e18 {
            self.fixed((scaled + if scaled < 0.0 { -0.5 } else { 0.5 }) as i64, decimals);
        } else {
            self.null();
        }
    }

    /// Writes true or false.
    pub fn bool(&mut self, value: bool) {
        self.value(if value { "true" } else { "false" });
    }

    /// Writes the value null.
    pub fn null(&mut self) {
        self.value("null");
    }

    /// Writes the beginning of a value, behind a comma where one is due.
    fn value(&mut self, text: &str) {
        if core::mem::replace(&mut self.is_behind, true) {
            self.window.text(",");
        }
        self.window.text(text);
    }
}

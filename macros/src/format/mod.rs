//! Python's two ways to put values into texts: `"%.2f" % value` and `"{:.2f}".format(value)`.

mod braces;
mod number;
mod percent;

pub use braces::braces;
pub use percent::percent;

use crate::memory::{Memory, Text};

/// Form in which a value is written.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    pub fill: char,
    /// `<`, `>`, `^`, `=` or 0 for what the value's type wants.
    pub align: u8,
    /// `+`, a blank or `-`.
    pub sign: u8,
    /// `#`: with the prefix of the base, and with a point in any case.
    pub is_alternate: bool,
    pub width: usize,
    pub comma: u8,
    pub precision: Option<usize>,
    /// Letter of the form, or 0.
    pub form: u8,
}

impl Default for Spec {
    fn default() -> Self {
        let align = 0;
        Self { fill: ' ', align, sign: b'-', is_alternate: false, width: 0, comma: 0, precision: None, form: 0 }
    }
}

/// Greatest width and precision.
const MOST: usize = 400;

/// Reads a number of a form; returns it and where it ends. Numbers that are too great stay at the greatest.
fn number(bytes: &[u8], mut at: usize) -> (usize, usize) {
    let mut value = 0;
    while let Some(digit) = bytes.get(at).filter(|byte| byte.is_ascii_digit()) {
        value = (value * 10 + usize::from(digit - b'0')).min(MOST);
        at += 1;
    }
    (value, at)
}

/// Moves what was appended since a place so that it has the width of a form. The first bytes, a sign or a
/// prefix, stay in front of what fills where the form wants it.
fn align(memory: &mut Memory<'_>, from: usize, prefix: usize, spec: &Spec, default: u8) {
    let text = memory.text_since(from);
    let length = crate::chars::count(memory.text(text));
    let missing = spec.width.saturating_sub(length);
    if missing == 0 {
        return;
    }
    let align = if spec.align == 0 { default } else { spec.align };
    let (left, place) = match align {
        b'<' => (0, from),
        b'^' => (missing / 2, from),
        b'=' => (missing, from + prefix),
        _ => (missing, from),
    };
    memory.push_chars(spec.fill, missing - left);
    let end = memory.top;
    memory.push_chars(spec.fill, left);
    memory.rotate(place, memory.top, end - place);
}

/// Appends a string by a form.
pub fn write_text(memory: &mut Memory<'_>, text: Text, spec: &Spec) {
    let string = memory.text(text);
    let end = crate::chars::place(string, spec.precision.unwrap_or(usize::MAX));
    let from = memory.top;
    memory.push_text(text.part(0, end));
    align(memory, from, 0, spec, b'<')
}

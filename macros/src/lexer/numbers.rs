//! Numbers: whole, in other bases, with point or exponent.

use crate::chars;
use crate::digits::negative;
use crate::fault::{Result, Words};
use crate::lexer::Token;
use crate::lexer::reader::Reader;
use crate::memory::Memory;

/// Reads a number. Python's literals, other than templates, may begin or end with their point.
pub fn read(reader: &mut Reader<'_>, memory: &mut Memory<'_>, is_literal: bool) -> Result<Token> {
    let may_be_real = is_literal || reader.last != b'.';
    let base = match (reader.peek(0), reader.peek(1) | 0x20) {
        (b'0', b'x') => 16,
        (b'0', b'o') => 8,
        (b'0', b'b') => 2,
        _ => 10,
    };
    if base != 10 && is_digit_behind(reader, 2, base) {
        reader.skip(2);
        let from = memory.top;
        while is_digit_behind(reader, 0, base) {
            match reader.take() {
                b'_' => {}
                digit => memory.push_byte(digit),
            }
        }
        let token = whole(memory, memory.bytes(memory.text_since(from)), base);
        memory.top = from;
        return token;
    }
    let from = memory.top;
    digits(reader, memory);
    let mut is_real = false;
    if may_be_real && reader.peek(0) == b'.' && (is_literal || reader.peek(1).is_ascii_digit()) {
        is_real = true;
        memory.push_byte(reader.take());
        digits(reader, memory);
    }
    let sign = usize::from(matches!(reader.peek(1), b'+' | b'-'));
    if may_be_real && reader.peek(0) | 0x20 == b'e' && reader.peek(1 + sign).is_ascii_digit() {
        is_real = true;
        (0..=sign).for_each(|_| memory.push_byte(reader.take()));
        digits(reader, memory);
    }
    let text = memory.text_since(from);
    let token = if is_real { real(memory, memory.text(text)) } else { decimal(memory, memory.bytes(text)) };
    memory.top = from;
    token
}

fn is_digit_behind(reader: &Reader<'_>, index: usize, base: u32) -> bool {
    let is_digit = |index| chars::digit(reader.peek(index), base).is_some();
    is_digit(index) || reader.peek(index) == b'_' && is_digit(index + 1)
}

/// Takes digits, and leaves out a `_` between two of them.
fn digits(reader: &mut Reader<'_>, memory: &mut Memory<'_>) {
    loop {
        match reader.peek(0) {
            b'0'..=b'9' => memory.push_byte(reader.take()),
            b'_' if reader.last.is_ascii_digit() && reader.peek(1).is_ascii_digit() => reader.skip(1),
            _ => return,
        }
    }
}

fn real(memory: &Memory<'_>, text: &str) -> Result<Token> {
    match gcode::read_f64(text) {
        Some(value) if value.is_finite() => Ok(Token::Float(value)),
        _ => memory.fail(Words::TooLarge),
    }
}

fn decimal(memory: &Memory<'_>, digits: &[u8]) -> Result<Token> {
    if digits.first() == Some(&b'0') && digits.iter().any(|digit| *digit != b'0') {
        return memory.fail(Words::LeadingZero);
    }
    if digits.is_empty() {
        return memory.fail(Words::NumberMissing);
    }
    whole(memory, digits, 10)
}

fn whole(memory: &Memory<'_>, digits: &[u8], base: u32) -> Result<Token> {
    match negative(digits, base).and_then(i64::checked_neg) {
        Some(value) => Ok(Token::Int(value)),
        None => memory.fail(Words::TooLarge),
    }
}

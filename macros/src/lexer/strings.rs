//! Strings in quotes, with the escapes of Python.

use crate::fault::{Result, Words};
use crate::lexer::Token;
use crate::lexer::reader::Reader;
use crate::memory::Memory;

/// Reads a string, its quotes included.
pub fn read(reader: &mut Reader<'_>, memory: &mut Memory<'_>) -> Result<Token> {
    let from = memory.top;
    let quote = reader.take();
    loop {
        if reader.is_at_end() {
            return memory.fail(Words::StringEnd);
        }
        match reader.take() {
            byte if byte == quote => break,
            b'\\' => escape(reader, memory)?,
            byte => memory.push_byte(byte),
        }
    }
    if core::str::from_utf8(memory.bytes(memory.text_since(from))).is_err() {
        return memory.fail(Words::NotUtf8);
    }
    Ok(Token::Str(memory.intern(from)))
}

fn escape(reader: &mut Reader<'_>, memory: &mut Memory<'_>) -> Result<()> {
    let byte = reader.take();
    let char = match byte {
        b'\n' => return Ok(()),
        b'n' => '\n',
        b't' => '\t',
        b'r' => '\r',
        b'a' => '\x07',
        b'b' => '\x08',
        b'f' => '\x0c',
        b'v' => '\x0b',
        b'\\' | b'\'' | b'"' => char::from(byte),
        b'0'..=b'7' => octal(reader, byte),
        b'x' => hex(reader, memory, 2)?,
        b'u' => hex(reader, memory, 4)?,
        b'U' => hex(reader, memory, 8)?,
        b'N' => return memory.fail(Words::CharacterName),
        _ => {
            memory.push_byte(b'\\');
            memory.push_byte(byte);
            return Ok(());
        }
    };
    memory.push_char(char);
    Ok(())
}

fn octal(reader: &mut Reader<'_>, first: u8) -> char {
    let mut value = u32::from(first - b'0');
    for _ in 0..2 {
        if !matches!(reader.peek(0), b'0'..=b'7') {
            break;
        }
        value = value * 8 + u32::from(reader.take() - b'0');
    }
    char::from_u32(value).unwrap_or('\0')
}

fn hex(reader: &mut Reader<'_>, memory: &Memory<'_>, count: usize) -> Result<char> {
    let mut value: u32 = 0;
    for _ in 0..count {
        let Some(digit) = crate::chars::digit(reader.peek(0), 16) else {
            return memory.fail(Words::EscapeShort);
        };
        reader.take();
        value = value.wrapping_mul(16).wrapping_add(digit);
    }
    char::from_u32(value).map_or_else(|| memory.fail(Words::NoCharacter), Ok)
}

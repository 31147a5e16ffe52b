//! Text to tokens, by the rules of Jinja2 with Klipper's delimiters: `{%` `%}` `{` `}` `{#` `#}`.

mod numbers;
mod reader;
mod strings;

use crate::chars::{self, Sides};
use crate::fault::{About, Fault, Result, Words};
use crate::memory::{Memory, Text};
use reader::Reader;

/// Most brackets within brackets.
const MOST_BRACKETS: usize = 32;
/// Text between tags is cut into pieces of so many bytes or a few more.
const PIECE: usize = 250;

/// A word of a template.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(u32)]
pub enum Token {
    End,
    /// Text of the template between two tags.
    Data(Text),
    /// The `{` before a value that is written.
    OutputBegin,
    /// The `}` behind a value that is written.
    OutputEnd,
    /// The `{%` before a tag.
    TagBegin,
    /// The `%}` behind a tag.
    TagEnd,
    Name(Text),
    Str(Text),
    Int(i64),
    Float(f64),
    /// A sign; of those of two characters the first, with the highest bit set.
    Sign(u8),
}

/// Signs of two characters.
pub const POWER: u8 = b'*' | 0x80;
pub const FLOOR_DIVIDE: u8 = b'/' | 0x80;
pub const EQUAL: u8 = b'=' | 0x80;
pub const UNEQUAL: u8 = b'!' | 0x80;
pub const AT_LEAST: u8 = b'>' | 0x80;
pub const AT_MOST: u8 = b'<' | 0x80;

/// Part of the template that the lexer is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Data,
    Output,
    Tag,
    /// A Python literal, which has no delimiters.
    Literal,
}

/// Reads tokens from bytes.
pub struct Lexer<'s> {
    reader: Reader<'s>,
    state: State,
    brackets: [u8; MOST_BRACKETS],
    open: usize,
    /// Whether a `-` at the end of the last tag takes the blanks that follow.
    trims: bool,
    /// Line and column of the last token.
    pub place: (u16, u16),
}

impl<'s> Lexer<'s> {
    /// A lexer for a template.
    pub fn new(source: &'s mut dyn Iterator<Item = u8>) -> Self {
        let reader = Reader::new(source);
        Self { reader, state: State::Data, brackets: [0; MOST_BRACKETS], open: 0, trims: false, place: (1, 1) }
    }

    /// A lexer for a Python literal.
    pub fn of_literal(source: &'s mut dyn Iterator<Item = u8>) -> Self {
        Self { state: State::Literal, ..Self::new(source) }
    }

    /// The next token; fails where no token can be read.
    pub fn next(&mut self, memory: &mut Memory<'_>) -> Result<Token> {
        if self.state == State::Data {
            return self.data(memory);
        }
        self.reader.skip_blanks();
        self.place = self.reader.place;
        if self.open == 0
            && let Some(token) = self.end_of_tag()
        {
            return Ok(token);
        }
        let byte = self.reader.peek(0);
        match byte {
            0 if self.reader.is_at_end() => Ok(Token::End),
            b'0'..=b'9' => numbers::read(&mut self.reader, memory, self.state == State::Literal),
            b'.' if self.state == State::Literal => numbers::read(&mut self.reader, memory, true),
            b'a'..=b'z' | b'A'..=b'Z' | b'_' => self.name(memory),
            b'\'' | b'"' => strings::read(&mut self.reader, memory),
            _ => self.sign(memory),
        }
    }

    fn data(&mut self, memory: &mut Memory<'_>) -> Result<Token> {
        loop {
            if self.trims {
                self.reader.skip_blanks();
                self.trims = false;
            }
            let from = memory.top;
            self.place = self.reader.place;
            while !self.reader.is_at_end() && self.reader.peek(0) != b'{' {
                let byte = self.reader.take();
                memory.push_byte(byte);
                let next = self.reader.peek(0);
                let is_seam = byte.is_ascii_graphic() && next.is_ascii();
                if memory.top - from >= PIECE && is_seam {
                    return data_token(memory, from);
                }
            }
            let is_tag = self.reader.peek(0) == b'{';
            let sign = self.reader.peek(if matches!(self.reader.peek(1), b'%' | b'#') { 2 } else { 1 });
            if is_tag && sign == b'-' {
                trim_end(memory, from);
            }
            if memory.top > from {
                return data_token(memory, from);
            }
            if !is_tag {
                return Ok(Token::End);
            }
            if let Some(token) = self.begin_of_tag(memory)? {
                return Ok(token);
            }
        }
    }

    /// Takes the sign that begins a tag; none if it was a comment, which is over then.
    fn begin_of_tag(&mut self, memory: &Memory<'_>) -> Result<Option<Token>> {
        self.place = self.reader.place;
        self.reader.take();
        let kind = self.reader.peek(0);
        if matches!(kind, b'%' | b'#') {
            self.reader.take();
        }
        if matches!(self.reader.peek(0), b'-' | b'+') {
            self.reader.take();
        }
        match kind {
            b'#' => self.comment(memory).map(|()| None),
            b'%' => {
                self.state = State::Tag;
                Ok(Some(Token::TagBegin))
            }
            _ => {
                self.state = State::Output;
                Ok(Some(Token::OutputBegin))
            }
        }
    }

    fn comment(&mut self, memory: &Memory<'_>) -> Result<()> {
        let mut before = 0;
        while !self.reader.is_at_end() {
            let byte = self.reader.take();
            if byte == b'#' && self.reader.peek(0) == b'}' {
                self.reader.take();
                self.trims = before == b'-';
                return Ok(());
            }
            before = byte;
        }
        memory.fail(Words::CommentEnd)
    }

    fn end_of_tag(&mut self) -> Option<Token> {
        let signs = [0, 1, 2].map(|index| self.reader.peek(index));
        let (length, token, trims) = match (self.state, signs) {
            (State::Tag, [b'-', b'%', b'}']) => (3, Token::TagEnd, true),
            (State::Tag, [b'+', b'%', b'}']) => (3, Token::TagEnd, false),
            (State::Tag, [b'%', b'}', _]) => (2, Token::TagEnd, false),
            (State::Output, [b'-', b'}', _]) => (2, Token::OutputEnd, true),
            (State::Output, [b'}', ..]) => (1, Token::OutputEnd, false),
            _ => return None,
        };
        self.reader.skip(length);
        self.state = State::Data;
        self.trims = trims;
        Some(token)
    }

    fn name(&mut self, memory: &mut Memory<'_>) -> Result<Token> {
        let from = memory.top;
        while self.reader.peek(0).is_ascii_alphanumeric() || self.reader.peek(0) == b'_' {
            memory.push_byte(self.reader.take());
        }
        if !self.reader.peek(0).is_ascii() && !self.reader.is_blank() {
            return memory.fail(Words::NameLetters);
        }
        Ok(Token::Name(memory.intern(from)))
    }

    fn sign(&mut self, memory: &Memory<'_>) -> Result<Token> {
        let first = self.reader.take();
        let second = self.reader.peek(0);
        let is_double = match first {
            b'*' | b'/' => second == first,
            b'=' | b'!' | b'<' | b'>' => second == b'=',
            _ => false,
        };
        if is_double {
            self.reader.take();
            return Ok(Token::Sign(first | 0x80));
        }
        match first {
            b'(' | b'[' | b'{' => self.open_bracket(memory, first)?,
            b')' | b']' | b'}' => self.close_bracket(memory, first)?,
            b'+' | b'-' | b'*' | b'/' | b'%' | b'~' | b'=' | b'<' | b'>' | b'.' | b':' | b'|' | b',' | b';' => {}
            _ => return Err(Fault::with(memory, Words::Meaningless, About::Byte(first))),
        }
        Ok(Token::Sign(first))
    }

    fn open_bracket(&mut self, memory: &Memory<'_>, bracket: u8) -> Result<()> {
        let Some(place) = self.brackets.get_mut(self.open) else {
            return memory.fail(Words::Brackets);
        };
        *place = bracket;
        self.open += 1;
        Ok(())
    }

    fn close_bracket(&mut self, memory: &Memory<'_>, bracket: u8) -> Result<()> {
        let opening = match bracket {
            b')' => b'(',
            b']' => b'[',
            _ => b'{',
        };
        let last = self.open.checked_sub(1).and_then(|last| self.brackets.get(last));
        if last != Some(&opening) {
            let words = Words::BracketOpen;
            return Err(Fault::with(memory, words, About::Byte(bracket)));
        }
        self.open -= 1;
        Ok(())
    }
}

fn data_token(memory: &mut Memory<'_>, from: usize) -> Result<Token> {
    if core::str::from_utf8(memory.bytes(memory.text_since(from))).is_err() {
        return memory.fail(Words::NotUtf8);
    }
    Ok(Token::Data(memory.intern(from)))
}

/// Drops the blanks at the end of what was appended since a place.
fn trim_end(memory: &mut Memory<'_>, from: usize) {
    let text = memory.text_since(from);
    let (_, left) = chars::strip(memory.text(text), None, Sides::Right);
    memory.top = from + left;
}

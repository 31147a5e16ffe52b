//! Pull parser: tokens out of text that comes in pieces of any size.

use super::number::{Number, Reader};
use crate::limits::{DEPTH, KEY_BYTES};
use crate::utf8::Utf8;

/// Bytes of the longest character.
const CHARACTER: usize = 4;

/// Smallest meaningful piece of JSON text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Token<'t> {
    /// Beginning of an object.
    BeginObject,
    /// End of an object.
    EndObject,
    /// Beginning of an array.
    BeginArray,
    /// End of an array.
    EndArray,
    /// Name of what follows.
    Key(&'t str),
    /// Piece of a string, cut between characters, and whether it is the last one, which may be empty.
    Text(&'t str, bool),
    /// Number, as it was written.
    Number(Number),
    /// The value true or false.
    Bool(bool),
    /// The value that is none.
    Null,
}

/// Reason why text is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// The text is no JSON.
    Syntax,
    /// Arrays and objects are nested too deep.
    Depth,
    /// A key is too long.
    Key,
    /// A number is too long, or out of range.
    Number,
}

/// Place in the grammar.
#[derive(Clone, Copy, Debug)]
enum Place {
    Value,
    /// Value, or the end of an array.
    FirstValue,
    Key,
    /// Key, or the end of an object.
    FirstKey,
    Colon,
    /// Comma, or the end of what is open.
    Behind,
    Text,
    Escape,
    /// Digits of an escape, so many of which have come, and their value.
    Hex(u8, u16),
    Number(Reader),
    /// Word of which so many letters have come.
    Word(Word, u8),
    Broken(Error),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Word {
    True,
    False,
    Null,
}

impl Word {
    const fn text(self) -> &'static [u8] {
        match self {
            Self::True => b"true",
            Self::False => b"false",
            Self::Null => b"null",
        }
    }
}

/// Effect of a byte on the tokens.
enum Step {
    /// The byte is taken.
    On,
    /// A token ends with the byte.
    Token(Ended),
    /// A token ended before the byte, which is not taken.
    Before(Ended),
}

/// Token without its text, which is in the buffer.
enum Ended {
    BeginObject,
    EndObject,
    BeginArray,
    EndArray,
    Key,
    Text(bool),
    Number(Number),
    Word(Word),
}

/// Parser of one JSON text.
#[derive(Clone, Debug)]
pub struct Parser {
    place: Place,
    /// A bit for each array (0) or object (1) that is open, the innermost one lowest.
    open: u16,
    depth: u8,
    buffer: [u8; KEY_BYTES + CHARACTER],
    length: u8,
    /// Whether the buffer's text has been handed out.
    is_told: bool,
    is_key: bool,
    check: Utf8,
    /// First half of a pair of escapes; 0 if there is none.
    high: u16,
}

impl Default for Parser {
    fn default() -> Self {
        Self::new()
    }
}

impl Parser {
    /// Makes a parser for a text that begins.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            place: Place::Value,
            open: 0,
            depth: 0,
            buffer: [0; KEY_BYTES + CHARACTER],
            length: 0,
            is_told: false,
            is_key: false,
            check: Utf8::new(),
            high: 0,
        }
    }

    /// Returns how many arrays and objects are open.
    #[must_use]
    pub fn depth(&self) -> usize {
        usize::from(self.depth)
    }

    /// Returns the next token, and takes its bytes from `input`. None when there are no more bytes: the text
    /// goes on with the next piece.
    ///
    /// # Errors
    /// The text is not taken; this stays so.
    pub fn next(&mut self, input: &mut &[u8]) -> Result<Option<Token<'_>>, Error> {
        while let Some((byte, rest)) = input.split_first() {
            let ended = match self.step(*byte) {
                Ok(Step::Before(ended)) => ended,
                Ok(Step::Token(ended)) => {
                    *input = rest;
                    ended
                }
                Ok(Step::On) => {
                    *input = rest;
                    continue;
                }
                Err(error) => {
                    self.place = Place::Broken(error);
                    return Err(error);
                }
            };
            return Ok(Some(self.token(ended)));
        }
        Ok(None)
    }

    /// Ends the text. A number may end with it, which is returned.
    ///
    /// # Errors
    /// The text is not whole.
    pub fn finish(&mut self) -> Result<Option<Number>, Error> {
        let number = match self.place {
            Place::Behind if self.depth == 0 => return Ok(None),
            Place::Number(reader) if self.depth == 0 => reader.end().ok_or(Error::Syntax)?,
            Place::Broken(error) => return Err(error),
            _ => return Err(Error::Syntax),
        };
        self.place = Place::Behind;
        Ok(Some(number))
    }

    fn token(&mut self, ended: Ended) -> Token<'_> {
        let text = self.buffer.get(..usize::from(self.length)).unwrap_or_default();
        let text = core::str::from_utf8(text).unwrap_or_default();
        self.is_told = true;
        match ended {
            Ended::BeginObject => Token::BeginObject,
            Ended::EndObject => Token::EndObject,
            Ended::BeginArray => Token::BeginArray,
            Ended::EndArray => Token::EndArray,
            Ended::Key => Token::Key(text),
            Ended::Text(is_last) => Token::Text(text, is_last),
            Ended::Number(number) => Token::Number(number),
            Ended::Word(Word::True) => Token::Bool(true),
            Ended::Word(Word::False) => Token::Bool(false),
            Ended::Word(Word::Null) => Token::Null,
        }
    }

    fn step(&mut self, byte: u8) -> Result<Step, Error> {
        if core::mem::take(&mut self.is_told) {
            self.length = 0;
        }
        let is_between = matches!(
            self.place,
            Place::Value | Place::FirstValue | Place::Key | Place::FirstKey | Place::Colon | Place::Behind
        );
        if is_between && matches!(byte, b' ' | b'\t' | b'\n' | b'\r') {
            return Ok(Step::On);
        }
        match (self.place, byte) {
            (Place::FirstValue, b']') | (Place::FirstKey, b'}') => Ok(self.close()),
            (Place::Value | Place::FirstValue, _) => self.begin_value(byte),
            (Place::Key | Place::FirstKey, b'"') => Ok(self.begin_text(true)),
            (Place::Colon, b':') => Ok(self.go(Place::Value)),
            (Place::Behind, b',') if self.depth > 0 => {
                Ok(self.go(if self.open & 1 != 0 { Place::Key } else { Place::Value }))
            }
            (Place::Behind, b']') if self.depth > 0 && self.open & 1 == 0 => Ok(self.close()),
            (Place::Behind, b'}') if self.depth > 0 && self.open & 1 != 0 => Ok(self.close()),
            (Place::Text, _) => self.text(byte),
            (Place::Escape, _) => self.escape(byte),
            (Place::Hex(digits, value), _) => self.hex(digits, value, byte),
            (Place::Number(reader), _) => self.number(reader, byte),
            (Place::Word(word, letters), _) => self.word(word, letters, byte),
            (Place::Broken(error), _) => Err(error),
            _ => Err(Error::Syntax),
        }
    }

    fn go(&mut self, place: Place) -> Step {
        self.place = place;
        Step::On
    }

    fn begin_value(&mut self, byte: u8) -> Result<Step, Error> {
        match byte {
            b'{' => self.open(true),
            b'[' => self.open(false),
            b'"' => Ok(self.begin_text(false)),
            b't' => Ok(self.go(Place::Word(Word::True, 1))),
            b'f' => Ok(self.go(Place::Word(Word::False, 1))),
            b'n' => Ok(self.go(Place::Word(Word::Null, 1))),
            _ => Reader::begin(byte).map(|reader| self.go(Place::Number(reader))).ok_or(Error::Syntax),
        }
    }

    fn open(&mut self, is_object: bool) -> Result<Step, Error> {
        if self.depth() >= DEPTH {
            return Err(Error::Depth);
        }
        self.depth += 1;
        self.open = self.open << 1 | u16::from(is_object);
        self.place = if is_object { Place::FirstKey } else { Place::FirstValue };
        Ok(Step::Token(if is_object { Ended::BeginObject } else { Ended::BeginArray }))
    }

    fn close(&mut self) -> Step {
        let is_object = self.open & 1 != 0;
        self.open >>= 1;
        self.depth -= 1;
        self.place = Place::Behind;
        Step::Token(if is_object { Ended::EndObject } else { Ended::EndArray })
    }

    fn begin_text(&mut self, is_key: bool) -> Step {
        (self.is_key, self.length, self.high) = (is_key, 0, 0);
        self.go(Place::Text)
    }

    fn text(&mut self, byte: u8) -> Result<Step, Error> {
        let is_between = self.check.is_whole();
        if self.high != 0 && byte != b'\\' {
            return Err(Error::Syntax);
        }
        if is_between && usize::from(self.length) > KEY_BYTES && byte != b'"' {
            return if self.is_key { Err(Error::Key) } else { Ok(Step::Before(Ended::Text(false))) };
        }
        match byte {
            b'"' if is_between => self.end_text(),
            b'\\' if is_between => Ok(self.go(Place::Escape)),
            0..=0x1F => Err(Error::Syntax),
            _ if self.check.push(byte) => {
                self.push(byte);
                Ok(Step::On)
            }
            _ => Err(Error::Syntax),
        }
    }

    fn end_text(&mut self) -> Result<Step, Error> {
        if self.is_key && usize::from(self.length) > KEY_BYTES {
            return Err(Error::Key);
        }
        self.place = if self.is_key { Place::Colon } else { Place::Behind };
        Ok(Step::Token(if self.is_key { Ended::Key } else { Ended::Text(true) }))
    }

    fn escape(&mut self, byte: u8) -> Result<Step, Error> {
        let byte = match byte {
            b'u' => return Ok(self.go(Place::Hex(0, 0))),
            b'"' | b'\\' | b'/' => byte,
            b'b' => 8,
            b'f' => 12,
            b'n' => b'\n',
            b'r' => b'\r',
            b't' => b'\t',
            _ => return Err(Error::Syntax),
        };
        if self.high != 0 {
            return Err(Error::Syntax);
        }
        self.push(byte);
        Ok(self.go(Place::Text))
    }

    fn hex(&mut self, digits: u8, value: u16, byte: u8) -> Result<Step, Error> {
        let digit = char::from(byte).to_digit(16).ok_or(Error::Syntax)?;
        let value = value << 4 | digit as u16;
        if digits < 3 {
            return Ok(self.go(Place::Hex(digits + 1, value)));
        }
        let unit = match (core::mem::take(&mut self.high), value) {
            (0, 0xD800..=0xDBFF) => {
                self.high = value;
                return Ok(self.go(Place::Text));
            }
            (0, _) => u32::from(value),
            (high, 0xDC00..=0xDFFF) => 0x1_0000 + (u32::from(high & 0x3FF) << 10 | u32::from(value & 0x3FF)),
            _ => return Err(Error::Syntax),
        };
        // Second halves without a first one are no characters.
        let character = char::from_u32(unit).ok_or(Error::Syntax)?;
        let mut bytes = [0; CHARACTER];
        character.encode_utf8(&mut bytes).bytes().for_each(|byte| self.push(byte));
        Ok(self.go(Place::Text))
    }

    fn push(&mut self, byte: u8) {
        if let Some(place) = self.buffer.get_mut(usize::from(self.length)) {
            *place = byte;
            self.length += 1;
        }
    }

    fn number(&mut self, mut reader: Reader, byte: u8) -> Result<Step, Error> {
        if reader.push(byte) {
            return if reader.is_too_long() { Err(Error::Number) } else { Ok(self.go(Place::Number(reader))) };
        }
        let number = reader.end().ok_or(Error::Syntax)?;
        self.place = Place::Behind;
        Ok(Step::Before(Ended::Number(number)))
    }

    fn word(&mut self, word: Word, letters: u8, byte: u8) -> Result<Step, Error> {
        if word.text().get(usize::from(letters)) != Some(&byte) {
            return Err(Error::Syntax);
        }
        if usize::from(letters) + 1 < word.text().len() {
            return Ok(self.go(Place::Word(word, letters + 1)));
        }
        self.place = Place::Behind;
        Ok(Step::Token(Ended::Word(word)))
    }
}

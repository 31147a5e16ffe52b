//! Python literals, as Klipper keeps values of variables: read and written.

use crate::environment::Nothing;
use crate::fault::{Error, Fault, Result, fail};
use crate::lexer::{Lexer, Token};
use crate::memory::{Memory, Text};
use crate::run::{DEEPEST, Run, TOO_DEEP};
use crate::value::{Map, SIZE, Seq, Value};

/// Reads a literal.
pub fn read(memory: &mut Memory<'_>, source: &mut dyn Iterator<Item = u8>) -> Result<Value> {
    let mut reader = Reader { lexer: Lexer::of_literal(source), token: Token::End };
    reader.advance(memory)?;
    let value = reader.values(memory, Token::End, Seq::Tuple, DEEPEST)?;
    if reader.token == Token::End { Ok(value) } else { fail("something stands behind the value") }
}

/// Writes a Python literal as Python would write it, as in the file of saved variables. Returns the length of
/// what was written into `output`.
///
/// # Errors
///
/// The text is no literal of numbers, strings, truth values, `None`, lists, tuples and dicts; memory or output
/// are too small.
pub fn rewrite(text: &str, memory: &mut [u8], output: &mut [u8]) -> core::result::Result<usize, Error> {
    let mut machine = Nothing;
    let mut memory = Memory::new(memory);
    memory.is_sealed = true;
    let mut run = Run { memory, machine: &mut machine, given: 0 };
    let written = read(&mut run.memory, &mut text.bytes()).and_then(|value| run.to_repr(value));
    let result = written.and_then(|text| match output.get_mut(..usize::from(text.len)) {
        Some(place) => {
            place.copy_from_slice(run.memory.bytes(text));
            Ok(place.len())
        }
        None => fail("the value is too long to be kept"),
    });
    result.map_err(|fault| Error::new(fault, (1, 1), &run.memory))
}

struct Reader<'s> {
    lexer: Lexer<'s>,
    token: Token,
}

impl Reader<'_> {
    fn advance(&mut self, memory: &mut Memory<'_>) -> Result<()> {
        self.token = self.lexer.next(memory)?;
        Ok(())
    }

    /// Values up to an end; one alone stays as it is, if it is no list.
    fn values(&mut self, memory: &mut Memory<'_>, end: Token, kind: Seq, depth: u8) -> Result<Value> {
        let head = memory.new_block(0, SIZE)?;
        let mut is_one = false;
        while self.token != end {
            let value = self.value(memory, depth)?;
            let at = memory.grow(head, SIZE)?;
            memory.set_value(at, value);
            is_one = memory.block(head).len == 1 && self.token != Token::Sign(b',');
            if self.token != Token::Sign(b',') {
                break;
            }
            self.advance(memory)?;
        }
        if self.token != end {
            return fail("a value does not end where it should: see the brackets and commas");
        }
        if kind == Seq::Tuple && is_one {
            return Ok(memory.value(memory.block(head).data));
        }
        if end == Token::End && memory.block(head).len == 0 {
            return fail("a value is missing");
        }
        Ok(Value::Seq(kind, head))
    }

    fn value(&mut self, memory: &mut Memory<'_>, depth: u8) -> Result<Value> {
        if depth == 0 {
            return fail(TOO_DEEP);
        }
        let token = self.token;
        self.advance(memory)?;
        match token {
            Token::Int(value) => Ok(Value::Int(value)),
            Token::Float(value) => Ok(Value::Float(value)),
            Token::Str(text) => self.strings(memory, text),
            Token::Name(name) => match memory.bytes(name) {
                b"True" => Ok(Value::Bool(true)),
                b"False" => Ok(Value::Bool(false)),
                b"None" => Ok(Value::None),
                _ => Err(Fault::about("this is no value: a text has to stand in quotes", name)),
            },
            Token::Sign(sign @ (b'-' | b'+')) => self.signed(memory, sign == b'-'),
            Token::Sign(b'[') => {
                let value = self.values(memory, Token::Sign(b']'), Seq::List, depth - 1)?;
                self.advance(memory)?;
                Ok(value)
            }
            Token::Sign(b'(') => {
                let value = self.values(memory, Token::Sign(b')'), Seq::Tuple, depth - 1)?;
                self.advance(memory)?;
                Ok(value)
            }
            Token::Sign(b'{') => self.dict(memory, depth - 1),
            _ => fail("a value is missing: a text has to stand in quotes"),
        }
    }

    /// Strings that follow each other are one.
    fn strings(&mut self, memory: &mut Memory<'_>, first: Text) -> Result<Value> {
        let mut text = first;
        while let Token::Str(more) = self.token {
            let from = memory.top;
            memory.push_text(text)?;
            memory.push_text(more)?;
            text = memory.text_since(from);
            self.advance(memory)?;
        }
        Ok(Value::Str(text))
    }

    fn signed(&mut self, memory: &mut Memory<'_>, is_negative: bool) -> Result<Value> {
        let token = self.token;
        self.advance(memory)?;
        match token {
            Token::Int(value) => Ok(Value::Int(if is_negative { -value } else { value })),
            Token::Float(value) => Ok(Value::Float(if is_negative { -value } else { value })),
            _ => fail("a number is missing behind the sign"),
        }
    }

    fn dict(&mut self, memory: &mut Memory<'_>, depth: u8) -> Result<Value> {
        let head = memory.new_block(0, 2 * SIZE)?;
        while self.token != Token::Sign(b'}') {
            let key = self.value(memory, depth)?;
            if self.token != Token::Sign(b':') {
                return fail("a : is missing behind the key of a dict");
            }
            self.advance(memory)?;
            let value = self.value(memory, depth)?;
            put(memory, head, key, value)?;
            if self.token != Token::Sign(b',') {
                break;
            }
            self.advance(memory)?;
        }
        if self.token != Token::Sign(b'}') {
            return fail("a } is missing behind a dict");
        }
        self.advance(memory)?;
        Ok(Value::Map(Map::Dict, head))
    }
}

/// Writes an entry; the last of a key stays.
fn put(memory: &mut Memory<'_>, head: u16, key: Value, value: Value) -> Result<()> {
    let mut nothing = Nothing;
    let lent = core::mem::replace(memory, Memory::new(&mut []));
    let mut run = Run { memory: lent, machine: &mut nothing, given: 0 };
    let result = run.put(head, key, value);
    drop(core::mem::replace(memory, run.memory));
    result
}

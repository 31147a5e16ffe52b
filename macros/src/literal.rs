//! Python literals, as Klipper keeps values of variables: read and written.

use crate::fault::{Fault, Result, Words};
use crate::lexer::{Lexer, Token};
use crate::memory::{Memory, Text};
use crate::number::{float, number};
use crate::value::{DEEPEST, Map, SIZE, Seq, Value, View};

/// Reads a literal into memory; fails if the text is none.
pub fn read(memory: &mut Memory<'_>, source: &mut dyn Iterator<Item = u8>) -> Result<Value> {
    let mut reader = Reader { lexer: Lexer::of_literal(source), token: Token::End };
    reader.advance(memory)?;
    let value = reader.values(memory, Token::End, Seq::Tuple, DEEPEST)?;
    if reader.token == Token::End { Ok(value) } else { memory.fail(Words::LiteralRest) }
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
        let head = memory.new_list();
        let mut is_one = false;
        while self.token != end {
            let value = self.value(memory, depth)?;
            let at = memory.grow(head, SIZE);
            memory.set_value(at, value);
            is_one = memory.count(head) == 1 && self.token != Token::Sign(b',');
            if self.token != Token::Sign(b',') {
                break;
            }
            self.advance(memory)?;
        }
        if self.token != end {
            return memory.fail(Words::LiteralEnd);
        }
        if kind == Seq::Tuple && is_one {
            return Ok(memory.element(head, 0));
        }
        if end == Token::End && memory.count(head) == 0 {
            return memory.fail(Words::LiteralWord);
        }
        Ok(Value::seq(kind, head))
    }

    fn value(&mut self, memory: &mut Memory<'_>, depth: u8) -> Result<Value> {
        if depth == 0 {
            return memory.fail(Words::TooDeep);
        }
        let token = self.token;
        self.advance(memory)?;
        match token {
            Token::Int(value) => Ok(memory.int(value)),
            Token::Float(value) => Ok(Value::float(value)),
            Token::Str(text) => self.strings(memory, text),
            Token::Name(name) => match memory.bytes(name) {
                b"True" => Ok(Value::bool(true)),
                b"False" => Ok(Value::bool(false)),
                b"None" => Ok(Value::NONE),
                _ => Err(Fault::about(memory, Words::LiteralWord, name)),
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
            _ => memory.fail(Words::LiteralWord),
        }
    }

    /// Strings that follow each other are one.
    fn strings(&mut self, memory: &mut Memory<'_>, first: Text) -> Result<Value> {
        let mut text = first;
        while let Token::Str(more) = self.token {
            let from = memory.top;
            memory.push_text(text);
            memory.push_text(more);
            text = memory.text_since(from);
            self.advance(memory)?;
        }
        Ok(Value::str(text))
    }

    fn signed(&mut self, memory: &mut Memory<'_>, is_negative: bool) -> Result<Value> {
        let token = self.token;
        self.advance(memory)?;
        match token {
            Token::Int(value) => Ok(memory.int(if is_negative { -value } else { value })),
            Token::Float(value) => Ok(Value::float(if is_negative { -value } else { value })),
            _ => memory.fail(Words::NumberMissing),
        }
    }

    fn dict(&mut self, memory: &mut Memory<'_>, depth: u8) -> Result<Value> {
        let head = memory.new_block(0, 2 * SIZE);
        while self.token != Token::Sign(b'}') {
            let key = self.value(memory, depth)?;
            if self.token != Token::Sign(b':') {
                return memory.fail(Words::LiteralEnd);
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
            return memory.fail(Words::LiteralEnd);
        }
        self.advance(memory)?;
        Ok(Value::map(Map::Dict, head))
    }
}

/// Writes an entry of a dict; the last of a key stays. Keys are strings, numbers and words, as in JSON.
fn put(memory: &mut Memory<'_>, head: u16, key: Value, value: Value) -> Result<()> {
    if matches!(key.view(), View::Seq(..) | View::Map(..)) {
        return memory.fail(Words::LiteralKey);
    }
    let known = (0..memory.count(head))
        .map(|index| memory.place(head, index, 2 * SIZE))
        .find(|at| is_same(memory, memory.value(*at), key));
    let at = match known {
        Some(at) => at,
        None => {
            let at = memory.grow(head, 2 * SIZE);
            memory.set_value(at, key);
            at
        }
    };
    memory.set_value(at + SIZE, value);
    Ok(())
}

fn is_same(memory: &Memory<'_>, a: Value, b: Value) -> bool {
    if let (Some(a), Some(b)) = (a.text(), b.text()) {
        return memory.bytes(a) == memory.bytes(b);
    }
    let real = |value| number(memory, value).map(float);
    a.is_none() && b.is_none() || real(a).is_some() && real(a) == real(b)
}

//! Names, literals, and what stands behind a value in brackets or after a point.

use super::Parser;
use super::expressions::Form;
use crate::code::Op;
use crate::fault::{Result, Words};
use crate::lexer::Token;
use crate::memory::Text;
use crate::names;

/// Words that are values.
pub const CONSTANTS: names::Table = "none|None ;true|True ;false|False ;";

impl Parser<'_, '_, '_> {
    /// A name, a literal, or an expression in parentheses.
    pub fn primary(&mut self) -> Result<()> {
        match self.token {
            Token::Name(name) => {
                self.advance()?;
                match names::find(CONSTANTS, self.memory.bytes(name)) {
                    // Instructions of constants have the order of their names.
                    Some(number) => {
                        self.memory.push_byte(Op::None as u8 + number);
                        Ok(())
                    }
                    None => {
                        self.emit_word(Op::Load, name.at() as u16);
                        Ok(())
                    }
                }
            }
            Token::Str(text) => self.strings(text),
            Token::Int(value) => {
                self.advance()?;
                self.integer(value);
                Ok(())
            }
            Token::Float(value) => {
                self.advance()?;
                self.emit(Op::Float);
                self.memory.push_bytes(&value.to_le_bytes());
                Ok(())
            }
            Token::Sign(b'(') => {
                self.advance()?;
                self.tuple(Form { in_parentheses: true, is_bare: false })?;
                self.expect(Token::Sign(b')'), Words::ParenthesisMissing)
            }
            Token::Sign(b'[') => self.list(),
            Token::Sign(b'{') => self.dict(),
            _ => Err(self.unexpected(Words::ValueMissing)),
        }
    }

    fn integer(&mut self, value: i64) {
        if let Ok(small) = u16::try_from(value) {
            return self.emit_word(Op::Small, small);
        }
        self.emit(Op::Int);
        self.memory.push_bytes(&value.to_le_bytes())
    }

    /// Strings that follow each other are one.
    fn strings(&mut self, first: Text) -> Result<()> {
        self.advance()?;
        self.emit_word(Op::Str, first.at() as u16);
        while let Token::Str(text) = self.token {
            self.advance()?;
            self.emit_word(Op::Str, text.at() as u16);
            self.emit(Op::Join);
        }
        Ok(())
    }

    fn list(&mut self) -> Result<()> {
        self.advance()?;
        let mut count = 0;
        while self.token != Token::Sign(b']') {
            if count > 0 {
                self.expect(Token::Sign(b','), Words::CommaOrBracket)?;
            }
            if self.token == Token::Sign(b']') {
                break;
            }
            self.expression()?;
            count += 1;
        }
        self.advance()?;
        self.emit_word(Op::List, count);
        Ok(())
    }

    fn dict(&mut self) -> Result<()> {
        self.advance()?;
        let mut count = 0;
        while self.token != Token::Sign(b'}') {
            if count > 0 {
                self.expect(Token::Sign(b','), Words::CommaOrBrace)?;
            }
            if self.token == Token::Sign(b'}') {
                break;
            }
            self.expression()?;
            self.expect(Token::Sign(b':'), Words::ColonMissing)?;
            self.expression()?;
            count += 1;
        }
        self.advance()?;
        self.emit_word(Op::Dict, count);
        Ok(())
    }

    /// Attributes, subscripts and calls behind a value.
    pub fn postfix(&mut self) -> Result<()> {
        loop {
            match self.token {
                Token::Sign(b'.') => self.attribute()?,
                Token::Sign(b'[') => self.subscript()?,
                Token::Sign(b'(') => self.call()?,
                _ => return Ok(()),
            }
        }
    }

    fn attribute(&mut self) -> Result<()> {
        self.advance()?;
        match self.token {
            Token::Name(name) => {
                self.advance()?;
                if self.token != Token::Sign(b'(') {
                    self.emit_word(Op::Attribute, name.at() as u16);
                    return Ok(());
                }
                let count = self.arguments()?;
                self.emit_word(Op::Method, name.at() as u16);
                self.memory.push_byte(count);
                Ok(())
            }
            Token::Int(number) => {
                self.advance()?;
                self.integer(number);
                self.emit(Op::Item);
                Ok(())
            }
            _ => Err(self.unexpected(Words::NameMissing)),
        }
    }

    fn subscript(&mut self) -> Result<()> {
        self.advance()?;
        let mut count = 0;
        let mut is_slice = false;
        while self.token != Token::Sign(b']') {
            if count > 0 {
                self.expect(Token::Sign(b','), Words::BracketMissing)?;
            }
            is_slice |= self.index()?;
            count += 1;
        }
        self.advance()?;
        if count == 1 {
            self.emit(if is_slice { Op::Slice } else { Op::Item });
            return Ok(());
        }
        if is_slice {
            return self.memory.fail(Words::SliceAlone);
        }
        self.emit_word(Op::Tuple, count);
        self.emit(Op::Item);
        Ok(())
    }

    /// An index, or the three parts of a slice; returns whether it was one.
    fn index(&mut self) -> Result<bool> {
        let colon = Token::Sign(b':');
        if self.token == colon {
            self.emit(Op::None);
        } else {
            self.expression()?;
            if self.token != colon {
                return Ok(false);
            }
        }
        self.advance()?;
        self.bound()?;
        if self.token == colon {
            self.advance()?;
            self.bound()?;
        } else {
            self.emit(Op::None);
        }
        Ok(true)
    }

    fn bound(&mut self) -> Result<()> {
        if matches!(self.token, Token::Sign(b':' | b']' | b',')) {
            {
                self.emit(Op::None);
                Ok(())
            }
        } else {
            self.expression()
        }
    }
}

//! Calls, filters and tests.

use super::Parser;
use crate::code::Op;
use crate::fault::{Fault, Result, Words};
use crate::lexer::{self, Token};
use crate::memory::Text;
use crate::names::{self, Filter, Test};

impl Parser<'_, '_, '_> {
    /// A call of the value before it.
    pub fn call(&mut self) -> Result<()> {
        let count = self.arguments()?;
        self.emit(Op::Call);
        self.memory.push_byte(count);
        Ok(())
    }

    /// Arguments in parentheses; returns how many.
    pub fn arguments(&mut self) -> Result<u8> {
        self.advance()?;
        let mut count: u8 = 0;
        let mut has_names = false;
        while self.token != Token::Sign(b')') {
            if count > 0 {
                self.expect(Token::Sign(b','), Words::CommaOrParenthesis)?;
                if self.token == Token::Sign(b')') {
                    break;
                }
            }
            if let Token::Sign(sign @ (b'*' | lexer::POWER)) = self.token {
                self.advance()?;
                self.expression()?;
                self.emit(if sign == b'*' { Op::Spread } else { Op::SpreadNamed });
                has_names = true;
                count = count.saturating_add(1);
                continue;
            }
            let next = self.peek_argument_name()?;
            if let Some(name) = next {
                self.advance()?;
                self.advance()?;
                self.expression()?;
                self.emit_word(Op::Keyword, name.at() as u16);
                has_names = true;
            } else if has_names {
                return self.memory.fail(Words::NamesLast);
            } else {
                self.expression()?;
            }
            count = count.saturating_add(1);
        }
        self.advance()?;
        Ok(count)
    }

    fn peek_argument_name(&mut self) -> Result<Option<Text>> {
        let Token::Name(name) = self.token else { return Ok(None) };
        Ok((self.peek()? == Token::Sign(b'=')).then_some(name))
    }

    /// Filters, tests and calls behind a value.
    pub fn filters_and_tests(&mut self) -> Result<()> {
        loop {
            match self.token {
                Token::Sign(b'|') => self.filter()?,
                Token::Sign(b'(') => self.call()?,
                Token::Name(name) if self.memory.is(name, "is") => self.test()?,
                _ => return Ok(()),
            }
        }
    }

    /// A filter behind its `|`.
    pub fn filter(&mut self) -> Result<()> {
        self.advance()?;
        let name = self.expect_name(Words::NameMissing)?;
        let mut is_known = true;
        while self.skip_sign(b'.')? {
            self.expect_name(Words::NameMissing)?;
            is_known = false;
        }
        let count = if self.token == Token::Sign(b'(') { self.arguments()? } else { 0 };
        match names::find(Filter::NAMES, self.memory.bytes(name)) {
            Some(number) if is_known => {
                self.emit_word(Op::Filter, u16::from(number) | u16::from(count) << 8);
                Ok(())
            }
            _ => self.unknown(Fault::about(self.memory, Words::NoFilter, name), name),
        }
    }

    fn unknown(&mut self, fault: Fault, name: Text) -> Result<()> {
        if !self.is_soft && self.unknown.is_none() {
            self.unknown = Some((self.memory.top, fault));
        }
        self.emit_word(Op::Unknown, name.at() as u16);
        Ok(())
    }

    /// A test behind its `is`.
    fn test(&mut self) -> Result<()> {
        self.advance()?;
        let is_negated = self.skip_name("not")?;
        let name = self.expect_name(Words::NameMissing)?;
        let count = match self.token {
            Token::Sign(b'(') => self.arguments()?,
            Token::Name(next) if matches!(self.memory.bytes(next), b"else" | b"or" | b"and") => 0,
            Token::Name(next) if self.memory.is(next, "is") => {
                return self.memory.fail(Words::TwoTests);
            }
            Token::Name(_) | Token::Str(_) | Token::Int(_) | Token::Float(_) | Token::Sign(b'[' | b'{') => {
                self.primary()?;
                self.postfix()?;
                1
            }
            _ => 0,
        };
        match names::find(Test::NAMES, self.memory.bytes(name)) {
            Some(number) => self.emit_word(Op::Test, u16::from(number) | u16::from(count) << 8),
            None => self.unknown(Fault::about(self.memory, Words::NoTest, name), name)?,
        }
        if is_negated {
            {
                self.emit(Op::Not);
                Ok(())
            }
        } else {
            Ok(())
        }
    }
}

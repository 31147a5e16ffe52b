//! Templates to code, in one pass without a tree.

mod calls;
mod expressions;
mod primary;
mod statements;
mod tags;
mod targets;

use crate::code::{self, Op};
use crate::fault::{About, Fault, Result, Words};
use crate::lexer::{Lexer, Token};
use crate::memory::{Memory, Text};
use tags::Tags;

/// Most expressions within expressions, each operator and each bracket one.
const DEEPEST: u8 = 32;

/// Reads a template and writes its code.
pub struct Parser<'m, 'a, 's> {
    memory: &'m mut Memory<'a>,
    lexer: Lexer<'s>,
    token: Token,
    ahead: Option<(Token, (u16, u16))>,
    /// Line and column of the current token.
    pub place: (u16, u16),
    depth: u8,
    tags: Tags,
    /// Whether a name of a filter may be wrong until it is used, as within `if`.
    is_soft: bool,
    /// Place in the code of a filter or test that does not exist, and its fault.
    unknown: Option<(usize, Fault)>,
}

impl<'m, 'a, 's> Parser<'m, 'a, 's> {
    /// A parser that writes into memory.
    pub fn new(memory: &'m mut Memory<'a>, lexer: Lexer<'s>) -> Self {
        let token = Token::End;
        Self {
            memory,
            lexer,
            token,
            ahead: None,
            place: (1, 1),
            depth: 0,
            tags: Tags::NONE,
            is_soft: false,
            unknown: None,
        }
    }

    fn advance(&mut self) -> Result<Token> {
        let old = self.token;
        match self.ahead.take() {
            Some((token, place)) => (self.token, self.place) = (token, place),
            None => {
                let next = self.lexer.next(self.memory);
                self.place = self.lexer.place;
                self.token = next?;
            }
        }
        Ok(old)
    }

    /// The token behind the current one.
    fn peek(&mut self) -> Result<Token> {
        if let Some((token, _)) = self.ahead {
            return Ok(token);
        }
        let next = self.lexer.next(self.memory);
        let token = next.inspect_err(|_| self.place = self.lexer.place)?;
        self.ahead = Some((token, self.lexer.place));
        Ok(token)
    }

    fn is_name(&self, token: Token, word: &str) -> bool {
        matches!(token, Token::Name(name) if self.memory.is(name, word))
    }

    fn at_name(&self, word: &str) -> bool {
        self.is_name(self.token, word)
    }

    fn skip_name(&mut self, word: &str) -> Result<bool> {
        let is = self.at_name(word);
        if is {
            self.advance()?;
        }
        Ok(is)
    }

    fn skip_sign(&mut self, sign: u8) -> Result<bool> {
        let is = self.token == Token::Sign(sign);
        if is {
            self.advance()?;
        }
        Ok(is)
    }

    fn expect(&mut self, token: Token, words: Words) -> Result<()> {
        if self.token != token {
            return Err(self.unexpected(words));
        }
        self.advance().map(drop)
    }

    fn expect_name(&mut self, words: Words) -> Result<Text> {
        match self.token {
            Token::Name(name) => {
                self.advance()?;
                Ok(name)
            }
            _ => Err(self.unexpected(words)),
        }
    }

    /// The fault that the current token is another one than it should be.
    fn unexpected(&self, words: Words) -> Fault {
        let about = match self.token {
            Token::Name(text) | Token::Str(text) => About::Text(text),
            Token::Sign(sign) => About::Byte(sign & 0x7f),
            Token::OutputEnd => About::Byte(b'}'),
            Token::TagEnd => About::Word("%}"),
            Token::Int(_) | Token::Float(_) => About::Word("number"),
            Token::End => About::Word("end of the template"),
            Token::Data(_) | Token::OutputBegin | Token::TagBegin => About::Nothing,
        };
        Fault::with(self.memory, words, about)
    }

    fn emit(&mut self, op: Op) {
        code::emit(self.memory, op)
    }

    fn emit_word(&mut self, op: Op, word: u16) {
        code::emit_word(self.memory, op, word)
    }

    fn emit_jump(&mut self, op: Op) -> u16 {
        code::emit_jump(self.memory, op)
    }

    /// Leads a jump to the code that follows.
    fn lead_here(&mut self, operand: u16) {
        let here = self.memory.top;
        code::lead(self.memory, operand, here as u16);
    }

    fn deeper(&mut self) -> Result<()> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return self.memory.fail(Words::Brackets);
        }
        Ok(())
    }
}

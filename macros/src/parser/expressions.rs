//! Expressions with operators, by the precedence of Jinja2.

use super::Parser;
use crate::code::Op;
use crate::fault::{Result, Words};
use crate::lexer::{self, Token};

/// Precedences, the weakest first.
const OR: u8 = 1;
const AND: u8 = 2;
const NOT: u8 = 3;
const COMPARE: u8 = 4;
const ADD: u8 = 5;
const JOIN: u8 = 6;
const MULTIPLY: u8 = 7;
const POWER: u8 = 8;

/// Forms of an expression that stands where more than one value may.
#[derive(Clone, Copy, Debug, Default)]
pub struct Form {
    /// Without `a if b else c`, as behind `if` and `in`.
    pub is_bare: bool,
    /// In parentheses, so that it may be empty.
    pub in_parentheses: bool,
}

impl Parser<'_, '_, '_> {
    /// Values with commas between them make a tuple; one value alone stays as it is.
    pub fn tuple(&mut self, form: Form) -> Result<()> {
        let mut count = 0;
        let mut is_tuple = false;
        while !self.at_end_of_tuple() {
            if form.is_bare {
                self.binary(OR)?
            } else {
                self.expression()?
            }
            count += 1;
            if !self.skip_sign(b',')? {
                break;
            }
            is_tuple = true;
        }
        if count == 0 && !form.in_parentheses {
            return Err(self.unexpected(Words::ValueMissing));
        }
        if is_tuple || count == 0 {
            self.emit_word(Op::Tuple, count);
        }
        Ok(())
    }

    fn at_end_of_tuple(&self) -> bool {
        matches!(self.token, Token::OutputEnd | Token::TagEnd | Token::Sign(b')'))
    }

    /// An expression with or without a condition.
    pub fn expression(&mut self) -> Result<()> {
        let start = self.memory.top;
        self.binary(OR)?;
        while self.skip_name("if")? {
            self.condition(start)?;
        }
        Ok(())
    }

    /// Behind the value and `if`: the condition goes before the value.
    fn condition(&mut self, start: usize) -> Result<()> {
        self.emit_jump(Op::Jump);
        let value = self.memory.top - start;
        self.binary(OR)?;
        self.emit_jump(Op::Unless);
        let end = self.memory.top;
        self.memory.rotate(start, end, value);
        let to_end = end.saturating_sub(2) as u16;
        self.lead_here(end.saturating_sub(value + 2) as u16);
        if self.skip_name("else")? {
            self.deeper()?;
            self.expression()?;
            self.depth -= 1;
        } else {
            self.emit(Op::Missing);
            self.memory.push_word(0);
        }
        self.lead_here(to_end);
        if self.unknown.is_some_and(|(at, _)| at >= start) {
            self.unknown = None;
        }
        Ok(())
    }

    /// Operators of at least a precedence.
    pub fn binary(&mut self, least: u8) -> Result<()> {
        self.deeper()?;
        if least <= NOT && self.at_name("not") {
            self.advance()?;
            self.binary(NOT)?;
            self.emit(Op::Not);
        } else {
            self.unary(true)?;
        }
        while let Some((level, op)) = self.operator()?
            && level >= least
        {
            match op {
                Op::And | Op::Or => {
                    self.advance()?;
                    let end = self.emit_jump(op);
                    self.binary(level + 1)?;
                    self.lead_here(end);
                }
                _ if level == COMPARE => self.comparison(op)?,
                _ => {
                    self.advance()?;
                    self.binary(level + 1)?;
                    self.emit(op);
                }
            }
        }
        self.depth -= 1;
        Ok(())
    }

    /// The operator that comes next, with its precedence.
    fn operator(&mut self) -> Result<Option<(u8, Op)>> {
        let found = match self.token {
            Token::Sign(sign) => match sign {
                lexer::EQUAL => (COMPARE, Op::Equal),
                lexer::UNEQUAL => (COMPARE, Op::Unequal),
                b'<' => (COMPARE, Op::Less),
                lexer::AT_MOST => (COMPARE, Op::AtMost),
                b'>' => (COMPARE, Op::Greater),
                lexer::AT_LEAST => (COMPARE, Op::AtLeast),
                b'+' => (ADD, Op::Add),
                b'-' => (ADD, Op::Subtract),
                b'~' => (JOIN, Op::Join),
                b'*' => (MULTIPLY, Op::Multiply),
                b'/' => (MULTIPLY, Op::Divide),
                lexer::FLOOR_DIVIDE => (MULTIPLY, Op::FloorDivide),
                b'%' => (MULTIPLY, Op::Modulo),
                lexer::POWER => (POWER, Op::Power),
                _ => return Ok(None),
            },
            Token::Name(name) => match self.memory.bytes(name) {
                b"or" => (OR, Op::Or),
                b"and" => (AND, Op::And),
                b"in" => (COMPARE, Op::In),
                b"not" => {
                    let next = self.peek()?;
                    if !self.is_name(next, "in") {
                        return Ok(None);
                    }
                    (COMPARE, Op::NotIn)
                }
                _ => return Ok(None),
            },
            _ => return Ok(None),
        };
        Ok(Some(found))
    }

    /// Comparisons, of which each compares with the value before it: `a < b < c`.
    fn comparison(&mut self, first: Op) -> Result<()> {
        let mut op = first;
        let mut ends = 0;
        loop {
            self.advance()?;
            if op == Op::NotIn {
                self.advance()?;
            }
            self.binary(ADD)?;
            match self.operator()? {
                Some((COMPARE, next)) => {
                    self.emit(Op::Chain);
                    self.memory.push_byte(op as u8);
                    self.memory.push_word(ends);
                    ends = self.memory.top.saturating_sub(2) as u16;
                    op = next;
                }
                _ => break,
            }
        }
        self.emit(op);
        self.lead_all(ends);
        Ok(())
    }

    /// Leads jumps that hang on each other to the code that follows.
    pub fn lead_all(&mut self, mut chain: u16) {
        while chain != 0 && !self.memory.is_full {
            let next = self.memory.word(usize::from(chain));
            self.lead_here(chain);
            chain = next;
        }
    }

    /// A value with its sign, its subscripts and calls, and its filters and tests.
    pub fn unary(&mut self, with_filters: bool) -> Result<()> {
        self.deeper()?;
        if self.skip_sign(b'-')? {
            self.unary(false)?;
            self.emit(Op::Negative);
        } else if self.skip_sign(b'+')? {
            self.unary(false)?;
            self.emit(Op::Positive);
        } else {
            self.primary()?;
        }
        self.postfix()?;
        if with_filters {
            self.filters_and_tests()?;
        }
        self.depth -= 1;
        Ok(())
    }
}

//! Where values are stored: names, members of namespaces, and names within parentheses.

use super::Parser;
use super::primary::CONSTANTS;
use crate::code::Op;
use crate::fault::{Fault, Result, Words};
use crate::lexer::Token;
use crate::names;

impl Parser<'_, '_, '_> {
    /// Reads what stands before `=` or `in`, and writes the code that stores the last value there.
    pub fn targets(&mut self, is_loop: bool) -> Result<()> {
        let start = self.memory.top;
        if !self.target_list(is_loop)? {
            return Ok(());
        }
        // Variables that are new get their places before the parts of the value lie above them.
        let end = self.memory.top;
        let mut at = start;
        while at < end {
            match Op::from_byte(self.memory.byte(at)) {
                Op::StoreMember => at += 2,
                Op::Store => {
                    let name = self.memory.word(at + 1);
                    self.emit_word(Op::Declare, name);
                }
                _ => {}
            }
            at += 3;
        }
        self.memory.rotate(start, self.memory.top, end - start);
        Ok(())
    }

    /// Targets with commas between them; returns whether there were commas.
    fn target_list(&mut self, is_loop: bool) -> Result<bool> {
        let start = self.memory.top;
        let mut count = 0;
        let mut is_tuple = false;
        while count == 0 || !(self.at_name("in") || matches!(self.token, Token::Sign(b'=' | b')'))) {
            is_tuple |= self.target(is_loop)?;
            count += 1;
            if !self.skip_sign(b',')? {
                break;
            }
            if count == 1 {
                let length = self.memory.top - start;
                self.emit_word(Op::Unpack, 0);
                self.memory.rotate(start, self.memory.top, length);
                is_tuple = true;
            }
        }
        if Op::from_byte(self.memory.byte(start)) == Op::Unpack && is_tuple && self.memory.word(start + 1) == 0 {
            self.memory.set_word(start + 1, count);
        }
        Ok(is_tuple)
    }

    fn target(&mut self, is_loop: bool) -> Result<bool> {
        if self.skip_sign(b'(')? {
            self.deeper()?;
            let is_tuple = self.target_list(is_loop)?;
            self.depth -= 1;
            self.expect(Token::Sign(b')'), Words::ParenthesisMissing)?;
            return Ok(is_tuple);
        }
        let name = self.expect_name(Words::NameMissing)?;
        let is_of_loop = self.memory.is(name, "loop") && (is_loop || self.tags.has_loop());
        if is_of_loop || names::find(CONSTANTS, self.memory.bytes(name)).is_some() {
            return Err(Fault::about(self.memory, Words::NoTarget, name));
        }
        let name = name.at() as u16;
        if !is_loop && self.skip_sign(b'.')? {
            let member = self.expect_name(Words::NameMissing)?;
            self.emit_word(Op::StoreMember, name);
            self.memory.push_word(member.at() as u16);
        } else {
            self.emit_word(Op::Store, name);
        }
        Ok(false)
    }
}

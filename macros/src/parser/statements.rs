//! Tags: `if`, `for`, `set`, and which are refused.

use super::Parser;
use super::expressions::Form;
use super::tags::{Kind, Open, Tag};
use crate::code::{self, Op};
use crate::fault::{Fault, Result, Words};
use crate::lexer::Token;
use crate::names;

impl Parser<'_, '_, '_> {
    /// Reads the whole template.
    pub fn template(&mut self) -> Result<()> {
        self.advance()?;
        while !self.memory.is_full {
            let token = self.token;
            match token {
                Token::Data(text) => {
                    self.emit_word(Op::Text, text.at() as u16);
                    self.advance()?;
                    continue;
                }
                Token::OutputBegin | Token::TagBegin => {}
                _ => break,
            }
            self.mark(self.place);
            self.advance()?;
            let end = if token == Token::TagBegin {
                self.tag()?;
                (Token::TagEnd, Words::TagEnd)
            } else {
                self.tuple(Form::default())?;
                self.emit(Op::Emit);
                (Token::OutputEnd, Words::OutputEnd)
            };
            self.check_names()?;
            self.expect(end.0, end.1)?;
        }
        let open = self.tags.last();
        if open.kind != Kind::Template && !self.memory.is_full {
            self.place = open.place;
            return self.memory.fail(Words::NoEnd);
        }
        self.emit(Op::End);
        if self.memory.is_full { self.memory.fail(Words::NoMemory) } else { Ok(()) }
    }

    /// Notes the place of a tag in the code.
    fn mark(&mut self, (line, column): (u16, u16)) {
        self.emit_word(Op::At, line);
        self.memory.push_word(column)
    }

    fn check_names(&mut self) -> Result<()> {
        self.unknown.take().map_or(Ok(()), |(_, fault)| Err(fault))
    }

    fn tag(&mut self) -> Result<()> {
        let place = self.place;
        let name = self.expect_name(Words::NameMissing)?;
        let tag = names::find(Tag::NAMES, self.memory.bytes(name)).map(Tag::from_number);
        let words = match (tag, self.tags.last().kind) {
            (Some(Tag::If), _) => return self.begin_if(place),
            (Some(Tag::ElseIf), Kind::If) => return self.next_branch(true),
            (Some(Tag::Else), Kind::If) => return self.next_branch(false),
            (Some(Tag::EndIf), Kind::If | Kind::Else) => return self.end_if(),
            (Some(Tag::For), _) => return self.begin_for(place),
            (Some(Tag::Else), Kind::For) => return self.else_of_for(),
            (Some(Tag::EndFor), Kind::For | Kind::ForElse) => return self.end_for(),
            (Some(Tag::Set), _) => return self.set(place),
            (Some(Tag::EndSet), Kind::Set) => return self.end_set(),
            (Some(Tag::Refused), _) => Words::TagRefused,
            _ => Words::TagMisplaced,
        };
        self.place = place;
        Err(Fault::about(self.memory, words, name))
    }

    /// Begins what ends with a tag of its own. A `:` may stand before the end of the tag.
    fn open(&mut self, open: Open, is_soft: bool) -> Result<()> {
        self.check_names()?;
        self.is_soft = is_soft;
        self.skip_sign(b':')?;
        self.tags.push(self.memory, open)
    }

    /// A condition, and the jump where it does not hold.
    fn condition_of_branch(&mut self) -> Result<u16> {
        self.tuple(Form { is_bare: true, in_parentheses: false })?;
        Ok(self.emit_jump(Op::Unless))
    }

    fn begin_if(&mut self, place: (u16, u16)) -> Result<()> {
        let branch = self.condition_of_branch()?;
        self.open(Open { branch, ..Open::new(Kind::If, place, self.is_soft) }, true)
    }

    /// Ends a branch and begins that of `elif` or `else`.
    fn next_branch(&mut self, has_test: bool) -> Result<()> {
        let mut open = self.tags.pop();
        self.emit_word(Op::Jump, open.ends);
        open.ends = self.memory.top.saturating_sub(2) as u16;
        self.lead_here(open.branch);
        if has_test {
            self.mark(self.lexer.place);
            open.branch = self.condition_of_branch()?;
        } else {
            open.kind = Kind::Else;
        }
        self.skip_sign(b':')?;
        self.tags.push(self.memory, open)
    }

    fn end_if(&mut self) -> Result<()> {
        let open = self.tags.pop();
        if open.kind == Kind::If {
            self.lead_here(open.branch);
        }
        self.lead_all(open.ends);
        self.is_soft = open.was_soft;
        Ok(())
    }

    fn begin_for(&mut self, place: (u16, u16)) -> Result<()> {
        let start = self.memory.top;
        self.targets(true)?;
        let length = self.memory.top - start;
        if !self.skip_name("in")? {
            return Err(self.unexpected(Words::InMissing));
        }
        self.tuple(Form { is_bare: true, in_parentheses: false })?;
        self.emit(Op::ForBegin);
        let mut open = Open::new(Kind::For, place, self.is_soft);
        open.branch = self.emit_jump(Op::ForNext).saturating_sub(length as u16);
        open.again = open.branch.saturating_sub(1);
        self.memory.rotate(start, self.memory.top, length);
        if self.skip_name("if")? {
            self.expression()?;
            let passes = self.emit_jump(Op::Or);
            let back = self.emit_jump(Op::ForAgain);
            code::lead(self.memory, back, open.again);
            self.lead_here(passes);
            self.emit(Op::Drop);
        }
        if self.at_name("recursive") {
            return self.memory.fail(Words::Recursive);
        }
        let from = self.memory.top;
        self.memory.push_bytes(b"loop");
        let name = self.memory.intern(from);
        self.emit_word(Op::ForCount, name.at() as u16);
        self.open(open, false)
    }

    /// Ends the turns of a loop.
    fn end_turns(&mut self, open: Open) -> Result<u16> {
        let back = self.emit_jump(Op::ForAgain);
        code::lead(self.memory, back, open.again);
        self.lead_here(open.branch);
        Ok(self.emit_jump(Op::ForEnd))
    }

    fn else_of_for(&mut self) -> Result<()> {
        let mut open = self.tags.pop();
        open.branch = self.end_turns(open)?;
        open.kind = Kind::ForElse;
        self.emit(Op::FrameBegin);
        self.skip_sign(b':')?;
        self.tags.push(self.memory, open)
    }

    fn end_for(&mut self) -> Result<()> {
        let open = self.tags.pop();
        let end = if open.kind == Kind::For {
            self.end_turns(open)?
        } else {
            self.emit(Op::FrameEnd);
            open.branch
        };
        self.lead_here(end);
        self.is_soft = open.was_soft;
        Ok(())
    }

    fn set(&mut self, place: (u16, u16)) -> Result<()> {
        let start = self.memory.top;
        self.targets(false)?;
        let length = self.memory.top - start;
        if self.skip_sign(b'=')? {
            self.tuple(Form::default())?;
            self.memory.rotate(start, self.memory.top, length);
            return Ok(());
        }
        while self.token == Token::Sign(b'|') {
            self.filter()?;
        }
        self.memory.rotate(start, self.memory.top, length);
        let mut open = Open::new(Kind::Set, place, self.is_soft);
        (open.branch, open.again) = (start as u16, (self.memory.top - start) as u16);
        self.emit(Op::CaptureBegin);
        self.open(open, false)
    }

    /// The text that was caught goes through the filters, and is stored.
    fn end_set(&mut self) -> Result<()> {
        let open = self.tags.pop();
        self.emit(Op::CaptureEnd);
        self.memory.rotate(usize::from(open.branch), self.memory.top, usize::from(open.again));
        self.is_soft = open.was_soft;
        Ok(())
    }
}

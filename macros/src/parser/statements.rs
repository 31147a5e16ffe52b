//! Tags: `if`, `for`, `set`, and which are refused.

use super::Parser;
use super::expressions::Form;
use crate::code::{self, Op};
use crate::fault::{Fault, Result, Words};
use crate::lexer::Token;
use crate::memory::{Memory, Text};

/// Most tags within tags.
const MOST_OPEN: usize = 16;
/// Most names before the `=` of a set, or between `for` and `in`.
const MOST_TARGETS: usize = 8;

/// Tags of Jinja2 that Klipper's macros do without.
const REFUSED: &[&str] = &[
    "macro",
    "call",
    "include",
    "import",
    "from",
    "extends",
    "block",
    "filter",
    "with",
    "autoescape",
    "print",
    "raw",
    "do",
];

/// Tag that waits for its end.
#[derive(Clone, Copy, Debug)]
enum Kind {
    If,
    Else,
    For,
    ForElse,
    Set,
}

#[derive(Clone, Copy, Debug)]
struct Open {
    kind: Kind,
    place: (u16, u16),
    /// Operand of the jump to what follows this branch.
    branch: usize,
    /// Operands of the jumps to the end, which hang on each other.
    ends: u16,
    /// First instruction of each turn.
    again: usize,
    was_soft: bool,
    targets: Targets,
}

/// Targets of a value: variables, or members of namespaces.
#[derive(Clone, Copy, Debug, Default)]
struct Targets {
    list: [(u16, u16); MOST_TARGETS],
    count: usize,
    is_tuple: bool,
}

/// Tags that wait for their ends.
struct Stack {
    list: [Option<Open>; MOST_OPEN],
    count: usize,
}

impl Stack {
    fn push(&mut self, memory: &Memory<'_>, open: Open) -> Result<()> {
        let Some(place) = self.list.get_mut(self.count) else {
            return memory.fail(Words::TooManyTags);
        };
        *place = Some(open);
        self.count += 1;
        Ok(())
    }

    fn last(&self) -> Option<Open> {
        self.list.get(self.count.checked_sub(1)?).copied().flatten()
    }

    fn pop(&mut self) {
        self.count = self.count.saturating_sub(1);
    }

    fn has_loop(&self) -> bool {
        self.list.iter().take(self.count).flatten().any(|open| matches!(open.kind, Kind::For))
    }
}

impl Parser<'_, '_, '_> {
    /// Reads the whole template.
    pub fn template(&mut self) -> Result<()> {
        let mut stack = Stack { list: [None; MOST_OPEN], count: 0 };
        self.advance()?;
        loop {
            match self.token {
                Token::Data(text) => {
                    self.emit_word(Op::Text, text.at() as u16)?;
                    self.advance()?;
                }
                Token::OutputBegin => {
                    self.mark()?;
                    self.advance()?;
                    self.tuple(Form::default())?;
                    self.emit(Op::Emit)?;
                    self.check_names()?;
                    self.expect(Token::OutputEnd, Words::OutputEnd)?;
                }
                Token::TagBegin => {
                    self.mark()?;
                    self.advance()?;
                    self.tag(&mut stack)?;
                    self.check_names()?;
                    self.expect(Token::TagEnd, Words::TagEnd)?;
                }
                _ => break,
            }
        }
        if let Some(open) = stack.last() {
            self.place = open.place;
            return self.memory.fail(Words::NoEnd);
        }
        self.emit(Op::End)
    }

    /// Notes the place of a tag in the code.
    fn mark(&mut self) -> Result<()> {
        let (line, column) = self.place;
        self.emit_word(Op::At, line)?;
        self.memory.push_word(column)
    }

    fn check_names(&mut self) -> Result<()> {
        self.unknown.take().map_or(Ok(()), |(_, fault)| Err(fault))
    }

    fn tag(&mut self, stack: &mut Stack) -> Result<()> {
        let place = self.place;
        let name = self.expect_name(Words::NameMissing)?;
        let open = stack.last();
        match (self.memory.bytes(name), open.map(|open| open.kind)) {
            (b"if", _) => self.begin_if(stack, place),
            (b"elif", Some(Kind::If)) => self.next_branch(stack, true),
            (b"else", Some(Kind::If)) => self.next_branch(stack, false),
            (b"endif", Some(Kind::If | Kind::Else)) => self.end_if(stack),
            (b"for", _) => self.begin_for(stack, place),
            (b"else", Some(Kind::For)) => self.else_of_for(stack),
            (b"endfor", Some(Kind::For | Kind::ForElse)) => self.end_for(stack),
            (b"set", _) => self.set(stack, place),
            (b"endset", Some(Kind::Set)) => self.end_set(stack),
            _ => {
                self.place = place;
                let is_refused = REFUSED.iter().any(|word| self.memory.is(name, word));
                let words = if is_refused {
                    Words::TagRefused
                } else {
                    Words::TagMisplaced
                };
                Err(Fault::about(self.memory, words, name))
            }
        }
    }

    fn begin_if(&mut self, stack: &mut Stack, place: (u16, u16)) -> Result<()> {
        self.tuple(Form { is_bare: true, in_parentheses: false })?;
        let branch = self.emit_jump(Op::Unless)?;
        let was_soft = self.is_soft;
        self.check_names()?;
        self.is_soft = true;
        self.skip_sign(b':')?;
        let targets = Targets::default();
        stack.push(self.memory, Open { kind: Kind::If, place, branch, ends: 0, again: 0, was_soft, targets })
    }

    /// Ends a branch and begins that of `elif` or `else`.
    fn next_branch(&mut self, stack: &mut Stack, has_test: bool) -> Result<()> {
        let Some(mut open) = stack.last() else { return Ok(()) };
        stack.pop();
        self.emit_word(Op::Jump, open.ends)?;
        open.ends = self.memory.top as u16 - 2;
        self.lead_here(open.branch);
        if has_test {
            let (line, column) = self.lexer.place;
            self.emit_word(Op::At, line)?;
            self.memory.push_word(column)?;
            self.tuple(Form { is_bare: true, in_parentheses: false })?;
            open.branch = self.emit_jump(Op::Unless)?;
        } else {
            open.kind = Kind::Else;
        }
        self.skip_sign(b':')?;
        stack.push(self.memory, open)
    }

    fn end_if(&mut self, stack: &mut Stack) -> Result<()> {
        let Some(open) = stack.last() else { return Ok(()) };
        stack.pop();
        if matches!(open.kind, Kind::If) {
            self.lead_here(open.branch);
        }
        self.lead_all(open.ends);
        self.is_soft = open.was_soft;
        Ok(())
    }

    fn begin_for(&mut self, stack: &mut Stack, place: (u16, u16)) -> Result<()> {
        let targets = self.targets(true)?;
        if !self.skip_name("in")? {
            return Err(self.unexpected(Words::InMissing));
        }
        self.tuple(Form { is_bare: true, in_parentheses: false })?;
        self.emit(Op::ForBegin)?;
        let again = self.memory.top;
        let branch = self.emit_jump(Op::ForNext)?;
        self.store(&targets)?;
        if self.skip_name("if")? {
            self.expression()?;
            let passes = self.emit_jump(Op::Or)?;
            let back = self.emit_jump(Op::ForAgain)?;
            code::lead(self.memory, back, again);
            self.lead_here(passes);
            self.emit(Op::Drop)?;
        }
        if self.at_name("recursive") {
            return self.memory.fail(Words::Recursive);
        }
        let from = self.memory.top;
        self.memory.push_bytes(b"loop")?;
        let name = self.memory.intern(from)?;
        self.emit_word(Op::ForCount, name.at() as u16)?;
        let was_soft = self.is_soft;
        self.check_names()?;
        self.is_soft = false;
        self.skip_sign(b':')?;
        stack.push(self.memory, Open { kind: Kind::For, place, branch, ends: 0, again, was_soft, targets })
    }

    /// Ends the turns of a loop.
    fn end_turns(&mut self, open: &Open) -> Result<usize> {
        let back = self.emit_jump(Op::ForAgain)?;
        code::lead(self.memory, back, open.again);
        self.lead_here(open.branch);
        self.emit_jump(Op::ForEnd)
    }

    fn else_of_for(&mut self, stack: &mut Stack) -> Result<()> {
        let Some(mut open) = stack.last() else { return Ok(()) };
        stack.pop();
        open.branch = self.end_turns(&open)?;
        open.kind = Kind::ForElse;
        self.emit(Op::FrameBegin)?;
        self.skip_sign(b':')?;
        stack.push(self.memory, open)
    }

    fn end_for(&mut self, stack: &mut Stack) -> Result<()> {
        let Some(open) = stack.last() else { return Ok(()) };
        stack.pop();
        let end = if matches!(open.kind, Kind::For) {
            self.end_turns(&open)?
        } else {
            self.emit(Op::FrameEnd)?;
            open.branch
        };
        self.lead_here(end);
        self.is_soft = open.was_soft;
        Ok(())
    }

    fn set(&mut self, stack: &mut Stack, place: (u16, u16)) -> Result<()> {
        let targets = self.targets(false)?;
        if stack.has_loop() && targets.has(self.memory, "loop") {
            return self.memory.fail(Words::LoopName);
        }
        if self.skip_sign(b'=')? {
            self.tuple(Form::default())?;
            return self.store(&targets);
        }
        if self.token == Token::Sign(b'|') {
            return self.memory.fail(Words::FilterOfSet);
        }
        self.emit(Op::CaptureBegin)?;
        let was_soft = self.is_soft;
        self.is_soft = false;
        self.skip_sign(b':')?;
        stack.push(self.memory, Open { kind: Kind::Set, place, branch: 0, ends: 0, again: 0, was_soft, targets })
    }

    fn end_set(&mut self, stack: &mut Stack) -> Result<()> {
        let Some(open) = stack.last() else { return Ok(()) };
        stack.pop();
        self.emit(Op::CaptureEnd)?;
        self.is_soft = open.was_soft;
        self.store(&open.targets)
    }

    /// Names before `=` or `in`.
    fn targets(&mut self, is_loop: bool) -> Result<Targets> {
        let mut targets = Targets::default();
        let in_parentheses = self.skip_sign(b'(')?;
        while !targets.is_tuple || !(self.at_name("in") || matches!(self.token, Token::Sign(b'=' | b')'))) {
            let name = self.expect_name(Words::NameMissing)?;
            let mut member = Text::default();
            if !is_loop && self.skip_sign(b'.')? {
                member = self.expect_name(Words::NameMissing)?;
            }
            if is_constant(self.memory.bytes(name)) || is_loop && self.memory.is(name, "loop") {
                return Err(Fault::about(self.memory, Words::NoTarget, name));
            }
            let Some(place) = targets.list.get_mut(targets.count) else {
                return self.memory.fail(Words::TooManyNames);
            };
            *place = (name.at() as u16, member.at() as u16);
            targets.count += 1;
            if !self.skip_sign(b',')? {
                break;
            }
            targets.is_tuple = true;
        }
        if in_parentheses {
            self.expect(Token::Sign(b')'), Words::ParenthesisMissing)?;
        }
        Ok(targets)
    }

    /// Stores the last value.
    fn store(&mut self, targets: &Targets) -> Result<()> {
        if targets.is_tuple {
            for (name, _) in targets.list.iter().take(targets.count).filter(|(_, member)| *member == 0) {
                self.emit_word(Op::Declare, *name)?;
            }
            self.emit_word(Op::Unpack, targets.count as u16)?;
        }
        for (name, member) in targets.list.iter().take(targets.count) {
            if *member == 0 {
                self.emit_word(Op::Store, *name)?;
            } else {
                self.emit_word(Op::StoreMember, *name)?;
                self.memory.push_word(*member)?;
            }
        }
        Ok(())
    }
}

impl Targets {
    fn has(&self, memory: &Memory<'_>, word: &str) -> bool {
        self.list.iter().take(self.count).any(|(name, _)| memory.is(memory.interned(*name), word))
    }
}

fn is_constant(name: &[u8]) -> bool {
    matches!(name, b"true" | b"True" | b"false" | b"False" | b"none" | b"None")
}

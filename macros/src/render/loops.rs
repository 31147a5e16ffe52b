//! Variables that are set, texts that are caught, and loops.

use super::Machine;
use crate::code::Op;
use crate::fault::{Fault, Result, Words};
use crate::memory::{Text, Use};
use crate::run::containers::LOOP_PLACES;
use crate::run::wrong;
use crate::value::{Map, Value, View};

impl Machine<'_, '_> {
    /// Instructions that take values away.
    #[inline(never)]
    pub fn store(&mut self, op: Op) -> Result<()> {
        match op {
            Op::Drop => drop(self.run.memory.pop()),
            Op::Unpack => return self.unpack(),
            Op::Declare => {
                let name = self.word();
                let value = self.run.memory.pop();
                if self.place_of(name).is_none() {
                    self.run.memory.push_named(Use::Variable, name, Value::NONE);
                }
                self.run.memory.push(value);
            }
            Op::Store => {
                let name = self.word();
                let value = self.run.memory.pop();
                return self.set(name, value);
            }
            _ => {
                let (name, member) = (self.string(), self.string());
                let value = self.run.memory.pop();
                let View::Map(Map::Namespace, head) = self.variable(name)?.view() else {
                    return Err(Fault::about(&self.run.memory, Words::OnlyNamespaces, name));
                };
                self.run.put_kept(head, Value::str(member), value)?;
            }
        }
        Ok(())
    }

    /// Sets a variable of the innermost loop or block.
    fn set(&mut self, name: u16, value: Value) -> Result<()> {
        let value = self.keep(value);
        match self.place_of(name) {
            Some(index) => self.run.memory.set_at(index, value),
            None => self.run.memory.push_named(Use::Variable, name, value),
        }
        Ok(())
    }

    /// Place of a variable of the innermost loop or block on the stack.
    fn place_of(&self, name: u16) -> Option<usize> {
        let memory = &self.run.memory;
        (self.frame..memory.depth()).find(|index| memory.name_at(*index, Use::Variable) == Some(name))
    }

    /// Keeps a value when the statement is over: of a string no more than itself.
    fn keep(&mut self, value: Value) -> Value {
        let memory = &mut self.run.memory;
        if !value.lies_behind(memory.keep, memory.pool) {
            return value;
        }
        if let Some(text) = value.text() {
            let moved = memory.move_down(text, memory.keep);
            memory.keep += moved.len();
            memory.top = memory.keep;
            return Value::str(moved);
        }
        memory.keep = memory.top;
        value
    }

    /// Puts the parts of a value on the stack, the first one last.
    fn unpack(&mut self) -> Result<()> {
        let count = usize::from(self.word());
        let value = self.run.memory.pop();
        let length = self.run.iterate(value)?;
        if length != count {
            return self.run.memory.fail(Words::OtherCount);
        }
        for index in (0..count).rev() {
            let part = self.run.element(value, index)?;
            self.run.memory.push(part);
        }
        // Storing the first of them may not take the place of the others.
        self.run.memory.keep = self.run.memory.top;
        self.run.use_up(value);
        Ok(())
    }

    /// Blocks with variables of their own.
    #[inline(never)]
    pub fn frames(&mut self, op: Op) -> Result<()> {
        match op {
            Op::FrameBegin | Op::CaptureBegin => {
                self.run.memory.push(Value::count(self.frame));
                self.run.memory.push(Value::count(self.written));
                self.frame = self.run.memory.depth();
            }
            _ => {
                self.run.memory.cut(self.frame);
                let from = whole(self.run.memory.pop());
                self.frame = whole(self.run.memory.pop());
                if op == Op::CaptureEnd {
                    let text = self.catch(from)?;
                    self.run.memory.push(Value::str(text));
                }
            }
        }
        Ok(())
    }

    /// Takes back what was written since a place.
    fn catch(&mut self, from: usize) -> Result<Text> {
        self.run.memory.top = self.run.memory.keep;
        let start = self.run.memory.top;
        self.run.memory.push_bytes(self.output.get(from..self.written).unwrap_or_default());
        self.written = from;
        Ok(self.run.memory.text_since(start))
    }

    /// Instructions that begin, go on with and end loops.
    #[inline(never)]
    pub fn turn(&mut self, op: Op) -> Result<()> {
        match op {
            Op::ForBegin => self.begin(),
            Op::ForNext => self.next_turn(),
            Op::ForCount => {
                let name = self.word();
                let at = self.frame - LOOP_PLACES;
                let turns = whole_at(self, at + 1) + 1;
                self.run.memory.set_at(at + 1, Value::count(turns as usize));
                self.run.memory.push_named(Use::Variable, name, Value::turns(at));
                Ok(())
            }
            Op::ForAgain => {
                self.run.memory.cut(self.frame);
                let kept = whole_at(self, self.frame - 1) as u16 as usize;
                let memory = &mut self.run.memory;
                memory.keep = kept.max(memory.floor);
                memory.top = memory.keep;
                self.leap(true);
                Ok(())
            }
            _ => {
                let at = self.frame - LOOP_PLACES;
                let turns = whole_at(self, at + 1);
                self.frame = (whole_at(self, at + 3) >> 16) as usize;
                let value = self.run.memory.at(at);
                self.run.use_up(value);
                self.run.memory.cut(at);
                self.leap(turns >= 0);
                Ok(())
            }
        }
    }

    fn leap(&mut self, is_taken: bool) {
        let distance = self.word();
        if is_taken {
            self.next = usize::from((self.next as u16).wrapping_add(distance));
        }
    }

    /// Begins a loop. On the stack are its elements, the number of the turn, the number of the next element,
    /// and the frame and memory to go back to at its end.
    fn begin(&mut self) -> Result<()> {
        let value = self.run.memory.pop();
        if matches!(value.view(), View::Loop(_)) || !self.run.is_iterable(value) {
            return Err(wrong(&self.run.memory, Words::NotIterable, value));
        }
        let value = self.keep(value);
        let back = self.frame << 16 | self.run.memory.keep;
        for value in [value, Value::small(-1), Value::small(0), Value::count(back)] {
            self.run.memory.push(value);
        }
        self.frame = self.run.memory.depth();
        Ok(())
    }

    fn next_turn(&mut self) -> Result<()> {
        let at = self.frame - LOOP_PLACES;
        let value = self.run.memory.at(at);
        let next = whole_at(self, at + 2) as usize;
        if next >= self.run.length(value).unwrap_or(0) {
            self.leap(true);
            return Ok(());
        }
        self.leap(false);
        self.run.memory.set_at(at + 2, Value::count(next + 1));
        let element = self.run.element(value, next)?;
        self.run.memory.push(element);
        Ok(())
    }
}

fn whole(value: Value) -> usize {
    value.as_short().unwrap_or(0) as usize
}

fn whole_at(machine: &Machine<'_, '_>, index: usize) -> i64 {
    machine.run.memory.at(index).as_short().unwrap_or(0)
}

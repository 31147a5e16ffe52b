//! Lists and dicts that grow, loops as values, and what the machine has made into them.

use super::{Run, order, wrong};
use crate::environment::Kind;
use crate::fault::{Fault, Result, Words};
use crate::memory::Text;
use crate::names::{self, OfLoop};
use crate::value::{DEEPEST, Map, SIZE, Seq, Value, View, types};

/// Places on the stack that a loop has: what it goes through, where it is, and the loop around it.
pub const LOOP_PLACES: usize = 4;

impl Run<'_, '_> {
    /// Place of the entry with a key.
    pub fn find(&mut self, head: u16, key: Value) -> Result<Option<usize>> {
        for index in 0..self.memory.count(head) {
            let at = self.memory.place(head, index, 2 * SIZE);
            let known = self.memory.value(at);
            if order::equal(self, known, key, DEEPEST)? {
                return Ok(Some(at));
            }
        }
        Ok(None)
    }

    /// Writes an entry of a dict.
    pub fn put(&mut self, head: u16, key: Value, value: Value) -> Result<()> {
        if !order::is_hashable(self, key) {
            return Err(wrong(&self.memory, Words::NotHashable, key));
        }
        let at = match self.find(head, key)? {
            Some(at) => at,
            None => {
                let at = self.memory.grow(head, 2 * SIZE);
                self.memory.set_value(at, key);
                at
            }
        };
        self.memory.set_value(at + SIZE, value);
        Ok(())
    }

    /// Writes an entry of a dict that stays when the statement is over.
    pub fn put_kept(&mut self, head: u16, key: Value, value: Value) -> Result<()> {
        let before = self.memory.block(head);
        self.put(head, key, value)?;
        let (keep, pool) = (self.memory.keep, self.memory.pool);
        let is_new = before != self.memory.block(head);
        if is_new || key.lies_behind(keep, pool) || value.lies_behind(keep, pool) {
            self.keep();
        }
        Ok(())
    }

    /// Copies all entries of a dict into another.
    pub fn put_all(&mut self, head: u16, from: Value) -> Result<()> {
        if !from.is(types::DICT) {
            return self.put_pairs(head, from);
        }
        for index in 0..self.length(from).unwrap_or(0) {
            let (key, value) = self.entry(from, index)?;
            self.put(head, key, value)?;
        }
        Ok(())
    }

    fn put_pairs(&mut self, head: u16, from: Value) -> Result<()> {
        for index in 0..self.iterate(from)? {
            let pair = self.element(from, index)?;
            if self.iterate(pair)? != 2 {
                return self.memory.fail(Words::Pairs);
            }
            let (key, value) = (self.element(pair, 0)?, self.element(pair, 1)?);
            self.put(head, key, value)?;
        }
        Ok(())
    }

    /// Key and value of a dict by number.
    pub fn entry(&mut self, map: Value, index: usize) -> Result<(Value, Value)> {
        match map.view() {
            View::Map(_, head) => {
                let at = self.memory.place(head, index, 2 * SIZE);
                Ok((self.memory.value(at), self.memory.value(at + SIZE)))
            }
            View::Object(object) => {
                let key = self.part(object, index)?;
                let Some(name) = key.text() else { return Ok((key, Value::NONE)) };
                let value = self.member(object, name)?;
                Ok((key, if value.is_undefined() { Value::NONE } else { value }))
            }
            _ => Ok((Value::NONE, Value::NONE)),
        }
    }

    /// A list of the elements of what can be gone through.
    pub fn list_of(&mut self, kind: Seq, value: Value) -> Result<Value> {
        let length = self.iterate(value)?;
        let head = self.memory.new_block(length.min(usize::from(u16::MAX)), SIZE);
        for index in 0..length {
            let element = self.element(value, index)?;
            self.append(head, element);
        }
        self.use_up(value);
        Ok(Value::seq(kind, head))
    }

    /// Empties what can be gone through only once.
    pub fn use_up(&mut self, value: Value) {
        if let View::Seq(Seq::Once, head) = value.view() {
            self.memory.set_count(head, 0);
        }
    }

    /// A value of the machine's with all its parts in memory.
    pub fn settle(&mut self, value: Value, depth: u8) -> Result<Value> {
        if depth == 0 {
            return self.memory.fail(Words::TooDeep);
        }
        let View::Object(object) = value.view() else { return self.settle_parts(value, depth) };
        let length = self.machine.length(object);
        match object.kind {
            Kind::Lookup => Ok(value),
            Kind::Dict => {
                let map = self.map(Map::Dict, length);
                let Some(head) = map.head() else { return Ok(map) };
                for index in 0..length {
                    let (key, part) = self.entry(value, index)?;
                    let part = self.settle(part, depth - 1)?;
                    self.put(head, key, part)?;
                }
                Ok(map)
            }
            Kind::List | Kind::Tuple => {
                let head = self.memory.new_block(length, SIZE);
                for index in 0..length {
                    let part = self.part(object, index)?;
                    let part = self.settle(part, depth - 1)?;
                    self.append(head, part);
                }
                Ok(Value::seq(if object.kind == Kind::List { Seq::List } else { Seq::Tuple }, head))
            }
        }
    }

    /// Brings the parts of a value in memory into memory, each into its place.
    fn settle_parts(&mut self, value: Value, depth: u8) -> Result<Value> {
        let (head, size, offset) = match value.view() {
            View::Seq(_, head) => (head, SIZE, 0),
            View::Map(_, head) => (head, 2 * SIZE, SIZE),
            _ => return Ok(value),
        };
        for index in 0..self.memory.count(head) {
            let at = self.memory.place(head, index, size) + offset;
            let part = self.memory.value(at);
            if part.is(types::OBJECT | types::IN_MEMORY) {
                let settled = self.settle(part, depth - 1)?;
                self.memory.set_value(at, settled);
                if matches!(part.view(), View::Object(_)) && at < self.memory.keep {
                    self.keep();
                }
            }
        }
        Ok(value)
    }

    /// Length of what a loop goes through.
    pub fn loop_length(&mut self, place: u16) -> Option<usize> {
        let value = self.memory.at(usize::from(place));
        self.length(value)
    }

    /// Number of the turn of a loop from 0, and of the element, which differ where elements are passed over.
    pub fn turn(&self, place: u16) -> (i32, i32) {
        let number = |offset: usize| self.memory.at(usize::from(place) + offset).as_short().unwrap_or(0) as i32;
        (number(1), number(2))
    }

    /// Value of an attribute of a loop, as in `loop.index`.
    pub fn loop_attribute(&mut self, place: u16, name: Text) -> Result<Value> {
        let (turn, next) = self.turn(place);
        let length = self.loop_length(place).unwrap_or(0) as i32;
        let Some(number) = names::find(OfLoop::NAMES, self.memory.bytes(name)) else {
            return Ok(Value::undefined(name));
        };
        if number >= OfLoop::Last as u8 && turn + 1 != next {
            return self.memory.fail(Words::LoopEnd);
        }
        let value = self.memory.at(usize::from(place));
        Ok(match OfLoop::from_number(number) {
            OfLoop::Index => Value::small(turn + 1),
            OfLoop::Index0 => Value::small(turn),
            OfLoop::First => Value::bool(turn == 0),
            OfLoop::Last => Value::bool(next >= length),
            OfLoop::Length => Value::small(length),
            OfLoop::RevIndex => Value::small(length - turn),
            OfLoop::RevIndex0 => Value::small(length - next),
            OfLoop::Depth => Value::small(1),
            OfLoop::Depth0 => Value::small(0),
            OfLoop::Previous if turn > 0 => self.element(value, (turn - 1) as usize)?,
            OfLoop::Next if next < length => self.element(value, next as usize)?,
            OfLoop::Previous | OfLoop::Next => Value::undefined(name),
            OfLoop::Cycle | OfLoop::Changed => Value::METHOD,
        })
    }
}

/// The fault that something of the machine's would be changed.
pub fn fixed(run: &Run<'_, '_>) -> Fault {
    run.memory.fault(Words::Fixed)
}

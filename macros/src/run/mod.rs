//! Values in memory, and how they are looked into.

pub mod containers;
pub mod lookup;
pub mod numbers;
pub mod order;
pub mod print;
pub mod texts;

use crate::environment::{Environment, Given, Kind, Object};
use crate::fault::{Fault, Result, Words};
use crate::literal;
use crate::memory::{Memory, Text};
use crate::value::{Map, Seq, Value, View};

/// Length of the head of a container that the machine has given: the next one, its name, its owner.
const ENTRY: usize = 10;
/// Owner of the variables.
pub const VARIABLES: u32 = u32::MAX;

/// Memory and machine of a rendering. The memory comes first, so that both have one address.
#[repr(C)]
pub struct Run<'r, 'a> {
    pub memory: Memory<'a>,
    pub machine: &'r mut dyn Environment,
    /// First of the containers that the machine has given, in memory.
    pub given: u16,
}

impl Run<'_, '_> {
    /// A value of the machine's as one in memory.
    pub fn take(memory: &mut Memory<'_>, given: Given<'_>) -> Result<Value> {
        Ok(match given {
            Given::None => Value::NONE,
            Given::Bool(is) => Value::bool(is),
            Given::Int(int) => return Ok(memory.int(int)),
            Given::Float(float) => Value::float(float),
            Given::Text(text) => Value::str(memory.copy_in(text)),
            Given::Literal(text) => literal::read(memory, &mut text.bytes())?,
            Given::Object(object) => Value::object(object),
        })
    }

    /// Member of an object of the machine's; undefined where there is none.
    pub fn member(&mut self, object: Object, name: Text) -> Result<Value> {
        if let Some(value) = self.given_before(object.id, name) {
            return Ok(value);
        }
        // Klipper's printer takes names with blanks around them.
        let known = if object.kind == Kind::Lookup { self.memory.trim(name) } else { name };
        match self.machine.member(object, self.memory.text(known)) {
            Some(given) => Self::take(&mut self.memory, given),
            None => Ok(Value::undefined(name)),
        }
    }

    /// Member of an object of the machine's. A container that is made of a literal stays for the rest of the
    /// rendering, with what the template changes in it.
    pub fn kept_member(&mut self, object: Object, name: Text) -> Result<Value> {
        let member = self.member(object, name)?;
        if member.head().is_some() && self.given_before(object.id, name).is_none() {
            self.note_given(object.id, name, member);
        }
        Ok(member)
    }

    /// A container that the machine has given before.
    pub fn given_before(&self, owner: u32, name: Text) -> Option<Value> {
        let mut entry = self.given;
        while entry != 0 {
            let at = usize::from(entry);
            let known = Text::from_bits(self.memory.long_word(at + 2));
            if self.memory.long_word(at + 6) == owner && self.memory.bytes(known) == self.memory.bytes(name) {
                return Some(self.memory.value(at + ENTRY));
            }
            entry = self.memory.word(at);
        }
        None
    }

    /// Notes a container of the machine's, which stays from now on.
    pub fn note_given(&mut self, owner: u32, name: Text, value: Value) {
        let at = self.memory.reserve(ENTRY + crate::value::SIZE);
        self.memory.set_word(at, self.given);
        self.memory.set_long_word(at + 2, name.bits());
        self.memory.set_long_word(at + 6, owner);
        self.memory.set_value(at + ENTRY, value);
        self.given = at as u16;
        self.keep();
    }

    /// Name or element of an object of the machine's.
    pub fn part(&mut self, object: Object, index: usize) -> Result<Value> {
        let given = self.machine.element(object, index);
        given.map_or(Ok(Value::MISSING), |given| Self::take(&mut self.memory, given))
    }

    /// A text of the program as a value.
    pub fn str(&mut self, text: &str) -> Value {
        Value::str(self.memory.copy_in(text))
    }

    /// A list or tuple of values.
    pub fn seq(&mut self, kind: Seq, values: &[Value]) -> Value {
        let head = self.memory.new_block(values.len(), crate::value::SIZE);
        values.iter().for_each(|value| self.append(head, *value));
        Value::seq(kind, head)
    }

    /// Appends a value to a list, tuple or view.
    #[inline(never)]
    pub fn append(&mut self, head: u16, value: Value) {
        let at = self.memory.grow(head, crate::value::SIZE);
        self.memory.set_value(at, value);
    }

    /// An empty dict or namespace.
    pub fn map(&mut self, kind: Map, room: usize) -> Value {
        Value::map(kind, self.memory.new_block(room, 2 * crate::value::SIZE))
    }

    /// Keeps what is in memory: something that stays refers to it.
    #[inline(never)]
    pub fn keep(&mut self) {
        self.memory.keep = self.memory.top;
        self.memory.floor = self.memory.top;
    }
}

/// The fault that a value has the wrong type.
#[inline(never)]
pub fn wrong(memory: &Memory<'_>, words: Words, value: Value) -> Fault {
    if let View::Undefined(name) = value.view() {
        return undefined(memory, name);
    }
    Fault::of(memory, words, value.kind())
}

/// The fault that something is used that is not there.
#[inline(never)]
pub fn undefined(memory: &Memory<'_>, name: Text) -> Fault {
    Fault::about(memory, Words::Undefined, name)
}

//! Arguments of a call, which lie on the stack.

use crate::fault::{Fault, Result, Words};
use crate::memory::{Text, Use};
use crate::run::{Run, wrong};
use crate::value::Value;

/// Most arguments that have names.
const MOST: usize = 4;

/// Arguments of a call: places on the stack, the first one first.
#[derive(Clone, Copy, Debug)]
pub struct Arguments {
    pub first: usize,
    pub count: usize,
}

/// Arguments in the order in which the callee names them.
pub type Bound = [Option<Value>; MOST];

impl Arguments {
    /// The arguments without the first one.
    pub fn rest(self) -> Self {
        Self { first: self.first + 1, count: self.count.saturating_sub(1) }
    }

    /// The arguments with those of `*list` and `**dict` one by one.
    pub fn spread(self, run: &mut Run<'_, '_>) -> Result<Self> {
        let places = self.first..self.first + self.count;
        if !places.clone().any(|index| matches!(run.memory.use_at(index), Use::Spread | Use::SpreadNamed)) {
            return Ok(self);
        }
        for index in places {
            let value = run.memory.at(index);
            match run.memory.use_at(index) {
                Use::Spread => {
                    for part in 0..run.iterate(value)? {
                        let part = run.element(value, part)?;
                        run.memory.push(part);
                    }
                }
                Use::SpreadNamed => {
                    for part in 0..run.iterate(value)? {
                        let (key, part) = run.entry(value, part)?;
                        let Some(key) = key.text() else { return Err(run.memory.fault(Words::WantsText)) };
                        // Names have their length before them, as the strings of the template.
                        run.memory.push_word(key.len() as u16);
                        let name = run.memory.copy_text(key);
                        run.memory.push_named(Use::Keyword, name.at() as u16, part);
                    }
                }
                kind => {
                    let name = run.memory.name_at(index, kind).unwrap_or(0);
                    run.memory.push_named(kind, name, value);
                }
            }
        }
        let first = self.first + self.count;
        Ok(Self { first, count: run.memory.depth() - first })
    }

    /// Number of the arguments without a name.
    pub fn positions(self, run: &Run<'_, '_>) -> usize {
        (0..self.count).filter(|index| run.memory.name_at(self.first + index, Use::Keyword).is_none()).count()
    }

    /// An argument without a name.
    pub fn position(self, run: &Run<'_, '_>, index: usize) -> Option<Value> {
        (index < self.positions(run)).then(|| run.memory.at(self.first + index))
    }

    /// The argument with a name.
    pub fn keyword(self, run: &Run<'_, '_>, name: Text) -> Option<Value> {
        self.word(run, run.memory.bytes(name))
    }

    fn word(self, run: &Run<'_, '_>, name: &[u8]) -> Option<Value> {
        (self.first..self.first + self.count).find_map(|index| {
            let known = run.memory.name_at(index, Use::Keyword)?;
            let is = run.memory.bytes(run.memory.interned(known)) == name;
            is.then(|| run.memory.at(index))
        })
    }

    /// Name and value of an argument that has a name, by its place.
    pub fn named(self, run: &Run<'_, '_>, index: usize) -> Option<(Text, Value)> {
        let name = run.memory.name_at(self.first + index, Use::Keyword)?;
        Some((run.memory.interned(name), run.memory.at(self.first + index)))
    }

    /// The arguments in the order of the callee's names, which stand behind each other with blanks.
    pub fn bind(self, run: &Run<'_, '_>, names: &'static [u8]) -> Result<Bound> {
        let mut bound = Bound::default();
        let positions = self.positions(run);
        let mut used = 0;
        for (index, name) in names.split(|byte| *byte == b' ').filter(|name| !name.is_empty()).enumerate() {
            let value = if index < positions { Some(run.memory.at(self.first + index)) } else { self.word(run, name) };
            used += usize::from(value.is_some());
            if let Some(place) = bound.get_mut(index) {
                *place = value;
            }
        }
        if used < self.count {
            return Err(Fault::of(
                &run.memory,
                Words::TooManyArguments,
                core::str::from_utf8(names).unwrap_or_default(),
            ));
        }
        Ok(bound)
    }
}

/// An argument that has to be given.
#[inline(never)]
pub fn needed(run: &Run<'_, '_>, argument: Option<Value>) -> Result<Value> {
    argument.ok_or_else(|| run.memory.fault(Words::ArgumentMissing))
}

/// Whole number that an argument is; truth values are 0 and 1.
#[inline(never)]
pub fn whole(run: &Run<'_, '_>, value: Value) -> Result<i64> {
    match run.memory.whole(value) {
        Some(int) => Ok(int),
        None => Err(wrong(&run.memory, Words::WantsWhole, value)),
    }
}

/// Text that an argument is, which has to be given.
#[inline(never)]
pub fn text(run: &Run<'_, '_>, argument: Option<Value>) -> Result<Text> {
    let value = needed(run, argument)?;
    value.text().ok_or_else(|| wrong(&run.memory, Words::WantsText, value))
}

/// Text that an argument is, or none for `none` and where there is no argument.
#[inline(never)]
pub fn optional_text(run: &Run<'_, '_>, argument: Option<Value>) -> Result<Option<Text>> {
    if argument.is_none_or(Value::is_none) { Ok(None) } else { text(run, argument).map(Some) }
}

//! The parameters of a program: `#1` to `#5000`, and those with names.
//!
//! `#1` to `#30` are a subroutine's own, as are names; `#31` and above, and names that begin with `_`, are
//! for all. A parameter with a number that was never set is 0. What a line sets counts from the next line on
//! (NIST RS-274/NGC, section 3.3.2.1), so it waits here until the line has been read.

use gcode::expression::Name;
use gcode::{Parameter, Problem};
use heapless::Vec;

/// Parameters that belong to a subroutine: `#1` to this one.
pub(crate) const LOCALS: usize = 30;
/// The last one that a program may use as it likes.
const LAST: u16 = 5_000;
/// Numbered parameters other than 0, at once.
const MOST_NUMBERED: usize = 256;
/// Names at once.
const MOST_NAMED: usize = 64;
/// Parameters that one line sets.
const MOST_OF_A_LINE: usize = 16;

/// A subroutine's own numbered parameters.
pub(crate) type Locals = [f64; LOCALS];

/// A parameter with a name.
#[derive(Clone, Debug)]
struct Named {
    name: Name,
    /// How deep the subroutine is called that it belongs to; 0 for those of all.
    level: u8,
    value: f64,
}

/// The parameters.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    locals: Locals,
    /// Those other than 0, in order.
    numbered: Vec<(u16, f64), MOST_NUMBERED>,
    named: Vec<Named, MOST_NAMED>,
    /// Set by the line that is being read.
    waiting: Vec<(Parameter, f64), MOST_OF_A_LINE>,
    /// How deep the subroutine that runs is called.
    level: u8,
    /// One that is kept over a power cycle has been written.
    has_changed: bool,
}

impl Memory {
    /// Becomes another one, in place: it is the largest part of a program.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        fn copy<T: Clone, const N: usize>(to: &mut Vec<T, N>, from: &Vec<T, N>) {
            to.clear();
            // As many fit as there are.
            let _ = to.extend_from_slice(from);
        }
        self.locals = other.locals;
        copy(&mut self.numbered, &other.numbered);
        copy(&mut self.named, &other.named);
        copy(&mut self.waiting, &other.waiting);
        (self.level, self.has_changed) = (other.level, other.has_changed);
    }

    /// The value of a parameter that programs keep here; `None` when there is none.
    pub(crate) fn get(&self, parameter: &Parameter) -> Option<f64> {
        match parameter {
            Parameter::Numbered(number @ 1..=30) => self.locals.get(usize::from(*number) - 1).copied(),
            Parameter::Numbered(number @ 31..=LAST) => {
                let place = self.numbered.binary_search_by_key(number, |(number, _)| *number);
                Some(place.ok().and_then(|place| self.numbered.get(place)).map_or(0.0, |(_, value)| *value))
            }
            Parameter::Numbered(_) => None,
            Parameter::Named(name) => {
                let level = self.level_of(name);
                let named = self.named.iter().find(|named| named.level == level && named.name == *name);
                // No subroutine has given anything yet.
                let given = || matches!(name.as_str(), "_value" | "_value_returned").then_some(0.0);
                named.map(|named| named.value).or_else(given)
            }
        }
    }

    fn level_of(&self, name: &Name) -> u8 {
        if name.starts_with('_') { 0 } else { self.level + 1 }
    }

    /// Keeps what a line sets until it has been read.
    pub(crate) fn set_later(&mut self, parameter: Parameter, value: f64) -> Result<(), Problem> {
        self.waiting.push((parameter, value)).map_err(|_| Problem::TooManyParameters)
    }

    /// The next parameter that the line has set.
    pub(crate) fn take_waiting(&mut self) -> Option<(Parameter, f64)> {
        if self.waiting.is_empty() { None } else { Some(self.waiting.remove(0)) }
    }

    /// The line is not carried out.
    pub(crate) fn forget_waiting(&mut self) {
        self.waiting.clear();
    }

    /// Whether the line has set something.
    pub(crate) fn has_waiting(&self) -> bool {
        !self.waiting.is_empty()
    }

    /// Writes a parameter.
    ///
    /// # Errors
    /// When there is no room, or none with this number.
    pub(crate) fn set(&mut self, parameter: &Parameter, value: f64) -> Result<(), Problem> {
        match parameter {
            Parameter::Numbered(number @ 1..=30) => {
                if let Some(place) = self.locals.get_mut(usize::from(*number) - 1) {
                    *place = value;
                }
                Ok(())
            }
            Parameter::Numbered(number @ 31..=LAST) => self.set_numbered(*number, value),
            Parameter::Numbered(_) => Err(Problem::ReadOnly),
            Parameter::Named(name) => self.set_named(name, value),
        }
    }

    fn set_numbered(&mut self, number: u16, value: f64) -> Result<(), Problem> {
        self.has_changed = true;
        match self.numbered.binary_search_by_key(&number, |(number, _)| *number) {
            Ok(place) if value == 0.0 => {
                self.numbered.remove(place);
            }
            Ok(place) => {
                if let Some((_, kept)) = self.numbered.get_mut(place) {
                    *kept = value;
                }
            }
            Err(_) if value == 0.0 => {}
            Err(place) => {
                return self.numbered.insert(place, (number, value)).map_err(|_| Problem::TooManyParameters);
            }
        }
        Ok(())
    }

    fn set_named(&mut self, name: &Name, value: f64) -> Result<(), Problem> {
        let level = self.level_of(name);
        if let Some(named) = self.named.iter_mut().find(|named| named.level == level && named.name == *name) {
            named.value = value;
            return Ok(());
        }
        let named = Named { name: name.clone(), level, value };
        self.named.push(named).map_err(|_| Problem::TooManyParameters)
    }

    /// A subroutine begins, with these as its own; those of its caller, to come back to.
    pub(crate) fn enter(&mut self, own: Locals) -> Locals {
        self.level = self.level.saturating_add(1);
        core::mem::replace(&mut self.locals, own)
    }

    /// A subroutine has ended.
    pub(crate) fn leave(&mut self, callers: Locals) {
        let own = self.level + 1;
        self.named.retain(|named| named.level != own);
        self.level = self.level.saturating_sub(1);
        self.locals = callers;
    }

    /// What a subroutine gave: `#<_value>`, and whether it gave any, `#<_value_returned>`.
    pub(crate) fn give_back(&mut self, value: Option<f64>) {
        let given = [("_value", value.unwrap_or(0.0)), ("_value_returned", f64::from(u8::from(value.is_some())))];
        for (name, value) in given {
            if let Ok(name) = Name::try_from(name) {
                // Where there is no room, it is missed where it is asked for.
                let _ = self.set_named(&name, value);
            }
        }
    }

    /// Programs have ended: what belonged to them is forgotten.
    pub(crate) fn end(&mut self) {
        self.forget_waiting();
        self.level = 0;
        self.locals = Locals::default();
        self.named.retain(|named| named.level == 0);
    }

    /// What is kept over a power cycle: of the numbered parameters that are not 0, the one at this place.
    pub(crate) fn at(&self, place: usize) -> Option<(u16, f64)> {
        self.numbered.get(place).copied()
    }

    /// How many of them there are.
    pub(crate) fn kept(&self) -> usize {
        self.numbered.len()
    }

    /// Something else that is kept has been written.
    pub(crate) const fn changed(&mut self) {
        self.has_changed = true;
    }

    /// Whether one of them has been written since the last call.
    pub(crate) const fn take_changed(&mut self) -> bool {
        core::mem::replace(&mut self.has_changed, false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    fn named(name: &str) -> Parameter {
        Parameter::Named(Name::try_from(name).unwrap())
    }

    #[test]
    fn subroutines_have_their_own() {
        let mut memory = Memory::default();
        for (parameter, value) in [(Parameter::Numbered(1), 1.0), (named("depth"), 2.0), (named("_all"), 3.0)] {
            memory.set(&parameter, value).unwrap();
        }
        let mut own = Locals::default();
        own[0] = 7.0;
        let callers = memory.enter(own);
        assert_eq!(memory.get(&Parameter::Numbered(1)), Some(7.0));
        assert_eq!(memory.get(&named("depth")), None);
        assert_eq!(memory.get(&named("_all")), Some(3.0));
        memory.set(&named("depth"), 9.0).unwrap();
        memory.leave(callers);
        assert_eq!(memory.get(&Parameter::Numbered(1)), Some(1.0));
        assert_eq!(memory.get(&named("depth")), Some(2.0));
        let callers = memory.enter(Locals::default());
        assert_eq!(memory.get(&named("depth")), None, "a call does not find what the one before it left");
        memory.leave(callers);
    }

    #[test]
    fn there_is_an_end_to_the_room() {
        let mut memory = Memory::default();
        for number in 0..MOST_NUMBERED as u16 {
            memory.set(&Parameter::Numbered(31 + number), 1.0).unwrap();
        }
        assert_eq!(memory.set(&Parameter::Numbered(4_000), 1.0), Err(Problem::TooManyParameters));
        memory.set(&Parameter::Numbered(31), 0.0).unwrap();
        memory.set(&Parameter::Numbered(4_000), 1.0).unwrap();
        assert_eq!(memory.set(&Parameter::Numbered(5_001), 1.0), Err(Problem::ReadOnly));
        assert_eq!(memory.get(&Parameter::Numbered(0)), None);
    }

    proptest! {
        #[test]
        fn what_is_written_last_is_read(writes in prop::collection::vec((1_u16..90, -2_i8..3), 0..200)) {
            let (mut memory, mut model) = (Memory::default(), BTreeMap::new());
            for (number, value) in writes {
                memory.set(&Parameter::Numbered(number), f64::from(value)).unwrap();
                model.insert(number, f64::from(value));
            }
            for number in 1..90 {
                let expected = model.get(&number).copied().unwrap_or(0.0);
                prop_assert_eq!(memory.get(&Parameter::Numbered(number)), Some(expected));
            }
            let kept: Vec<u16, 90> = (0..).map_while(|place| memory.at(place)).map(|(number, _)| number).collect();
            prop_assert!(kept.is_sorted());
        }
    }
}

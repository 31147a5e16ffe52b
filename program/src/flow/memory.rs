//! Parameters of a program: `#1` to `#5000`, and named parameters.
//!
//! `#1` to `#30` are local to a subroutine, as are names; `#31` and above, and names that begin with `_`, are
//! global. A numbered parameter that was never set is 0. Assignments take effect behind their line (NIST
//! RS-274/NGC, section 3.3.2.1), so they wait here until the line has been read.

use gcode::expression::Name;
use gcode::{Parameter, Problem};
use heapless::Vec;

/// Number of local parameters: `#1` to `#30`.
pub(crate) const LOCALS: usize = 30;
/// Highest number that a program may use freely.
const LAST: u16 = 5_000;
/// Capacity for numbered parameters other than 0.
const MOST_NUMBERED: usize = 256;
/// Capacity for named parameters.
const MOST_NAMED: usize = 64;
/// Greatest number of parameters that one line sets.
const MOST_OF_A_LINE: usize = 16;

/// A subroutine's local numbered parameters.
pub(crate) type Locals = [f64; LOCALS];

/// Parameter with a name.
#[derive(Clone, Debug)]
struct Named {
    name: Name,
    /// Call depth of the subroutine that owns the parameter; 0 for global parameters.
    level: u8,
    value: f64,
}

/// Memory of all parameters.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    locals: Locals,
    /// Numbered parameters other than 0, in order.
    numbered: Vec<(u16, f64), MOST_NUMBERED>,
    named: Vec<Named, MOST_NAMED>,
    /// Assignments of the line that is being read.
    waiting: Vec<(Parameter, f64), MOST_OF_A_LINE>,
    /// Call depth of the current subroutine.
    level: u8,
    /// Whether a persistent parameter has been written.
    has_changed: bool,
}

impl Memory {
    /// Copies another memory in place, because memory is the largest part of a program.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        fn copy<T: Clone, const N: usize>(to: &mut Vec<T, N>, from: &Vec<T, N>) {
            to.clear();
            // Both lists have the same capacity.
            let _ = to.extend_from_slice(from);
        }
        self.locals = other.locals;
        copy(&mut self.numbered, &other.numbered);
        copy(&mut self.named, &other.named);
        copy(&mut self.waiting, &other.waiting);
        (self.level, self.has_changed) = (other.level, other.has_changed);
    }

    /// Returns the value of a parameter stored here; `None` when there is none.
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
                // Both names are 0 until a subroutine returns a value.
                let given = || matches!(name.as_str(), "_value" | "_value_returned").then_some(0.0);
                named.map(|named| named.value).or_else(given)
            }
        }
    }

    fn level_of(&self, name: &Name) -> u8 {
        if name.starts_with('_') { 0 } else { self.level + 1 }
    }

    /// Queues an assignment until its line has been read.
    pub(crate) fn set_later(&mut self, parameter: Parameter, value: f64) -> Result<(), Problem> {
        self.waiting.push((parameter, value)).map_err(|_| Problem::TooManyParameters)
    }

    /// Returns the next queued assignment of the line.
    pub(crate) fn take_waiting(&mut self) -> Option<(Parameter, f64)> {
        if self.waiting.is_empty() { None } else { Some(self.waiting.remove(0)) }
    }

    /// Drops the queued assignments, because the line is not carried out.
    pub(crate) fn forget_waiting(&mut self) {
        self.waiting.clear();
    }

    /// Whether the line has queued an assignment.
    pub(crate) fn has_waiting(&self) -> bool {
        !self.waiting.is_empty()
    }

    /// Sets a parameter at once.
    ///
    /// # Errors
    /// When there is no room, or no parameter with this number.
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

    /// Enters a subroutine with these local parameters; returns the caller's.
    pub(crate) fn enter(&mut self, own: Locals) -> Locals {
        self.level = self.level.saturating_add(1);
        core::mem::replace(&mut self.locals, own)
    }

    /// Leaves a subroutine and restores the caller's local parameters.
    pub(crate) fn leave(&mut self, callers: Locals) {
        let own = self.level + 1;
        self.named.retain(|named| named.level != own);
        self.level = self.level.saturating_sub(1);
        self.locals = callers;
    }

    /// Sets the returned value, `#<_value>`, and whether a value was returned, `#<_value_returned>`.
    pub(crate) fn give_back(&mut self, value: Option<f64>) {
        let given = [("_value", value.unwrap_or(0.0)), ("_value_returned", f64::from(u8::from(value.is_some())))];
        for (name, value) in given {
            if let Ok(name) = Name::try_from(name) {
                // Without room the parameter is missing, and reading it is the error.
                let _ = self.set_named(&name, value);
            }
        }
    }

    /// Forgets local parameters at the end of programs.
    pub(crate) fn end(&mut self) {
        self.forget_waiting();
        self.level = 0;
        self.locals = Locals::default();
        self.named.retain(|named| named.level == 0);
    }

    /// Returns the persistent parameter at this index: a numbered parameter that is not 0.
    pub(crate) fn at(&self, place: usize) -> Option<(u16, f64)> {
        self.numbered.get(place).copied()
    }

    /// Returns the number of persistent parameters.
    pub(crate) fn kept(&self) -> usize {
        self.numbered.len()
    }

    /// Notes that persistent state outside this memory has been written.
    pub(crate) const fn changed(&mut self) {
        self.has_changed = true;
    }

    /// Returns whether persistent state has been written since the last call.
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

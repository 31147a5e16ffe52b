//! Macros of the machine, which it tells a few at a time, while an answer is made that lists them.

use core::cell::Cell;

use heapless::{String, Vec};

/// Macros that are held at once: as many as go out with one packet.
const ROWS: usize = 4;
/// Longest name of a macro, as the machine has it.
const NAME_BYTES: usize = 96;
/// Longest text that a macro says of itself, bytes; the rest is left out.
const ABOUT_BYTES: usize = 96;

/// A macro.
#[derive(Debug)]
pub struct Macro {
    /// Name as it is written.
    pub name: String<NAME_BYTES>,
    /// Description; empty where there is none.
    pub about: String<ABOUT_BYTES>,
}

/// Macros that were told last, some that follow each other. All zero at first.
#[derive(Debug)]
pub struct Macros {
    /// Number of the list that they are of.
    list: u32,
    /// Number of the first one.
    first: u16,
    rows: Vec<Macro, ROWS>,
    /// Whether the list ends behind them.
    is_end: bool,
    /// Number of the macro that an answer wanted last, from 1.
    wanted: Cell<u16>,
}

impl Macros {
    /// Makes the macros of a machine that has told none.
    #[must_use]
    pub const fn new() -> Self {
        Self { list: 0, first: 0, rows: Vec::new(), is_end: false, wanted: Cell::new(0) }
    }

    /// Forgets what was told, when the list is another one.
    pub fn keep(&mut self, list: u32) {
        if list != self.list {
            (self.list, self.is_end) = (list, false);
            self.rows.clear();
        }
    }

    /// Returns the macro of this number, which is none behind the last one; no answer until the machine has
    /// told it.
    pub fn at(&self, number: u16) -> Option<Option<&Macro>> {
        self.wanted.set(number.saturating_add(1));
        let row = number.checked_sub(self.first).map(usize::from);
        let is_behind = self.is_end && row.is_some_and(|row| row >= self.rows.len());
        if is_behind { Some(None) } else { self.rows.get(row?).map(Some) }
    }

    /// Returns the number of the macro that is to be told next; none while there are enough.
    #[must_use]
    pub fn next(&self) -> Option<u16> {
        let wanted = self.wanted.get().checked_sub(1)?;
        let behind = self.first.saturating_add(self.rows.len() as u16);
        if wanted < self.first || wanted >= behind && !self.is_end {
            return Some(wanted);
        }
        (!self.is_end && !self.rows.is_full()).then_some(behind)
    }

    /// Takes the macro of this number; none: there are no more.
    pub fn tell(&mut self, number: u16, told: Option<(&str, &str)>) {
        let behind = self.first.saturating_add(self.rows.len() as u16);
        if number != behind || self.rows.is_full() || self.is_end {
            self.rows.clear();
            (self.first, self.is_end) = (number, false);
        }
        let Some((name, about)) = told else {
            self.is_end = true;
            return;
        };
        // The machine has no longer ones.
        let [name, about] = [name, about].map(|text| String::try_from(text).unwrap_or_default());
        // Room was made.
        let _ = self.rows.push(Macro { name, about });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [&str; 6] = ["A", "B", "C", "D", "E", "F"];

    /// Has the machine tell what is wanted. Returns the numbers.
    fn tell(macros: &mut Macros) -> std::vec::Vec<u16> {
        let mut told = std::vec::Vec::new();
        while let Some(number) = macros.next() {
            macros.tell(number, ALL.get(usize::from(number)).map(|name| (*name, "")));
            told.push(number);
        }
        told
    }

    /// Returns the name of a macro, as far as it is known.
    fn name(macros: &Macros, number: u16) -> Option<Option<&str>> {
        macros.at(number).map(|row| row.map(|row| row.name.as_str()))
    }

    #[test]
    fn macros_are_told_a_few_at_a_time_and_each_that_is_wanted() {
        let mut macros = Macros::new();
        assert!(tell(&mut macros).is_empty(), "nobody wants any");
        assert_eq!(name(&macros, 0), None);
        assert_eq!(tell(&mut macros), [0, 1, 2, 3]);
        assert_eq!((name(&macros, 3), name(&macros, 4)), (Some(Some("D")), None));
        assert_eq!(tell(&mut macros), [4, 5, 6]);
        assert_eq!((name(&macros, 5), name(&macros, 6), name(&macros, 9)), (Some(Some("F")), Some(None), Some(None)));
        assert!(tell(&mut macros).is_empty() && name(&macros, 0).is_none(), "another answer begins");
        assert_eq!((tell(&mut macros), name(&macros, 0)), (vec![0, 1, 2, 3], Some(Some("A"))));
        macros.keep(0);
        assert_eq!(name(&macros, 0), Some(Some("A")));
        macros.keep(1);
        assert_eq!(name(&macros, 0), None, "they have been read anew");
    }
}

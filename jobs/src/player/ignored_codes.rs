//! Codes of a job that were not carried out and make no difference to the part: counted, and said at its end.

use core::fmt;

use gcode::Code;
use heapless::Vec;

/// Greatest number of names that are told apart; a file has a handful.
const MOST: usize = 24;

/// Name of something passed over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Name {
    /// A code of a line.
    Code(Code),
    /// A word that its code does not take.
    Word(Code, char),
    /// A command by name.
    Command(&'static str),
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Code(code) => code.fmt(f),
            Self::Word(code, letter) => write!(f, "{code} {letter}"),
            Self::Command(name) => f.write_str(name),
        }
    }
}

/// Notes about a file while it is played.
#[derive(Debug, Default)]
pub struct Noted {
    /// Codes and words that the job did not take.
    pub passed_over: PassedOver,
    /// An S that the spindle cannot turn with has been told.
    pub told_speed: bool,
}

/// Counts of everything passed over.
#[derive(Debug, Default)]
pub struct PassedOver {
    counts: Vec<(Name, u32), MOST>,
    others: u32,
}

impl PassedOver {
    /// Counts one more of this name.
    pub fn count(&mut self, name: Name) {
        let known = self.counts.iter_mut().find(|(known, _)| *known == name);
        if let Some((_, count)) = known {
            *count = count.saturating_add(1);
        } else if self.counts.push((name, 1)).is_err() {
            self.others = self.others.saturating_add(1);
        }
    }

    /// Whether every code was carried out.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.counts.is_empty()
    }
}

/// Writes names with their counts: `M73 3x, M300 1x`.
impl fmt::Display for PassedOver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, (name, count)) in self.counts.iter().enumerate() {
            write!(f, "{}{name} {count}x", if place == 0 { "" } else { ", " })?;
        }
        if self.others > 0 { write!(f, ", others {}x", self.others) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_is_counted_and_the_kinds_have_an_end() {
        let mut passed = PassedOver::default();
        assert!(passed.is_empty());
        for name in [Name::Code(Code::m(73)), Name::Command("TIMELAPSE_*"), Name::Code(Code::m(73))] {
            passed.count(name);
        }
        assert_eq!(passed.to_string(), "M73 2x, TIMELAPSE_* 1x");
        (0..30).for_each(|number| passed.count(Name::Code(Code::m(800 + number))));
        assert!(passed.to_string().ends_with(", M821 1x, others 8x"), "{passed}");
    }
}

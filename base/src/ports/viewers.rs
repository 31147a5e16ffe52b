//! Viewers of the machine: pages in browsers, and displays.

use crate::snapshot::Snapshot;

/// An operator's factors; 1 is as programmed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Factors {
    /// Of the speed of rapids.
    pub rapid: Option<f64>,
    /// Of the spindle's speed.
    pub spindle: Option<f64>,
}

/// Access to those who look at the machine. A board without any leaves all of it out.
pub trait Viewers {
    /// Whether somebody looks, and was last shown the machine long enough ago.
    fn wants_snapshot(&self) -> bool {
        false
    }

    /// Shows the machine as it is now.
    fn show(&mut self, _snapshot: &Snapshot) {}

    /// Whether somebody draws the path that the machine makes; once no, when nobody does any more; none while
    /// nobody has.
    fn follows_path(&mut self) -> Option<bool> {
        None
    }

    /// Tells of a place on the path that the machine has come to: X, Y and Z in machine coordinates, mm, and
    /// whether material was laid or cut on the way there.
    fn add_to_path(&mut self, _at: [f32; 3], _lays: bool) {}

    /// Takes factors that an operator wants to have in force at once.
    fn take_factors(&mut self) -> Option<Factors> {
        None
    }

    /// Whether viewers have yet to be given the heights of the mesh of this number.
    fn wants_heights(&self, _number: u32) -> bool {
        false
    }

    /// Gives a row of heights of the mesh of this number, mm: rows from the front, each from the left.
    fn show_heights(&mut self, _number: u32, _row: usize, _heights: &[f32]) {}

    /// Returns the number of the macro that viewers want to be told of next, counted from 0 in the order of
    /// the configuration; none while they want none.
    fn wants_macro(&mut self) -> Option<u16> {
        None
    }

    /// Tells of the macro of this number: its name, and what it says of itself; none: there are no more.
    fn show_macro(&mut self, _number: u16, _shown: Option<(&str, &str)>) {}

    /// A job begins, and with it another path.
    fn begin_path(&mut self) {}
}

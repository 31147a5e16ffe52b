//! Record of each axis' phase at its switch.

use base::spread::Spread;
use units::{Axis, PerAxis};

use super::cycle::{CYCLE, nearest, within};
use super::readings::{Reading, Unread, Way};

/// Number of latest phases that are kept for the report.
pub(super) const KEPT: usize = 16;

/// The phases of all axes at their switches, since power up.
#[derive(Debug, Default)]
pub struct EndstopPhases {
    axes: PerAxis<Record>,
}

/// Phases of a single axis.
#[derive(Debug, Default)]
pub(super) struct Record {
    /// Reading at the slow approach of the homing under way.
    pub(super) reading: Option<Result<Reading, Unread>>,
    /// Travel of the motors when the switch closed in the fast approach.
    pub(super) fast_made: Option<Way>,
    /// Travel of the motors in the last homing, at the place that it found.
    pub(super) home_made: Option<Way>,
    /// Phase of the first homing, with which others are compared if none is calibrated.
    pub(super) first: Option<f64>,
    /// Phases of all homings, not wrapped: each as near to the first as can be.
    pub(super) collected: Spread,
    /// Latest phases, 0 to 1023; the newest at the end.
    pub(super) last: heapless::Vec<u16, KEPT>,
    /// Travel of the axis for a place of the cycle, mm.
    pub(super) mm: f64,
    /// Whether the drivers report the phase: then it holds after the next power up too.
    pub(super) is_absolute: bool,
}

impl EndstopPhases {
    pub(super) fn of(&mut self, axis: Axis) -> &mut Record {
        &mut self.axes[axis]
    }

    /// Forgets counted phases. Without supply an external driver may lose its place in the cycle, so its
    /// counted steps say nothing any more. A driver on the board reports its place.
    pub fn lose_supply(&mut self) {
        for record in &mut self.axes.0 {
            record.home_made = None;
            if !record.is_absolute {
                record.forget();
            }
        }
    }
}

impl Record {
    /// Adds the phase of a further homing.
    pub(super) fn collect(&mut self, phase: f64) {
        let first = self.collected.first();
        let near = if self.collected.count() == 0 { phase } else { first + nearest(phase - first, CYCLE) };
        self.collected.add(near);
        if self.last.is_full() {
            self.last.remove(0);
        }
        // The oldest was removed above, so there is room.
        let _ = self.last.push(within(phase, CYCLE) as u16);
    }

    /// Forgets the collected phases, and the phase of reference.
    pub(super) fn forget(&mut self) {
        (self.first, self.collected) = (None, Spread::default());
        self.last.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Phases on both sides of the cycle's end are as near to each other as anywhere else.
        #[test]
        fn what_is_collected_does_not_depend_on_where_the_cycle_begins(
            middle in 0.0..CYCLE, offs in proptest::collection::vec(-120.0..120.0_f64, 1..40),
        ) {
            let mut record = Record::default();
            offs.iter().for_each(|off| record.collect(within(middle + off, CYCLE)));
            let mean = offs.iter().sum::<f64>() / offs.len() as f64;
            prop_assert!(nearest(record.collected.mean() - middle - mean, CYCLE).abs() < 1e-6);
            let [least, most] = offs.iter().fold([f64::MAX, f64::MIN], |[a, b], off| [a.min(*off), b.max(*off)]);
            prop_assert!((record.collected.range() - (most - least)).abs() < 1e-6);
            prop_assert_eq!(record.last.len(), offs.len().min(KEPT));
        }
    }
}

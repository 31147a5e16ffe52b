//! What is known of each axis' phase at its switch: the owner.

use units::{Axis, PerAxis};

use super::cycle::{CYCLE, nearest, within};
use super::found::{Reading, Unread, Way};
use crate::spread::Spread;

/// The last phases that are kept to be shown.
pub(super) const KEPT: usize = 16;

/// The phases of all axes at their switches, since power up.
#[derive(Debug, Default)]
pub(crate) struct EndstopPhases {
    axes: PerAxis<Record>,
}

/// Of one axis.
#[derive(Debug, Default)]
pub(super) struct Record {
    /// What was read in the homing under way, at the slow approach.
    pub(super) reading: Option<Result<Reading, Unread>>,
    /// How far the motors had come when the switch closed in the fast one.
    pub(super) fast_made: Option<Way>,
    /// The same of the last homing, at the place that it found.
    pub(super) home_made: Option<Way>,
    /// The phase of the first homing: what others are compared with where none is calibrated.
    pub(super) first: Option<f64>,
    /// Every homing's, not wrapped: as near to the first as can be.
    pub(super) collected: Spread,
    /// The last of them, 0 to 1023; the newest at the end.
    pub(super) last: heapless::Vec<u16, KEPT>,
    /// How far the axis goes for one place of the cycle, mm.
    pub(super) mm: f64,
    /// The drivers say it: it is true after the next power up too.
    pub(super) is_absolute: bool,
}

impl EndstopPhases {
    pub(super) fn of(&mut self, axis: Axis) -> &mut Record {
        &mut self.axes[axis]
    }

    /// Without supply an external driver forgets where it was in its cycle, as far as anybody knows: what was
    /// counted of it says nothing any more. A driver on the board says where it is.
    pub(crate) fn lose_supply(&mut self) {
        for record in &mut self.axes.0 {
            record.home_made = None;
            if !record.is_absolute {
                record.forget();
            }
        }
    }
}

impl Record {
    /// One more homing found this phase.
    pub(super) fn collect(&mut self, phase: f64) {
        let first = self.collected.first();
        let near = if self.collected.count() == 0 { phase } else { first + nearest(phase - first, CYCLE) };
        self.collected.add(near);
        if self.last.is_full() {
            self.last.remove(0);
        }
        // There is room now.
        let _ = self.last.push(within(phase, CYCLE) as u16);
    }

    /// What was collected, and what it was compared with.
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

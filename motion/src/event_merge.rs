//! Merging of the motors' step events: the next event of each motor, kept sorted by time.
//!
//! Entries are [`key`](crate::series::key)s. At most six and usually two or three in play: insertion from the
//! front beats a heap.

use units::MAX_ACTUATORS;

/// No event: later than any.
pub(crate) const NEVER: u32 = u32::MAX;

/// The motors' next events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct EventMerge {
    entries: [u32; MAX_ACTUATORS],
}

impl EventMerge {
    /// No motor has an event.
    pub const EMPTY: Self = Self { entries: [NEVER; MAX_ACTUATORS] };

    /// Whether no motor has an event.
    pub fn is_empty(&self) -> bool {
        self.first() == NEVER
    }

    /// The earliest event, or [`NEVER`].
    #[inline(always)]
    pub fn first(&self) -> u32 {
        let [first, ..] = self.entries;
        first
    }

    /// Puts another event, or [`NEVER`], in the place of the earliest one.
    #[inline(always)]
    pub fn replace_first(&mut self, entry: u32) {
        for place in 1..MAX_ACTUATORS {
            if self.entries[place] >= entry {
                self.entries[place - 1] = entry;
                return;
            }
            self.entries[place - 1] = self.entries[place];
        }
        self.entries[MAX_ACTUATORS - 1] = entry;
    }

    /// Adds an event of a motor that has none.
    pub fn insert(&mut self, mut entry: u32) {
        for place in &mut self.entries {
            if entry < *place {
                core::mem::swap(place, &mut entry);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    proptest! {
        #[test]
        fn events_leave_in_order_of_time_then_motor(times in prop::collection::vec(0..1_000_u32, 6), more in prop::collection::vec(0..300_u32, 40)) {
            let key = |time: u32, motor: u32| time << 5 | motor;
            let mut merge = EventMerge::EMPTY;
            for (motor, time) in (0..).zip(&times) {
                merge.insert(key(*time, motor));
            }
            let mut more = more.into_iter();
            let mut seen = Vec::new();
            while !merge.is_empty() {
                let first = merge.first();
                seen.push(first);
                let (time, motor) = (first >> 5, first & 31);
                merge.replace_first(more.next().map_or(NEVER, |step| key(time + step + 1, motor)));
            }
            prop_assert_eq!(seen.len(), 46);
            prop_assert!(seen.is_sorted(), "{seen:?}");
        }
    }
}

//! Which motor is next: the motors' next events, kept sorted by time.
//!
//! An entry is one word: offset from the beginning of the segment in ticks, times eight, plus the motor. Comparing words
//! compares times, and breaks ties by motor, so the order is the same on every machine. At most six entries and
//! usually two or three in play: insertion from the front beats a heap.

use units::MAX_ACTUATORS;

/// No event: later than any.
const NEVER: u32 = u32::MAX;
const MOTOR_BITS: u32 = 3;
const MOTOR_MASK: u32 = (1 << MOTOR_BITS) - 1;

/// The motors' next events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Agenda {
    entries: [u32; MAX_ACTUATORS],
}

impl Agenda {
    pub const EMPTY: Self = Self { entries: [NEVER; MAX_ACTUATORS] };

    pub fn is_empty(&self) -> bool {
        *self == Self::EMPTY
    }

    /// Offset of the earliest event in ticks and its motor.
    #[inline]
    pub fn first(&self) -> Option<(i32, usize)> {
        let [first, ..] = self.entries;
        if first == NEVER {
            return None;
        }
        Some(((first >> MOTOR_BITS) as i32, (first & MOTOR_MASK) as usize))
    }

    /// Whether the earliest event has its tick for itself.
    #[inline]
    pub fn first_is_alone(&self) -> bool {
        let [first, second, ..] = self.entries;
        (first ^ second) >> MOTOR_BITS != 0
    }

    /// Puts another event in the place of the earliest one; `None`: that motor has no more.
    #[inline]
    pub fn replace_first(&mut self, event: Option<(i32, usize)>) {
        let entry = event.map_or(NEVER, word);
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
    pub fn insert(&mut self, offset: i32, motor: usize) {
        let mut entry = word((offset, motor));
        for place in &mut self.entries {
            if entry < *place {
                core::mem::swap(place, &mut entry);
            }
        }
    }
}

/// Offsets are never negative and stay far below 2^28 ticks.
#[inline]
fn word((offset, motor): (i32, usize)) -> u32 {
    (offset as u32) << MOTOR_BITS | motor as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    proptest! {
        #[test]
        fn events_leave_in_order_of_time_then_motor(mut times in prop::collection::vec(0..1_000_i32, 6), more in prop::collection::vec(0..300_i32, 40)) {
            let mut agenda = Agenda::EMPTY;
            for (motor, time) in times.iter().enumerate() {
                agenda.insert(*time, motor);
            }
            let mut more = more.into_iter();
            let mut seen = Vec::new();
            while let Some((time, motor)) = agenda.first() {
                seen.push((time, motor));
                prop_assert_eq!(times[motor], time);
                let others = agenda.entries[1..].iter().filter(|entry| **entry >> MOTOR_BITS == time as u32);
                prop_assert_eq!(agenda.first_is_alone(), others.count() == 0);
                let next = more.next().map(|step| time + step + 1);
                agenda.replace_first(next.map(|next| (next, motor)));
                times[motor] = next.unwrap_or(0);
            }
            prop_assert_eq!(seen.len(), 46);
            prop_assert!(seen.is_sorted(), "{seen:?}");
            prop_assert!(agenda.is_empty());
        }
    }
}

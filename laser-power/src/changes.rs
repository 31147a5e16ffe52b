//! Changes of duty on their way to the step queue, in order of time.
//!
//! Rising and falling edges may have different delays, so an edge may be due before the one ahead of it. Then
//! the later one is what the program wants from there on, and the one ahead is dropped: an edge never
//! overtakes another. A pulse or a gap whose beginning is lost thereby is counted.

use units::{Ring, Ticks};

/// Changes that can wait: those of a delay of 10 ms at 25 000 a second.
const CAPACITY: usize = 256;

#[derive(Clone, Copy, Debug)]
struct Change {
    at: u64,
    duty: u16,
}

/// Answer to the feed's request for a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NextChange {
    /// The laser gets this duty, in 1/65535, then.
    Due(Ticks, u16),
    /// The next change is that far off.
    Later(Ticks),
    /// Nothing waits.
    None,
}

impl NextChange {
    /// Whether a change is due.
    #[must_use]
    pub const fn is_due(self) -> bool {
        matches!(self, Self::Due(..))
    }
}

/// The changes that wait.
#[derive(Debug)]
pub struct Changes {
    waiting: Ring<Change, CAPACITY>,
    /// The last change handed out.
    taken: Change,
}

impl Default for Changes {
    fn default() -> Self {
        Self::new()
    }
}

impl Changes {
    /// Creates an empty list.
    #[must_use]
    pub const fn new() -> Self {
        Self { waiting: Ring::new(Change { at: 0, duty: 0 }), taken: Change { at: 0, duty: 0 } }
    }

    /// The change of power that was added last.
    fn newest(&mut self) -> Change {
        self.waiting.last_mut().copied().unwrap_or(self.taken)
    }

    /// Appends a change. Returns the number of pulses and gaps whose beginning is lost.
    #[inline(never)]
    pub fn push(&mut self, at: Ticks, duty: u16) -> u32 {
        let is_on = |change: Change| change.duty > 0;
        let mut lost = 0;
        while let Some(last) = self.waiting.last_mut().copied().filter(|last| last.at >= at.0) {
            self.waiting.drop_last();
            lost += u32::from(is_on(last) != is_on(self.newest()));
        }
        let newest = self.newest();
        if newest.duty == duty {
            return lost;
        }
        let change = Change { at: at.0.max(newest.at), duty };
        if !self.waiting.push(change)
            && let Some(last) = self.waiting.last_mut()
        {
            // No room: what comes last counts, from the place of the one before on.
            last.duty = duty;
            lost += 1;
        }
        lost
    }

    /// Takes the next change, if it is due before `until`.
    pub fn take(&mut self, until: Ticks) -> NextChange {
        match self.waiting.get(0) {
            Some(change) if change.at < until.0 => {
                self.waiting.drop_first();
                self.taken = change;
                NextChange::Due(Ticks(change.at), change.duty)
            }
            Some(change) => NextChange::Later(Ticks(change.at)),
            None => NextChange::None,
        }
    }

    /// Whether a change is due before `until`.
    #[must_use]
    pub fn has_before(&self, until: Ticks) -> bool {
        self.waiting.get(0).is_some_and(|change| change.at < until.0)
    }

    /// Returns whether no change waits.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Drops what waits; the laser goes off at once, whatever it did.
    pub fn off_at_once(&mut self, at: Ticks) {
        self.waiting.clear();
        let _fits = self.waiting.push(Change { at: at.0, duty: 0 });
    }

    /// Drops what waits, as nothing is played any more.
    pub fn clear(&mut self) {
        self.waiting.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn drain(changes: &mut Changes) -> Vec<(u64, u16)> {
        let mut all = Vec::new();
        while let NextChange::Due(at, duty) = changes.take(Ticks(u64::MAX)) {
            all.push((at.0, duty));
        }
        all
    }

    proptest! {
        #[test]
        fn changes_come_out_in_order_and_end_at_the_last_duty(pushes in prop::collection::vec((0..1_000_u64, 0..4_u16), 1..200)) {
            let mut changes = Changes::new();
            pushes.iter().for_each(|(at, duty)| { changes.push(Ticks(*at), *duty); });
            let all = drain(&mut changes);
            prop_assert!(all.windows(2).all(|pair| pair[0].0 <= pair[1].0 && pair[0].1 != pair[1].1), "{all:?}");
            prop_assert_eq!(all.last().map_or(0, |last| last.1), pushes.last().expect("one").1);
        }
    }

    #[test]
    fn a_pulse_shorter_than_the_difference_of_the_delays_is_told() {
        let mut changes = Changes::new();
        assert_eq!(changes.push(Ticks(110), 9), 0);
        assert_eq!(changes.push(Ticks(105), 0), 1, "the fall comes before the rise");
        assert_eq!(drain(&mut changes), []);
        assert_eq!((changes.push(Ticks(200), 9), changes.push(Ticks(210), 5), changes.push(Ticks(205), 7)), (0, 0, 0));
        assert_eq!(drain(&mut changes), [(200, 9), (205, 7)]);
    }

    #[test]
    fn a_full_ring_keeps_the_last_duty() {
        let mut changes = Changes::new();
        let lost: u32 = (0..CAPACITY as u64 + 5).map(|n| changes.push(Ticks(n), (n % 7) as u16 + 1)).sum();
        assert_eq!(lost, 5);
        assert_eq!(drain(&mut changes).last().map(|last| last.1), Some(((CAPACITY as u64 + 4) % 7) as u16 + 1));
    }
}

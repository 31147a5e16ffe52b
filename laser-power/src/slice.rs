//! A slice of trajectory: where the path is, and how fast, at each share of its time.

use crate::{greatest, least};

/// Slice of trajectory along a block: a cubic of the path distance over the time.
#[derive(Clone, Copy, Debug)]
pub struct Slice {
    /// Path distance from the beginning of the block to the beginning of the slice, mm.
    pub from: f64,
    /// Path distance at its end.
    pub end: f64,
    /// Path speed at the beginning, mm/s.
    pub entry: f64,
    /// Path speed at the end, mm/s.
    pub exit: f64,
    /// Duration of the slice, seconds.
    pub seconds: f64,
}

impl Slice {
    /// Path distance from its beginning and speed, mm and mm for a whole slice, at a share of its time.
    #[inline(never)]
    fn along(&self, share: f64) -> (f64, f64) {
        let (length, entry, exit) = (self.end - self.from, self.entry * self.seconds, self.exit * self.seconds);
        let (square, cube) = (3.0 * length - 2.0 * entry - exit, entry + exit - 2.0 * length);
        let way = share * (entry + share * (square + share * cube));
        (way, entry + share * (2.0 * square + share * 3.0 * cube))
    }

    /// Returns the share of its time at which it comes to this path distance.
    #[must_use]
    #[inline(never)]
    pub fn share_at(&self, distance: f64) -> f64 {
        let (wanted, length) = (distance - self.from, self.end - self.from);
        if wanted <= 0.0 || length <= 0.0 {
            return 0.0;
        }
        let mut bounds = (0.0, 1.0);
        let mut share = least(wanted / length, 1.0);
        for _ in 0..8 {
            let (way, speed) = self.along(share);
            if way < wanted {
                bounds.0 = share
            } else {
                bounds.1 = share
            }
            let next = share + (wanted - way) / speed;
            // Newton's method where it stays within bounds.
            share = if next >= bounds.0 && next <= bounds.1 { next } else { 0.5 * (bounds.0 + bounds.1) };
        }
        share
    }

    /// Returns the path speed at a share of its time, mm/s.
    #[must_use]
    #[inline(never)]
    pub fn speed_at(&self, share: f64) -> f64 {
        if share <= 0.0 {
            self.entry
        } else if share >= 1.0 {
            self.exit
        } else {
            greatest(self.along(share).1 / self.seconds, 0.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Even acceleration: the way is known at each share of the time.
        #[test]
        fn the_share_of_a_place_is_the_time_at_which_the_path_is_there(
            entry in 0.0..500.0_f64, exit in 0.1..500.0_f64, seconds in 1e-5..5e-4_f64, at in 0.001..0.999_f64,
        ) {
            let way = |share: f64| (entry * share + 0.5 * (exit - entry) * share * share) * seconds;
            let slice = Slice { from: 7.0, end: 7.0 + way(1.0), entry, exit, seconds };
            let share = slice.share_at(7.0 + way(at));
            prop_assert!((way(share) - way(at)).abs() < 1e-9, "{share} for {at}");
            prop_assert!((slice.speed_at(at) - (entry + at * (exit - entry))).abs() < 1e-6 * (entry + exit));
            prop_assert_eq!([slice.speed_at(0.0), slice.speed_at(1.0)], [entry, exit]);
        }
    }

    #[test]
    fn a_place_before_a_slice_is_at_its_beginning() {
        let slice = Slice { from: 1.0, end: 2.0, entry: 10.0, exit: 10.0, seconds: 0.1 };
        assert_eq!([slice.share_at(0.5), Slice { end: 1.0, ..slice }.share_at(3.0)], [0.0, 0.0]);
    }
}

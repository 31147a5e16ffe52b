//! Minimum cruise ratio: no short bursts of speed.
//!
//! Beside the plan with the whole acceleration a there is a second one, the cruise plan, with `a (1 - r)`, in
//! squared speeds as well: going forwards, `forward^2 = min(limit, forward^2 before + gain)`, with the gain
//! `2 a (1 - r) L`; going backwards, `entry^2 = min(forward^2, entry^2 of the next + gain)`. At the end of
//! its acceleration the cruise plan has the peak `(entry^2 + entry^2 of the next + gain) / 2`. The peak is
//! the greatest speed of the whole run up and down, which then takes the whole acceleration: of a way that it
//! goes up and down without the cruise speed in between, the share r is left for cruising.
//!
//! Blocks that only speed up have the peak of those behind them, blocks that only slow down that of those
//! before: known in constant time from the next block and, at release, from the one before.

use crate::least;

/// The cruise plan of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CruisePlan {
    /// Squared entry speed going forwards.
    pub forward_sq: f64,
    /// Squared entry speed of the plan.
    pub entry_sq: f64,
    /// Greatest squared speed, if it is known from here on.
    peak_sq: f64,
}

/// The peak is that of what comes before: this block only slows down.
const AS_BEFORE: f64 = -1.0;

impl CruisePlan {
    /// The plan of a block for which no cruise ratio is kept.
    pub const NONE: Self = Self { forward_sq: 0.0, entry_sq: 0.0, peak_sq: 0.0 };

    /// Greatest squared speed; `None`: as before.
    pub fn peak_sq(&self) -> Option<f64> {
        if self.peak_sq >= 0.0 { Some(self.peak_sq) } else { None }
    }

    /// Returns the plan of a block going forwards, from its limit of entry speed, and from the plan of the
    /// block before and the gain along that one, if it still waits.
    pub fn forward(entry_limit_sq: f64, before: Option<(Self, f64)>) -> Self {
        let forward_sq = match before {
            Some((before, gain_sq)) => least(entry_limit_sq, before.forward_sq + gain_sq),
            None => entry_limit_sq,
        };
        Self { forward_sq, entry_sq: 0.0, peak_sq: AS_BEFORE }
    }

    /// Returns the plan of a block going backwards, from the gain along it and the plan of the block after,
    /// or the squared speed at the end of all that is known.
    pub fn backward(self, gain_sq: f64, next: Option<Self>, rest_sq: f64) -> Self {
        let mut plan = self;
        let next_sq = next.map_or(rest_sq, |next| next.entry_sq);
        let reachable_sq = next_sq + gain_sq;
        plan.entry_sq = least(plan.forward_sq, reachable_sq);
        plan.peak_sq = if plan.entry_sq == reachable_sq {
            AS_BEFORE
        } else if plan.entry_sq + gain_sq > next_sq * (1.0 + 1e-9) {
            0.5 * (plan.entry_sq + reachable_sq)
        } else {
            // The block speeds up all along, to the peak of the blocks behind; without such a peak, to its
            // own end.
            next.and_then(|next| next.peak_sq()).unwrap_or(next_sq)
        };
        plan
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLOW_END: CruisePlan = CruisePlan { forward_sq: 100.0, entry_sq: 20.0, peak_sq: AS_BEFORE };

    fn backward(forward_sq: f64, gain_sq: f64, next: Option<CruisePlan>) -> (f64, Option<f64>) {
        let plan = CruisePlan { forward_sq, ..CruisePlan::NONE }.backward(gain_sq, next, 4.0);
        (plan.entry_sq, plan.peak_sq())
    }

    #[test]
    fn the_peak_is_where_speeding_up_and_slowing_down_meet() {
        // 30 more than 10 is 20 more than 20: 50 in all.
        assert_eq!(backward(10.0, 50.0, Some(SLOW_END)), (10.0, Some(40.0)));
        assert_eq!(backward(10.0, 50.0, None), (10.0, Some(32.0)), "at the end of all that is known");
    }

    #[test]
    fn blocks_that_only_slow_down_or_speed_up_have_the_peak_of_others() {
        assert_eq!(backward(100.0, 50.0, Some(SLOW_END)), (70.0, None));
        assert_eq!(backward(10.0, 5.0, Some(SLOW_END)), (10.0, Some(20.0)), "its own end is the peak");
        assert_eq!(backward(10.0, 5.0, Some(CruisePlan { peak_sq: 30.0, ..SLOW_END })), (10.0, Some(30.0)));
    }

    #[test]
    fn going_forwards_a_block_gains_what_the_one_before_allows() {
        let forward = |limit, before| CruisePlan::forward(limit, before).forward_sq;
        let before = CruisePlan { forward_sq: 10.0, ..CruisePlan::NONE };
        assert_eq!(forward(100.0, Some((before, 5.0))), 15.0);
        assert_eq!(forward(12.0, Some((before, 5.0))), 12.0);
        assert_eq!(forward(12.0, None), 12.0);
    }
}

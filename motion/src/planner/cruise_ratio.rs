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

use super::{Block, LookAhead, Planner};
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
    /// Greatest squared speed; `None`: as before.
    pub fn peak_sq(&self) -> Option<f64> {
        if self.peak_sq >= 0.0 { Some(self.peak_sq) } else { None }
    }
}

impl Block {
    /// Returns the block's cruise plan, where a minimum cruise ratio is asked for.
    pub(crate) const fn cruise_plan(&self) -> CruisePlan {
        match self.look_ahead {
            LookAhead::CruisePlan(plan) => plan,
            _ => CruisePlan { forward_sq: 0.0, entry_sq: 0.0, peak_sq: 0.0 },
        }
    }

    pub(super) const fn set_cruise_plan(&mut self, plan: CruisePlan) {
        self.look_ahead = LookAhead::CruisePlan(plan);
    }
}

impl Planner {
    /// Asks for a share of cruising from now on; zero: for none.
    pub(crate) fn keep_cruise_ratio(&mut self, ratio: f64) {
        self.gentle_share = if ratio > 0.0 { Some(1.0 - ratio) } else { None };
    }

    /// Whether a minimum cruise ratio is kept.
    pub(crate) const fn keeps_cruise_ratio(&self) -> bool {
        self.gentle_share.is_some()
    }

    /// Greatest squared speed of the run up or down that a released block is part of, as far as blocks that
    /// are still there tell.
    pub(crate) fn cruise_peak_sq(&self, block: u32) -> Option<f64> {
        let so_far = (0..super::KEPT as u32).map_while(|n| self.released_block(block.wrapping_sub(n)));
        so_far.into_iter().find_map(|block| block.cruise_plan().peak_sq())
    }

    fn gain_sq(block: &Block, share: f64) -> f64 {
        2.0 * block.acceleration * share * block.length
    }

    /// The forward step, from the block before, if it still waits.
    pub(super) fn cruise_plan_forward(&self, block: &Block, before: Option<&Block>) -> Option<CruisePlan> {
        let share = self.gentle_share?;
        let forward_sq = match before {
            Some(before) => least(block.entry_limit_sq, before.cruise_plan().forward_sq + Self::gain_sq(before, share)),
            None => block.entry_limit_sq,
        };
        Some(CruisePlan { forward_sq, entry_sq: 0.0, peak_sq: AS_BEFORE })
    }

    /// The backward step, from the block after, or the end of all that is known.
    pub(super) fn cruise_plan_backward(&self, block: &Block, next: Option<&Block>) -> Option<CruisePlan> {
        let gain_sq = Self::gain_sq(block, self.gentle_share?);
        let mut plan = block.cruise_plan();
        let next_sq = next.map_or(self.rest_sq, |next| next.cruise_plan().entry_sq);
        let reachable_sq = next_sq + gain_sq;
        plan.entry_sq = least(plan.forward_sq, reachable_sq);
        plan.peak_sq = if plan.entry_sq == reachable_sq {
            AS_BEFORE
        } else if plan.entry_sq + gain_sq > next_sq * (1.0 + 1e-9) {
            0.5 * (plan.entry_sq + reachable_sq)
        } else {
            // The block speeds up all along, to the peak of the blocks behind; without such a peak, to its
            // own end.
            next.and_then(|next| next.cruise_plan().peak_sq()).unwrap_or(next_sq)
        };
        Some(plan)
    }
}

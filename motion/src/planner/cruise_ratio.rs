//! Minimum cruise ratio: no short bursts of speed.
//!
//! Beside the plan with the whole acceleration a there is a calm one with `a (1 - r)`, in squared speeds as well: going forwards,
//! `forward^2 = min(limit, forward^2 before + gain)`, with the gain `2 a (1 - r) L`; going backwards, `calm^2 = min(forward^2, calm^2 of the
//! next + gain)`. Where the calm plan stops accelerating, its peak is `(calm^2 + calm^2 of the next + gain) / 2`. That is the greatest speed
//! of the whole run up and down, which then takes the whole acceleration: of a way that it goes up and down without the cruise
//! speed in between, the share r is left for cruising.
//!
//! Blocks that only speed up have the peak of those behind them, blocks that only slow down that of those before: known in constant time
//! from the next block and, at release, from the one before.

use super::{Block, Planner};
use crate::least;

/// The calm plan of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Calm {
    /// Squared entry speed going forwards.
    pub forward_sq: f64,
    /// Squared entry speed of the plan.
    pub entry_sq: f64,
    /// Greatest squared speed, if it is known from here on.
    peak_sq: f64,
}

/// The peak is that of what comes before: this block only slows down.
const AS_BEFORE: f64 = -1.0;

impl Calm {
    /// Greatest squared speed; `None`: as before.
    pub fn peak_sq(&self) -> Option<f64> {
        if self.peak_sq >= 0.0 { Some(self.peak_sq) } else { None }
    }
}

impl Block {
    /// Its calm plan, where calm is asked for.
    pub(crate) const fn calm(&self) -> Calm {
        let [forward_sq, entry_sq, peak_sq] = self.notes;
        Calm { forward_sq, entry_sq, peak_sq }
    }

    pub(super) const fn set_calm(&mut self, calm: Calm) {
        self.notes = [calm.forward_sq, calm.entry_sq, calm.peak_sq];
    }
}

impl Planner {
    /// Asks for a share of cruising from now on; zero: for none.
    pub(crate) fn keep_calm(&mut self, ratio: f64) {
        self.calm_share = if ratio > 0.0 { Some(1.0 - ratio) } else { None };
    }

    /// A minimum cruise ratio is kept.
    pub(crate) const fn is_calm(&self) -> bool {
        self.calm_share.is_some()
    }

    /// Greatest squared speed of the run up or down that a released block is part of, as far as blocks that are still there tell.
    pub(crate) fn calm_peak_sq(&self, block: u32) -> Option<f64> {
        let so_far = (0..super::KEPT as u32).map_while(|n| self.released_block(block.wrapping_sub(n)));
        so_far.into_iter().find_map(|block| block.calm().peak_sq())
    }

    fn gain_sq(block: &Block, share: f64) -> f64 {
        2.0 * block.acceleration * share * block.length
    }

    /// The forward step, from the block before, if it still waits.
    pub(super) fn calm_from(&self, block: &Block, before: Option<&Block>) -> Option<Calm> {
        let share = self.calm_share?;
        let forward_sq = match before {
            Some(before) => least(block.entry_limit_sq, before.calm().forward_sq + Self::gain_sq(before, share)),
            None => block.entry_limit_sq,
        };
        Some(Calm { forward_sq, entry_sq: 0.0, peak_sq: AS_BEFORE })
    }

    /// The backward step, from the block after, or the end of all that is known.
    pub(super) fn calmed(&self, block: &Block, next: Option<&Block>) -> Option<Calm> {
        let gain_sq = Self::gain_sq(block, self.calm_share?);
        let mut calm = block.calm();
        let next_sq = next.map_or(self.rest_sq, |next| next.calm().entry_sq);
        let reachable_sq = next_sq + gain_sq;
        calm.entry_sq = least(calm.forward_sq, reachable_sq);
        calm.peak_sq = if calm.entry_sq == reachable_sq {
            AS_BEFORE
        } else if calm.entry_sq + gain_sq > next_sq * (1.0 + 1e-9) {
            0.5 * (calm.entry_sq + reachable_sq)
        } else {
            // It speeds up all along, to what comes behind; with nothing to come up to, to its own end.
            next.and_then(|next| next.calm().peak_sq()).unwrap_or(next_sq)
        };
        Some(calm)
    }
}

//! Look-ahead: a queue of blocks and the speed at each junction.
//!
//! The plan must always be able to stop at the end of the last block known. Going backwards, a block may be
//! entered at most with `entry^2 = min(limit, next entry^2 + 2 a L)`. The value only ever grows as more
//! blocks become known, so the reverse pass over new blocks ends at the first old block whose value does not
//! change: everything before it stands. Going forwards needs no pass at all: when a block is released its
//! entry speed is final, so its exit is the lesser of the next block's planned entry and what it can reach by
//! accelerating.
//!
//! Cost: `push` and `release` are constant; `plan` visits each block at most once, and in practice those
//! within one braking distance. No pass needs a square root: speeds are squared throughout.

mod block;
mod brake;
mod brake_pass;
mod cruise_ratio;
mod curve_jerk;
mod curve_limits;
mod detour;
mod envelope;
mod junction;
mod peak;
mod ring;

pub use block::{Block, Overrides};
pub(crate) use brake::{Brake, ROUNDING, SAME};
pub(crate) use curve_limits::curve_envelope;
pub(crate) use detour::MOST_OF_DETOUR;
pub(crate) use envelope::{Envelope, SMALLEST};
pub(crate) use junction::{corner_sq, is_tangent, jump_sq};
pub(crate) use ring::KEPT;
pub use ring::{BlockRing, Planner};

use crate::config::MOST_BLOCKS;
use cruise_ratio::CruisePlan;

impl Planner {
    /// Appends a block whose corner is known. `cruise_before` is the cruise speed of the block before it,
    /// zero when it starts from rest. False when full.
    pub(crate) fn push(&mut self, block: Block, cruise_before: f64, rest: f64, overrides: &Overrides) -> bool {
        if self.len() >= MOST_BLOCKS {
            return false;
        }
        let mut block = block;
        block.entry_limit_sq = entry_limit_sq(&block, cruise_before, overrides);
        block.entry_sq = 0.0;
        self.overrides = *overrides;
        let before = if self.is_empty() { None } else { Some(self.block(self.end.wrapping_sub(1))) };
        if let Some(plan) = self.cruise_plan_forward(&block, before) {
            block.set_cruise_plan(plan);
        }
        self.rest_sq = rest * rest;
        self.reserve = 0.0;
        *self.block_mut(self.end) = block;
        self.end = self.end.wrapping_add(1);
        true
    }

    /// Puts a longer block in the place of the last one, which waits: it begins like that. The whole of it is
    /// kept in reserve: for the plan, the path ends at its beginning. Returns the length of the one before.
    pub(crate) fn replace_last(&mut self, block: &Block, overrides: &Overrides) -> f64 {
        let last = self.block_mut(self.end.wrapping_sub(1));
        let before = core::mem::replace(last, *block);
        let cruise = block.cruise(overrides);
        (last.corner_sq, last.is_tangent, last.look_ahead) = (before.corner_sq, before.is_tangent, before.look_ahead);
        (last.entry_limit_sq, last.entry_sq) = (crate::least(before.entry_limit_sq, cruise * cruise), before.entry_sq);
        self.set_reserve(block.length);
        before.length
    }

    /// Reverse pass over whatever is new. At most one visit to each block.
    pub(crate) fn plan(&mut self) {
        if self.planned == self.end {
            return;
        }
        if self.has_jerk() {
            return self.plan_brakes();
        }
        let mut exit_sq = self.rest_sq;
        let mut count = self.end;
        let mut settled = self.settled;
        let mut reserve = self.reserve;
        while count != self.first {
            count = count.wrapping_sub(1);
            let known = count.wrapping_sub(self.planned) as i32 >= 0;
            let after = count.wrapping_add(1);
            let next = if after == self.end { None } else { Some(self.block(after)) };
            let cruise_plan = self.cruise_plan_backward(self.block(count), next);
            let block = self.block_mut(count);
            let reachable_sq = exit_sq + 2.0 * block.acceleration * (block.length - reserve);
            reserve = 0.0;
            let entry_sq = if reachable_sq < block.entry_limit_sq { reachable_sq } else { block.entry_limit_sq };
            let at_limit = entry_sq == block.entry_limit_sq && cruise_plan.is_none_or(|plan| plan.entry_sq == entry_sq);
            if at_limit && count.wrapping_sub(settled) as i32 > 0 {
                settled = count;
            }
            // An old block that keeps its speed shields all before it.
            if !known && entry_sq == block.entry_sq && cruise_plan.is_none_or(|plan| plan == block.cruise_plan()) {
                break;
            }
            if let Some(plan) = cruise_plan {
                block.set_cruise_plan(plan);
            }
            block.entry_sq = entry_sq;
            exit_sq = entry_sq;
        }
        self.planned = self.end;
        self.settled = settled;
    }

    /// Recomputes every junction for changed overrides. `cruise_before` belongs to the block that is being
    /// executed.
    pub(crate) fn replan(&mut self, cruise_before: f64, overrides: &Overrides) {
        self.overrides = *overrides;
        let mut before = cruise_before;
        let mut count = self.first;
        while count != self.end {
            let block = self.block_mut(count);
            block.entry_limit_sq = entry_limit_sq(block, before, overrides);
            before = block.cruise(overrides);
            let earlier = if count == self.first { None } else { Some(self.block(count.wrapping_sub(1))) };
            if let Some(plan) = self.cruise_plan_forward(self.block(count), earlier) {
                self.block_mut(count).set_cruise_plan(plan);
            }
            count = count.wrapping_add(1);
        }
        self.planned = self.first;
        self.settled = self.first;
        self.plan();
    }

    /// Whether profiles are limited in jerk.
    fn has_jerk(&self) -> bool {
        !self.is_empty() && self.block(self.end.wrapping_sub(1)).jerk > 0.0
    }

    /// The reverse pass, where profiles are limited in jerk.
    pub(crate) fn plan_jerk(&mut self) {
        if self.has_jerk() && self.planned != self.end {
            self.plan_brakes();
        }
    }

    /// Says whether more is going to be appended soon.
    pub(crate) fn set_complete(&mut self, complete: bool) {
        if self.complete != complete {
            self.complete = complete;
            if self.has_jerk() && self.planned == self.end {
                self.plan_brakes();
            }
        }
    }

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
        let so_far = (0..KEPT as u32).map_while(|n| self.released_block(block.wrapping_sub(n)));
        so_far.into_iter().find_map(|block| block.cruise_plan().peak_sq())
    }

    fn cruise_plan_forward(&self, block: &Block, before: Option<&Block>) -> Option<CruisePlan> {
        let share = self.gentle_share?;
        let before = before.map(|before| (before.cruise_plan(), before.gain_sq(share)));
        Some(CruisePlan::forward(block.entry_limit_sq, before))
    }

    fn cruise_plan_backward(&self, block: &Block, next: Option<&Block>) -> Option<CruisePlan> {
        let gain_sq = block.gain_sq(self.gentle_share?);
        Some(block.cruise_plan().backward(gain_sq, next.map(Block::cruise_plan), self.rest_sq))
    }
}

/// Returns the limit by the corner and both blocks' cruise speeds.
fn entry_limit_sq(block: &Block, cruise_before: f64, overrides: &Overrides) -> f64 {
    let cruise = block.cruise(overrides);
    let slower = if cruise < cruise_before { cruise } else { cruise_before };
    let slower_sq = slower * slower;
    if block.corner_sq < slower_sq { block.corner_sq } else { slower_sq }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::boxed::Box;

    const PLAIN: Overrides = Overrides { feed: 1.0, rapid: 1.0 };

    fn block(length: f64, acceleration: f64, speed: f64, corner: f64) -> Block {
        Block { length, acceleration, speed_limit: speed, requested: speed, corner_sq: corner * corner, ..Block::EMPTY }
    }

    fn blocks() -> impl Strategy<Value = std::vec::Vec<Block>> {
        let one = (0.001..5.0_f64, 100.0..5_000.0_f64, 1.0..300.0_f64, 0.0..300.0_f64);
        prop::collection::vec(one.prop_map(|(l, a, v, c)| block(l, a, v, c)), 1..MOST_BLOCKS)
    }

    fn filled(blocks: &[Block], plan_after: impl Fn(usize) -> bool) -> Box<Planner> {
        let mut planner = Box::new(Planner::new(Box::default()));
        let mut cruise = 0.0;
        for (index, block) in blocks.iter().enumerate() {
            assert!(planner.push(*block, cruise, 0.0, &PLAIN));
            cruise = block.cruise(&PLAIN);
            if plan_after(index) {
                planner.plan();
            }
        }
        planner.plan();
        planner
    }

    fn entries(planner: &Planner) -> std::vec::Vec<f64> {
        (planner.first..planner.end).map(|count| planner.block(count).entry_sq).collect()
    }

    proptest! {
        #[test]
        fn planning_bit_by_bit_gives_the_plan_of_the_whole(blocks in blocks(), every in 1_usize..20) {
            let (whole, parts) = (filled(&blocks, |_| false), filled(&blocks, |index| index % every == 0));
            prop_assert_eq!(entries(&whole), entries(&parts));
        }

        #[test]
        fn every_move_can_brake_to_the_next_entry_speed(blocks in blocks()) {
            let planner = filled(&blocks, |_| true);
            for (index, block) in blocks.iter().enumerate() {
                let entry_sq = planner.block(index as u32).entry_sq;
                let next_sq = if index + 1 < blocks.len() { planner.block(index as u32 + 1).entry_sq } else { 0.0 };
                let reachable_sq = next_sq + 2.0 * block.acceleration * block.length;
                prop_assert!(entry_sq <= reachable_sq, "enters at {entry_sq} (mm/s)^2, can shed {reachable_sq}");
                prop_assert!(entry_sq <= block.requested * block.requested && entry_sq <= block.corner_sq);
            }
        }

        #[test]
        fn no_entry_speed_could_be_higher(blocks in blocks()) {
            // The plan is optimal: each entry meets the corner, a cruise speed, or the braking distance
            // exactly.
            let planner = filled(&blocks, |_| true);
            for (index, block) in blocks.iter().enumerate() {
                let planned = planner.block(index as u32);
                let next_sq = if index + 1 < blocks.len() { planner.block(index as u32 + 1).entry_sq } else { 0.0 };
                let reachable_sq = next_sq + 2.0 * block.acceleration * block.length;
                prop_assert!(planned.entry_sq == planned.entry_limit_sq || planned.entry_sq == reachable_sq);
            }
        }
    }

    proptest! {
        #[test]
        fn a_settled_front_keeps_its_exit_whatever_comes(known in blocks(), more in blocks()) {
            let mut planner = filled(&known, |_| true);
            if planner.front_is_settled() {
                let exit_sq = planner.block(1).entry_sq;
                let mut cruise = known.last().map_or(0.0, |last| last.cruise(&PLAIN));
                for block in more {
                    planner.push(block, cruise, 0.0, &PLAIN);
                    cruise = block.cruise(&PLAIN);
                    planner.plan();
                }
                prop_assert_eq!(planner.block(1).entry_sq, exit_sq);
            }
        }
    }

    #[test]
    fn a_released_block_makes_room_and_a_full_queue_refuses() {
        let mut planner = filled(&[block(1.0, 1_000.0, 50.0, 50.0); MOST_BLOCKS - 1], |_| true);
        assert!(planner.push(block(1.0, 1_000.0, 50.0, 50.0), 50.0, 0.0, &PLAIN));
        assert!(!planner.push(block(1.0, 1_000.0, 50.0, 50.0), 50.0, 0.0, &PLAIN));
        assert!(planner.release().is_some());
        assert!(planner.push(block(1.0, 1_000.0, 50.0, 50.0), 50.0, 0.0, &PLAIN));
        planner.clear();
        assert!(planner.is_empty() && planner.release().is_none());
    }

    #[test]
    fn an_override_lowers_every_junction_and_lifting_it_restores_them() {
        let blocks = [block(10.0, 1_000.0, 100.0, 200.0); 20];
        let mut planner = filled(&blocks, |_| true);
        let before = entries(&planner);
        planner.replan(10.0, &Overrides { feed: 0.1, rapid: 1.0 });
        assert!(entries(&planner).iter().all(|entry_sq| *entry_sq <= 100.000_1), "{:?}", entries(&planner));
        planner.replan(0.0, &PLAIN);
        assert_eq!(entries(&planner)[1..], before[1..]);
    }
}

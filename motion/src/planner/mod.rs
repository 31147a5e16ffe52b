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
mod cruise_ratio;
mod curve_jerk;
mod curve_limits;
mod detour;
mod junction;
mod peak;

pub use block::{Block, Overrides};
pub(crate) use block::{Envelope, SMALLEST};
pub(crate) use brake::{Brake, ROUNDING, SAME, is_tangent};
pub(crate) use curve_limits::curve_envelope;
pub(crate) use detour::MOST_OF_DETOUR;
pub(crate) use junction::{corner_sq, jump_sq};

use crate::elsewhere::Elsewhere;
use block::LookAhead;

/// Number of blocks that fit: at 0.2 mm a block and 100 mm/s, half a second of look-ahead. See [`BlockRing`].
pub const CAPACITY: usize = 256;
/// Released blocks that stay in the ring behind those that wait, where trajectory may be taken back.
pub(crate) const KEPT: usize = 32;

/// The place of the blocks that wait. About 44 KiB, all zero at the start, looked at for every piece of the
/// trajectory: a board gives it its fastest memory.
#[derive(Debug)]
pub struct BlockRing([Block; CAPACITY]);

impl BlockRing {
    /// Creates an empty ring.
    #[must_use]
    pub const fn new() -> Self {
        Self([Block::ZERO; CAPACITY])
    }
}

impl Default for BlockRing {
    fn default() -> Self {
        Self::new()
    }
}

/// The queue of blocks that have not begun. Blocks are counted from the beginning of time (wrapping).
#[derive(Debug)]
pub struct Planner {
    blocks: Elsewhere<BlockRing>,
    /// Count of the first block that may be taken back, if it is still there.
    kept: u32,
    /// Count of blocks ever released.
    first: u32,
    /// Count of blocks ever pushed.
    end: u32,
    /// Blocks before this one have been through a reverse pass.
    planned: u32,
    /// Newest block whose entry speed is as high as its corner allows: no block to come can change its entry,
    /// nor any before it.
    settled: u32,
    /// Squared speed with which the last block ends: that of a standstill.
    rest_sq: f64,
    /// Length of the last block that the rounding of a corner behind it may yet take, mm. The block's entry
    /// speed is planned without that length, so that it can only grow.
    reserve: f64,
    /// Whether nothing will be appended soon: the path ends with the last block.
    complete: bool,
    /// Overrides that are in force.
    overrides: Overrides,
    /// Share of the acceleration that the cruise plan may use.
    gentle_share: Option<f64>,
}

impl Planner {
    /// Creates an empty queue.
    pub(crate) const fn new(blocks: Elsewhere<BlockRing>) -> Self {
        Self {
            blocks,
            kept: 0,
            first: 0,
            end: 0,
            planned: 0,
            settled: 0,
            rest_sq: 0.0,
            reserve: 0.0,
            complete: true,
            overrides: Overrides { feed: 1.0, rapid: 1.0 },
            gentle_share: None,
        }
    }

    /// Returns the number of blocks that wait.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.end.wrapping_sub(self.first) as usize
    }

    /// Returns whether no block waits.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.first == self.end
    }

    /// Count of blocks ever pushed, wrapping: changes whenever something new comes.
    pub(crate) const fn pushed(&self) -> u32 {
        self.end
    }

    /// Count of blocks ever released, wrapping.
    pub(crate) const fn released(&self) -> u32 {
        self.first
    }

    fn block(&self, count: u32) -> &Block {
        // The remainder is always in range: the check disappears.
        &self.blocks.0[count as usize % CAPACITY]
    }

    fn block_mut(&mut self, count: u32) -> &mut Block {
        &mut self.blocks.0[count as usize % CAPACITY]
    }

    /// The block so many after the front.
    pub(crate) fn ahead(&self, index: usize) -> Option<&Block> {
        if index < self.len() { Some(self.block(self.first.wrapping_add(index as u32))) } else { None }
    }

    /// The block that would be released next.
    #[must_use]
    pub fn front(&self) -> Option<&Block> {
        if self.is_empty() { None } else { Some(self.block(self.first)) }
    }

    /// Appends a block whose corner is known. `cruise_before` is the cruise speed of the block before it,
    /// zero when it starts from rest. False when full.
    pub(crate) fn push(&mut self, block: Block, cruise_before: f64, rest: f64, overrides: &Overrides) -> bool {
        if self.len() >= CAPACITY {
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

    /// Sets the length of the last block that a corner behind it may yet take, mm.
    pub(crate) fn set_reserve(&mut self, reserve: f64) {
        if reserve != self.reserve && !self.is_empty() {
            self.reserve = reserve;
            self.planned = self.end.wrapping_sub(1);
        }
    }

    /// Lets the last block end earlier by `by` mm, no more than its reserve, at `target`.
    pub(crate) fn shorten_last(&mut self, by: f64, target: &units::PerAxis<f64>) {
        let last = self.block_mut(self.end.wrapping_sub(1));
        last.length -= by;
        last.target = *target;
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

    /// Whether the exit speed of the next block to be released is final, whatever comes behind.
    pub(crate) fn front_is_settled(&self) -> bool {
        self.settled.wrapping_sub(self.first) as i32 > 0
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

    /// Takes the next block out. Plan first.
    pub(crate) fn release(&mut self) -> Option<Block> {
        let block = *self.front()?;
        self.first = self.first.wrapping_add(1);
        // The marks never lag behind the queue, so that counts compare rightly for ever.
        for mark in [&mut self.planned, &mut self.settled] {
            if mark.wrapping_sub(self.first) as i32 <= 0 {
                *mark = self.first;
            }
        }
        Some(block)
    }

    /// A block that was released and can be taken back: nothing has taken its place, and what followed it is
    /// still to follow.
    pub(crate) fn released_block(&self, count: u32) -> Option<&Block> {
        let is_kept = count.wrapping_sub(self.kept) as i32 >= 0 && (self.end.wrapping_sub(count) as usize) <= CAPACITY;
        let is_released = (self.first.wrapping_sub(count) as i32) > 0;
        if is_kept && is_released { Some(self.block(count)) } else { None }
    }

    /// The block of this count, that waits or was released.
    pub(crate) fn any_block(&self, count: u32) -> Option<&Block> {
        if (self.end.wrapping_sub(count) as i32) > 0 { Some(self.block(count)) } else { None }
    }

    /// Makes everything behind a released block wait again. Then [`Self::replan`].
    pub(crate) fn take_back(&mut self, count: u32) {
        self.first = count.wrapping_add(1);
        // A block that is executed again is not shortened any more for a rounded corner.
        self.reserve = 0.0;
    }

    /// Squared speed with which the block in execution should end: the planned entry of the next one.
    pub(crate) fn next_entry_sq(&self) -> f64 {
        self.front().map_or(self.rest_sq, |next| next.entry_sq)
    }

    /// Forgets every block of the queue.
    pub(crate) fn clear(&mut self) {
        self.first = self.end;
        self.kept = self.end;
        self.planned = self.end;
        self.settled = self.end;
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
        prop::collection::vec(one.prop_map(|(l, a, v, c)| block(l, a, v, c)), 1..CAPACITY)
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
        let mut planner = filled(&[block(1.0, 1_000.0, 50.0, 50.0); CAPACITY - 1], |_| true);
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

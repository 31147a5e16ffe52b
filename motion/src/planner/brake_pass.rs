//! Look-ahead with jerk: where each block must have slowed down, and to what.
//!
//! Ramps ([`crate::ramp`]) have an acceleration between their ends, so speeds at junctions do not say all.
//! Instead each block knows its *anchor*: the junction ahead at which a ramp down has to end, with what
//! speed, and how far that is. Without acceleration a speed v is safe at a distance S before the anchor with
//! speed w if the ramp from v to w is no longer than S (or v is below w) and no junction between is passed
//! too fast.
//!
//! Going backwards, the anchor of a block is either its own end or the anchor of the next block, passing
//! through the junction with whatever acceleration there is. Passing through is allowed where the path goes
//! straight on, the limits of acceleration and jerk are the same on both sides, and the junction's own limit
//! does not hold speed down already. The speed of a ramp at a junction is bounded twice, either bound is
//! enough: by the steepest ramp to the anchor ([`crate::ramp::Bounds::launch`]), or because it begins no
//! faster than the junction allows (`top`).
//!
//! A block that is known keeps its anchor unless the new one allows as much speed: so a speed that was safe
//! stays safe whatever is appended. An anchor's speed may still grow as more becomes known; a ramp to a
//! somewhat higher speed may be longer, by 8.9 % at most (`D(v, v/3) / D(v, 0) = 4/3 sqrt(2/3)`, the greatest
//! there is), which is kept in reserve until it cannot.
//!
//! Cost: as without jerk, constant for each block visited, and the pass ends at the first block that keeps
//! its anchor.

use super::{
    block::Block,
    brake::{Brake, ROUNDING},
    ring::Planner,
};
use crate::{greatest, least, square_root};

impl Planner {
    /// The anchor of a block before `next`, or before the end of all that is known; and the greatest safe
    /// speed without acceleration at its beginning, squared.
    pub(crate) fn brake(&self, block: &Block, next: Option<&Block>) -> (Brake, f64) {
        let brake = match next {
            None => own_end(block, self.rest_sq, self.complete),
            Some(next) => {
                let cruise = block.cruise(&self.overrides);
                through(block, next, cruise)
                    .unwrap_or_else(|| own_end(block, next.entry_sq, self.complete || next.is_at_limit()))
            }
        };
        (brake, entry_sq_by(&brake, block))
    }

    /// The anchor of the running block by what its path allows, whatever is asked for: as [`Self::brake`],
    /// from as far on as any way from `speed` to rest reaches.
    pub(crate) fn hard_brake(&self, block: &Block, speed: f64) -> Brake {
        let (mut bounds, mut length, mut count) = (block.bounds(), block.length, 0);
        while let (true, Some(next)) = (length < bounds.length(speed, 0.0), self.ahead(count)) {
            bounds = bounds.and(&next.bounds());
            length += next.length;
            count += 1;
        }
        let mut after: Option<Block> = None;
        for index in (0..count).rev() {
            let Some(mut next) = self.ahead(index).copied() else { continue };
            next.entry_limit_sq = next.bound() * next.bound();
            let (brake, entry_sq) = self.hard_step(&next, after.as_ref());
            next.set_brake(brake, entry_sq);
            after = Some(next);
        }
        self.hard_step(block, after.as_ref()).0
    }

    /// Returns the anchor, of those that a block may have, that lets the block be entered faster.
    fn hard_step(&self, block: &Block, next: Option<&Block>) -> (Brake, f64) {
        let (brake, entry_sq) = self.brake(block, next);
        let far = Brake { sure: true, ..brake };
        let near = own_end(block, next.map_or(self.rest_sq, |next| next.entry_sq), true);
        let near_sq = entry_sq_by(&near, block);
        if near_sq > entry_sq { (near, near_sq) } else { (far, entry_sq) }
    }

    /// Runs the reverse pass of jerk-limited look-ahead.
    pub(super) fn plan_brakes(&mut self) {
        let mut count = self.end;
        let mut settled = self.settled;
        while count != self.first {
            count = count.wrapping_sub(1);
            let after = count.wrapping_add(1);
            let next = if after == self.end { None } else { Some(self.block(after)) };
            let block = self.block(count);
            let (brake, entry_sq) = match next {
                // A rounded corner may yet take the end of the last block.
                None => self.brake(&Block { length: block.length - self.reserve, ..*block }, None),
                next => self.brake(block, next),
            };
            let is_new = count.wrapping_sub(self.planned) as i32 >= 0;
            let same = brake == block.brake() && entry_sq == block.entry_sq;
            let (brake, entry_sq) = match next {
                // An anchor within the block was that of a block whose end might be taken; there is nothing
                // to stop for.
                Some(next) if entry_sq < block.entry_sq && block.brake().length < block.length - ROUNDING => {
                    let brake = own_end(block, next.entry_sq, self.complete || next.is_at_limit());
                    let entry_sq = entry_sq_by(&brake, block);
                    // Rest can be had at its end, if it could before.
                    if entry_sq >= block.entry_sq {
                        (brake, entry_sq)
                    } else {
                        (own_end(block, 0.0, false), block.entry_sq)
                    }
                }
                _ if !is_new && (same || entry_sq < block.entry_sq) => break,
                _ => (brake, entry_sq),
            };
            let block = self.block_mut(count);
            block.set_brake(brake, entry_sq);
            if block.is_at_limit() && count.wrapping_sub(settled) as i32 > 0 {
                settled = count;
            }
        }
        self.planned = self.end;
        self.settled = settled;
    }
}

/// A block's own end as its anchor.
fn own_end(block: &Block, speed_sq: f64, sure: bool) -> Brake {
    Brake { length: block.length, speed: square_root(speed_sq), top: f64::INFINITY, sure }
}

/// The greatest safe speed without acceleration at the beginning of a block with this anchor, squared.
fn entry_sq_by(brake: &Brake, block: &Block) -> f64 {
    let entry = least(brake.top, greatest(brake.reach(brake.length, &block.bounds()), brake.speed));
    least(entry * entry, block.entry_limit_sq)
}

/// The anchor of the block after, if ramps may run through to it.
fn through(block: &Block, next: &Block, cruise: f64) -> Option<Brake> {
    if !next.is_tangent || !next.ramps_like(block) || next.is_at_limit() {
        return None;
    }
    let (far, limit, bounds) = (next.brake(), next.limit(), block.bounds());
    let top = if bounds.launch(far.speed, limit) < far.length { least(far.top, limit) } else { far.top };
    // A long block need not be slow for the sake of a ramp that fits into it.
    if top < cruise && bounds.length(cruise, square_root(next.entry_sq)) <= block.length {
        return None;
    }
    Some(Brake { length: block.length + far.length, top, ..far })
}

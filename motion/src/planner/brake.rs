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

use core::f64::consts::SQRT_2;

use super::{Block, Envelope, LookAhead, Planner};
use crate::{config::Limits, greatest, least, ramp::Bounds, square_root};

/// Ramps to an anchor whose speed is not final are given this much more room than they need.
const RESERVE: f64 = 1.09;
/// Rounding of path lengths, mm.
pub(crate) const ROUNDING: f64 = 1e-9;
/// Speeds that differ by less are one: a ramp between them is far longer than their difference (it goes with
/// its root).
pub(crate) const SAME: f64 = 1.0 + 1e-9;
/// Cosine of the greatest angle (26 degrees) at which a path counts as going on without a corner.
const SMOOTH: f64 = 0.9;
/// Shortest time in which the acceleration reaches its limit, seconds; stands in where no jerk limits an
/// axis.
const SHORTEST_RISE: f64 = 0.000_5;

/// A block's anchor. (Its entry speed by this is in [`Block::entry_sq`].)
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Brake {
    /// Distance from the block's beginning to the anchor, mm.
    pub length: f64,
    /// Greatest speed at the anchor.
    pub speed: f64,
    /// Greatest speed at the beginning of a ramp to the anchor.
    pub top: f64,
    /// The anchor's speed is final.
    pub sure: bool,
}

impl Brake {
    /// Room that a ramp down from `speed` to the anchor takes, with reserve.
    pub fn braking(&self, speed: f64, bounds: &Bounds) -> f64 {
        if speed <= self.speed * SAME {
            return 0.0;
        }
        bounds.length(speed, self.speed) * if self.sure { 1.0 } else { RESERVE }
    }

    /// Whether a speed without acceleration is safe `room` before the anchor.
    pub fn is_safe(&self, speed: f64, room: f64, bounds: &Bounds) -> bool {
        let ramp = if speed <= self.speed * SAME { 0.0 } else { bounds.length(speed, self.speed) };
        // A speed chosen as safe, within its rounding, must be found safe afterwards too.
        speed <= self.top * (1.0 + 1e-12) && ramp <= room + 2.0 * ROUNDING
    }

    /// Returns the greatest safe speed without acceleration, with reserve.
    fn reach(&self, room: f64, bounds: &Bounds) -> f64 {
        bounds.reach(self.speed, if self.sure { room } else { room / RESERVE })
    }
}

/// Whether the path goes straight on, as nearly as a finely cut curve does.
pub(crate) fn is_tangent(before: Option<[f64; 3]>, after: Option<[f64; 3]>) -> bool {
    let (Some(before), Some(after)) = (before, after) else { return false };
    before.iter().zip(after).map(|(p, n)| p * n).sum::<f64>() >= SMOOTH
}

/// The greatest `unit * 2^(n/4)` that is not above `value`.
fn rounded_down(value: f64, unit: f64) -> f64 {
    let n = libm::floor(4.0 * libm::log2(value / unit) + 1e-9);
    least(unit * power_of_two(n), value)
}

/// `2^(quarters/4)` of a whole number of quarters, rounded as [`libm::exp2`] does it, which has a table of
/// 4 kB for any exponent.
fn power_of_two(quarters: f64) -> f64 {
    /// 2 to the power of no, one, two and three quarters.
    const ROOTS: [f64; 4] = [1.0, 1.189_207_115_002_721, SQRT_2, 1.681_792_830_507_429];
    let whole = libm::floor(0.25 * quarters);
    let root = ROOTS.get((quarters - 4.0 * whole) as usize);
    libm::ldexp(root.copied().unwrap_or(1.0), whole as i32)
}

impl Block {
    /// The limits of ramps in it.
    pub(crate) fn bounds(&self) -> Bounds {
        Bounds { acceleration: self.acceleration, jerk: self.jerk }
    }

    /// Whether ramps may run from `other` into this block or back: same limits.
    pub(crate) fn ramps_like(&self, other: &Self) -> bool {
        self.jerk == other.jerk && self.acceleration == other.acceleration
    }

    /// Returns the block's anchor, where profiles are limited in jerk.
    pub(crate) const fn brake(&self) -> Brake {
        match self.look_ahead {
            LookAhead::Brake(brake) => brake,
            _ => Brake { length: 0.0, speed: 0.0, top: 0.0, sure: true },
        }
    }

    /// Sets its anchor, and its entry speed by that.
    pub(crate) const fn set_brake(&mut self, brake: Brake, entry_sq: f64) {
        self.look_ahead = LookAhead::Brake(brake);
        self.entry_sq = entry_sq;
    }

    /// Greatest speed at its beginning by its corner and both cruise speeds.
    pub(crate) fn limit(&self) -> f64 {
        square_root(self.entry_limit_sq)
    }

    /// Greatest speed at its beginning that no override changes: by its corner and its speed limit.
    pub(crate) fn bound(&self) -> f64 {
        least(square_root(self.corner_sq), self.speed_limit)
    }

    /// Whether the planned entry speed has reached its limit.
    fn is_at_limit(&self) -> bool {
        self.entry_sq >= self.entry_limit_sq
    }
}

impl Envelope {
    /// Sets the jerk of a straight move, if any is configured.
    pub(crate) fn limit_straight_jerk(&mut self, limits: &Limits) {
        if !limits.has_jerk() {
            return;
        }
        let mut jerk = limits.jerk.map_or(f64::INFINITY, |jerk| jerk.get());
        let shares = self.primary.unwrap_or_default();
        for (part, limit) in shares.iter().zip(limits.axis_jerk) {
            if let (Some(limit), true) = (limit, *part != 0.0) {
                jerk = least(jerk, limit.get() / libm::fabs(*part));
            }
        }
        self.limit_jerk(jerk, &shares, limits);
    }

    /// Sets the jerk. Acceleration and jerk are rounded down to steps of a fourth root of two, so that they
    /// stay the same from chord to chord of a curve.
    ///
    /// `shares` is how much of a millimetre of path each of X Y Z moves at most.
    pub(crate) fn limit_jerk(&mut self, jerk: f64, shares: &[f64; 3], limits: &Limits) {
        let mut unit = limits.jerk.map_or(f64::INFINITY, |jerk| jerk.get());
        for (part, limit) in shares.iter().zip(limits.axis_jerk) {
            if let (Some(limit), true) = (limit, *part != 0.0) {
                unit = least(unit, limit.get());
            }
        }
        self.acceleration = rounded_down(self.acceleration, limits.acceleration.get());
        let fastest = self.acceleration / SHORTEST_RISE;
        self.jerk = if jerk < fastest { rounded_down(jerk, unit) } else { fastest };
    }
}

impl Planner {
    /// Whether profiles are limited in jerk.
    pub(super) fn has_jerk(&self) -> bool {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarters_of_a_power_of_two_are_those_of_the_library() {
        for quarters in -4000..4000 {
            let quarters = f64::from(quarters);
            assert_eq!(power_of_two(quarters), libm::exp2(0.25 * quarters), "{quarters}");
        }
        for beyond in [-1e9, 1e9, f64::NEG_INFINITY, f64::INFINITY] {
            assert_eq!(power_of_two(beyond), libm::exp2(0.25 * beyond), "{beyond}");
        }
    }
}

//! Anchor of a block, its brake point: the junction ahead at which a ramp down has to end, with what speed,
//! and how far that is ([`super::brake_pass`] finds it).

use crate::ramp::Bounds;

/// Ramps to an anchor whose speed is not final are given this much more room than they need.
const RESERVE: f64 = 1.09;
/// Rounding of path lengths, mm.
pub(crate) const ROUNDING: f64 = 1e-9;
/// Speeds that differ by less are one: a ramp between them is far longer than their difference (it goes with
/// its root).
pub(crate) const SAME: f64 = 1.0 + 1e-9;

/// Anchor of a block. (The entry speed by this is in the block.)
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
    pub fn reach(&self, room: f64, bounds: &Bounds) -> f64 {
        bounds.reach(self.speed, if self.sure { room } else { room / RESERVE })
    }
}

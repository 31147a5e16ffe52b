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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_reach_is_safe_and_leaves_its_reserve(
            room in 0.01..50.0_f64, speed in 0.0..100.0_f64, acceleration in 100.0..5_000.0_f64, rise in 0.001..0.1_f64,
        ) {
            let bounds = Bounds { acceleration, jerk: acceleration / rise };
            for sure in [true, false] {
                let brake = Brake { length: room, speed, top: f64::INFINITY, sure };
                let reach = brake.reach(room, &bounds);
                prop_assert!(brake.is_safe(reach, room, &bounds));
                let braking = brake.braking(reach, &bounds);
                prop_assert!(braking <= room * (1.0 + 1e-6) + 1e-6, "{braking} mm from {reach} mm/s, sure: {sure}");
                prop_assert!(brake.braking(reach + 1.0, &bounds) > room, "it could be faster");
            }
        }
    }

    #[test]
    fn a_speed_above_the_top_is_not_safe_however_much_room_there_is() {
        let bounds = Bounds { acceleration: 1_000.0, jerk: 1e5 };
        let brake = Brake { length: 100.0, speed: 5.0, top: 20.0, sure: true };
        assert!(brake.is_safe(20.0, 100.0, &bounds) && !brake.is_safe(20.1, 100.0, &bounds));
    }
}

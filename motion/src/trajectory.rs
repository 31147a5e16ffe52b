//! The trajectory: pieces of position over time.
//!
//! Time is absolute, in step ticks with 32 bits of fraction: exact to add, never wrapping, equal on every
//! machine. A piece is the distance along a path as a polynomial of local time. Filters (input shaping,
//! pressure advance) stand between here and [`crate::knots`].

use fixed::types::U96F32;
use units::{Axis, PerAxis, STEP_CLOCK_HZ, Ticks};

use crate::{
    convert::{fixed_32, float_of_u64},
    path::Path,
};

/// A point on, or a length of, the step clock, finer than a tick: 96 bits of ticks, 32 of fraction.
pub type TickTime = U96F32;

/// Fixed-point units of [`TickTime`] in a second.
const UNITS_PER_SECOND: f64 = STEP_CLOCK_HZ as f64 * 4_294_967_296.0;

/// A length of time in seconds, zero when negative or not a number.
#[must_use]
pub fn tick_time(seconds: f64) -> TickTime {
    TickTime::from_bits(fixed_32(seconds * STEP_CLOCK_HZ as f64))
}

/// Returns the time from one moment to a later one, seconds; zero when it is not later.
#[must_use]
pub(crate) fn seconds_between(from: TickTime, to: TickTime) -> f64 {
    let units = to.saturating_sub(from).to_bits();
    // A slow move may take longer than the 21 s of 64 bits.
    let (high, low) = (float_of_u64((units >> 64) as u64), float_of_u64(units as u64));
    (high * 18_446_744_073_709_551_616.0 + low) / UNITS_PER_SECOND
}

/// Seconds in the low half of a length of [`TickTime`].
pub(crate) fn seconds_of(units: u64) -> f64 {
    float_of_u64(units) / UNITS_PER_SECOND
}

/// The whole tick at a point in time.
#[must_use]
pub const fn whole_ticks(time: TickTime) -> Ticks {
    Ticks((time.to_bits() >> 32) as u64)
}

/// A point in time at a whole tick.
#[must_use]
pub const fn at_tick(ticks: Ticks) -> TickTime {
    TickTime::from_bits((ticks.0 as u128) << 32)
}

/// Constant jerk along a path: none in a trapezoid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Piece {
    /// Time at its beginning.
    pub start: TickTime,
    /// Duration of the piece, in seconds.
    pub duration: f64,
    /// The way of the whole block.
    pub path: Path,
    /// Path distance at which the piece begins, mm.
    pub base: f64,
    /// Path speed at the beginning, mm/s.
    pub speed: f64,
    /// Path acceleration at the beginning, mm/s^2.
    pub acceleration: f64,
    /// Path jerk, mm/s^3.
    pub jerk: f64,
}

/// Trajectory was taken back: what follows replaces it. No axis had used it, or those that had stood still;
/// but for extruders with pressure advance, which go over from the old to the new over one latency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TakenBack {
    /// Number that changes each time.
    pub count: u32,
    /// Time from which the trajectory was taken back.
    pub from: TickTime,
    /// Time up to which the output of the filters was settled then: until there extruders follow the old
    /// trajectory.
    pub out: TickTime,
}

impl Piece {
    /// Path distance from the beginning after `t` seconds, mm.
    #[must_use]
    pub fn distance(&self, t: f64) -> f64 {
        (self.speed + (0.5 * self.acceleration + self.jerk / 6.0 * t) * t) * t
    }

    /// Path speed after `t` seconds, mm/s.
    #[must_use]
    pub fn speed_at(&self, t: f64) -> f64 {
        self.speed + (self.acceleration + 0.5 * self.jerk * t) * t
    }

    /// Path acceleration after `t` seconds, mm/s^2.
    #[must_use]
    pub fn acceleration_at(&self, t: f64) -> f64 {
        self.acceleration + self.jerk * t
    }

    /// Machine position at this path distance from the beginning.
    #[must_use]
    pub fn point_after(&self, distance: f64) -> PerAxis<f64> {
        self.path.point(self.base + distance)
    }

    /// Returns the movement of each axis for a millimetre of path at this path distance from the beginning.
    #[must_use]
    pub fn tangent_after(&self, distance: f64) -> PerAxis<f64> {
        self.path.tangent(self.base + distance)
    }
}

/// The point at `distance` from `origin` along `direction`.
#[must_use]
pub(crate) fn along(origin: &PerAxis<f64>, direction: &PerAxis<f64>, distance: f64) -> PerAxis<f64> {
    let mut point = *origin;
    for axis in Axis::ALL {
        point[axis] += direction[axis] * distance;
    }
    point
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_times_are_told_as_well_as_short_ones() {
        for seconds in [1e-6, 20.0, 22.0, 3_600.0] {
            let from = at_tick(Ticks(12_345));
            assert!((seconds_between(from, from + tick_time(seconds)) / seconds - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn seconds_become_ticks_and_nonsense_becomes_nothing() {
        assert_eq!(whole_ticks(tick_time(0.001)), Ticks(200_000));
        assert_eq!(tick_time(-1.0), TickTime::ZERO);
        assert_eq!(tick_time(f64::NAN), TickTime::ZERO);
        assert_eq!(whole_ticks(at_tick(Ticks(7)) + tick_time(2.6e-9 + 2.6e-9)), Ticks(8));
    }
}

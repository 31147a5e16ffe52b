//! The trajectory: pieces of position over time.
//!
//! Time is absolute, in step ticks with 32 bits of fraction: exact to add, never wrapping, equal on every
//! machine. A piece is the distance along a path as a polynomial of local time. Filters (input shaping,
//! pressure advance) stand between here and [`crate::knots`].

use units::{Axis, PerAxis};
pub use units::{TickTime, tick_time, whole_ticks};
pub(crate) use units::{at_tick, seconds_between, seconds_of};

use crate::path::Path;

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

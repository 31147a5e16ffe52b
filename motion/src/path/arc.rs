//! A part of a circle in any plane, or several turns of it.
//!
//! With u from the centre to the start and v, as long and at right angles to it, the way the arc sets out,
//! the place at angle p is `(cos p - 1) u + sin p v` from the start. `cos p - 1` is taken as `-2 sin^2 (p /
//! 2)`, which keeps its digits for the shortest arcs of the widest circles.

use super::{Vector, mix, size};

use crate::square_root;

/// A circle, evenly travelled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// Vector from the centre to the start, mm.
    arm: Vector,
    /// Vector as long, at right angles, ahead.
    ahead: Vector,
    /// Angle of the arc, rad, above zero. More than a turn is allowed.
    angle: f64,
    /// Length of the whole path, rise included, mm.
    length: f64,
}

impl Arc {
    /// Creates an arc from the vector from the centre to the start, the one of the same length at right
    /// angles to it that points ahead, the angle in rad, and the rise of the path in all at right angles to
    /// both, mm.
    #[must_use]
    pub fn new(arm: [f64; 3], ahead: [f64; 3], angle: f64, rise: f64) -> Self {
        let way = size(arm) * angle;
        Self { arm, ahead, angle, length: square_root(way * way + rise * rise) }
    }

    /// Length of the path, mm.
    #[must_use]
    pub const fn length(&self) -> f64 {
        self.length
    }

    /// Returns the vector from the centre to the start, mm.
    #[must_use]
    pub const fn arm(&self) -> [f64; 3] {
        self.arm
    }

    /// Returns the vector as long as the arm, at right angles to it, in the direction in which the arc sets
    /// out.
    #[must_use]
    pub const fn ahead(&self) -> [f64; 3] {
        self.ahead
    }

    /// Returns the whole angle of the arc, rad.
    #[must_use]
    pub const fn angle(&self) -> f64 {
        self.angle
    }

    /// Angle for a millimetre of path, rad/mm.
    pub(crate) const fn rate(&self) -> f64 {
        self.angle / self.length
    }

    /// Returns the addition to X, Y and Z after `s` mm of path.
    pub(super) fn offset(&self, s: f64) -> Vector {
        let (sin, cos) = libm::sincos(0.5 * self.angle * (s / self.length));
        mix(-2.0 * sin * sin, self.arm, 2.0 * sin * cos, self.ahead)
    }

    /// Returns the addition for the next millimetre of path, after `s` mm.
    pub(super) fn slope(&self, s: f64) -> Vector {
        let rate = self.rate();
        let (sin, cos) = libm::sincos(self.angle * (s / self.length));
        mix(-rate * sin, self.arm, rate * cos, self.ahead)
    }

    /// Returns the change of the slope for each millimetre of path, 1/mm.
    pub(super) fn bend(&self, s: f64) -> Vector {
        let rate_sq = self.rate() * self.rate();
        let (sin, cos) = libm::sincos(self.angle * (s / self.length));
        mix(-rate_sq * cos, self.arm, -rate_sq * sin, self.ahead)
    }

    /// Returns the change of the bend for each millimetre of path, 1/mm^2.
    pub(super) fn twist(&self, s: f64) -> Vector {
        let cubed = self.rate() * self.rate() * self.rate();
        let (sin, cos) = libm::sincos(self.angle * (s / self.length));
        mix(cubed * sin, self.arm, -cubed * cos, self.ahead)
    }
}

//! Two vertical towers left and right, a rod on each down to the tool, and a bed that moves in Y.
//!
//! Alpha is the left carriage, beta the right one: `z + sqrt(L^2 - d^2)` with d the distance in X. Gamma is
//! Y.

use super::space::{Axes, LEAST_CLEARANCE, Motors, TINY};

use crate::square_root;

/// Configured geometry, left and right, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deltesian {
    /// Length of the rods.
    pub arm_length: [f64; 2],
    /// Distance in X of tower and tool with the tool in the middle.
    pub arm_x_length: [f64; 2],
}

impl Default for Deltesian {
    fn default() -> Self {
        Self { arm_length: [250.0; 2], arm_x_length: [124.0; 2] }
    }
}

impl Deltesian {
    /// Whether the towers stand apart and the rods reach the middle.
    pub(super) fn is_sound(&self) -> bool {
        let [left, right] = self.arm_x_length;
        left + right > 1.0 && self.clearance([0.0; 3]) > LEAST_CLEARANCE
    }

    /// Distance in X from tool to tower, and how far the rod rises; left, right.
    fn rods(&self, x: f64) -> [(f64, f64); 2] {
        let ([l, r], [left, right]) = (self.arm_length, self.arm_x_length);
        [(-left - x, l), (right - x, r)].map(|(dx, arm)| (dx, square_root(crate::greatest(arm * arm - dx * dx, TINY))))
    }

    /// Returns the motors' positions at a point.
    pub(super) fn motors(&self, [x, y, z]: Axes) -> Motors {
        let [(_, left), (_, right)] = self.rods(x);
        [z + left, z + right, y]
    }

    /// Returns the motors' speeds at a point, from the axes' speeds.
    pub(super) fn velocities(&self, [x, ..]: Axes, [vx, vy, vz]: Axes) -> Motors {
        let [left, right] = self.rods(x).map(|(dx, rise)| vz + dx * vx / rise);
        [left, right, vy]
    }

    /// The lower meeting point of two circles.
    pub(super) fn axes(&self, [alpha, beta, gamma]: Motors) -> Axes {
        let ([l, r], [left, right]) = (self.arm_length, self.arm_x_length);
        let (dx, dz) = (left + right, beta - alpha);
        let span_sq = dx * dx + dz * dz;
        // The tool lies from the left carriage so far towards the right one, then as far square to that,
        // downwards.
        let along = 0.5 * (l * l - r * r + span_sq) / span_sq;
        let square = square_root(crate::greatest(l * l / span_sq - along * along, 0.0));
        [-left + along * dx + square * dz, gamma, alpha + along * dz - square * dx]
    }

    /// Distance in mm to where a rod would lie flat; negative beyond.
    pub(super) fn clearance(&self, [x, ..]: Axes) -> f64 {
        let ([l, r], [left, right]) = (self.arm_length, self.arm_x_length);
        crate::least(l - libm::fabs(-left - x), r - libm::fabs(right - x))
    }
}

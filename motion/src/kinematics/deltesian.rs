//! Two vertical towers left and right, a rod on each down to the tool, and a bed that moves in Y.
//!
//! Alpha is the left carriage, beta the right one: `z + sqrt(L^2 - d^2)` with d the distance in X. Gamma is
//! Y.

use units::Deltesian;

use super::space::{Axes, LEAST_CLEARANCE, Motors, TINY};

use crate::square_root;

/// Whether the towers stand apart and the rods reach the middle.
pub(super) fn is_sound(towers: &Deltesian) -> bool {
    let [left, right] = towers.arm_x_length;
    left + right > 1.0 && clearance(towers, [0.0; 3]) > LEAST_CLEARANCE
}

/// Distance in X from tool to tower, and how far the rod rises; left, right.
fn rods(towers: &Deltesian, x: f64) -> [(f64, f64); 2] {
    let ([l, r], [left, right]) = (towers.arm_length, towers.arm_x_length);
    [(-left - x, l), (right - x, r)].map(|(dx, arm)| (dx, square_root(crate::greatest(arm * arm - dx * dx, TINY))))
}

/// Returns the motors' positions at a point.
pub(super) fn motors(towers: &Deltesian, [x, y, z]: Axes) -> Motors {
    let [(_, left), (_, right)] = rods(towers, x);
    [z + left, z + right, y]
}

/// Returns the motors' speeds at a point, from the axes' speeds.
pub(super) fn velocities(towers: &Deltesian, [x, ..]: Axes, [vx, vy, vz]: Axes) -> Motors {
    let [left, right] = rods(towers, x).map(|(dx, rise)| vz + dx * vx / rise);
    [left, right, vy]
}

/// The lower meeting point of two circles.
pub(super) fn axes(towers: &Deltesian, [alpha, beta, gamma]: Motors) -> Axes {
    let ([l, r], [left, right]) = (towers.arm_length, towers.arm_x_length);
    let (dx, dz) = (left + right, beta - alpha);
    let span_sq = dx * dx + dz * dz;
    // The tool lies from the left carriage so far towards the right one, then as far square to that,
    // downwards.
    let along = 0.5 * (l * l - r * r + span_sq) / span_sq;
    let square = square_root(crate::greatest(l * l / span_sq - along * along, 0.0));
    [-left + along * dx + square * dz, gamma, alpha + along * dz - square * dx]
}

/// Distance in mm to where a rod would lie flat; negative beyond.
pub(super) fn clearance(towers: &Deltesian, [x, ..]: Axes) -> f64 {
    let ([l, r], [left, right]) = (towers.arm_length, towers.arm_x_length);
    crate::least(l - libm::fabs(-left - x), r - libm::fabs(right - x))
}

//! A turning bed and an arm over it: alpha is the distance from the middle in mm, beta the bed's angle in
//! degrees from +X, gamma Z.
//!
//! The middle itself has every angle: no path may touch it. A path that passes it closely turns the bed
//! quickly, so its speed follows from the bed's rate; cut long lines (`mm_per_line_segment`) and only the
//! piece near the middle is slow.

use super::space::{Axes, Motors, TINY};

use crate::square_root;

/// Distance from the middle, or 1 nm.
fn radius([x, y, _]: Axes) -> f64 {
    square_root(crate::greatest(x * x + y * y, TINY))
}

/// Returns the motors' positions at a point.
pub(super) fn motors(axes: Axes) -> Motors {
    let [x, y, z] = axes;
    [radius(axes), libm::atan2(y, x).to_degrees(), z]
}

/// Returns the motors' speeds at a point, from the axes' speeds.
pub(super) fn velocities(axes: Axes, [vx, vy, vz]: Axes) -> Motors {
    let ([x, y, _], r) = (axes, radius(axes));
    [(x * vx + y * vy) / r, ((x * vy - y * vx) / (r * r)).to_degrees(), vz]
}

/// Returns the point for the motors' positions.
pub(super) fn axes([alpha, beta, gamma]: Motors) -> Axes {
    let radians = beta.to_radians();
    [alpha * libm::cos(radians), alpha * libm::sin(radians), gamma]
}

/// Returns the distance from the middle, mm.
pub(super) fn clearance(axes: Axes) -> f64 {
    radius(axes)
}

/// The place nearest to the middle on the line from `from` on, as a share of the way along `by`.
pub(super) fn nearest([x, y, _]: Axes, [dx, dy, _]: Axes) -> f64 {
    -(x * dx + y * dy) / (dx * dx + dy * dy)
}

//! A SCARA of the Morgan kind: two links, both motors in the tower, their angles counted from +X in degrees.
//!
//! Alpha is the angle of the inner link, beta that of the outer one in space (not of the elbow), gamma is Z.
//! With r the distance of the tool from the tower, the elbow's cosine is `(r^2 - l1^2 - l2^2) / 2 l1 l2`; the
//! elbow bends to the left.

use units::Morgan;

use super::space::{Axes, Motors, TINY};

use crate::square_root;

/// Whether both links have a length, no axis is scaled to nothing, and the elbow can turn.
pub(super) fn is_sound(arm: &Morgan) -> bool {
    let ([sx, sy], [folded, stretched]) = (arm.scaling, arm.cosine);
    arm.arm1 > 0.0 && arm.arm2 > 0.0 && sx != 0.0 && sy != 0.0 && stretched > -folded
}

/// Returns X and Y seen from the tower.
fn local(arm: &Morgan, [x, y, _]: Axes) -> [f64; 2] {
    let ([tx, ty], [sx, sy]) = (arm.tower, arm.scaling);
    [x * sx - tx, y * sy - ty]
}

fn elbow_cosine(arm: &Morgan, r_sq: f64) -> f64 {
    (r_sq - arm.arm1 * arm.arm1 - arm.arm2 * arm.arm2) / (2.0 * arm.arm1 * arm.arm2)
}

/// Cosine and sine of the elbow.
fn elbow(arm: &Morgan, [x, y]: [f64; 2]) -> [f64; 2] {
    let cosine = crate::least(crate::greatest(elbow_cosine(arm, x * x + y * y), -1.0), 1.0);
    [cosine, square_root(crate::greatest(1.0 - cosine * cosine, TINY))]
}

/// Returns the motors' positions at a point.
pub(super) fn motors(arm: &Morgan, axes: Axes) -> Motors {
    let ([x, y], [_, _, z]) = (local(arm, axes), axes);
    let [cosine, sine] = elbow(arm, [x, y]);
    let inner = libm::atan2(y, x) - libm::atan2(arm.arm2 * sine, arm.arm1 + arm.arm2 * cosine);
    [inner.to_degrees(), (inner + libm::atan2(sine, cosine)).to_degrees(), z]
}

/// Returns the motors' speeds at a point, from the axes' speeds.
pub(super) fn velocities(arm: &Morgan, axes: Axes, [vx, vy, vz]: Axes) -> Motors {
    let ([x, y], [sx, sy]) = (local(arm, axes), arm.scaling);
    let (vx, vy) = (vx * sx, vy * sy);
    let [cosine, sine] = elbow(arm, [x, y]);
    // The elbow, from the tower: the tool's place turned back by the angle at the tower.
    let share = arm.arm1 / crate::greatest(x * x + y * y, TINY);
    let (along, sideways) = (arm.arm1 + arm.arm2 * cosine, arm.arm2 * sine);
    let (ex, ey) = (share * (along * x + sideways * y), share * (along * y - sideways * x));
    // Cramer's rule gives both angles' velocities from the tool's.
    let across = arm.arm1 * arm.arm2 * sine;
    let inner = (vx * (x - ex) + vy * (y - ey)) / across;
    let outer = -(vx * ex + vy * ey) / across;
    [inner.to_degrees(), outer.to_degrees(), vz]
}

/// Returns the point for the motors' positions.
pub(super) fn axes(arm: &Morgan, [alpha, beta, gamma]: Motors) -> Axes {
    let ([tx, ty], [sx, sy]) = (arm.tower, arm.scaling);
    let (alpha, beta) = (alpha.to_radians(), beta.to_radians());
    let x = arm.arm1 * libm::cos(alpha) + arm.arm2 * libm::cos(beta);
    let y = arm.arm1 * libm::sin(alpha) + arm.arm2 * libm::sin(beta);
    [(x + tx) / sx, (y + ty) / sy, gamma]
}

/// Distance in mm to where the arm is stretched or folded completely.
pub(super) fn clearance(arm: &Morgan, axes: Axes) -> f64 {
    let ([x, y], [sx, sy]) = (local(arm, axes), arm.scaling);
    let r = square_root(x * x + y * y);
    let stretched = arm.arm1 + arm.arm2 - r;
    let folded = r - libm::fabs(arm.arm1 - arm.arm2);
    crate::least(stretched, folded) / crate::greatest(libm::fabs(sx), libm::fabs(sy))
}

/// Whether the configuration allows the elbow's angle.
pub(super) fn is_within_limits(arm: &Morgan, axes: Axes) -> bool {
    let ([x, y], [folded, stretched]) = (local(arm, axes), arm.cosine);
    let cosine = elbow_cosine(arm, x * x + y * y);
    cosine >= -folded && cosine <= stretched
}

/// The place nearest to the tower on the line from `from` on, as a share of the way along `by`.
pub(super) fn nearest(arm: &Morgan, from: Axes, [dx, dy, _]: Axes) -> f64 {
    let ([x, y], [sx, sy]) = (local(arm, from), arm.scaling);
    let (dx, dy) = (dx * sx, dy * sy);
    -(x * dx + y * dy) / (dx * dx + dy * dy)
}

/// The parameters M665 knows, with their letters.
pub(super) const fn parameters(arm: &Morgan) -> [(char, f64); 8] {
    let ([x, y], [a, b], [d, e]) = (arm.tower, arm.scaling, arm.cosine);
    [('L', arm.arm1), ('P', arm.arm2), ('X', x), ('Y', y), ('A', a), ('B', b), ('D', d), ('E', e)]
}

/// Creates a machine with the values of [`parameters`] in their order.
pub(super) const fn with_parameters(values: [f64; 8]) -> Morgan {
    let [arm1, arm2, x, y, a, b, d, e] = values;
    Morgan { arm1, arm2, tower: [x, y], scaling: [a, b], cosine: [d, e] }
}

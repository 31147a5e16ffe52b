//! Three shoulder motors, an upper arm on each, rods of equal length down to the tool.
//!
//! In the vertical plane of one arm, with D the joint of the effector beyond the shoulder (outwards), w its
//! depth below it and k its distance from the plane, the elbow at angle t (degrees, positive down) must be a
//! rod's length away: `D cos t + w sin t = c` with `c = (rf^2 + D^2 + w^2 + k^2 - re^2) / 2 rf`. With `p^2 =
//! D^2 + w^2` the solution with the elbow outside is `t = atan2(w, D) - acos(c / p)`; it exists while `c <
//! p`, and its derivative divides by `sqrt(p^2 - c^2)`.

use units::RotaryDelta;

use super::{
    space::{Axes, Motors, TINY},
    spheres,
};

use crate::square_root;

/// Outward directions of the arms of alpha, beta and gamma: 120 degrees apart, alpha towards -Y.
const ARMS: [[f64; 2]; 3] = [[0.0, -1.0], [0.866_025_403_784_438_6, 0.5], [-0.866_025_403_784_438_6, 0.5]];
/// Distance of an equilateral triangle's side from its middle, for a side of 1.
const INRADIUS: f64 = 0.288_675_134_594_812_9;

/// An arm seen in its plane.
struct Plane {
    /// D, w and k of the module's text.
    out: f64,
    down: f64,
    sideways: f64,
}

/// Whether every length is above zero, and the least angle below the greatest.
pub(super) fn is_sound(delta: &RotaryDelta) -> bool {
    let lengths = [delta.effector, delta.base, delta.rod, delta.arm];
    lengths.into_iter().all(|length| length > 0.0) && delta.angles.is_sorted()
}

/// Returns the height of the shafts above the effector's joints when the tool is at Z 0.
fn drop_to_bed(delta: &RotaryDelta) -> f64 {
    delta.z_offset - delta.tool_offset - delta.effector_offset
}

fn sign(delta: &RotaryDelta) -> f64 {
    if delta.mirror_xy { -1.0 } else { 1.0 }
}

/// A direction, or a point less the constant parts, in an arm's plane.
fn turned(delta: &RotaryDelta, [nx, ny]: [f64; 2], [x, y, z]: Axes) -> Plane {
    let (x, y) = (sign(delta) * x, sign(delta) * y);
    Plane { out: x * nx + y * ny, down: -z, sideways: y * nx - x * ny }
}

fn plane(delta: &RotaryDelta, arm: [f64; 2], axes: Axes) -> Plane {
    let turned = turned(delta, arm, axes);
    Plane {
        out: turned.out + INRADIUS * (delta.effector - delta.base),
        down: turned.down + drop_to_bed(delta),
        ..turned
    }
}

/// p, c and the root of their squares' difference.
fn triangle(delta: &RotaryDelta, plane: &Plane) -> (f64, f64, f64) {
    let span_sq = plane.out * plane.out + plane.down * plane.down;
    let c =
        (delta.arm * delta.arm + span_sq + plane.sideways * plane.sideways - delta.rod * delta.rod) / (2.0 * delta.arm);
    (square_root(span_sq), c, square_root(crate::greatest(span_sq - c * c, TINY)))
}

fn angle(delta: &RotaryDelta, plane: &Plane) -> f64 {
    let (_, c, root) = triangle(delta, plane);
    // acos(c / p) without dividing, good everywhere.
    libm::atan2(plane.down, plane.out) - libm::atan2(root, c)
}

/// Returns the motors' positions at a point.
pub(super) fn motors(delta: &RotaryDelta, axes: Axes) -> Motors {
    ARMS.map(|arm| angle(delta, &plane(delta, arm, axes)).to_degrees())
}

/// Returns the motors' speeds at a point, from the axes' speeds.
pub(super) fn velocities(delta: &RotaryDelta, axes: Axes, velocity: Axes) -> Motors {
    ARMS.map(|arm| {
        let (plane, turned) = (plane(delta, arm, axes), turned(delta, arm, velocity));
        let (span, c, root) = triangle(delta, &plane);
        // Cosine and sine of the angle, from the two parts of which it is the difference.
        let span_sq = crate::greatest(span * span, TINY);
        let cosine = (plane.out * c + plane.down * root) / span_sq;
        let sine = (plane.down * c - plane.out * root) / span_sq;
        let change = (plane.out * turned.out + plane.down * turned.down + plane.sideways * turned.sideways) / delta.arm;
        let pull = turned.out * cosine + turned.down * sine;
        ((change - pull) / root).to_degrees()
    })
}

/// Returns the point for the motors' positions.
pub(super) fn axes(delta: &RotaryDelta, [alpha, beta, gamma]: Motors) -> Axes {
    let elbow = |[nx, ny]: [f64; 2], degrees: f64| {
        let radians = degrees.to_radians();
        let out = INRADIUS * (delta.base - delta.effector) + delta.arm * libm::cos(radians);
        [nx * out, ny * out, -delta.arm * libm::sin(radians)]
    };
    let [a, b, c] = ARMS;
    let [[x, y, z], _] = spheres::meet([elbow(a, alpha), elbow(b, beta), elbow(c, gamma)], [delta.rod; 3]);
    [sign(delta) * x, sign(delta) * y, z + drop_to_bed(delta)]
}

/// A lower bound of the distance in mm to where an arm and its rod lie in one line, or the rod across the
/// plane.
pub(super) fn clearance(delta: &RotaryDelta, axes: Axes) -> f64 {
    let of_arm = |arm| {
        let plane = plane(delta, arm, axes);
        let (span, ..) = triangle(delta, &plane);
        let across = delta.rod - libm::fabs(plane.sideways);
        let rod = square_root(crate::greatest(delta.rod * delta.rod - plane.sideways * plane.sideways, 0.0));
        let stretched = rod + delta.arm - span;
        let folded = span - libm::fabs(rod - delta.arm);
        // Moving sideways shortens the rod as seen in the plane too: half of the distance is surely free.
        0.5 * crate::least(across, crate::least(stretched, folded))
    };
    ARMS.map(of_arm).into_iter().fold(f64::INFINITY, crate::least)
}

/// Whether the arms can stand at the angles that a point takes.
pub(super) fn is_within_angles(delta: &RotaryDelta, axes: Axes) -> bool {
    let [least, greatest] = delta.angles;
    motors(delta, axes).into_iter().all(|angle| angle >= least && angle <= greatest)
}

/// The parameters M665 knows, with their letters.
pub(super) const fn parameters(delta: &RotaryDelta) -> [(char, f64); 7] {
    [
        ('A', delta.effector),
        ('B', delta.base),
        ('C', delta.rod),
        ('D', delta.arm),
        ('E', delta.z_offset),
        ('I', delta.effector_offset),
        ('H', delta.tool_offset),
    ]
}

/// Returns the machine with the values of [`parameters`] in their order.
pub(super) const fn with_parameters(delta: RotaryDelta, values: [f64; 7]) -> RotaryDelta {
    let [effector, base, rod, arm, z_offset, effector_offset, tool_offset] = values;
    RotaryDelta { effector, base, rod, arm, z_offset, effector_offset, tool_offset, ..delta }
}

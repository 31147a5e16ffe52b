//! Where a path leads, from what defines it, with the standard library's functions.

use units::PerAxis;

use crate::path::{Arc, Curve, Path};

/// The place after `s` mm, and what the next millimetre adds to each axis.
pub fn place(path: &Path, s: f64) -> (PerAxis<f64>, PerAxis<f64>) {
    let mut place = path.origin;
    let mut direction = path.direction;
    for axis in units::Axis::ALL {
        place[axis] += path.direction[axis] * s;
    }
    let (offset, slope) = match &path.curve {
        Curve::Line => return (place, direction),
        Curve::Arc(arc) => circle(arc, s),
    };
    for axis in 0..3 {
        place.0[axis] += offset[axis];
        direction.0[axis] += slope[axis];
    }
    (place, direction)
}

/// A circle around the centre that the start has at the other end of its arm: the arm turned about the axis of rotation, by Rodrigues'
/// formula.
fn circle(arc: &Arc, s: f64) -> ([f64; 3], [f64; 3]) {
    let arm = arc.arm();
    let radius_sq: f64 = arm.iter().map(|part| part * part).sum();
    let axis = cross(arm, arc.ahead()).map(|part| part / radius_sq);
    let angle = arc.angle() * s / arc.length();
    let (sine, cosine) = angle.sin_cos();
    let aside = cross(axis, arm);
    let turned = [0, 1, 2].map(|n| arm[n] * cosine + aside[n] * sine);
    let onward = cross(axis, turned);
    let rate = arc.angle() / arc.length();
    ([0, 1, 2].map(|n| turned[n] - arm[n]), onward.map(|part| part * rate))
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

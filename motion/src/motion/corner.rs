//! Rounding corners (G64 P): an arc takes the place of the ends of two lines.
//!
//! Symbols: d1 and d2 the directions before and after, t the angle between them, R the radius, e the distance
//! from the corner to the arc. An arc that touches both lines begins and ends `R tan(t/2)` from the corner
//! and leaves it by `R (1 / cos(t/2) - 1)`, so the radius for a deviation e is `e c / (1 - c)` with `c =
//! cos(t/2)`, or `e c (1 + c) / s^2`, which does not cancel. The arc may take up to [`MOST_CUT`] of each
//! line; where that is less the radius, and with it the deviation, is smaller.
//!
//! The line before is still in the queue: it was planned as if the most had been taken of it, so its entry
//! speed only grows. Once that line has begun, because the sender is slow, the corner stays sharp.

use units::{Axis, PerAxis};

use super::Motion;
use crate::{
    least,
    moves::{Corner, Move},
    path::{self, Arc, Curve, Path, Vector, dot, mix},
    planner::{Envelope, curve_envelope},
    square_root,
};

/// Share of a line that each of its corners may take: both together leave something of it.
pub(super) const MOST_CUT: f64 = 0.48;
/// Cosine of an angle so small that nothing need be rounded: the junction is free.
const STRAIGHT: f64 = 0.999_9;
/// Cosine of half an angle so near to a reversal that an arc would be no faster than the corner.
const REVERSAL: f64 = 0.1;
/// Radii below this, mm, are corners.
const SMALLEST_RADIUS: f64 = 1e-3;

/// The arc in place of a corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rounding {
    /// Length cut off each of the two lines, mm.
    pub cut: f64,
    /// Places where the arc begins and ends.
    pub from: PerAxis<f64>,
    pub to: PerAxis<f64>,
    pub arc: Arc,
    pub envelope: Envelope,
}

impl Motion {
    /// Returns the rounding of the corner between the last move and a straight one that adds `unit` to each
    /// axis for a millimetre, if the corner is rounded.
    pub(super) fn rounding(&self, envelope: &Envelope, unit: &PerAxis<f64>, request: &Move) -> Option<Rounding> {
        let (config, last, Corner::Rounded(tolerance)) = (self.config.as_ref()?, self.last?, request.corner) else {
            return None;
        };
        let ((unit_before, length_before), before, after) = (last.line?, last.exit.direction?, envelope.primary?);
        let alike = last.mode == request.mode && last.power == request.power;
        let room = config.queue_size > 2 && !self.planner.is_empty();
        if !alike || !room {
            return None;
        }
        let most = MOST_CUT * least(length_before, envelope.length);
        let (cut, arc) = arc_between(before, after, tolerance, most)?;
        let (mut from, mut to) = (self.planned, self.planned);
        for axis in Axis::ALL {
            from[axis] -= cut * unit_before[axis];
            to[axis] += cut * unit[axis];
        }
        let requested = least(last.requested, request.feed_rate.get());
        let path = Path::new(from, &to, arc.length(), Curve::Arc(arc));
        let over = self.compensation.over_path(&path, arc.length());
        let envelope = curve_envelope(config, &path, arc.length(), requested, &over).ok()?;
        // The plan before it counts on ending no slower than at rest.
        let is_usable = envelope.speed_limit > config.limits.minimum_speed.get();
        is_usable.then_some(Rounding { cut, from, to, arc, envelope })
    }
}

/// The arc between two lines, and what it takes of each.
fn arc_between(before: Vector, after: Vector, tolerance: f64, most: f64) -> Option<(f64, Arc)> {
    let cosine = dot(before, after);
    if cosine > STRAIGHT {
        return None;
    }
    let (half_sin, half_cos) =
        (square_root(0.5 * (1.0 - cosine)), square_root(crate::greatest(0.5 * (1.0 + cosine), 0.0)));
    if half_cos < REVERSAL {
        return None;
    }
    let wanted = tolerance * half_cos * (1.0 + half_cos) / (half_sin * half_sin);
    let tangent = half_sin / half_cos;
    let radius = least(wanted, most / tangent);
    if radius < SMALLEST_RADIUS {
        return None;
    }
    // Direction from the start to the centre: at right angles to the line before, towards the line after.
    let sideways = mix(1.0, after, -cosine, before);
    let length = path::size(sideways);
    let arm = sideways.map(|part| -part * radius / length);
    let ahead = before.map(|part| part * radius);
    Some((radius * tangent, Arc::new(arm, ahead, 2.0 * libm::atan2(half_sin, half_cos), 0.0)))
}

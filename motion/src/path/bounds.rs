//! Extent of a path along each axis: arcs and splines bulge beyond their beginning and end.

use core::f64::consts::PI;

use units::{Axis, PerAxis};

use super::{Arc, Curve, Path, Spline};
use crate::{greatest, least, square_root};

const TURN: f64 = 2.0 * PI;

/// The least box along the axes that holds something, machine positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The least position of each axis.
    pub least: PerAxis<f64>,
    /// The greatest position of each axis.
    pub most: PerAxis<f64>,
}

impl Bounds {
    /// Bounds of a single place.
    #[must_use]
    pub const fn of(place: PerAxis<f64>) -> Self {
        Self { least: place, most: place }
    }

    /// Bounds of these places and another.
    #[must_use]
    pub fn and(mut self, place: &PerAxis<f64>) -> Self {
        Axis::ALL.into_iter().for_each(|axis| self.reach(axis, place[axis]));
        self
    }

    /// Bounds of both extents together.
    #[must_use]
    pub fn or(self, other: &Self) -> Self {
        self.and(&other.least).and(&other.most)
    }

    fn reach(&mut self, axis: Axis, place: f64) {
        self.least[axis] = least(self.least[axis], place);
        self.most[axis] = greatest(self.most[axis], place);
    }
}

impl Path {
    /// The bounds of its first `length` mm, which for a curve are all of it.
    #[must_use]
    pub fn bounds(&self, length: f64) -> Bounds {
        let mut bounds = Bounds::of(self.origin).and(&self.point(length));
        for (index, axis) in Axis::PRIMARY.into_iter().enumerate() {
            let (from, drift) = (self.origin[axis], self.direction[axis] * length);
            match &self.curve {
                Curve::Line => {}
                Curve::Arc(arc) => turning_points(arc, index, drift).for_each(|place| bounds.reach(axis, from + place)),
                Curve::Spline(spline) => {
                    // The movement beside the cubic grows evenly with the distance: rounding, or all movement
                    // of the axis.
                    let [low, high] = cubic_bounds(spline, index);
                    bounds.reach(axis, from + low + least(drift, 0.0));
                    bounds.reach(axis, from + high + greatest(drift, 0.0));
                }
            }
        }
        bounds
    }
}

/// Returns the places where one of X, Y and Z turns back on an arc, seen from its start. The axis goes along
/// `arm (cos p - 1) + ahead sin p` for angles p up to that of the arc, and evenly by `drift` in all. With
/// `arm = r cos c` and `ahead = r sin c` the axis stands where `r sin(p - c)` is the drift for each radian.
/// Of several turns the first and the last go furthest.
fn turning_points(arc: &Arc, index: usize, drift: f64) -> impl Iterator<Item = f64> {
    let part = |vector: [f64; 3]| vector.get(index).copied().unwrap_or(0.0);
    let (arm, ahead, angle) = (part(arc.arm()), part(arc.ahead()), arc.angle());
    let radius = square_root(arm * arm + ahead * ahead);
    let even = drift / angle;
    // An axis that drifts more than the circle comes back never turns, nor does an axis without a circle.
    let turns_back = libm::fabs(even) < radius;
    let (rises, at) = if turns_back { (libm::asin(even / radius), libm::atan2(ahead, arm)) } else { (0.0, 0.0) };
    let first = move |p: f64| p - TURN * libm::floor(p / TURN);
    let place = move |p: f64| {
        let (sin, cos) = libm::sincos(p);
        arm * (cos - 1.0) + ahead * sin + even * p
    };
    let on_the_way = [at + rises, at + PI - rises].map(first).into_iter().filter(move |p| turns_back && *p <= angle);
    on_the_way.flat_map(move |p| [p, p + TURN * libm::floor((angle - p) / TURN)]).map(place)
}

/// The least and the greatest value of `u (a + u (b + u c))` for one of X, Y and Z, u from 0 to 1.
fn cubic_bounds(spline: &Spline, index: usize) -> [f64; 2] {
    let [a, b, c] = spline.cubic().map(|vector| vector.get(index).copied().unwrap_or(0.0));
    let place = |u: f64| u * (a + u * (b + u * c));
    // The place stands still where `a + 2 b u + 3 c u^2` is zero. The root is added to b with b's own sign,
    // so nothing cancels; the other solution follows from the product of both. A root that is not a number is
    // not between 0 and 1.
    let q = -(b + libm::copysign(square_root(greatest(b * b - 3.0 * a * c, 0.0)), b));
    let stands = [q / (3.0 * c), a / q].into_iter().filter(|u| *u > 0.0 && *u < 1.0);
    let mut bounds = [least(0.0, place(1.0)), greatest(0.0, place(1.0))];
    for value in stands.map(place) {
        bounds = [least(bounds[0], value), greatest(bounds[1], value)];
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Arc, ArcShape, Bezier, ParametricCurve, Plane, SplineMoves};
    use proptest::prelude::*;
    use std::vec::Vec;

    /// Every sampled place is within the bounds, but for `out`, and each bound is met within `met`, mm.
    fn holds(
        bounds: &Bounds,
        places: impl Iterator<Item = PerAxis<f64>>,
        [out, met]: [f64; 2],
    ) -> Result<(), TestCaseError> {
        let sampled = places.map(Bounds::of).reduce(|all, one| all.or(&one)).expect("places");
        for axis in Axis::ALL {
            let low = sampled.least[axis] - bounds.least[axis];
            let high = bounds.most[axis] - sampled.most[axis];
            prop_assert!(low >= -out && high >= -out, "{axis:?} goes out by {low} or {high}");
            prop_assert!(low < met && high < met, "{axis:?} has {low} or {high} too much");
        }
        Ok(())
    }

    fn path_of(arc: Arc, from: PerAxis<f64>) -> (Path, f64) {
        let (to, curve) = arc.parts(1).next().expect("a part");
        (Path::new(from, &to, curve.length(), curve), curve.length())
    }

    proptest! {
        #[test]
        fn an_arc_stays_within_its_bounds_and_meets_them(
            radius in 0.1_f64..100.0, start in 0.0..TURN, sweep in 0.001_f64..6.27, clockwise in any::<bool>(),
            plane in prop::sample::select(&[Plane::Xy, Plane::Xz, Plane::Yz][..]), turns in 1_u32..4,
            rise in -20.0..20.0_f64, off in (-0.03..0.03_f64, -0.03..0.03_f64),
        ) {
            let (first, second) = plane.axes();
            let signed = if clockwise { -sweep } else { sweep };
            let on = |angle: f64, rise: f64| {
                let mut place = PerAxis([rise; units::MAX_AXES]);
                (place[first], place[second]) = (7.0 + radius * angle.cos(), radius * angle.sin());
                place
            };
            let (from, mut to) = (on(start, 0.0), on(start + signed, rise));
            (to[first], to[second]) = (to[first] + off.0, to[second] + off.1);
            let shape = ArcShape {
                plane, to_centre_first: 7.0 - from[first], to_centre_second: -from[second], clockwise, turns,
            };
            let Ok(arc) = Arc::new(from, to, &shape) else { return Ok(()) };
            let angle = arc.turns() * TURN;
            let (path, length) = path_of(arc, from);
            let places = (0..=20_000).map(|n| path.point(length * f64::from(n) / 20_000.0));
            // The circle bulges by this much between two samples.
            let step = angle / 20_000.0;
            holds(&path.bounds(length), places, [1e-9, 1e-9 + 2.0 * radius * step * step])?;
        }

        #[test]
        fn a_spline_stays_within_its_bounds_and_meets_them(
            points in prop::array::uniform4((-40.0..40.0_f64, -40.0..40.0_f64)), rise in -5.0..5.0_f64,
        ) {
            let bezier = Bezier::cubic(points.map(|(x, y)| [x, y, 0.0]));
            let at = |t: f64, z: f64| { let [x, y, _] = bezier.place(t); PerAxis([x, y, z, 0.0, 0.0, 0.0]) };
            let (from, to) = (at(0.0, 0.0), at(1.0, rise));
            let (mut here, mut places) = (from, Vec::new());
            for (target, curve) in SplineMoves::new(bezier, from, to) {
                places.extend([here, target]);
                let path = Path::new(here, &target, curve.length(), curve);
                if !curve.is_line() {
                    places.extend((0..200).map(|n| path.point(curve.length() * f64::from(n) / 200.0)));
                }
                here = target;
            }
            holds(&SplineMoves::new(bezier, from, to).bounds(), places.into_iter(), [1e-9, 1e-3])?;
        }
    }

    #[test]
    fn a_half_circle_bulges_by_its_radius_and_a_full_one_to_all_sides() {
        let point = |x: f64, y: f64| PerAxis([x, y, 0.0, 0.0, 0.0, 0.0]);
        let shape =
            ArcShape { plane: Plane::Xy, to_centre_first: 10.0, to_centre_second: 0.0, clockwise: true, turns: 1 };
        for (to, least, most) in [(20.0, (0.0, 0.0), (20.0, 10.0)), (0.0, (0.0, -10.0), (20.0, 10.0))] {
            let arc = Arc::new(point(0.0, 0.0), point(to, 0.0), &shape).expect("an arc");
            let bounds = arc.bounds();
            for (is, shall) in [(bounds.least, least), (bounds.most, most)] {
                assert!((is[Axis::X] - shall.0).abs() < 1e-9 && (is[Axis::Y] - shall.1).abs() < 1e-9, "{bounds:?}");
            }
        }
    }
}

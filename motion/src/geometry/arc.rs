//! Arcs (G2, G3) as the program means them: in any of the three planes, of any number of turns, with the
//! third axis and A B C following evenly (helix). By default an arc stays one ([`Arc::parts`]); where a
//! configuration asks for chords, it is cut ([`super::Chords`]).
//!
//! An end that is not quite on the circle (programs round to three digits) is reached all the same: the
//! difference is spread over the whole arc. An end off by more than [`off_allowed`] is a mistake.

use units::{Axis, PerAxis, Plane};

use crate::square_root;

use crate::path::{self, Bounds, Curve, Path, Vector};

/// Shape of an arc as the program gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcShape {
    /// Plane of the circle.
    pub plane: Plane,
    /// Distance from the start to the centre along the plane's first axis, mm.
    pub to_centre_first: f64,
    /// Distance from the start to the centre along the plane's second axis, mm.
    pub to_centre_second: f64,
    /// G2 rather than G3.
    pub clockwise: bool,
    /// Turns begun (P): with 1 the end is reached at once, each more is a whole turn before that.
    pub turns: u32,
}

impl ArcShape {
    /// Creates an arc from a radius (R) in place of a centre: the arc of at most half a turn, or with a
    /// negative radius the other one.
    ///
    /// # Errors
    /// Fails when start and end are one place in the plane, or too far apart for the radius.
    pub fn by_radius(
        from: &PerAxis<f64>,
        to: &PerAxis<f64>,
        plane: Plane,
        radius: f64,
        clockwise: bool,
    ) -> Result<Self, ArcError> {
        let (first, second) = plane.axes();
        let (dx, dy) = (to[first] - from[first], to[second] - from[second]);
        let apart = square_root(dx * dx + dy * dy);
        if !(apart.is_finite() && radius.is_finite()) || apart < LEAST_RADIUS {
            return Err(ArcError::NoWay);
        }
        let size = libm::fabs(radius);
        let half = 0.5 * apart;
        if half - size > off_allowed(size) {
            return Err(ArcError::TooFar { apart });
        }
        // Distance from the middle to the centre, to the left of the way where the arc is short and
        // counter-clockwise.
        let height = square_root(crate::greatest(size * size - half * half, 0.0));
        let to_left = clockwise == (radius < 0.0);
        let sideways = if to_left { height / apart } else { -height / apart };
        Ok(Self {
            plane,
            to_centre_first: 0.5 * dx - sideways * dy,
            to_centre_second: 0.5 * dy + sideways * dx,
            clockwise,
            turns: 1,
        })
    }
}

/// Reason for which an arc does not exist.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub enum ArcError {
    /// The centre is the start: the radius is zero, or something is not a number.
    NoRadius,
    /// The end is not on the circle.
    OffCircle {
        /// Distance of the end from the circle, mm.
        off: f64,
    },
    /// A radius does not say where the centre of a full circle is.
    NoWay,
    /// Start and end are farther apart than the circle is wide.
    TooFar {
        /// Distance of start and end, mm.
        apart: f64,
    },
    /// Neither a chord length nor an error is configured.
    NoChord,
}

impl core::fmt::Display for ArcError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NoRadius => f.write_str("the arc has no radius"),
            Self::OffCircle { off } => write!(f, "the end of the arc is {off:.3} mm off its circle"),
            Self::NoWay => f.write_str("an arc by R must end elsewhere: write a full circle with I J K"),
            Self::TooFar { apart } => write!(f, "the ends of the arc are {apart:.3} mm apart, more than twice R"),
            Self::NoChord => f.write_str("set mm_per_arc_segment or mm_max_arc_error above zero to cut arcs"),
        }
    }
}

/// Sweeps smaller than this, rad, mean a full turn.
const FULL_TURN: f64 = 5e-7;
/// Radii below this, mm, are none.
const LEAST_RADIUS: f64 = 1e-6;
const TURN: f64 = 2.0 * core::f64::consts::PI;
/// Most turns of an arc in a program.
pub const MOST_TURNS: u32 = 10_000;

/// Returns the distance by which the end may be off the circle, mm: 0.05, for large circles a thousandth of
/// the radius, at most 0.5.
fn off_allowed(radius: f64) -> f64 {
    crate::least(crate::greatest(0.05, 0.001 * radius), 0.5)
}

/// An arc between two places.
#[derive(Clone, Copy, Debug)]
pub struct Arc {
    from: PerAxis<f64>,
    pub(super) to: PerAxis<f64>,
    plane: Plane,
    centre: (f64, f64),
    /// Vector from the centre to the start.
    start: (f64, f64),
    /// Vector from the circle to the end.
    off: (f64, f64),
    /// Angle of the arc, counter-clockwise, rad.
    sweep: f64,
}

fn turned((x, y): (f64, f64), angle: f64) -> (f64, f64) {
    let (sin, cos) = libm::sincos(angle);
    (x * cos - y * sin, x * sin + y * cos)
}

impl Arc {
    /// An arc from one point to another.
    ///
    /// # Errors
    /// Fails when the shape has no radius, or the end is not on the circle.
    pub fn new(from: PerAxis<f64>, to: PerAxis<f64>, shape: &ArcShape) -> Result<Self, ArcError> {
        let (first, second) = shape.plane.axes();
        let start = (-shape.to_centre_first, -shape.to_centre_second);
        let centre = (from[first] + shape.to_centre_first, from[second] + shape.to_centre_second);
        let radius = square_root(start.0 * start.0 + start.1 * start.1);
        if !(radius.is_finite() && radius >= LEAST_RADIUS) {
            return Err(ArcError::NoRadius);
        }
        let end = (to[first] - centre.0, to[second] - centre.1);
        let more = shape.turns.clamp(1, MOST_TURNS) - 1;
        let one_way = if shape.clockwise { -TURN } else { TURN };
        let sweep = sweep(start, end, shape.clockwise) + one_way * f64::from(more);
        let reached = turned(start, sweep);
        let off = (end.0 - reached.0, end.1 - reached.1);
        let distance = square_root(off.0 * off.0 + off.1 * off.1);
        if !distance.is_finite() || distance > off_allowed(radius) {
            return Err(ArcError::OffCircle { off: distance });
        }
        Ok(Self { from, to, plane: shape.plane, centre, start, off, sweep })
    }

    /// Returns the radius, mm.
    pub(super) fn radius(&self) -> f64 {
        square_root(self.start.0 * self.start.0 + self.start.1 * self.start.1)
    }

    /// Returns the movement along the axis that is not in the plane, mm.
    fn rise(&self) -> f64 {
        let (first, second) = self.plane.axes();
        let rises = Axis::PRIMARY.into_iter().find(|axis| *axis != first && *axis != second);
        rises.map_or(0.0, |axis| self.to[axis] - self.from[axis])
    }

    /// Length of the path, mm.
    #[must_use]
    pub fn length(&self) -> f64 {
        let (along, rise) = (self.sweep * self.radius(), self.rise());
        square_root(along * along + rise * rise)
    }

    /// Turns, whole and begun.
    #[must_use]
    pub fn turns(&self) -> f64 {
        libm::fabs(self.sweep) / TURN
    }

    /// Returns the extent of the arc along each axis.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let whole = self.parts(1).next();
        whole.map_or(Bounds::of(self.from), |(to, curve)| {
            Path::new(self.from, &to, curve.length(), curve).bounds(curve.length())
        })
    }

    /// The place at a share of the way, 0 to 1.
    pub(super) fn place(&self, share: f64) -> PerAxis<f64> {
        let mut place = self.from;
        for axis in Axis::ALL {
            place[axis] += (self.to[axis] - self.from[axis]) * share;
        }
        let (x, y) = turned(self.start, self.sweep * share);
        let (first, second) = self.plane.axes();
        place[first] = self.centre.0 + x + self.off.0 * share;
        place[second] = self.centre.1 + y + self.off.1 * share;
        place
    }

    /// A vector in the plane.
    fn in_plane(&self, (x, y): (f64, f64)) -> Vector {
        match self.plane {
            Plane::Xy => [x, y, 0.0],
            Plane::Xz => [x, 0.0, y],
            Plane::Yz => [0.0, x, y],
        }
    }

    /// The arc in `count` equal parts: where each ends, and its curve.
    #[must_use]
    pub const fn parts(self, count: u32) -> ArcParts {
        ArcParts { arc: self, count: if count == 0 { 1 } else { count }, taken: 0 }
    }
}

/// The equal parts of an arc, one after the other: where each ends, and its curve.
#[derive(Clone, Copy, Debug)]
pub struct ArcParts {
    arc: Arc,
    count: u32,
    taken: u32,
}

impl Iterator for ArcParts {
    type Item = (PerAxis<f64>, Curve);

    fn next(&mut self) -> Option<Self::Item> {
        let Self { arc, count, taken } = *self;
        if taken >= count {
            return None;
        }
        self.taken += 1;
        let share = 1.0 / f64::from(count);
        let (x, y) = turned(arc.start, arc.sweep * share * f64::from(taken));
        let ahead = if arc.sweep < 0.0 { (y, -x) } else { (-y, x) };
        let angle = libm::fabs(arc.sweep) * share;
        let curve = path::Arc::new(arc.in_plane((x, y)), arc.in_plane(ahead), angle, arc.rise() * share);
        let end = if taken + 1 == count { arc.to } else { arc.place(share * f64::from(taken + 1)) };
        Some((end, Curve::Arc(curve)))
    }
}

/// Angle from `start` to `end` in the direction asked for: never zero, at most a full turn.
fn sweep(start: (f64, f64), end: (f64, f64), clockwise: bool) -> f64 {
    let angle = libm::atan2(start.0 * end.1 - start.1 * end.0, start.0 * end.0 + start.1 * end.1);
    match clockwise {
        true if angle >= -FULL_TURN => angle - TURN,
        false if angle <= FULL_TURN => angle + TURN,
        _ => angle,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    const HALF: ArcShape =
        ArcShape { plane: Plane::Xy, to_centre_first: 10.0, to_centre_second: 0.0, clockwise: true, turns: 1 };

    fn point(x: f64, y: f64, z: f64) -> PerAxis<f64> {
        PerAxis([x, y, z, 0.0, 0.0, 0.0])
    }

    fn arc(from: PerAxis<f64>, to: PerAxis<f64>, shape: &ArcShape) -> Arc {
        Arc::new(from, to, shape).expect("an arc")
    }

    #[test]
    fn clockwise_goes_over_the_top_from_left_to_right() {
        let (from, to) = (point(0.0, 0.0, 0.0), point(20.0, 0.0, 4.0));
        let middle = arc(from, to, &HALF).place(0.5).0;
        assert!(middle[1] > 9.9 && (middle[2] - 2.0).abs() < 1e-9, "{middle:?}");
        let under = arc(from, to, &ArcShape { clockwise: false, ..HALF });
        assert!(under.place(0.5).0[1] < -9.9);
    }

    #[test]
    fn an_arc_back_to_its_start_is_a_full_turn_and_p_adds_more() {
        let from = point(5.0, 5.0, 0.0);
        for (clockwise, turns) in [(true, 1), (false, 1), (true, 3), (false, 7)] {
            let circle = arc(from, from, &ArcShape { clockwise, turns, ..HALF });
            assert!((circle.turns() - f64::from(turns)).abs() < 1e-12);
            assert!((circle.length() - TURN * 10.0 * f64::from(turns)).abs() < 1e-9);
        }
        let quarter = arc(from, point(15.0, 15.0, 0.0), &ArcShape { turns: 2, ..HALF });
        assert!((quarter.turns() - 1.25).abs() < 1e-12);
    }

    #[test]
    fn each_plane_turns_its_first_axis_towards_its_second() {
        for (plane, first, second) in [(Plane::Xy, 0, 1), (Plane::Xz, 0, 2), (Plane::Yz, 1, 2)] {
            let mut from = point(0.0, 0.0, 0.0);
            from.0[first] = 10.0;
            let mut to = point(0.0, 0.0, 0.0);
            to.0[second] = 10.0;
            let shape = ArcShape { plane, to_centre_first: -10.0, clockwise: false, ..HALF };
            let arc = arc(from, to, &shape);
            assert!((arc.sweep - TURN / 4.0).abs() < 1e-12, "{plane:?} sweeps {}", arc.sweep);
        }
    }

    #[test]
    fn arcs_without_radius_and_ends_off_the_circle_are_refused() {
        let (from, to) = (point(0.0, 0.0, 0.0), point(20.0, 0.0, 0.0));
        let nowhere = ArcShape { to_centre_first: 0.0, ..HALF };
        assert_eq!(Arc::new(from, to, &nowhere).err(), Some(ArcError::NoRadius));
        let bad = ArcShape { to_centre_first: f64::NAN, ..HALF };
        assert_eq!(Arc::new(from, to, &bad).err(), Some(ArcError::NoRadius));
        assert!(matches!(Arc::new(from, point(20.1, 0.0, 0.0), &HALF), Err(ArcError::OffCircle { .. })));
        assert!(matches!(Arc::new(from, point(f64::NAN, 0.0, 0.0), &HALF), Err(ArcError::OffCircle { .. })));
        assert!(Arc::new(from, point(20.04, 0.0, 0.0), &HALF).is_ok());
        assert_eq!(ArcShape::by_radius(&from, &from, Plane::Xy, 5.0, true).err(), Some(ArcError::NoWay));
        let far = ArcShape::by_radius(&from, &to, Plane::Xy, 9.0, true);
        assert_eq!(far.err(), Some(ArcError::TooFar { apart: 20.0 }));
    }

    proptest! {
        #[test]
        fn a_radius_gives_the_shorter_arc_or_with_a_minus_the_longer_one(
            radius in 0.1..50.0_f64, start in 0.0..TURN, sweep in 0.1..6.1_f64, clockwise in any::<bool>(),
        ) {
            prop_assume!((sweep - TURN / 2.0).abs() > 1e-3);
            let signed = if clockwise { -sweep } else { sweep };
            let on = |angle: f64| point(3.0 + radius * angle.cos(), radius * angle.sin() - 2.0, 0.0);
            let (from, to) = (on(start), on(start + signed));
            let written = if sweep > TURN / 2.0 { -radius } else { radius };
            let shape = ArcShape::by_radius(&from, &to, Plane::Xy, written, clockwise).expect("a shape");
            prop_assert!((arc(from, to, &shape).sweep - signed).abs() < 1e-5);
        }

        #[test]
        fn parts_join_and_lie_on_the_helix(
            radius in 0.01_f64..200.0, start in 0.0..TURN, sweep in 0.01_f64..6.2, clockwise in any::<bool>(),
            plane in prop::sample::select(&[Plane::Xy, Plane::Xz, Plane::Yz][..]), turns in 1_u32..4, count in 1_u32..9,
        ) {
            let (first, second) = plane.axes();
            let rises = Axis::PRIMARY.into_iter().find(|axis| *axis != first && *axis != second).expect("the third");
            let signed = if clockwise { -sweep } else { sweep };
            let on = |angle: f64, rise: f64| {
                let mut place = PerAxis([0.0, 0.0, 0.0, rise, 0.0, 0.0]);
                (place[first], place[second]) = (radius * angle.cos(), radius * angle.sin());
                place[rises] = rise;
                place
            };
            let (from, to) = (on(start, 0.0), on(start + signed, 5.0));
            let shape = ArcShape {
                plane, to_centre_first: -from[first], to_centre_second: -from[second], clockwise, turns,
            };
            let arc = arc(from, to, &shape);
            let whole = arc.length();
            let (mut here, mut length) = (from, 0.0);
            let ends: Vec<_> = arc.parts(count).collect();
            prop_assert_eq!(ends.len(), count as usize);
            for (end, curve) in ends {
                let path = path::Path::new(here, &end, curve.length(), curve);
                for share in [0.0, 0.3, 1.0] {
                    let place = path.point(share * curve.length());
                    let off = place[first].hypot(place[second]) - radius;
                    prop_assert!(off.abs() < 1e-9, "{off} mm off the circle");
                    prop_assert!((place[rises] - 5.0 * (length + share * curve.length()) / whole).abs() < 1e-9);
                    prop_assert!((path.tangent(share * curve.length()).0[..3].iter().map(|part| part * part).sum::<f64>() - 1.0).abs() < 1e-9);
                }
                length += curve.length();
                here = end;
            }
            prop_assert_eq!(here, to);
            prop_assert!((length - whole).abs() < 1e-9 * whole);
        }
    }
}

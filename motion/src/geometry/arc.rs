//! Arcs (G2, G3) as chords, in any of the three planes, with the third axis and A B C following evenly (helix).
//!
//! The chord length is the longer of `mm_per_arc_segment` and the chord that leaves the arc by `mm_max_arc_error` = e:
//! for radius r, `2 sqrt(e (2 r - e))`. Points follow by an exact rotation of the radius vector; every `arc_correction` chords it
//! is taken from the angle anew, so that rounding cannot add up.

use units::{Axis, PerAxis};

/// The plane of an arc; the axis that is left out is the helix axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Plane {
    /// G17: X and Y.
    #[default]
    Xy,
    /// G18: X and Z, in this order: counter-clockwise turns X towards Z. Smoothieware's way, and the mirror image of
    /// RS274's, which looks at the plane from +Y.
    Xz,
    /// G19: Y and Z.
    Yz,
}

impl Plane {
    /// First and second axis, so that counter-clockwise turns the first towards the second.
    #[must_use]
    pub const fn axes(self) -> (Axis, Axis) {
        match self {
            Self::Xy => (Axis::X, Axis::Y),
            Self::Xz => (Axis::X, Axis::Z),
            Self::Yz => (Axis::Y, Axis::Z),
        }
    }
}

/// How finely arcs are cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcSettings {
    /// Least chord length, mm (`mm_per_arc_segment`); zero: not given.
    pub segment_length: f64,
    /// Greatest distance between chord and arc, mm (`mm_max_arc_error`); zero: not given.
    pub max_error: f64,
    /// Chords between exact recomputations (`arc_correction`).
    pub correction: u32,
}

impl Default for ArcSettings {
    fn default() -> Self {
        Self { segment_length: 0.0, max_error: 0.01, correction: 5 }
    }
}

/// What the program says about the arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcShape {
    /// The plane.
    pub plane: Plane,
    /// From the start to the centre along the plane's first axis, mm.
    pub to_centre_first: f64,
    /// From the start to the centre along the plane's second axis, mm.
    pub to_centre_second: f64,
    /// G2 rather than G3.
    pub clockwise: bool,
}

/// Why there is no such arc.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum ArcError {
    /// The centre is the start: the radius is zero, or something is not a number.
    NoRadius,
    /// Neither a chord length nor an error is configured.
    NoChord,
}

impl core::fmt::Display for ArcError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::NoRadius => "the arc has no radius",
            Self::NoChord => "set mm_per_arc_segment or mm_max_arc_error above zero to cut arcs",
        })
    }
}

/// Sweeps smaller than this, rad, mean a full turn.
const FULL_TURN: f64 = 5e-7;
/// Radii below this, mm, are none.
const LEAST_RADIUS: f64 = 1e-6;
/// A bound for nonsense settings.
const MOST_CHORDS: f64 = 1e6;
const TURN: f64 = 2.0 * core::f64::consts::PI;

/// The end points of the chords of an arc, the last being its exact target.
#[derive(Clone, Copy, Debug)]
pub struct Arc {
    from: PerAxis<f64>,
    to: PerAxis<f64>,
    plane: Plane,
    centre: (f64, f64),
    /// From the centre to the start.
    start: (f64, f64),
    /// From the centre to the last point taken.
    arm: (f64, f64),
    /// Sine and cosine of one chord's angle.
    rotation: (f64, f64),
    sweep: f64,
    chords: u32,
    taken: u32,
    correction: u32,
    since_exact: u32,
}

impl Arc {
    /// An arc from one point to another.
    ///
    /// # Errors
    /// When the shape has no radius or the settings give no chord.
    pub fn new(
        from: PerAxis<f64>,
        to: PerAxis<f64>,
        shape: &ArcShape,
        settings: &ArcSettings,
    ) -> Result<Self, ArcError> {
        let (first, second) = shape.plane.axes();
        let start = (-shape.to_centre_first, -shape.to_centre_second);
        let centre = (from[first] + shape.to_centre_first, from[second] + shape.to_centre_second);
        let radius = libm::sqrt(start.0 * start.0 + start.1 * start.1);
        if !(radius.is_finite() && radius >= LEAST_RADIUS) {
            return Err(ArcError::NoRadius);
        }
        let end = (to[first] - centre.0, to[second] - centre.1);
        let sweep = sweep(start, end, shape.clockwise);
        let rise = Axis::PRIMARY.into_iter().find(|axis| *axis != first && *axis != second);
        let rise = rise.map_or(0.0, |axis| to[axis] - from[axis]);
        let along = sweep * radius;
        let wanted = libm::ceil(libm::sqrt(along * along + rise * rise) / chord(radius, settings)?);
        let chords = if wanted >= 1.0 { crate::least(wanted, MOST_CHORDS) as u32 } else { 1 };
        let angle = sweep / f64::from(chords);
        Ok(Self {
            from,
            to,
            plane: shape.plane,
            centre,
            start,
            arm: start,
            rotation: (libm::sin(angle), libm::cos(angle)),
            sweep,
            chords,
            taken: 0,
            correction: settings.correction,
            since_exact: 0,
        })
    }

    /// How many chords there are in all.
    #[must_use]
    pub const fn chords(&self) -> u32 {
        self.chords
    }

    fn turn_arm(&mut self) {
        if self.since_exact < self.correction {
            let ((sin, cos), (x, y)) = (self.rotation, self.arm);
            self.arm = (x * cos - y * sin, x * sin + y * cos);
            self.since_exact += 1;
        } else {
            let angle = self.sweep * f64::from(self.taken) / f64::from(self.chords);
            let ((sin, cos), (x, y)) = ((libm::sin(angle), libm::cos(angle)), self.start);
            self.arm = (x * cos - y * sin, x * sin + y * cos);
            self.since_exact = 0;
        }
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

fn chord(radius: f64, settings: &ArcSettings) -> Result<f64, ArcError> {
    let error = settings.max_error;
    let by_error =
        if error > 0.0 && 2.0 * radius > error { 2.0 * libm::sqrt(error * (2.0 * radius - error)) } else { 0.0 };
    let chord = crate::greatest(by_error, settings.segment_length);
    if chord > 0.0 { Ok(chord) } else { fallback_chord(radius, error) }
}

/// An arc smaller than the allowed error may be any polygon; without an allowed error there is no answer.
fn fallback_chord(radius: f64, error: f64) -> Result<f64, ArcError> {
    if error > 0.0 { Ok(radius) } else { Err(ArcError::NoChord) }
}

impl Iterator for Arc {
    type Item = PerAxis<f64>;

    fn next(&mut self) -> Option<PerAxis<f64>> {
        if self.taken >= self.chords {
            return None;
        }
        self.taken += 1;
        if self.taken == self.chords {
            return Some(self.to);
        }
        self.turn_arm();
        let share = f64::from(self.taken) / f64::from(self.chords);
        let mut point = self.from;
        for axis in Axis::ALL {
            point[axis] += (self.to[axis] - self.from[axis]) * share;
        }
        let (first, second) = self.plane.axes();
        point[first] = self.centre.0 + self.arm.0;
        point[second] = self.centre.1 + self.arm.1;
        Some(point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    const HALF: ArcShape = ArcShape { plane: Plane::Xy, to_centre_first: 10.0, to_centre_second: 0.0, clockwise: true };

    fn point(x: f64, y: f64, z: f64) -> PerAxis<f64> {
        PerAxis([x, y, z, 0.0, 0.0, 0.0])
    }

    fn points(from: PerAxis<f64>, to: PerAxis<f64>, shape: &ArcShape, settings: &ArcSettings) -> Vec<PerAxis<f64>> {
        Arc::new(from, to, shape, settings).expect("an arc").collect()
    }

    #[test]
    fn clockwise_goes_over_the_top_from_left_to_right() {
        let (from, to) = (point(0.0, 0.0, 0.0), point(20.0, 0.0, 4.0));
        let over = points(from, to, &HALF, &ArcSettings::default());
        let middle = over[over.len() / 2 - 1].0;
        assert!(middle[1] > 9.9 && (middle[2] - 2.0).abs() < 1e-9, "{middle:?}");
        let under = points(from, to, &ArcShape { clockwise: false, ..HALF }, &ArcSettings::default());
        assert!(under[under.len() / 2 - 1].0[1] < -9.9);
        assert_eq!((over.last(), under.last()), (Some(&to), Some(&to)));
    }

    #[test]
    fn an_arc_back_to_its_start_is_a_full_turn() {
        let from = point(5.0, 5.0, 0.0);
        for clockwise in [true, false] {
            let shape = ArcShape { clockwise, ..HALF };
            let length: f64 = std::iter::once(from)
                .chain(points(from, from, &shape, &ArcSettings::default()))
                .collect::<Vec<_>>()
                .windows(2)
                .map(|pair| (pair[1].0[0] - pair[0].0[0]).hypot(pair[1].0[1] - pair[0].0[1]))
                .sum();
            assert!((length - TURN * 10.0).abs() < 0.05, "{length} mm");
        }
    }

    #[test]
    fn each_plane_turns_its_first_axis_towards_its_second() {
        for (plane, first, second) in [(Plane::Xy, 0, 1), (Plane::Xz, 0, 2), (Plane::Yz, 1, 2)] {
            let mut from = point(0.0, 0.0, 0.0);
            from.0[first] = 10.0;
            let mut to = point(0.0, 0.0, 0.0);
            to.0[second] = 10.0;
            let shape = ArcShape { plane, to_centre_first: -10.0, to_centre_second: 0.0, clockwise: false };
            let arc = Arc::new(from, to, &shape, &ArcSettings::default()).expect("an arc");
            assert!((arc.sweep - TURN / 4.0).abs() < 1e-12, "{plane:?} sweeps {}", arc.sweep);
        }
    }

    #[test]
    fn arcs_without_radius_or_chord_are_refused() {
        let (from, to) = (point(0.0, 0.0, 0.0), point(20.0, 0.0, 0.0));
        let nowhere = ArcShape { to_centre_first: 0.0, ..HALF };
        assert_eq!(Arc::new(from, to, &nowhere, &ArcSettings::default()).err(), Some(ArcError::NoRadius));
        let bad = ArcShape { to_centre_first: f64::NAN, ..HALF };
        assert_eq!(Arc::new(from, to, &bad, &ArcSettings::default()).err(), Some(ArcError::NoRadius));
        let none = ArcSettings { max_error: 0.0, ..ArcSettings::default() };
        assert_eq!(Arc::new(from, to, &HALF, &none).err(), Some(ArcError::NoChord));
    }

    proptest! {
        #[test]
        fn chords_stay_within_the_error_and_on_the_circle(
            radius in 0.01_f64..200.0, start in 0.0..TURN, sweep in 0.01_f64..6.2, clockwise in any::<bool>(),
            max_error in 0.001_f64..0.1, correction in 0_u32..50,
        ) {
            let signed = if clockwise { -sweep } else { sweep };
            let from = point(radius * start.cos(), radius * start.sin(), 0.0);
            let to = point(radius * (start + signed).cos(), radius * (start + signed).sin(), 1.0);
            let shape = ArcShape {
                plane: Plane::Xy, to_centre_first: -from.0[0], to_centre_second: -from.0[1], clockwise,
            };
            let settings = ArcSettings { segment_length: 0.0, max_error, correction };
            let mut before = from;
            for after in points(from, to, &shape, &settings) {
                let ([x0, y0, ..], [x1, y1, ..]) = (before.0, after.0);
                prop_assert!((x1.hypot(y1) - radius).abs() < 1e-9, "off the circle");
                let sagitta = radius - (0.5 * (x0 + x1)).hypot(0.5 * (y0 + y1));
                prop_assert!(sagitta <= max_error * 1.000_001, "leaves the arc by {sagitta} mm");
                before = after;
            }
            prop_assert_eq!(before, to);
        }
    }
}

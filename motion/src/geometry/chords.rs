//! Arcs as chords, where a configuration asks for them.
//!
//! The chord length is the longer of `mm_per_arc_segment` and the chord that leaves the arc by
//! `mm_max_arc_error` = e: for radius r, `2 sqrt(e (2 r - e))`. Every corner is computed from its angle, so
//! rounding cannot add up.

use units::{ArcSettings, PerAxis};

use crate::square_root;

use super::arc::{Arc, ArcError};

/// Most chords of an arc: a bound for nonsense settings.
const MOST_CHORDS: f64 = 1e6;

/// The end points of the chords of an arc, the last being its exact target.
#[derive(Clone, Copy, Debug)]
pub struct Chords {
    arc: Arc,
    chords: u32,
    taken: u32,
}

impl Chords {
    /// Cuts an arc into equal chords.
    ///
    /// # Errors
    /// Fails when the settings give no chord.
    pub fn new(arc: Arc, settings: &ArcSettings) -> Result<Self, ArcError> {
        let wanted = libm::ceil(arc.length() / chord(arc.radius(), settings)?);
        let chords = if wanted >= 1.0 { crate::least(wanted, MOST_CHORDS) as u32 } else { 1 };
        Ok(Self { arc, chords, taken: 0 })
    }
}

fn chord(radius: f64, settings: &ArcSettings) -> Result<f64, ArcError> {
    let error = settings.max_error;
    let by_error =
        if error > 0.0 && 2.0 * radius > error { 2.0 * square_root(error * (2.0 * radius - error)) } else { 0.0 };
    let chord = crate::greatest(by_error, settings.segment_length);
    if chord > 0.0 { Ok(chord) } else { fallback_chord(radius, error) }
}

/// An arc smaller than the allowed error may be any polygon; without an allowed error there is no answer.
fn fallback_chord(radius: f64, error: f64) -> Result<f64, ArcError> {
    if error > 0.0 { Ok(radius) } else { Err(ArcError::NoChord) }
}

impl Iterator for Chords {
    type Item = PerAxis<f64>;

    fn next(&mut self) -> Option<PerAxis<f64>> {
        if self.taken >= self.chords {
            return None;
        }
        self.taken += 1;
        if self.taken == self.chords {
            return Some(self.arc.to);
        }
        Some(self.arc.place(f64::from(self.taken) / f64::from(self.chords)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{ArcShape, Plane};
    use proptest::prelude::*;

    const TURN: f64 = 2.0 * core::f64::consts::PI;

    fn point(x: f64, y: f64, z: f64) -> PerAxis<f64> {
        PerAxis([x, y, z, 0.0, 0.0, 0.0])
    }

    #[test]
    fn without_a_setting_there_is_no_chord() {
        let shape =
            ArcShape { plane: Plane::Xy, to_centre_first: 10.0, to_centre_second: 0.0, clockwise: true, turns: 1 };
        let arc = Arc::new(point(0.0, 0.0, 0.0), point(20.0, 0.0, 0.0), &shape).expect("an arc");
        let none = ArcSettings::default();
        assert!(!none.cut());
        assert_eq!(Chords::new(arc, &none).err(), Some(ArcError::NoChord));
    }

    proptest! {
        #[test]
        fn chords_stay_within_the_error_and_on_the_circle(
            radius in 0.01_f64..200.0, start in 0.0..TURN, sweep in 0.01_f64..6.2, clockwise in any::<bool>(),
            max_error in 0.001_f64..0.1,
        ) {
            let signed = if clockwise { -sweep } else { sweep };
            let from = point(radius * start.cos(), radius * start.sin(), 0.0);
            let to = point(radius * (start + signed).cos(), radius * (start + signed).sin(), 1.0);
            let shape = ArcShape {
                plane: Plane::Xy, to_centre_first: -from.0[0], to_centre_second: -from.0[1], clockwise, turns: 1,
            };
            let settings = ArcSettings { segment_length: 0.0, max_error };
            let arc = Arc::new(from, to, &shape).expect("an arc");
            let mut before = from;
            for after in Chords::new(arc, &settings).expect("chords") {
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

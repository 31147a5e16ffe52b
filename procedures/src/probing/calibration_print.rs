//! M665.4: lengths measured on the part of Klipper's DELTA_ANALYZE, and the distances they mean.
//!
//! The part has a pillar in the middle and six around it, 65 mm away at every 60 degrees from 210 on. The
//! pillars are ridged, and calipers lie on ridges 4.5 mm from a pillar's axis. Calipers are closed over two
//! pillars: the distance between two sides that face the same way is that length less the width of a pillar,
//! which takes the width of the filament's track out. Source: Klipper's calibrate_size.stl, and its
//! description in "Delta calibration".

use base::failure::{Failure, Texts};
use program::Words;

/// Distance from the middle to the axis of an outer pillar, mm.
const OUTER_RADIUS: f64 = 65.0;
/// Distance from a pillar's axis to its ridge, mm.
const RIDGE: f64 = 4.5;
/// Direction of the first outer pillar, and angle between two neighbours, degrees.
const FIRST: f64 = 210.0;
const NEXT: f64 = 60.0;
/// Index of the middle pillar's width, of three, across each outer pillar's direction.
const CENTRE_WIDTHS: [usize; 6] = [0, 2, 1, 0, 2, 1];

/// Lengths measured on the part, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CalibrationPrint {
    centre: Option<[f64; 6]>,
    outer: Option<[f64; 6]>,
    centre_widths: Option<[f64; 3]>,
    outer_widths: Option<[f64; 6]>,
    scale: Option<f64>,
}

/// A distance on the part: its ends, and its measured length, mm.
pub(super) type Measured = ([[f64; 2]; 2], f64);

impl CalibrationPrint {
    /// Keeps the list with the number P, and the scale.
    ///
    /// # Errors
    /// When the list is not whole.
    pub(super) fn keep(&mut self, texts: &Texts, words: &Words<'_>) -> Result<(), Failure> {
        self.scale = words.get('S').or(self.scale);
        let Some(list) = words.get('P') else { return Ok(()) };
        let lengths = ['A', 'B', 'C', 'D', 'E', 'F'].map(|letter| words.as_length(letter));
        let six =
            lengths.iter().copied().collect::<Option<heapless::Vec<f64, 6>>>().and_then(|six| six.into_array().ok());
        let three = || if let [Some(a), Some(b), Some(c), None, None, None] = lengths { Some([a, b, c]) } else { None };
        let is_whole = match list as u8 {
            2 => {
                self.centre_widths = three().or(self.centre_widths);
                three().is_some()
            }
            list => {
                let place = match list {
                    0 => &mut self.centre,
                    1 => &mut self.outer,
                    _ => &mut self.outer_widths,
                };
                *place = six.or(*place);
                six.is_some()
            }
        };
        let text = "M665.4 needs A to F, six lengths; three, A to C, for P2, the widths of the middle pillar";
        if is_whole { Ok(()) } else { Err(texts.because(text)) }
    }

    /// Returns the twelve distances of the part.
    ///
    /// # Errors
    /// When a list is missing.
    pub(super) fn distances(&self, texts: &Texts) -> Result<[Measured; 12], Failure> {
        let missing = |what: &str| texts.refused(format_args!("of the part {what} is missing: M665.4"));
        let centre = self.centre.ok_or_else(|| missing("CENTER_DISTS (P0)"))?;
        let outer = self.outer.ok_or_else(|| missing("OUTER_DISTS (P1)"))?;
        let [a, b, c] = self.centre_widths.ok_or_else(|| missing("CENTER_PILLAR_WIDTHS (P2)"))?;
        let outer_widths = self.outer_widths.ok_or_else(|| missing("OUTER_PILLAR_WIDTHS (P3)"))?;
        let scale = self.scale.unwrap_or(1.0);
        let [radius, ridge] = [OUTER_RADIUS, RIDGE].map(|mm| mm * scale);
        let at = |pillar: usize, distance: f64| {
            let angle = (FIRST + NEXT * pillar as f64).to_radians();
            [distance * libm::cos(angle), distance * libm::sin(angle)]
        };
        let mut all = [([[0.0; 2]; 2], 0.0); 12];
        let pillars = centre.iter().zip(outer).zip(outer_widths).zip(CENTRE_WIDTHS).enumerate();
        for (pillar, (((centre, outer), outer_width), centre_width)) in pillars {
            // Two distances: from the middle pillar to this; and from this towards the pillar after the next.
            let [from, far] = [0.0, radius].map(|way| at(pillar, way + ridge));
            let width = [a, b, c].get(centre_width).copied().unwrap_or(a);
            let axis = at(pillar, radius);
            let towards = |way: f64| {
                let [x, y] = at(pillar + 2, way);
                [axis[0] + x, axis[1] + y]
            };
            if let Some(place) = all.get_mut(pillar) {
                *place = ([from, far], centre - width);
            }
            if let Some(place) = all.get_mut(6 + pillar) {
                *place = ([towards(ridge), towards(ridge + radius)], outer - outer_width);
            }
        }
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distances_lie_where_the_part_has_them() {
        let print = CalibrationPrint {
            centre: Some([74.0; 6]),
            outer: Some([75.0; 6]),
            centre_widths: Some([9.0, 9.1, 9.2]),
            outer_widths: Some([9.5; 6]),
            scale: Some(2.0),
        };
        let all = print.distances(&Texts::new()).unwrap_or_else(|_| panic!("it is whole"));
        for (place, ([[x, y], [i, j]], measured)) in all.into_iter().enumerate() {
            assert!((libm::hypot(i - x, j - y) - 130.0).abs() < 1e-9, "{place}");
            let wanted = if place < 6 { 74.0 - [9.0, 9.2, 9.1][place % 3] } else { 65.5 };
            assert!((measured - wanted).abs() < 1e-12, "{place}: {measured}");
        }
        // The first outer distance: from pillar A, at 210 degrees, in the direction of 330 degrees.
        let ([[x, y], [i, j]], _) = all[6];
        assert!((y - j - 65.0).abs() < 1e-9 && i > x, "{x} {y} {i} {j}");
        assert!(CalibrationPrint { outer: None, ..print }.distances(&Texts::new()).is_err());
    }
}

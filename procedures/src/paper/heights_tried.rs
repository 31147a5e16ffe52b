//! Heights that were tried with a sheet of paper under the tool, and the choice of the next.

use core::fmt;

use heapless::Vec;

/// Greatest number of heights that are remembered; of more, the farthest gives way.
const MOST: usize = 16;
/// Longest step between tried heights, mm: the same as Klipper's.
const LONGEST: f64 = 0.2;
/// Greatest difference of heights that count as the same, mm.
const SAME: f64 = 1e-6;

/// Step to the next height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    /// Step by a distance, mm.
    By(f64),
    /// Step halfway to the nearest height that was tried on that side.
    Halfway { up: bool },
    /// Step all the way to the nearest height that was tried on that side.
    Whole { up: bool },
}

/// Heights that were tried, lowest first.
#[derive(Clone, Debug, Default)]
pub(super) struct Tried {
    heights: Vec<f64, MOST>,
}

impl Tried {
    /// Notes a height at which the tool has been.
    pub fn note(&mut self, height: f64) {
        if self.heights.iter().any(|known| libm::fabs(known - height) < SAME) {
            return;
        }
        if self.heights.is_full() {
            let far = |index: &usize| self.heights.get(*index).map_or(0.0, |known| libm::fabs(known - height));
            let farthest = (0..MOST).max_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0);
            self.heights.remove(farthest);
        }
        // A height was removed above, so there is room.
        let _ = self.heights.push(height);
        units::sort_short(&mut self.heights, f64::total_cmp);
    }

    /// Returns the nearest tried heights below and above this height.
    fn beside(&self, here: f64) -> (Option<f64>, Option<f64>) {
        let below = self.heights.iter().rev().find(|height| **height < here - SAME);
        let above = self.heights.iter().find(|height| **height > here + SAME);
        (below.copied(), above.copied())
    }

    /// Returns the height that this step leads to.
    pub fn next(&self, here: f64, step: Step) -> f64 {
        let (below, above) = self.beside(here);
        let (up, share) = match step {
            Step::By(mm) => return here + mm,
            Step::Halfway { up } => (up, 0.5),
            Step::Whole { up } => (up, 1.0),
        };
        let beside = if up { above } else { below };
        let way = beside.map_or(f64::INFINITY, |height| share * libm::fabs(height - here));
        let way = if way < LONGEST { way } else { LONGEST };
        if up { here + way } else { here - way }
    }

    /// Returns the text `-0.150 < 0.050 < 0.250`: the tried height below, the present height, the tried
    /// height above.
    pub fn shown(&self, here: f64) -> Shown {
        let (below, above) = self.beside(here);
        Shown { below, here, above }
    }
}

/// Text of the heights, as [`Tried::shown`] returns it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shown {
    below: Option<f64>,
    here: f64,
    above: Option<f64>,
}

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(below) = self.below {
            write!(f, "{below:.3} < ")?;
        }
        write!(f, "{:.3}", self.here)?;
        match self.above {
            Some(above) => write!(f, " < {above:.3}"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn halves_close_in_on_what_was_tried() {
        let mut tried = Tried::default();
        tried.note(0.3);
        tried.note(0.0);
        assert_eq!(tried.next(0.3, Step::Halfway { up: false }), 0.15);
        assert_eq!(tried.next(0.3, Step::Whole { up: false }), 0.3 - LONGEST, "no step is longer");
        assert_eq!(tried.next(0.15, Step::Whole { up: false }), 0.0);
        assert_eq!(tried.next(0.0, Step::Halfway { up: false }), -LONGEST, "nothing was tried there");
        assert_eq!(tried.next(0.1, Step::By(-0.05)), 0.05);
        assert_eq!(tried.shown(0.15).to_string(), "0.000 < 0.150 < 0.300");
        assert_eq!(tried.shown(-1.0).to_string(), "-1.000 < 0.000");
    }

    proptest! {
        /// A person who says only whether the tool is too high or too low ends at the paper.
        #[test]
        fn whoever_answers_too_high_or_too_low_finds_the_paper(paper in -3.0..3.0_f64, start in -3.0..3.0_f64) {
            let (mut tried, mut here) = (Tried::default(), start);
            for _ in 0..60 {
                tried.note(here);
                here = tried.next(here, Step::Halfway { up: here < paper });
            }
            prop_assert!((here - paper).abs() < 0.01, "{here} for {paper}");
        }
    }
}

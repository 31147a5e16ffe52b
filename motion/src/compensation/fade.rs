//! Fading: the share of the correction that is left at a height.
//!
//! The correction fades from all of it to nothing, or to the same everywhere ([`Fade::target`]), by `1 - t^3
//! (10 - 15 t + 6 t^2)`, whose first and second derivatives are zero at both ends: where fading begins and
//! ends, speeds and accelerations of the motors go on without a jump.

use super::limits::CompensationError;

/// Greatest size of the first and the second derivative of the law above: 15/8 and 10/sqrt 3.
const STEEPEST: f64 = 1.875;
const BENDIEST: f64 = 5.773_502_691_896_258;
/// Greatest change of Z's way by fading: half, so that the map always has an inverse.
const MOST_CHANGE: f64 = 0.5;

/// Heights, mm of the program's machine space, between which the correction fades.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fade {
    /// Height up to which the correction is whole, mm.
    pub start: f64,
    /// Height from which on only the target is left of the correction, mm.
    pub end: f64,
    /// Correction that is left above the end, mm, the same everywhere: the difference from it fades.
    pub target: f64,
}

impl Fade {
    /// Checks that the heights are finite, in order, and far enough apart for corrections of `most` mm.
    pub(super) fn check(&self, most: f64) -> Result<(), CompensationError> {
        let length = self.end - self.start;
        let is_finite = self.start.is_finite() && self.end.is_finite() && self.target.is_finite();
        if !(is_finite && length > 0.0) {
            return Err(CompensationError::FadeOrder);
        }
        let most = most + libm::fabs(self.target);
        if length * MOST_CHANGE < STEEPEST * most {
            let least = libm::ceil(STEEPEST / MOST_CHANGE * most * 10.0) * 0.1;
            return Err(CompensationError::FadeShort { least_mm: least as f32 });
        }
        Ok(())
    }

    /// The share at height `z`, and its change for each mm.
    #[must_use]
    pub fn share(&self, z: f64) -> (f64, f64) {
        let length = self.end - self.start;
        let t = (z - self.start) / length;
        if t <= 0.0 {
            (1.0, 0.0)
        } else if t >= 1.0 {
            (0.0, 0.0)
        } else {
            let rest = 1.0 - t;
            (1.0 - t * t * t * (10.0 - t * (15.0 - 6.0 * t)), -30.0 * t * t * rest * rest / length)
        }
    }

    /// Bounds of the share's first and second derivative between two heights.
    pub(super) fn derivatives(&self, low: f64, high: f64) -> (f64, f64) {
        if high <= self.start || low >= self.end {
            return (0.0, 0.0);
        }
        let length = self.end - self.start;
        (STEEPEST / length, BENDIEST / (length * length))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_share_falls_smoothly_within_its_bounds(start in -5.0..5.0_f64, length in 0.5..50.0_f64, t in -0.2..1.2_f64) {
            let fade = Fade { start, end: start + length, target: 0.0 };
            let z = start + t * length;
            let (share, slope) = fade.share(z);
            prop_assert!((0.0..=1.0).contains(&share));
            let step = 1e-5 * length;
            let (before, after) = (fade.share(z - step), fade.share(z + step));
            prop_assert!((slope - (after.0 - before.0) / (2.0 * step)).abs() < 1e-6 / length, "the slope is the change of the share");
            let (steepest, bendiest) = fade.derivatives(z, z);
            prop_assert!(slope.abs() <= steepest * 1.000_1 + 1e-9);
            prop_assert!((after.1 - before.1).abs() / (2.0 * step) <= bendiest * 1.001 + 1e-6);
        }
    }

    #[test]
    fn fades_that_are_no_fades_are_refused() {
        let check = |start, end, most| Fade { start, end, target: 0.0 }.check(most);
        assert_eq!(check(1.0, 10.0, 1.0), Ok(()));
        assert_eq!(check(10.0, 1.0, 0.0), Err(CompensationError::FadeOrder));
        assert_eq!(check(f64::NAN, 1.0, 0.0), Err(CompensationError::FadeOrder));
        assert_eq!(check(0.0, 3.0, 1.0), Err(CompensationError::FadeShort { least_mm: 3.8 }));
        let aside = Fade { start: 0.0, end: 3.0, target: -0.5 };
        assert_eq!((aside.check(0.3), aside.check(0.5)), (Ok(()), Err(CompensationError::FadeShort { least_mm: 3.8 })));
    }
}

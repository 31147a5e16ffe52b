//! Skew: axes that are not at right angles to each other.
//!
//! Seen from the program, Y leans towards X by the factor `xy`, Z towards X by `xz` and towards Y by `yz`: a
//! millimetre along the one carries the tool that much along the other. The motors' place takes that back:
//! `y' = y - yz z`, `x' = x - xy y - (xz - xy yz) z`, the inverse of `y = y' + yz z`, `x = x' + xy y' + xz
//! z`.

use units::PerAxis;

use crate::square_root;

use super::limits::{CompensationError, MOST_SKEW};

/// Skew factors: the tangents of the angles missing to 90 degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Skew {
    /// Tool movement along X for a millimetre along Y.
    pub xy: f64,
    /// Tool movement along X for a millimetre along Z.
    pub xz: f64,
    /// Tool movement along Y for a millimetre along Z.
    pub yz: f64,
}

impl Skew {
    /// No skew: axes at right angles.
    pub const NONE: Self = Self { xy: 0.0, xz: 0.0, yz: 0.0 };

    /// The factor of a plane from a printed (or milled) square ABCD: its diagonals AC and BD and its side AD,
    /// where AD lies along the second axis of the plane. `None` when no figure has these lengths.
    ///
    /// With the origin in A the figure is a parallelogram of sides u (AB) and w (AD): `AC^2 - BD^2 = 4 u w
    /// cos A` and `AC^2 + BD^2 = 2 (u^2 + w^2)`. The factor is the cotangent of the angle in A.
    #[must_use]
    pub fn from_square(ac: f64, bd: f64, ad: f64) -> Option<f64> {
        let side_sq = 0.5 * (ac * ac + bd * bd) - ad * ad;
        if !(ac > 0.0 && bd > 0.0 && ad > 0.0 && side_sq > 0.0) {
            return None;
        }
        let cosine = (ac * ac - bd * bd) / (4.0 * square_root(side_sq) * ad);
        let sine_sq = 1.0 - cosine * cosine;
        (sine_sq > 0.0).then(|| cosine / square_root(sine_sq))
    }

    /// Checks that every factor is a number within bounds.
    pub(crate) fn check(&self) -> Result<(), CompensationError> {
        let is_fine = |factor: &f64| libm::fabs(*factor) <= MOST_SKEW;
        if [self.xy, self.xz, self.yz].iter().all(is_fine) { Ok(()) } else { Err(CompensationError::Skew) }
    }

    /// Takes the skew back: from the program's point (or direction) to the motors'.
    #[must_use]
    pub fn apply(&self, of: &PerAxis<f64>) -> PerAxis<f64> {
        let [x, y, z, a, b, c] = of.0;
        let across = self.xz - self.xy * self.yz;
        PerAxis([x - self.xy * y - across * z, y - self.yz * z, z, a, b, c])
    }

    /// Adds the skew again: from the motors' point (or direction) to the program's.
    #[must_use]
    pub fn undo(&self, of: &PerAxis<f64>) -> PerAxis<f64> {
        let [x, y, z, a, b, c] = of.0;
        PerAxis([x + self.xy * y + self.xz * z, y + self.yz * z, z, a, b, c])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_square_has_no_skew_and_a_leaning_one_its_tangent() {
        let diagonal = 2.0_f64.sqrt() * 100.0;
        assert_eq!(Skew::from_square(diagonal, diagonal, 100.0), Some(0.0));
        // A (0,0), B (100,0), D (3,100), C (103,100).
        let ad = 3.0_f64.hypot(100.0);
        let factor = Skew::from_square(103.0_f64.hypot(100.0), 97.0_f64.hypot(100.0), ad).expect("a figure");
        assert!((factor - 0.03).abs() < 1e-12, "{factor}");
        assert_eq!(Skew::from_square(1.0, 1.0, 10.0), None);
        assert_eq!(Skew::from_square(f64::NAN, 1.0, 1.0), None);
        assert_eq!(Skew::from_square(200.0, 0.0, 100.0), None);
    }

    proptest! {
        #[test]
        fn what_is_taken_back_can_be_given_back(
            point in prop::array::uniform3(-500.0..500.0_f64), factors in prop::array::uniform3(-0.1..0.1_f64),
        ) {
            let [xy, xz, yz] = factors;
            let (skew, [x, y, z]) = (Skew { xy, xz, yz }, point);
            let there = PerAxis([x, y, z, 1.0, 2.0, 3.0]);
            let back = skew.undo(&skew.apply(&there));
            for (one, other) in there.0.iter().zip(back.0) {
                prop_assert!((one - other).abs() < 1e-10);
            }
        }
    }
}

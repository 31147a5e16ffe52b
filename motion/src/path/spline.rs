//! A cubic of X, Y and Z, travelled at an even speed.
//!
//! The cubic is `P(u)` with u from 0 to 1. The place after s mm is wanted, so u must be known as a function
//! of the distance. No closed form exists. Here u is a polynomial of degree six, which has the right value,
//! slope and bend at both ends (they follow from `du/ds = 1 / |P'|`) and the right value in the middle; a
//! curve for which that is not good to [`EVEN_WITHIN`] is divided until it is ([`crate::geometry::Bezier`]).
//! So a place costs some forty multiplications, always the same, and no root.

use super::{Vector, dot, mix, size};
use crate::{greatest, least, square_root};

/// The distance travelled differs from that asked for by less than this, mm, and by less than `EVEN_SHARE`
/// of the whole.
pub const EVEN_WITHIN: f64 = 2e-8;
const EVEN_SHARE: f64 = 1e-6;
/// A curve whose direction turns by more than a quarter within it is divided in any case.
const LEAST_COSINE: f64 = 0.0;

/// An evenly travelled cubic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spline {
    /// `P(u) = u (a + u (b + u c))`, from the start, mm.
    cubic: [Vector; 3],
    /// `u(x) = x (w0 + x (w1 + ...))`, x being the share of the way.
    warp: [f64; 6],
    /// Length of the cubic itself, mm.
    flat: f64,
    /// Length of the path with its rise, mm.
    length: f64,
}

/// Nodes and weights of Gauss's rule of eight points on -1 to 1, half of them: the others mirror these.
/// (Abramowitz and Stegun, table 25.4.)
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_47),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

fn slope_of([a, b, c]: &[Vector; 3], u: f64) -> Vector {
    mix(1.0, *a, u, mix(2.0, *b, 3.0 * u, *c))
}

fn bend_of([_, b, c]: &[Vector; 3], u: f64) -> Vector {
    mix(2.0, *b, 6.0 * u, *c)
}

/// Length from 0 to u.
fn length_to(cubic: &[Vector; 3], u: f64) -> f64 {
    let half = 0.5 * u;
    let part = |(node, weight): (f64, f64)| {
        weight * (size(slope_of(cubic, half - half * node)) + size(slope_of(cubic, half + half * node)))
    };
    half * GAUSS.into_iter().map(part).sum::<f64>()
}

/// `du/dx` and its change where the whole is `length` long.
fn pace(cubic: &[Vector; 3], u: f64, length: f64) -> (f64, f64) {
    let (slope, bend) = (slope_of(cubic, u), bend_of(cubic, u));
    let rate = length / size(slope);
    (rate, -rate * rate * rate * rate * dot(slope, bend) / (length * length))
}

impl Spline {
    /// The cubic `u (a + u (b + u c))`, if it can be travelled evenly in one piece.
    #[must_use]
    pub fn fit(cubic: [[f64; 3]; 3]) -> Option<Self> {
        let whole = length_to(&cubic, 1.0);
        let (first, last) = (slope_of(&cubic, 0.0), slope_of(&cubic, 1.0));
        let is_tame = dot(first, last) > LEAST_COSINE * size(first) * size(last);
        if !(is_tame && whole.is_finite() && whole > 0.0) {
            return None;
        }
        let ((v0, a0), (v1, a1)) = (pace(&cubic, 0.0, whole), pace(&cubic, 1.0, whole));
        // Hermite's quintic from 0 to 1.
        let (rest, rest_v, rest_a) = (1.0 - v0 - 0.5 * a0, v1 - v0 - a0, a1 - a0);
        let c3 = 10.0 * rest - 4.0 * rest_v + 0.5 * rest_a;
        let c4 = -15.0 * rest + 7.0 * rest_v - rest_a;
        let c5 = 6.0 * rest - 3.0 * rest_v + 0.5 * rest_a;
        let mut spline = Self { cubic, warp: [v0, 0.5 * a0, c3, c4, c5, 0.0], flat: whole, length: whole };
        // Length missing in the middle: `64 x^3 (1 - x)^3` is one there and flat at the ends.
        let middle = spline.warped(0.5);
        let lacks = 0.5 * whole - length_to(&cubic, middle);
        let k = 64.0 * lacks / size(slope_of(&cubic, middle));
        spline.warp = [v0, 0.5 * a0, c3 + k, c4 - 3.0 * k, c5 + 3.0 * k, -k];
        let off = |x: f64| libm::fabs(length_to(&cubic, spline.warped(x)) - x * whole);
        let worst = greatest(greatest(off(0.25), off(0.75)), off(0.5));
        // An error that is not a number compares false.
        (worst < least(EVEN_WITHIN, EVEN_SHARE * whole)).then_some(spline)
    }

    /// Returns the spline, rising by so much in all at right angles to the curve, mm.
    #[must_use]
    pub fn rising(self, rise: f64) -> Self {
        Self { length: square_root(self.flat * self.flat + rise * rise), ..self }
    }

    /// Length of the path, mm.
    #[must_use]
    pub const fn length(&self) -> f64 {
        self.length
    }

    /// Length of the curve without its rise, mm.
    #[must_use]
    pub const fn flat_length(&self) -> f64 {
        self.flat
    }

    /// The cubic: `u (a + u (b + u c))` from the start, mm.
    #[must_use]
    pub const fn cubic(&self) -> &[[f64; 3]; 3] {
        &self.cubic
    }

    fn warped(&self, x: f64) -> f64 {
        let [w0, w1, w2, w3, w4, w5] = self.warp;
        x * (w0 + x * (w1 + x * (w2 + x * (w3 + x * (w4 + x * w5)))))
    }

    /// First and second derivative of u for a millimetre of path.
    fn warp_rates(&self, x: f64) -> (f64, f64) {
        let [w0, w1, w2, w3, w4, w5] = self.warp;
        let first = w0 + x * (2.0 * w1 + x * (3.0 * w2 + x * (4.0 * w3 + x * (5.0 * w4 + x * 6.0 * w5))));
        let second = 2.0 * w1 + x * (6.0 * w2 + x * (12.0 * w3 + x * (20.0 * w4 + x * 30.0 * w5)));
        (first / self.length, second / (self.length * self.length))
    }

    /// Returns the addition to X, Y and Z after `s` mm of path.
    pub(super) fn offset(&self, s: f64) -> Vector {
        let u = self.warped(s / self.length);
        let [a, b, c] = self.cubic;
        mix(u, a, u * u, mix(1.0, b, u, c))
    }

    /// Returns the addition for the next millimetre of path, after `s` mm.
    pub(super) fn slope(&self, s: f64) -> Vector {
        let x = s / self.length;
        let rate = self.warp_rates(x).0;
        slope_of(&self.cubic, self.warped(x)).map(|part| part * rate)
    }

    /// Returns the change of the slope for each millimetre of path, 1/mm.
    pub(super) fn bend(&self, s: f64) -> Vector {
        let x = s / self.length;
        let (u, (rate, change)) = (self.warped(x), self.warp_rates(x));
        mix(rate * rate, bend_of(&self.cubic, u), change, slope_of(&self.cubic, u))
    }

    /// Returns the change of the bend for each millimetre of path, 1/mm^2.
    pub(super) fn twist(&self, s: f64) -> Vector {
        let x = s / self.length;
        let (u, (rate, change)) = (self.warped(x), self.warp_rates(x));
        let [_, _, w2, w3, w4, w5] = self.warp;
        let third = 6.0 * w2 + x * (24.0 * w3 + x * (60.0 * w4 + x * 120.0 * w5));
        let third = third / (self.length * self.length * self.length);
        let [_, _, c] = self.cubic;
        let turning = mix(3.0 * rate * change, bend_of(&self.cubic, u), third, slope_of(&self.cubic, u));
        mix(1.0, turning, 6.0 * rate * rate * rate, c)
    }
}

//! Uniform cubic B-splines along a line of a grid: the coefficients of the natural spline, the weights of
//! coefficients at a place.

use crate::{greatest, least};
use units::MOST_SIDE;

/// Coefficients along a side: one more at each end.
pub(super) const SIDE: usize = MOST_SIDE + 2;

/// Turns `count` values at 1.. in `line` into the coefficients of the natural spline through them, at 0 to
/// `count + 1`: `c[i-1] + 4 c[i] + c[i+1] = 6 h[i]`, with no bend at both ends.
pub(super) fn natural(line: &mut [f64; SIDE], count: usize) {
    let mut factors = [0.0; SIDE];
    let get = |line: &[f64; SIDE], index: usize| line.get(index).copied().unwrap_or(0.0);
    // Forwards: each equation loses its first unknown. The first value is its own coefficient.
    for index in 2..count {
        let factor = 1.0 / (4.0 - get(&factors, index - 1));
        let known = 6.0 * get(line, index) - get(line, index - 1);
        if let (Some(to), Some(kept)) = (line.get_mut(index), factors.get_mut(index)) {
            *to = known * factor;
            *kept = factor;
        }
    }
    for index in (2..count).rev() {
        let after = get(&factors, index) * get(line, index + 1);
        if let Some(to) = line.get_mut(index) {
            *to -= after;
        }
    }
    let (first, second) = (get(line, 1), get(line, 2));
    let (last, before) = (get(line, count), get(line, count - 1));
    if let Some(to) = line.get_mut(0) {
        *to = 2.0 * first - second;
    }
    if let Some(to) = line.get_mut(count + 1) {
        *to = 2.0 * last - before;
    }
}

/// The cell of a place counted in grid distances, and how far in it is. Beyond three distances from the grid
/// nothing changes any more.
pub(super) fn cell(place: f64, last: i32) -> (i32, f64) {
    let bounded = least(greatest(place, -3.0), f64::from(last) + 3.0);
    let index = libm::floor(bounded) as i32;
    (index, bounded - f64::from(index))
}

/// The four B-splines that are not zero in a cell: their values and slopes.
pub(super) struct Weights {
    /// Weights of the height.
    pub value: [f64; 4],
    /// Weights of the slope, for each grid distance.
    pub slope: [f64; 4],
}

impl Weights {
    /// Returns the cell of a place counted in grid distances, and the weights there.
    pub fn at(place: f64, last: i32) -> (i32, Self) {
        let (index, t) = cell(place, last);
        (index, Self::of(t))
    }

    /// Returns the weights at a place in the cell, in grid distances.
    pub fn of(t: f64) -> Self {
        let rest = 1.0 - t;
        let value = [
            rest * rest * rest / 6.0,
            (4.0 - t * t * (6.0 - 3.0 * t)) / 6.0,
            (1.0 + t * (3.0 + t * (3.0 - 3.0 * t))) / 6.0,
            t * t * t / 6.0,
        ];
        let slope = [-0.5 * rest * rest, t * (1.5 * t - 2.0), 0.5 + t * (1.0 - 1.5 * t), 0.5 * t * t];
        Self { value, slope }
    }
}

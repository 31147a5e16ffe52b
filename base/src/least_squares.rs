//! Least squares: computes few unknowns from many measurements.
//!
//! The normal equations, gathered row by row and solved by Gauss and Jordan with the greatest pivot of each
//! column. Unknowns should be of like size, so that no square is lost beside another.

/// Greatest number of unknowns.
pub const MOST: usize = 12;
/// Share of the greatest sum below which a pivot is zero: the measurements do not determine an unknown.
const LEAST_PIVOT: f64 = 1e-12;

/// The sums of measurements so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct LeastSquares {
    /// Normal matrix; the right-hand sides stand in the last column.
    sums: [[f64; MOST + 1]; MOST],
}

impl LeastSquares {
    /// Adds one measurement: the coefficient of each unknown, and the measured value.
    pub fn add(&mut self, row: &[f64], value: f64) {
        for (sums, one) in self.sums.iter_mut().zip(row) {
            for (cell, other) in sums.iter_mut().zip(row) {
                *cell += one * other;
            }
            if let Some(last) = sums.last_mut() {
                *last += one * value;
            }
        }
    }

    /// Returns the variance of one of the first `count` unknowns, where each measurement has a variance of
    /// one.
    pub fn variance(mut self, count: usize, of: usize) -> Option<f64> {
        for (index, row) in self.sums.iter_mut().enumerate() {
            *row.last_mut()? = if index == of { 1.0 } else { 0.0 };
        }
        self.solve(count)?.get(of).copied()
    }

    /// Solves for the first `count` unknowns. `None` when the measurements do not determine all of them.
    pub fn solve(mut self, count: usize) -> Option<[f64; MOST]> {
        let rows = self.sums.get_mut(..count)?;
        let size = |row: &[f64; MOST + 1], column: usize| row.get(column).map_or(0.0, |cell| libm::fabs(*cell));
        let greatest = rows.iter().enumerate().map(|(index, row)| size(row, index)).fold(0.0, f64::max);
        for column in 0..count {
            let best = (column..count).max_by(|a, b| {
                let of = |index: &usize| rows.get(*index).map_or(0.0, |row| size(row, column));
                of(a).total_cmp(&of(b))
            })?;
            rows.swap(column, best);
            let pivot = *rows.get(column)?;
            if size(&pivot, column).is_nan() || size(&pivot, column) <= LEAST_PIVOT * greatest {
                return None;
            }
            for (_, row) in rows.iter_mut().enumerate().filter(|(index, _)| *index != column) {
                let share = row.get(column)? / pivot.get(column)?;
                for (cell, other) in row.iter_mut().zip(pivot) {
                    *cell -= share * other;
                }
            }
        }
        let mut values = [0.0; MOST];
        for (index, (value, row)) in values.iter_mut().zip(rows.iter()).enumerate() {
            *value = row.last()? / row.get(index)?;
        }
        Some(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_made_the_measurements_is_found(
            truth in proptest::array::uniform4(-5.0..5.0_f64),
            rows in proptest::collection::vec(proptest::array::uniform4(-1.0..1.0_f64), 12..30),
        ) {
            let mut sums = LeastSquares::default();
            for row in &rows {
                sums.add(row, row.iter().zip(truth).map(|(a, b)| a * b).sum());
            }
            let found = sums.solve(4).expect("enough of them");
            for (found, truth) in found.iter().zip(truth) {
                prop_assert!((found - truth).abs() < 1e-6, "{found} for {truth}");
            }
        }
    }

    #[test]
    fn a_mean_of_many_is_as_sure_as_their_number_says() {
        let mut sums = LeastSquares::default();
        for n in 0..25 {
            sums.add(&[1.0, f64::from(n % 5) - 2.0], 3.0);
        }
        let variance = sums.variance(2, 0).expect("known");
        assert!((variance - 1.0 / 25.0).abs() < 1e-12, "{variance}");
        assert_eq!(sums.solve(1).map(|found| found[0]), Some(3.0), "nothing was changed");
    }

    #[test]
    fn measurements_that_do_not_tell_give_nothing() {
        let mut sums = LeastSquares::default();
        for n in 0..9 {
            sums.add(&[1.0, 2.0, f64::from(n)], f64::from(n));
        }
        assert!(sums.solve(3).is_none());
        assert!(LeastSquares::default().solve(1).is_none());
    }
}

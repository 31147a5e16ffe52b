//! Statistics of repeated measurements: least, greatest, mean and deviation, without keeping the values.

/// Sums and extremes of the measurements.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    count: u32,
    least: f64,
    most: f64,
    sum: f64,
    squares: f64,
    first: f64,
}

impl Spread {
    /// Adds a measurement. Sums are of the distances from the first: far from the origin squares would lose
    /// digits.
    pub fn add(&mut self, at: f64) {
        if self.count == 0 {
            *self = Self { first: at, least: at, most: at, ..Self::default() };
        }
        let off = at - self.first;
        (self.least, self.most) = (self.least.min(at), self.most.max(at));
        (self.count, self.sum, self.squares) = (self.count + 1, self.sum + off, self.squares + off * off);
    }

    /// Returns the number of measurements.
    pub const fn count(&self) -> u32 {
        self.count
    }

    /// Returns the first measurement; zero without any.
    pub const fn first(&self) -> f64 {
        self.first
    }

    /// Returns the least and the greatest measurement.
    pub const fn ends(&self) -> [f64; 2] {
        [self.least, self.most]
    }

    /// Returns the greatest measurement less the least.
    pub fn range(&self) -> f64 {
        self.most - self.least
    }

    /// Returns the mean of the measurements.
    pub fn mean(&self) -> f64 {
        self.first + self.sum / f64::from(self.count.max(1))
    }

    /// Returns the standard deviation of the measurements.
    pub fn deviation(&self) -> f64 {
        let count = f64::from(self.count.max(1));
        let mean = self.sum / count;
        libm::sqrt((self.squares / count - mean * mean).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn figures_are_those_of_the_measurements(at in proptest::collection::vec(-500.0..500.0_f64, 1..20)) {
            let mut spread = Spread::default();
            at.iter().for_each(|at| spread.add(*at));
            let mean = at.iter().sum::<f64>() / at.len() as f64;
            let variance = at.iter().map(|at| (at - mean) * (at - mean)).sum::<f64>() / at.len() as f64;
            let most = at.iter().copied().fold(f64::MIN, f64::max);
            let least = at.iter().copied().fold(f64::MAX, f64::min);
            prop_assert!((spread.mean() - mean).abs() < 1e-9);
            prop_assert!((spread.deviation() - variance.sqrt()).abs() < 1e-6);
            prop_assert_eq!(spread.range(), most - least);
        }
    }
}

//! Statistics of a motor's load readings, and the search for a threshold from them.

/// Readings at a single speed and threshold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Readings {
    count: u32,
    sum: f32,
    squares: f32,
    least: u16,
    most: u16,
    zeros: u32,
}

impl Readings {
    /// Adds a reading to the statistics.
    pub fn add(&mut self, reading: u16) {
        let value = f32::from(reading);
        self.least = if self.count == 0 { reading } else { self.least.min(reading) };
        self.most = self.most.max(reading);
        self.count += 1;
        self.sum += value;
        self.squares += value * value;
        self.zeros += u32::from(reading == 0);
    }

    /// Returns the number of readings.
    pub const fn count(&self) -> u32 {
        self.count
    }

    /// Returns the least reading.
    pub const fn least(&self) -> u16 {
        self.least
    }

    /// Returns a value below all readings, and below what noise would make of more readings.
    pub fn least_likely(&self) -> f32 {
        f32::from(self.least).min(self.mean() - NOISE_ROOM * self.noise())
    }

    /// Returns a value above all readings, and above what noise would make of more readings.
    pub fn most_likely(&self) -> f32 {
        f32::from(self.most).max(self.mean() + NOISE_ROOM * self.noise())
    }

    /// Returns the mean of the readings.
    pub fn mean(&self) -> f32 {
        self.sum / self.count.max(1) as f32
    }

    /// Returns the readings' standard deviation.
    pub fn noise(&self) -> f32 {
        let mean = self.mean();
        libm::sqrtf((self.squares / self.count.max(1) as f32 - mean * mean).max(0.0))
    }

    /// Returns whether a motor that runs free gave the readings, with room for noise and for more load than
    /// it has here.
    pub fn are_free(&self, least_mean: f32) -> bool {
        self.zeros == 0 && self.mean() >= least_mean.max(NOISE_ROOM * self.noise())
    }

    /// Returns whether a motor that induces nothing gave the readings: every reading is 0.
    pub const fn are_stalled(&self) -> bool {
        self.count > 0 && self.zeros == self.count
    }
}

/// Mean reading of a free motor, at least, in standard deviations above 0.
const NOISE_ROOM: f32 = 5.0;

/// Binary search for the end of a range of thresholds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Halving {
    /// Lower bound: all thresholds below it are wrong.
    low: i8,
    /// Upper bound: this threshold and all above are right; [`LAST`] + 1 while none is known to be.
    high: i8,
}

impl Halving {
    /// Starts a search from `low` up to [`LAST`].
    pub const fn from(low: i8) -> Self {
        Self { low, high: LAST + 1 }
    }

    /// Returns the next threshold to try, or `None` when the search has ended.
    pub fn next(&self) -> Option<i8> {
        (self.low < self.high).then(|| middle(self.low, self.high))
    }

    /// Takes the result of the trial of [`Self::next`].
    pub fn tell(&mut self, is_right: bool) {
        let Some(tried) = self.next() else { return };
        if is_right {
            self.high = tried;
        } else {
            self.low = tried + 1;
        }
    }

    /// Returns the lowest right threshold, or `None` if all are wrong.
    pub fn found(&self) -> Option<i8> {
        (self.high <= LAST).then_some(self.high)
    }
}

/// Returns the mean of two thresholds, rounded down.
pub(super) const fn middle(low: i8, high: i8) -> i8 {
    ((low as i16 + high as i16).div_euclid(2)) as i8
}

/// Least and greatest value of the threshold (`SGT`).
pub(super) const FIRST: i8 = -64;
pub(super) const LAST: i8 = 63;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_that_is_right_is_found_in_seven_tries() {
        for lowest in FIRST..=LAST {
            let (mut halving, mut tries) = (Halving::from(FIRST), 0);
            while let Some(threshold) = halving.next() {
                halving.tell(threshold >= lowest);
                tries += 1;
            }
            assert!(halving.found() == Some(lowest) && tries <= 8, "{lowest}: {tries}");
        }
        let mut none = Halving::from(10);
        while none.next().is_some() {
            none.tell(false);
        }
        assert_eq!(none.found(), None);
    }

    #[test]
    fn free_means_above_zero_by_the_noise_and_stalled_means_zero() {
        let of = |values: &[u16]| {
            let mut readings = Readings::default();
            values.iter().for_each(|value| readings.add(*value));
            readings
        };
        let free = of(&[140, 160, 150, 155, 145]);
        assert!((free.mean() - 150.0).abs() < 0.1 && (free.noise() - 7.07).abs() < 0.1 && free.least() == 140);
        assert!(free.are_free(100.0) && !free.are_free(151.0) && !free.are_stalled());
        assert!(!of(&[300, 0, 300]).are_free(100.0), "a stall among them");
        assert!(!of(&[20, 300, 20, 300]).are_free(100.0), "it is too noisy to tell");
        assert!(of(&[0, 0]).are_stalled() && !of(&[0, 1]).are_stalled() && !Readings::default().are_stalled());
    }
}

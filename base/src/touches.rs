//! Several touches of a place: their result, the check of their distance, and their scatter over a whole bed.

use config::SamplesConfig;
use heapless::Vec;

/// Greatest number of touches of a place: the configuration allows no more.
pub const MOST: usize = 50;

/// Heights of touches of a place, mm, the lowest first.
#[derive(Clone, Debug, Default)]
pub struct Touches {
    heights: Vec<f64, MOST>,
}

impl Touches {
    /// Adds a touch at this height, mm.
    pub fn add(&mut self, height: f64) {
        let place = self.heights.iter().position(|other| *other > height).unwrap_or(self.heights.len());
        // The list holds as many touches as can be configured.
        let _ = self.heights.insert(place, height);
    }

    /// Returns the number of touches.
    pub fn count(&self) -> usize {
        self.heights.len()
    }

    /// Returns the difference of the highest and the lowest touch.
    pub fn range(&self) -> f64 {
        self.heights.first().zip(self.heights.last()).map_or(0.0, |(least, most)| most - least)
    }

    /// Returns whether the touches lie near enough to each other.
    pub fn agree(&self, settings: &SamplesConfig) -> bool {
        settings.tolerance.0 <= 0.0 || self.range() <= settings.tolerance.0
    }

    /// Returns the mean height, mm.
    pub fn mean(&self) -> f64 {
        self.heights.iter().sum::<f64>() / self.heights.len().max(1) as f64
    }

    /// Returns the median: the mean of the two in the middle for an even number.
    pub fn median(&self) -> f64 {
        let at = |index: usize| self.heights.get(index).copied().unwrap_or(0.0);
        let (half, count) = (self.heights.len() / 2, self.heights.len());
        if count.is_multiple_of(2) { 0.5 * (at(half.saturating_sub(1)) + at(half)) } else { at(half) }
    }

    /// Returns the result of the touches: median or mean, as configured.
    pub fn result(&self, settings: &SamplesConfig) -> f64 {
        if settings.median { self.median() } else { self.mean() }
    }

    /// Returns the sum of the squares of the touches' distances from their mean.
    fn squares(&self) -> f64 {
        let mean = self.mean();
        self.heights.iter().map(|height| (height - mean) * (height - mean)).sum()
    }
}

/// Scatter of the touches of a whole bed. Touches of the same place differ by the probe alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scatter {
    places: u32,
    touches: u32,
    again: u32,
    squares: f64,
    /// Whether medians counted, not means.
    median: bool,
    widest: f64,
    widest_at: [f64; 2],
}

impl Scatter {
    /// Adds the touches that counted at a place, and the number of its repetitions.
    pub fn add(&mut self, at: [f64; 2], touches: &Touches, again: u32, median: bool) {
        self.median = median;
        self.places += 1;
        self.touches += touches.count() as u32;
        self.again += again;
        self.squares += touches.squares();
        if touches.range() > self.widest {
            (self.widest, self.widest_at) = (touches.range(), at);
        }
    }

    /// Returns the standard deviation of a single touch, mm; `None` if every place was touched once.
    #[must_use]
    pub fn deviation(&self) -> Option<f64> {
        let freedom = self.touches.checked_sub(self.places).filter(|more| *more > 0)?;
        Some(libm::sqrt(self.squares / f64::from(freedom)))
    }
}

impl Scatter {
    /// Returns the standard deviation of the result of this many touches. Medians of many scatter by the root
    /// of half of pi more than means; of two they are the same.
    fn of_a_point(&self, deviation: f64, each: f64) -> f64 {
        const OF_MEDIANS: f64 = 1.253_314_137_315_500_3;
        let more = if self.median && each > 2.5 { OF_MEDIANS } else { 1.0 };
        more * deviation / libm::sqrt(each)
    }
}

/// Reports the scatter in a sentence, empty for single touches.
impl core::fmt::Display for Scatter {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Some(deviation) = self.deviation() else {
            return write!(
                f,
                "Touches: one at each of {} places; samples = 3 in [zprobe] says how they scatter",
                self.places
            );
        };
        let ([x, y], each) = (self.widest_at, f64::from(self.touches) / f64::from(self.places));
        write!(
            f,
            "Touches: {} at {} places, {} places again; standard deviation {deviation:.4} mm, of a point {:.4} mm; \
             {:.4} mm apart at most, at X{x:.1} Y{y:.1}",
            self.touches,
            self.places,
            self.again,
            self.of_a_point(deviation, each),
            self.widest,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use units::Mm;

    fn touches(heights: &[f64]) -> Touches {
        let mut all = Touches::default();
        heights.iter().for_each(|height| all.add(*height));
        all
    }

    fn settings(median: bool, tolerance: f64) -> SamplesConfig {
        SamplesConfig { count: 5, median, tolerance: Mm(tolerance), retries: 2, retract: Mm(1.0) }
    }

    #[test]
    fn a_median_leaves_out_what_went_wrong() {
        let one_wrong = touches(&[0.1, 0.11, 0.9, 0.09, 0.1]);
        assert_eq!(one_wrong.result(&settings(true, 0.0)), 0.1);
        assert!((one_wrong.result(&settings(false, 0.0)) - 0.26).abs() < 1e-12);
        assert!((touches(&[1.0, 4.0, 2.0, 9.0]).median() - 3.0).abs() < 1e-12);
        assert!(!one_wrong.agree(&settings(true, 0.5)) && one_wrong.agree(&settings(true, 0.82)));
        assert!(one_wrong.agree(&settings(true, 0.0)), "0: not looked at");
        assert_eq!((touches(&[2.0]).range(), touches(&[2.0]).median()), (0.0, 2.0));
    }

    proptest! {
        #[test]
        fn the_results_lie_within_the_touches(heights in prop::collection::vec(-2.0..2.0_f64, 1..20)) {
            let all = touches(&heights);
            let (low, high) = heights.iter().fold((f64::MAX, f64::MIN), |(l, h), z| (l.min(*z), h.max(*z)));
            for result in [all.median(), all.mean()] {
                prop_assert!(low - 1e-12 <= result && result <= high + 1e-12);
            }
            prop_assert_eq!(all.range(), high - low);
        }

        #[test]
        fn the_probes_own_scatter_is_found_whatever_the_bed(heights in prop::collection::vec(-2.0..2.0_f64, 200), offsets in prop::collection::vec(-0.1..0.1_f64, 4)) {
            // The same four offsets at each place: their deviation is that of the whole.
            let mut scatter = Scatter::default();
            for height in &heights {
                let at_place: std::vec::Vec<f64> = offsets.iter().map(|offset| height + offset).collect();
                scatter.add([1.0, 2.0], &touches(&at_place), 0, false);
            }
            let mean = offsets.iter().sum::<f64>() / 4.0;
            let wanted = (offsets.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / 3.0).sqrt();
            prop_assert!((scatter.deviation().expect("four each") - wanted).abs() < 1e-9);
        }
    }

    #[test]
    fn single_touches_tell_nothing_of_the_probe() {
        let mut scatter = Scatter::default();
        scatter.add([0.0; 2], &touches(&[0.3]), 0, false);
        assert_eq!(scatter.deviation(), None);
        assert!(std::format!("{scatter}").starts_with("Touches: one at each of 1 places"));
        scatter.add([5.0, 6.0], &touches(&[0.3, 0.4]), 1, true);
        assert!(std::format!("{scatter}").contains("3 at 2 places, 1 places again; standard deviation 0.0707 mm"));
        assert!(std::format!("{scatter}").ends_with("0.1000 mm apart at most, at X5.0 Y6.0"));
    }
}

//! M48, and Klipper's PROBE_ACCURACY: repeatability of the probe.

use base::failure::{Answer, Failure, Outcome};
use base::touches::{MOST, Touches};
use program::Words;
use units::{Axis, MmPerSecond};

use super::search::{Search, check_homed, search};
use crate::probing::ProbeHands;

/// Greatest travel of M48, mm: the search begins just above the bed.
const REPEAT_TRAVEL: f64 = 20.0;
/// Number of probes of M48 without P.
const REPEATS: f64 = 10.0;

/// M48: probes P times at the same place, with F at that rate; reports the differences. Unknown without a
/// probe.
pub fn repeatability<'c>(hands: &mut impl ProbeHands<'c>, words: &Words<'_>) -> Outcome {
    if !hands.config().probe.enable {
        return Ok(Answer::Unknown);
    }
    check_homed(hands)?;
    let probe = hands.tuning().probe;
    let rate = words.get('F').map_or(probe.slow_rate, MmPerSecond);
    let repeats = words.get('P').unwrap_or(REPEATS);
    hands.standstill()?;
    let start = hands.position();
    let mut seen = Spread::default();
    let mut first = Touches::default();
    for _ in 0..repeats as u32 {
        let found = search(hands, &Search::down(start, rate, REPEAT_TRAVEL, probe.reverse_z))?;
        hands.go_there(start, probe.return_rate)?;
        let Some(contact) = found else {
            return Err(Failure::refused(&"ZProbe not triggered within 20 mm"));
        };
        let distance = start[Axis::Z] - contact[Axis::Z];
        seen.add(distance);
        first.add(distance);
        hands.say(format_args!("Z:{distance:.4}\n"));
        hands.drain();
    }
    let (mean, deviation) = seen.mean_and_deviation();
    let ([least, most], median) = (seen.ends(), first.median());
    let of = if repeats > MOST as f64 { " of the first 50" } else { "" };
    hands.say(format_args!("Minimum: {least:.4} Maximum: {most:.4} Median{of}: {median:.4}\n"));
    hands.say(format_args!("Delta: {:.4}\nMean: {mean:.4} Standard deviation: {deviation:.4}\n", seen.delta()));
    Ok(Answer::Ok)
}

/// Statistics of several probes of a place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Spread {
    count: f64,
    /// The first value: sums of differences from it stay small, and so exact.
    first: f64,
    least: f64,
    most: f64,
    sum: f64,
    squares: f64,
}

impl Spread {
    fn add(&mut self, value: f64) {
        if self.count == 0.0 {
            (self.first, self.least, self.most) = (value, value, value);
        }
        self.count += 1.0;
        if value < self.least {
            self.least = value;
        }
        if value > self.most {
            self.most = value;
        }
        let part = value - self.first;
        self.sum += part;
        self.squares += part * part;
    }

    fn ends(&self) -> [f64; 2] {
        [self.least, self.most]
    }

    fn delta(&self) -> f64 {
        self.most - self.least
    }

    /// Returns the mean, and the standard deviation of the values themselves (not of the population they are
    /// drawn from).
    fn mean_and_deviation(&self) -> (f64, f64) {
        if self.count == 0.0 {
            return (0.0, 0.0);
        }
        let part = self.sum / self.count;
        let variance = self.squares / self.count - part * part;
        (self.first + part, libm::sqrt(if variance > 0.0 { variance } else { 0.0 }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn mean_and_deviation_are_the_textbooks(values in proptest::collection::vec(-50.0..50.0_f64, 1..40)) {
            let mut seen = Spread::default();
            values.iter().for_each(|value| seen.add(*value));
            let count = values.len() as f64;
            let mean = values.iter().sum::<f64>() / count;
            let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / count;
            let (found_mean, found_deviation) = seen.mean_and_deviation();
            prop_assert!((found_mean - mean).abs() < 1e-9, "{found_mean} for {mean}");
            // Near zero a root magnifies the rounding of its argument.
            prop_assert!((found_deviation * found_deviation - variance).abs() < 1e-9, "{found_deviation} for {variance}");
            let (least, most) = values.iter().fold((f64::MAX, f64::MIN), |(l, m), v| (l.min(*v), m.max(*v)));
            prop_assert_eq!(seen.delta(), most - least);
        }
    }
}

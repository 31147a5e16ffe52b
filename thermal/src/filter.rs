//! A low-pass filter of first order between a sensor and what follows it. Heat safety stands before it.

use units::{Celsius, Micros};

use crate::sensor::SensorFault;

/// State of the filter.
#[derive(Clone, Copy, Debug)]
pub struct Filter {
    /// Share of the way to the next reading that the filter goes at once, above 0 to 1.
    share: f32,
    at: Option<Celsius>,
}

impl Filter {
    /// Creates a filter with a time constant, s, for readings with this period. Behind a steady rise the
    /// filter is late by the time constant.
    pub fn new(time_constant_s: f32, period: Micros) -> Self {
        let period_s = period.seconds() as f32;
        let share = if time_constant_s > 0.0 { period_s / (time_constant_s + period_s) } else { 1.0 };
        Self { share, at: None }
    }

    /// Makes the next reading the first.
    pub const fn restart(&mut self) {
        self.at = None;
    }

    /// Takes a reading and returns the filtered one. A fault passes at once, and readings begin afresh after
    /// it.
    pub fn pass(&mut self, read: Result<Celsius, SensorFault>) -> Result<Celsius, SensorFault> {
        self.at = read.ok().map(|Celsius(read)| match self.at {
            Some(Celsius(at)) if self.share < 1.0 => Celsius(at + (read - at) * self.share),
            _ => Celsius(read),
        });
        match (read, self.at) {
            (Ok(_), Some(at)) => Ok(at),
            (read, _) => read,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PERIOD: Micros = Micros::from_millis(50);

    #[test]
    fn without_a_time_constant_readings_pass_as_they_are() {
        let mut filter = Filter::new(0.0, PERIOD);
        for celsius in [20.0, 250.0, -3.0] {
            assert_eq!(filter.pass(Ok(Celsius(celsius))), Ok(Celsius(celsius)));
        }
    }

    #[test]
    fn a_fault_passes_at_once_and_is_forgotten() {
        let mut filter = Filter::new(5.0, PERIOD);
        assert_eq!(filter.pass(Ok(Celsius(20.0))), Ok(Celsius(20.0)));
        assert_eq!(filter.pass(Err(SensorFault::SILENT)), Err(SensorFault::SILENT));
        assert_eq!(filter.pass(Ok(Celsius(90.0))), Ok(Celsius(90.0)));
    }

    proptest! {
        #[test]
        fn a_steady_rise_is_late_by_the_time_constant(constant in 0.1_f32..10.0, per_s in 0.5_f32..5.0) {
            let mut filter = Filter::new(constant, PERIOD);
            let mut late = 0.0;
            for sample in 0..(constant * 12.0 / 0.05) as u32 {
                let celsius = per_s * 0.05 * sample as f32;
                late = (celsius - filter.pass(Ok(Celsius(celsius))).unwrap().0) / per_s;
            }
            prop_assert!((late / constant - 1.0).abs() < 0.01, "{} s for {} s", late, constant);
        }

        #[test]
        fn after_the_time_constant_63_percent_of_a_jump_are_seen(constant in 1.0_f32..20.0) {
            let mut filter = Filter::new(constant, PERIOD);
            let mut seen = filter.pass(Ok(Celsius(0.0))).unwrap();
            for _ in 0..(constant / 0.05).round() as u32 {
                seen = filter.pass(Ok(Celsius(100.0))).unwrap();
            }
            prop_assert!((61.0..66.0).contains(&seen.0), "{}", seen);
        }
    }
}

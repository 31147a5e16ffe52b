//! Sensors whose output is a voltage: thermocouple amplifiers, and anything else with a curve of points.

use units::{Celsius, Volts};

use crate::thermistor::AdcCode;

/// Reference voltage of the converter on the Prime.
pub const REFERENCE: Volts = Volts(3.3);
/// Most points of a curve.
pub const MAX_POINTS: usize = 6;
/// Output of an AD8494, AD8495, AD8496 and AD8497 for each degree, V (AD849x datasheet rev. C,
/// "Specifications": gain 5 mV/C).
const AD849X_VOLTS_PER_KELVIN: f64 = 0.005;
/// Share of the range at either end in which an input is no measurement: see [`AdcCode`].
const DEAD_SHARE: f64 = 0.002;

/// Reason for a missing temperature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The input is at the upper end of the range.
    High,
    /// The input is at ground level.
    Low,
}

impl Fault {
    /// Returns the message for any sensor.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::High => "voltage at 3.3 V or above: check the sensor's plug and wires",
            Self::Low => "no voltage: check the sensor's supply and wire",
        }
    }

    /// Returns the message for a thermocouple amplifier. A thermocouple that breaks drives an AD849x to its
    /// positive end ("Thermocouple Break Detection").
    #[must_use]
    pub const fn amplifier_message(self) -> &'static str {
        match self {
            Self::High => "amplifier at its upper end: check the thermocouple and wires",
            Self::Low => "no voltage from the amplifier: check its supply and wire",
        }
    }
}

/// Reason why points make no curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveError {
    /// Fewer than two, or more than [`MAX_POINTS`].
    Count,
    /// Two points of one voltage, or one outside 0 to 3.3 V, or no numbers.
    Volts,
    /// Temperature rises in one part and falls in another: one temperature would have two voltages.
    Bends,
}

impl CurveError {
    /// Returns the message for the user.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::Count => "a curve of voltages takes two to six points, temperature,voltage each",
            Self::Volts => "the voltages must differ and lie from 0 to 3.3 V",
            Self::Bends => "temperature must rise with voltage all the way, or fall all the way",
        }
    }
}

/// Temperature over voltage: straight between the points, and on beyond the outer ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoltageCurve {
    /// Points of volts and degrees, by rising voltage.
    points: [[f64; 2]; MAX_POINTS],
    count: usize,
}

impl VoltageCurve {
    /// Creates a curve through points of (temperature C, volts), in any order.
    ///
    /// # Errors
    /// Points that make no curve.
    pub fn through(given: impl IntoIterator<Item = [f64; 2]>) -> Result<Self, CurveError> {
        let mut curve = Self { points: [[0.0; 2]; MAX_POINTS], count: 0 };
        for [celsius, volts] in given {
            let place = curve.points.get_mut(curve.count).ok_or(CurveError::Count)?;
            if !(celsius.is_finite() && (0.0..=f64::from(REFERENCE.0)).contains(&volts)) {
                return Err(CurveError::Volts);
            }
            *place = [volts, celsius];
            curve.count += 1;
        }
        let points = curve.points.get_mut(..curve.count).ok_or(CurveError::Count)?;
        units::sort_short(points, |one, other| one[0].total_cmp(&other[0]));
        curve.check()
    }

    fn check(self) -> Result<Self, CurveError> {
        let (mut rises, mut falls) = (false, false);
        for [[volts, celsius], [next_volts, next_celsius]] in self.pairs() {
            if next_volts - volts < 1e-6 {
                return Err(CurveError::Volts);
            }
            rises |= next_celsius >= celsius;
            falls |= next_celsius <= celsius;
        }
        match (rises, falls) {
            (false, false) => Err(CurveError::Count),
            (true, true) => Err(CurveError::Bends),
            _ => Ok(self),
        }
    }

    /// Creates the curve of an AD849x with this output at 0 C, the voltage of its REF pin.
    #[must_use]
    pub fn ad849x(offset: Volts) -> Self {
        let mut points = [[0.0; 2]; MAX_POINTS];
        let zero = f64::from(offset.0);
        points[0] = [zero, 0.0];
        points[1] = [zero + AD849X_VOLTS_PER_KELVIN * 100.0, 100.0];
        Self { points, count: 2 }
    }

    /// Iterates over pairs of neighbouring points.
    fn pairs(&self) -> impl DoubleEndedIterator<Item = [[f64; 2]; 2]> + '_ {
        let points = self.points.get(..self.count).unwrap_or_default();
        points.windows(2).filter_map(|pair| <[[f64; 2]; 2]>::try_from(pair).ok())
    }

    /// Returns the temperature at a reading.
    ///
    /// # Errors
    /// An input at an end of its range.
    pub fn celsius(&self, code: AdcCode) -> Result<Celsius, Fault> {
        let ratio = code.ratio();
        if ratio <= DEAD_SHARE {
            return Err(Fault::Low);
        }
        if ratio >= 1.0 - DEAD_SHARE {
            return Err(Fault::High);
        }
        let volts = ratio * f64::from(REFERENCE.0);
        let piece = self.pairs().find(|[_, [end, _]]| volts <= *end).or_else(|| self.pairs().next_back());
        let Some([[low, cold], [high, hot]]) = piece else { return Err(Fault::Low) };
        Ok(Celsius((cold + (hot - cold) * (volts - low) / (high - low)) as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn code(volts: f64) -> AdcCode {
        AdcCode((volts / 3.3 * 65_535.0).round() as u16)
    }

    #[test]
    fn an_amplifier_gives_five_millivolts_a_degree_from_its_offset() {
        for (offset, volts, celsius) in [(0.0, 0.125, 25.0), (1.25, 2.5, 250.0), (1.25, 1.2, -10.0), (0.0, 1.5, 300.0)]
        {
            let reads = VoltageCurve::ad849x(Volts(offset)).celsius(code(volts)).unwrap().0;
            assert!((reads - celsius).abs() < 0.02, "{reads} C, not {celsius}");
        }
    }

    #[test]
    fn both_ends_are_faults() {
        let curve = VoltageCurve::ad849x(Volts(0.0));
        assert_eq!(curve.celsius(AdcCode(0)), Err(Fault::Low));
        assert_eq!(curve.celsius(code(0.006)), Err(Fault::Low));
        assert!(curve.celsius(code(0.007)).is_ok());
        assert_eq!(curve.celsius(AdcCode::FULL_SCALE), Err(Fault::High));
        assert_eq!(curve.celsius(code(3.295)), Err(Fault::High));
        assert!(Fault::High.message() != Fault::High.amplifier_message());
    }

    #[test]
    fn points_that_make_no_curve_are_refused() {
        let refused = |points: &[[f64; 2]]| VoltageCurve::through(points.iter().copied()).unwrap_err();
        assert_eq!(refused(&[]), CurveError::Count);
        assert_eq!(refused(&[[20.0, 1.0]]), CurveError::Count);
        assert_eq!(refused(&[[20.0, 1.0]; 7]), CurveError::Count);
        assert_eq!(refused(&[[20.0, 1.0], [30.0, 1.0]]), CurveError::Volts);
        assert_eq!(refused(&[[20.0, 1.0], [30.0, 3.4]]), CurveError::Volts);
        assert_eq!(refused(&[[20.0, 1.0], [f64::NAN, 2.0]]), CurveError::Volts);
        assert_eq!(refused(&[[20.0, 1.0], [20.0, 2.0]]), CurveError::Bends);
        assert_eq!(refused(&[[20.0, 1.0], [90.0, 2.0], [50.0, 3.0]]), CurveError::Bends);
    }

    proptest! {
        #[test]
        fn every_point_is_met_in_whatever_order(
            steps in prop::collection::vec((0.1_f64..0.5, 1.0_f64..200.0), 2..=MAX_POINTS), falls: bool, turn in 0_usize..6,
        ) {
            let sign = if falls { -1.0 } else { 1.0 };
            let (mut volts, mut celsius, mut points) = (0.05, 0.0, Vec::new());
            for (more_volts, more_celsius) in steps {
                (volts, celsius) = (volts + more_volts, celsius + sign * more_celsius);
                points.push([celsius, volts]);
            }
            let turn = turn % points.len();
            points.rotate_left(turn);
            let curve = VoltageCurve::through(points.iter().copied()).unwrap();
            for [celsius, volts] in points {
                let reads = f64::from(curve.celsius(code(volts)).unwrap().0);
                // Half a count on the steepest piece of 200 C in 0.1 V.
                prop_assert!((reads - celsius).abs() < 0.06, "{} for {}", reads, celsius);
            }
        }
    }
}

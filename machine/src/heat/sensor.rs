//! Raw sensor readings to degrees Celsius.
//!
//! Thermistor divider: pull-up R2 to the reference, thermistor (with R1 in parallel if fitted) to ground, so
//! r = R2 / (full / counts - 1). Steinhart-Hart: 1/T = c1 + c2 ln r + c3 (ln r)^3. Beta: 1/T = 1/T0 + ln(r/R0)/beta.
//! (J. S. Steinhart and S. R. Hart, Deep-Sea Research 15, 1968.)

use units::{Celsius, Ohms};

use crate::ports::SensorReading;

/// 0 degrees Celsius in kelvin.
const ZERO_CELSIUS_K: f64 = 273.15;
/// Full scale of [`SensorReading::Counts`].
const FULL_SCALE: f64 = 65_535.0;
/// A thermistor this many times its nominal resistance is taken for an open circuit.
const OPEN_CIRCUIT: f64 = 8.0;

/// How resistance follows temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Curve {
    /// Steinhart-Hart coefficients.
    SteinhartHart([f64; 3]),
    /// Beta in kelvin.
    Beta(f64),
}

/// A thermistor in its divider.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermistor {
    /// Its curve.
    pub curve: Curve,
    /// Nominal resistance.
    pub r0: Ohms,
    /// Temperature at which `r0` holds.
    pub t0: Celsius,
    /// Resistor in parallel; 0 when none is fitted.
    pub r1_parallel: Ohms,
    /// Pull-up.
    pub r2_pull_up: Ohms,
}

impl Thermistor {
    /// Resistance at a reading; `None` when open or shorted.
    #[must_use]
    pub fn resistance(&self, counts: u16) -> Option<f64> {
        if counts == 0 || counts == u16::MAX {
            return None;
        }
        let parallel = f64::from(self.r2_pull_up.0) / (FULL_SCALE / f64::from(counts) - 1.0);
        let r1 = f64::from(self.r1_parallel.0);
        let resistance = if r1 > 0.0 { r1 * parallel / (r1 - parallel) } else { parallel };
        (resistance > 0.0 && resistance <= OPEN_CIRCUIT * f64::from(self.r0.0)).then_some(resistance)
    }

    /// Temperature at a reading; `None` when open or shorted.
    #[must_use]
    pub fn celsius(&self, counts: u16) -> Option<Celsius> {
        let resistance = self.resistance(counts)?;
        let inverse_kelvin = match self.curve {
            Curve::SteinhartHart([c1, c2, c3]) => {
                let ln_r = libm::log(resistance);
                c1 + c2 * ln_r + c3 * ln_r * ln_r * ln_r
            }
            Curve::Beta(beta) => {
                1.0 / (f64::from(self.t0.0) + ZERO_CELSIUS_K) + libm::log(resistance / f64::from(self.r0.0)) / beta
            }
        };
        let celsius = 1.0 / inverse_kelvin - ZERO_CELSIUS_K;
        celsius.is_finite().then_some(Celsius(celsius as f32))
    }
}

/// A temperature sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sensor {
    /// On an analog input.
    Thermistor(Thermistor),
    /// A thermocouple converter that reports degrees.
    Max31855,
}

impl Sensor {
    /// Temperature; `None` when the sensor gives none, or gives the kind of reading another sensor would.
    #[must_use]
    pub fn celsius(&self, raw: SensorReading) -> Option<Celsius> {
        match (self, raw) {
            (Self::Thermistor(thermistor), SensorReading::Counts(counts)) => thermistor.celsius(counts),
            (Self::Max31855, SensorReading::QuarterDegrees(quarters)) => Some(Celsius(f32::from(quarters) * 0.25)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EPCOS: Thermistor = Thermistor {
        curve: Curve::Beta(4_066.0),
        r0: Ohms(100_000.0),
        t0: Celsius(25.0),
        r1_parallel: Ohms(0.0),
        r2_pull_up: Ohms(4_700.0),
    };

    fn counts_at(resistance: f64) -> u16 {
        (FULL_SCALE * resistance / (resistance + 4_700.0)).round() as u16
    }

    #[test]
    fn nominal_resistance_is_nominal_temperature() {
        let celsius = EPCOS.celsius(counts_at(100_000.0)).unwrap();
        assert!((celsius.0 - 25.0).abs() < 0.05, "{celsius}");
    }

    #[test]
    fn published_steinhart_hart_coefficients_agree_with_the_beta_curve_when_cold() {
        let table = [7.223_783_003_193_46e-4, 2.163_018_520_545_78e-4, 9.264_102_563_570_2e-8];
        let precise = Thermistor { curve: Curve::SteinhartHart(table), ..EPCOS };
        let celsius = precise.celsius(counts_at(100_000.0)).unwrap();
        assert!((celsius.0 - 25.0).abs() < 1.0, "{celsius}");
    }

    #[test]
    fn open_and_shorted_thermistors_have_no_temperature() {
        for counts in [0, u16::MAX, counts_at(900_000.0)] {
            assert_eq!(EPCOS.celsius(counts), None, "{counts} counts");
        }
        assert_eq!(Sensor::Thermistor(EPCOS).celsius(SensorReading::Missing), None);
        assert_eq!(Sensor::Max31855.celsius(SensorReading::Fault), None);
        assert_eq!(Sensor::Max31855.celsius(SensorReading::QuarterDegrees(-6)), Some(Celsius(-1.5)));
    }

    #[test]
    fn a_parallel_resistor_is_taken_out() {
        let with_parallel = Thermistor { r1_parallel: Ohms(4_700.0), ..EPCOS };
        let both = 1.0 / (1.0 / 20_000.0 + 1.0 / 4_700.0);
        let resistance = with_parallel.resistance(counts_at(both)).unwrap();
        assert!((resistance - 20_000.0).abs() < 30.0, "{resistance}");
    }
}

//! Raw sensor readings to degrees Celsius. The law of thermistors, with its dead band and what counts as open
//! or shorted, is that of `drivers`; here is how the configuration describes one.

use config::{SensorConfig, SensorKind, ThermistorConfig};
use drivers::thermistor::{AdcCode, BuiltIn, Curve, CurveError, Divider, Law, Thermistor};
use units::{Celsius, Ohms};

use crate::ports::SensorReading;

/// A temperature sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sensor {
    /// On an analog input.
    Thermistor(Thermistor),
    /// A thermocouple converter that reports degrees.
    Max31855,
    /// A thermistor whose description makes none: it gives no temperature, so nothing heats by it.
    Unusable(CurveError),
}

impl Sensor {
    /// Temperature; `None` when the sensor gives none, or gives the kind of reading another sensor would.
    #[must_use]
    pub fn celsius(&self, raw: SensorReading) -> Option<Celsius> {
        match (self, raw) {
            (Self::Thermistor(thermistor), SensorReading::Counts(counts)) => {
                // Coefficients that fit no thermistor have a pole somewhere; what stands there is no reading.
                thermistor.celsius(AdcCode(counts)).ok().filter(|celsius| celsius.0.is_finite())
            }
            (Self::Max31855, SensorReading::QuarterDegrees(quarters)) => Some(Celsius(f32::from(quarters) * 0.25)),
            _ => None,
        }
    }

    /// What is wrong with its description, in words.
    #[must_use]
    pub const fn flaw(&self) -> Option<&'static str> {
        match self {
            Self::Unusable(error) => Some(error.message()),
            _ => None,
        }
    }
}

impl From<&SensorConfig> for Sensor {
    fn from(config: &SensorConfig) -> Self {
        match config.kind {
            SensorKind::Thermistor => thermistor(&config.thermistor).map_or_else(Self::Unusable, Self::Thermistor),
            SensorKind::Max31855 => Self::Max31855,
        }
    }
}

/// The thermistor that is described. The strongest rule given wins: three points, coefficients, a table
/// entry, beta.
fn thermistor(config: &ThermistorConfig) -> Result<Thermistor, CurveError> {
    let entry = config.table.and_then(|name| BuiltIn::named(name, config.use_beta_table));
    let beta = |kelvin: f64| Curve::from_beta(config.r0, config.t0, kelvin);
    let curve = match (config.rt_curve, config.coefficients, entry.map(|entry| entry.law)) {
        (Some(points), _, _) => Curve::from_points(points.map(|(c, ohms)| (Celsius(c as f32), Ohms(ohms as f32)))),
        (None, Some(coefficients), _) | (None, None, Some(Law::SteinhartHart(coefficients))) => {
            Curve::from_coefficients(coefficients)
        }
        (None, None, Some(Law::Beta(kelvin))) => beta(kelvin),
        (None, None, None) => beta(config.beta_k),
    }?;
    let parallel = (config.r1.0 > 0.0).then_some(config.r1);
    Ok(Thermistor::new(curve, Divider { pull_up: config.r2, parallel }, config.r0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const EPCOS: ThermistorConfig = ThermistorConfig {
        input: None,
        table: None,
        use_beta_table: false,
        beta_k: 4_066.0,
        r0: Ohms(100_000.0),
        t0: Celsius(25.0),
        r1: Ohms(0.0),
        r2: Ohms(4_700.0),
        coefficients: None,
        rt_curve: None,
    };

    fn sensor(thermistor: ThermistorConfig) -> Sensor {
        Sensor::from(&SensorConfig { thermistor, ..SensorConfig::default() })
    }

    /// Counts of a resistance from the input to ground, behind a pull-up of 4.7 kOhm.
    fn counts_at(ohms: f64) -> SensorReading {
        SensorReading::Counts((65_535.0 * ohms / (ohms + 4_700.0)).round() as u16)
    }

    #[test]
    fn nominal_resistance_is_nominal_temperature() {
        let celsius = sensor(EPCOS).celsius(counts_at(100_000.0)).unwrap();
        assert!((celsius.0 - 25.0).abs() < 0.05, "{celsius}");
        let elsewhere = ThermistorConfig { t0: Celsius(40.0), ..EPCOS };
        let celsius = sensor(elsewhere).celsius(counts_at(100_000.0)).unwrap();
        assert!((celsius.0 - 40.0).abs() < 0.05, "{celsius}");
    }

    #[test]
    fn published_steinhart_hart_coefficients_agree_with_the_beta_curve_when_cold() {
        let coefficients = Some([7.223_783_003_193_46e-4, 2.163_018_520_545_78e-4, 9.264_102_563_570_2e-8]);
        let celsius = sensor(ThermistorConfig { coefficients, ..EPCOS }).celsius(counts_at(100_000.0)).unwrap();
        assert!((celsius.0 - 25.0).abs() < 1.0, "{celsius}");
    }

    #[test]
    fn the_strongest_description_wins() {
        let points = [(25.0, 100_000.0), (150.0, 1_641.9), (250.0, 226.15)];
        let coefficients = Some([8.112_901_601_454_59e-4, 2.113_557_891_442_65e-4, 7.176_147_304_638_48e-8]);
        let at = |thermistor: ThermistorConfig, ohms| sensor(thermistor).celsius(counts_at(ohms)).unwrap().0;
        let with_beta = at(EPCOS, 226.15);
        let by_name = ThermistorConfig { table: Some("Semitec"), ..EPCOS };
        let by_beta_of_name = ThermistorConfig { use_beta_table: true, ..by_name };
        let by_coefficients = ThermistorConfig { coefficients, ..by_beta_of_name };
        let by_points = ThermistorConfig { rt_curve: Some(points), ..by_coefficients };
        assert!((at(by_points, 226.15) - 250.0).abs() < 0.3, "{}", at(by_points, 226.15));
        assert_eq!(at(by_coefficients, 226.15), at(by_name, 226.15));
        let of_name = at(by_beta_of_name, 226.15);
        let with_its_beta = at(ThermistorConfig { beta_k: 4_267.0, ..EPCOS }, 226.15);
        assert!(of_name == with_its_beta && of_name != with_beta, "{of_name}");
    }

    #[test]
    fn open_and_shorted_thermistors_have_no_temperature() {
        let epcos = sensor(EPCOS);
        // The ends of the converter's range, as far as its offset and gain error reach; and eight times the
        // nominal resistance.
        for counts in [0, 1, 131, u16::MAX - 131, u16::MAX - 1, u16::MAX] {
            assert_eq!(epcos.celsius(SensorReading::Counts(counts)), None, "{counts} counts");
        }
        assert_eq!(epcos.celsius(counts_at(900_000.0)), None);
        for counts in [132, 400] {
            assert!(epcos.celsius(SensorReading::Counts(counts)).unwrap().0 > 300.0, "{counts} counts");
        }
        // Cold is not open.
        assert!(epcos.celsius(counts_at(700_000.0)).unwrap().0 < 0.0);
    }

    #[test]
    fn a_reading_of_another_kind_is_none() {
        assert_eq!(sensor(EPCOS).celsius(SensorReading::Missing), None);
        assert_eq!(sensor(EPCOS).celsius(SensorReading::QuarterDegrees(100)), None);
        assert_eq!(Sensor::Max31855.celsius(SensorReading::Fault), None);
        assert_eq!(Sensor::Max31855.celsius(SensorReading::QuarterDegrees(-6)), Some(Celsius(-1.5)));
    }

    #[test]
    fn a_parallel_resistor_is_taken_out() {
        let both = 1.0 / (1.0 / 20_000.0 + 1.0 / 4_700.0);
        let alone = sensor(EPCOS).celsius(counts_at(20_000.0)).unwrap();
        let with_parallel = ThermistorConfig { r1: Ohms(4_700.0), ..EPCOS };
        let celsius = sensor(with_parallel).celsius(counts_at(both)).unwrap();
        assert!((celsius.0 - alone.0).abs() < 0.05, "{celsius} for {alone}");
    }

    #[test]
    fn a_description_that_makes_no_thermistor_reads_nothing_and_says_why() {
        let rising = Some([(0.0, 100.0), (50.0, 119.0), (100.0, 138.5)]);
        for flawed in [
            ThermistorConfig { rt_curve: rising, ..EPCOS },
            ThermistorConfig { coefficients: Some([7e-4, -2e-4, 1e-7]), ..EPCOS },
            ThermistorConfig { beta_k: 0.0, ..EPCOS },
        ] {
            let sensor = sensor(flawed);
            assert!(sensor.flaw().is_some(), "{flawed:?}");
            assert_eq!(sensor.celsius(counts_at(100_000.0)), None);
        }
        assert_eq!(sensor(EPCOS).flaw(), None);
    }
}

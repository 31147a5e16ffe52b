//! Conversion of raw sensor readings to degrees Celsius. The laws of sensors, with their dead bands and their
//! limits of open and shorted, are those of `drivers`; here they are built from the configuration.

use config::{HeaterId, SensorConfig, SensorKind, ThermistorConfig};
use drivers::platinum::{Platinum, PlatinumInput};
use drivers::thermistor::{AdcCode, BuiltIn, Curve, CurveError, Divider, Law, Thermistor};
use drivers::voltage_sensor::VoltageCurve;
use units::{Celsius, Ohms};

use crate::combined::{Parts, Rule};
use crate::io::SensorReading;

/// Reason why a sensor gives no temperature, in words that say what to check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorFault {
    words: &'static str,
    part: Option<HeaterId>,
}

impl SensorFault {
    /// Fault of a sensor that has not been read, or not for too long.
    pub const SILENT: Self = Self::new("the sensor has not been read");
    /// Fault of a reading that makes no temperature.
    const NO_TEMPERATURE: Self = Self::new("the reading makes no temperature: check its description");

    const fn new(words: &'static str) -> Self {
        Self { words, part: None }
    }

    /// Returns the fault in words.
    #[must_use]
    pub const fn message(self) -> &'static str {
        self.words
    }

    /// Returns the faulty part of a combined sensor.
    #[must_use]
    pub const fn part(self) -> Option<HeaterId> {
        self.part
    }

    /// Returns the fault for a combined sensor, caused by this part or by a part of that.
    pub(super) const fn of_part(self, part: HeaterId) -> Self {
        Self { part: if self.part.is_some() { self.part } else { Some(part) }, ..self }
    }
}

/// Law of a temperature sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sensor {
    /// Thermistor on an analog input.
    Thermistor(Thermistor),
    /// Platinum sensor on an analog input.
    Platinum(PlatinumInput),
    /// A thermocouple amplifier on an analog input.
    Amplifier(VoltageCurve),
    /// Any other sensor that gives a voltage.
    Voltage(VoltageCurve),
    /// Sensor that reports degrees: a converter chip, or the microcontroller's own sensor.
    Degrees,
    /// Combination of other sensors: see [`crate::combined::read`].
    Combined(Rule, Parts),
    /// Sensor whose description makes none, and the reason: it gives no temperature, so nothing heats by it.
    Unusable(&'static str),
}

impl Sensor {
    /// Returns the temperature for a raw reading.
    ///
    /// # Errors
    /// The reason if there is no temperature; also for the kind of reading that another sensor would give.
    pub fn celsius(&self, raw: SensorReading) -> Result<Celsius, SensorFault> {
        let fault = SensorFault::new;
        let celsius = match (self, raw) {
            (Self::Unusable(words), _) => Err(fault(words)),
            (Self::Combined(..), _) => Err(SensorFault::NO_TEMPERATURE),
            (_, SensorReading::Missing) => Err(SensorFault::SILENT),
            (_, SensorReading::Fault(words)) => Err(fault(words)),
            (Self::Thermistor(thermistor), SensorReading::Counts(counts)) => {
                thermistor.celsius(AdcCode(counts)).map_err(|flaw| fault(flaw.message()))
            }
            (Self::Platinum(platinum), SensorReading::Counts(counts)) => {
                platinum.celsius(AdcCode(counts)).map_err(|flaw| fault(flaw.message()))
            }
            (Self::Amplifier(curve), SensorReading::Counts(counts)) => {
                curve.celsius(AdcCode(counts)).map_err(|flaw| fault(flaw.amplifier_message()))
            }
            (Self::Voltage(curve), SensorReading::Counts(counts)) => {
                curve.celsius(AdcCode(counts)).map_err(|flaw| fault(flaw.message()))
            }
            (Self::Degrees, SensorReading::MilliDegrees(thousandths)) => Ok(Celsius(thousandths as f32 / 1e3)),
            _ => Err(SensorFault::NO_TEMPERATURE),
        }?;
        // Coefficients that fit no thermistor have a pole somewhere; a value near the pole is no reading.
        if celsius.0.is_finite() { Ok(celsius) } else { Err(SensorFault::NO_TEMPERATURE) }
    }

    /// Returns the fault of the sensor's description, in words.
    #[must_use]
    pub const fn flaw(&self) -> Option<&'static str> {
        match self {
            Self::Unusable(words) => Some(words),
            _ => None,
        }
    }
}

impl From<&SensorConfig> for Sensor {
    fn from(config: &SensorConfig) -> Self {
        if let Some(rule) = Rule::of(config.kind) {
            return Self::Combined(rule, config.parts);
        }
        match config.kind {
            SensorKind::Thermistor => {
                thermistor(&config.thermistor).map_or_else(|flaw| Self::Unusable(flaw.message()), Self::Thermistor)
            }
            SensorKind::Pt100 => platinum(Platinum::PT100, &config.thermistor),
            SensorKind::Pt1000 => platinum(Platinum::PT1000, &config.thermistor),
            SensorKind::Ad849x => Self::Amplifier(VoltageCurve::ad849x(config.amplifier_offset)),
            SensorKind::Voltage => VoltageCurve::through(config.voltage_points.into_iter().flatten())
                .map_or_else(|flaw| Self::Unusable(flaw.message()), Self::Voltage),
            // All remaining kinds report degrees.
            _ => Self::Degrees,
        }
    }
}

fn divider(config: &ThermistorConfig) -> Divider {
    Divider { pull_up: config.r2, parallel: (config.r1.0 > 0.0).then_some(config.r1) }
}

fn platinum(platinum: Platinum, config: &ThermistorConfig) -> Sensor {
    Sensor::Platinum(PlatinumInput { platinum, divider: divider(config) })
}

/// Returns the thermistor that is described. The strongest rule given wins: three points, coefficients, a
/// table entry, beta.
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
    Ok(Thermistor::new(curve, divider(config), config.r0))
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
    fn a_name_with_a_beta_brings_what_is_not_written_beside_it() {
        let described = |lines: &str| {
            let text = format!("[temperature control]\nt.enable = true\nt.thermistor_pin = ADC1_1\n{lines}");
            config::parse(text.as_bytes(), config::BoardId::default(), &mut ()).0.temperatures[0].sensor
        };
        let built_in = Thermistor::built_in("RRRF10K").unwrap();
        assert_eq!(Sensor::from(&described("t.thermistor = RRRF10K\n")), Sensor::Thermistor(built_in));
        let own = "t.thermistor = RRRF10K\nt.r0 = 12000\nt.r1 = 0\nt.r2 = 4700\nt.beta = 3900\n";
        let written = ThermistorConfig { beta_k: 3_900.0, r0: Ohms(12_000.0), ..EPCOS };
        assert_eq!(Sensor::from(&described(own)), sensor(written));
        let semitec = "t.thermistor = Semitec\nt.use_beta_table = true\nt.beta = 4200\n";
        assert_eq!(Sensor::from(&described(semitec)), sensor(ThermistorConfig { beta_k: 4_200.0, ..EPCOS }));
    }

    #[test]
    fn open_and_shorted_thermistors_have_no_temperature() {
        let epcos = sensor(EPCOS);
        // The ends of the converter's range, as far as its offset and gain error reach; and eight times the
        // nominal resistance.
        for counts in [0, 1, 131, u16::MAX - 131, u16::MAX - 1, u16::MAX] {
            assert_eq!(epcos.celsius(SensorReading::Counts(counts)).ok(), None, "{counts} counts");
        }
        assert_eq!(
            epcos.celsius(counts_at(900_000.0)).map_err(SensorFault::message),
            Err(drivers::thermistor::Fault::Open.message())
        );
        for counts in [132, 400] {
            assert!(epcos.celsius(SensorReading::Counts(counts)).unwrap().0 > 300.0, "{counts} counts");
        }
        // A cold sensor must not read as open.
        assert!(epcos.celsius(counts_at(700_000.0)).unwrap().0 < 0.0);
    }

    #[test]
    fn a_reading_of_another_kind_is_none() {
        assert_eq!(sensor(EPCOS).celsius(SensorReading::Missing), Err(SensorFault::SILENT));
        assert_eq!(sensor(EPCOS).celsius(SensorReading::MilliDegrees(25_000)), Err(SensorFault::NO_TEMPERATURE));
        let words = Sensor::Degrees.celsius(SensorReading::Fault("open")).map_err(SensorFault::message);
        assert_eq!(words, Err("open"));
        assert_eq!(Sensor::Degrees.celsius(SensorReading::MilliDegrees(-1_500)), Ok(Celsius(-1.5)));
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
            assert_eq!(sensor.celsius(counts_at(100_000.0)).map_err(SensorFault::message).err(), sensor.flaw());
        }
        assert_eq!(sensor(EPCOS).flaw(), None);
    }

    /// Counts of a voltage at the input.
    fn counts_of(volts: f64) -> SensorReading {
        SensorReading::Counts((65_535.0 * volts / 3.3).round() as u16)
    }

    #[test]
    fn platinum_reads_what_the_standard_says_and_faults_name_it() {
        for (kind, ohms) in [(SensorKind::Pt1000, 1_758.6), (SensorKind::Pt100, 175.86)] {
            let platinum = Sensor::from(&SensorConfig { kind, thermistor: EPCOS, ..SensorConfig::default() });
            let celsius = platinum.celsius(counts_at(ohms)).unwrap();
            assert!((celsius.0 - 200.0).abs() < 0.15, "{celsius}");
            for counts in [0, u16::MAX] {
                let fault = platinum.celsius(SensorReading::Counts(counts)).unwrap_err();
                assert!(fault.message().starts_with("platinum sensor"), "{}", fault.message());
            }
        }
    }

    #[test]
    fn voltages_read_by_their_offset_or_their_points() {
        let config = SensorConfig { amplifier_offset: units::Volts(1.25), ..SensorConfig::default() };
        let amplifier = Sensor::from(&SensorConfig { kind: SensorKind::Ad849x, ..config });
        assert!((amplifier.celsius(counts_of(2.25)).unwrap().0 - 200.0).abs() < 0.02);
        let mut points = [None; config::MAX_VOLTAGE_POINTS];
        let voltage = |points| {
            let mut described = config;
            (described.kind, described.voltage_points) = (SensorKind::Voltage, points);
            Sensor::from(&described)
        };
        assert!(voltage(points).flaw().is_some() && voltage(points).celsius(counts_of(1.0)).is_err());
        (points[0], points[1], points[2]) = (Some([0.0, 3.0]), Some([100.0, 2.0]), Some([300.0, 1.0]));
        assert!((voltage(points).celsius(counts_of(1.5)).unwrap().0 - 200.0).abs() < 0.02);
        let words = |sensor: Sensor| sensor.celsius(SensorReading::Counts(u16::MAX)).unwrap_err().message();
        assert!(words(amplifier).contains("thermocouple") && words(voltage(points)).contains("3.3 V"));
    }
}

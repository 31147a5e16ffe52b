//! Thermistors (NTC) behind a divider: converter counts to degrees Celsius, and back for tests and
//! simulators.
//!
//! Divider on the Prime: 4.7 kOhm from 3.3 V to the input, the thermistor from the input to ground, a unity
//! buffer behind it, so r = pull-up / (full / counts - 1). The converter's reference is the divider's supply;
//! its voltage cancels.

mod built_in;
mod curve;

pub use built_in::{BUILT_IN, BuiltIn, Law};
pub use curve::{Curve, CurveError};

use units::{Celsius, Ohms};

/// A reading of the 16-bit converter (RM0399, ADC data register, right-aligned).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct AdcCode(pub u16);

impl AdcCode {
    /// Code at the reference voltage.
    pub const FULL_SCALE: Self = Self(u16::MAX);
    /// Codes this close to an end of the range are no thermistor: 0.2 % of full scale is the converter's
    /// offset and gain error together with the buffer's.
    const DEAD_BAND: u16 = 131;

    /// Returns the share of the reference voltage, 0 to 1.
    #[must_use]
    pub fn ratio(self) -> f64 {
        f64::from(self.0) / f64::from(Self::FULL_SCALE.0)
    }
}

/// Reason for a missing temperature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The input is at the supply, or the resistance is beyond what the sensor has at any sane temperature: a
    /// broken wire or nothing plugged in.
    Open,
    /// The input is at ground level.
    Shorted,
}

impl Fault {
    /// Returns the message for the user.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::Open => "thermistor open: check its plug and wires",
            Self::Shorted => "thermistor shorted: check for bare or crushed wires",
        }
    }
}

/// The resistors around a thermistor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Divider {
    /// Resistor from the reference to the input.
    pub pull_up: Ohms,
    /// Resistor in parallel with the thermistor, if fitted.
    pub parallel: Option<Ohms>,
}

impl Divider {
    /// Divider of the Prime's inputs T1 to T3.
    pub const PRIME: Self = Self { pull_up: Ohms(4_700.0), parallel: None };

    /// Returns the thermistor's resistance at a reading.
    ///
    /// # Errors
    /// Readings at the ends of the range, and those only a thermistor of infinite resistance explains.
    pub fn ohms(&self, code: AdcCode) -> Result<Ohms, Fault> {
        if code.0 <= AdcCode::DEAD_BAND {
            return Err(Fault::Shorted);
        }
        if code.0 >= AdcCode::FULL_SCALE.0 - AdcCode::DEAD_BAND {
            return Err(Fault::Open);
        }
        let ratio = code.ratio();
        let below = f64::from(self.pull_up.0) * ratio / (1.0 - ratio);
        let ohms = match self.parallel {
            Some(parallel) => f64::from(parallel.0) * below / (f64::from(parallel.0) - below),
            None => below,
        };
        if ohms > 0.0 && ohms.is_finite() { Ok(Ohms(ohms as f32)) } else { Err(Fault::Open) }
    }

    /// Returns the reading of a resistance.
    #[must_use]
    pub fn code(&self, thermistor: Ohms) -> AdcCode {
        let ohms = f64::from(thermistor.0);
        let below = match self.parallel {
            Some(parallel) => ohms * f64::from(parallel.0) / (ohms + f64::from(parallel.0)),
            None => ohms,
        };
        let ratio = below / (below + f64::from(self.pull_up.0));
        AdcCode(libm::round(ratio * f64::from(AdcCode::FULL_SCALE.0)) as u16)
    }
}

/// A thermistor in its divider.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermistor {
    /// Curve of resistance over temperature.
    pub curve: Curve,
    /// Divider that contains the thermistor.
    pub divider: Divider,
    /// Resistance above which the circuit is open. Smoothieware's rule: eight times the nominal resistance,
    /// which a 100 k sensor has near -15 C.
    pub open_above: Ohms,
}

impl Thermistor {
    /// Creates a thermistor of nominal resistance `r0` (at 25 C).
    #[must_use]
    pub fn new(curve: Curve, divider: Divider, r0: Ohms) -> Self {
        Self { curve, divider, open_above: r0 * 8.0 }
    }

    /// Returns the built-in sensor of this name, ignoring case.
    #[must_use]
    pub fn built_in(name: &str) -> Option<Self> {
        BUILT_IN.iter().find(|entry| entry.name.eq_ignore_ascii_case(name)).map(BuiltIn::thermistor)
    }

    /// Returns the temperature at a reading.
    ///
    /// # Errors
    /// Open or shorted wires.
    pub fn celsius(&self, code: AdcCode) -> Result<Celsius, Fault> {
        let ohms = self.divider.ohms(code)?;
        if ohms > self.open_above {
            return Err(Fault::Open);
        }
        Ok(self.curve.celsius(ohms))
    }

    /// Returns the reading at a temperature.
    #[must_use]
    pub fn code(&self, celsius: Celsius) -> AdcCode {
        self.divider.code(self.curve.ohms(celsius))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const EVERY: core::ops::Range<usize> = 0..BUILT_IN.len();

    proptest! {
        #[test]
        fn a_temperature_survives_divider_and_converter(index in EVERY, celsius in 0.0_f32..280.0) {
            let thermistor = BUILT_IN[index].thermistor();
            let code = thermistor.code(Celsius(celsius));
            let back = thermistor.celsius(code).unwrap();
            // The tolerance is half a count either way, as degrees.
            let next = thermistor.celsius(AdcCode(code.0 + 1)).map_or(10.0, |c| (back.0 - c.0).abs());
            prop_assert!((back.0 - celsius).abs() <= 0.6 * next + 0.01, "{} for {}", back, celsius);
        }

        #[test]
        fn a_higher_reading_is_never_hotter(index in EVERY, first: u16, second: u16) {
            let thermistor = BUILT_IN[index].thermistor();
            let (low, high) = (first.min(second), first.max(second));
            if let (Ok(hot), Ok(cold)) = (thermistor.celsius(AdcCode(low)), thermistor.celsius(AdcCode(high))) {
                prop_assert!(hot >= cold);
            }
        }

        #[test]
        fn every_code_gives_a_finite_temperature_or_a_fault(index in EVERY, code: u16) {
            let thermistor = BUILT_IN[index].thermistor();
            match thermistor.celsius(AdcCode(code)) {
                Ok(celsius) => prop_assert!(celsius.0.is_finite() && celsius.0 > -273.15),
                // A working sensor at room temperature or above is never called open.
                Err(Fault::Open) => prop_assert!(AdcCode(code) > thermistor.code(Celsius(25.0))),
                Err(Fault::Shorted) => prop_assert!(code < 200),
            }
        }
    }

    #[test]
    fn ends_of_the_range_are_faults() {
        let thermistor = Thermistor::built_in("Honeywell100K").unwrap();
        assert_eq!(thermistor.celsius(AdcCode(0)), Err(Fault::Shorted));
        assert_eq!(thermistor.celsius(AdcCode::FULL_SCALE), Err(Fault::Open));
        assert_eq!(thermistor.celsius(thermistor.divider.code(Ohms(900_000.0))), Err(Fault::Open));
    }

    #[test]
    fn room_temperature_halves_a_divider_of_equal_resistors() {
        let curve = Curve::from_beta(Ohms(4_700.0), Celsius(25.0), 3_950.0).unwrap();
        let thermistor = Thermistor::new(curve, Divider::PRIME, Ohms(4_700.0));
        let celsius = thermistor.celsius(AdcCode(u16::MAX / 2)).unwrap();
        assert!((celsius.0 - 25.0).abs() < 0.01, "{celsius}");
    }

    #[test]
    fn a_parallel_resistor_is_taken_out() {
        let divider = Divider { pull_up: Ohms(1_600.0), parallel: Some(Ohms(680.0)) };
        for ohms in [50.0, 680.0, 10_000.0] {
            let back = divider.ohms(divider.code(Ohms(ohms))).unwrap();
            assert!((back.0 / ohms - 1.0).abs() < 0.01, "{back} for {ohms}");
        }
    }
}

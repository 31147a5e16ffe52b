//! Platinum resistance sensors: PT100, PT1000 and every other nominal resistance, by the equation of
//! Callendar and van Dusen with the coefficients of IEC 60751 (alpha 0.00385): R = R0 (1 + A t + B t^2) from
//! 0 to 850 C, and R = R0 (1 + A t + B t^2 + C (t - 100) t^3) from -200 to 0 C.

use units::{Celsius, Ohms};

use crate::thermistor::{self, AdcCode, Divider};

const A: f64 = 3.9083e-3;
const B: f64 = -5.775e-7;
const C: f64 = -4.183e-12;
/// Range of the standard's equation, C.
pub const RANGE: core::ops::RangeInclusive<f64> = -200.0..=850.0;

/// Curve of a platinum sensor's resistance over temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Platinum {
    /// Resistance at 0 C.
    pub r0: Ohms,
}

/// Returns the resistance at a temperature, C, as a share of that at 0 C.
fn share(celsius: f64) -> f64 {
    let cold = if celsius < 0.0 { C * (celsius - 100.0) * celsius * celsius * celsius } else { 0.0 };
    1.0 + celsius * (A + B * celsius) + cold
}

/// Returns the derivative of the resistance ratio over temperature, per degree.
fn slope(celsius: f64) -> f64 {
    let cold = if celsius < 0.0 { C * (4.0 * celsius - 300.0) * celsius * celsius } else { 0.0 };
    A + 2.0 * B * celsius + cold
}

impl Platinum {
    /// 100 Ohm at 0 C.
    pub const PT100: Self = Self { r0: Ohms(100.0) };
    /// 1000 Ohm at 0 C.
    pub const PT1000: Self = Self { r0: Ohms(1_000.0) };

    /// Returns the temperature at a resistance; `None` outside the values of [`RANGE`].
    #[must_use]
    pub fn celsius(&self, ohms: Ohms) -> Option<Celsius> {
        let measured = f64::from(ohms.0) / f64::from(self.r0.0);
        if !(share(*RANGE.start())..=share(*RANGE.end())).contains(&measured) {
            return None;
        }
        // The root is exact from 0 C on; below, where it is up to 2.4 C off, three of Newton's steps end
        // below a millikelvin.
        let mut celsius = (libm::sqrt(A * A - 4.0 * B * (1.0 - measured)) - A) / (2.0 * B);
        if celsius < 0.0 {
            for _ in 0..3 {
                celsius -= (share(celsius) - measured) / slope(celsius);
            }
        }
        Some(Celsius(celsius as f32))
    }

    /// Returns the resistance at a temperature of [`RANGE`].
    #[must_use]
    pub fn ohms(&self, celsius: Celsius) -> Ohms {
        Ohms((f64::from(self.r0.0) * share(f64::from(celsius.0))) as f32)
    }
}

/// Reason for a missing temperature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// More resistance than at 850 C.
    Open,
    /// Less resistance than at -200 C.
    Shorted,
}

impl Fault {
    /// Returns the message for the user.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::Open => "platinum sensor open (or a PT1000 set as pt100): check wires",
            Self::Shorted => "platinum sensor shorted (or a PT100 set as pt1000): check wires",
        }
    }
}

/// Platinum sensor in a divider, without an amplifier.
///
/// A count of the converter is 0.03 C for a PT1000 on 4.7 kOhm and 0.2 C for a PT100. The converter and the
/// buffer before it may be off by 0.2 % of the range, which is 3.4 C and 26 C at 0 C: a PT100 belongs on a
/// MAX31865.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlatinumInput {
    /// Resistance curve of the sensor.
    pub platinum: Platinum,
    /// Divider that contains the sensor.
    pub divider: Divider,
}

impl PlatinumInput {
    /// Returns the temperature at a reading.
    ///
    /// # Errors
    /// Open or shorted wires, or another sensor.
    pub fn celsius(&self, code: AdcCode) -> Result<Celsius, Fault> {
        let ohms = self.divider.ohms(code).map_err(|fault| match fault {
            thermistor::Fault::Open => Fault::Open,
            thermistor::Fault::Shorted => Fault::Shorted,
        })?;
        let beyond = if ohms > self.platinum.r0 { Fault::Open } else { Fault::Shorted };
        self.platinum.celsius(ohms).ok_or(beyond)
    }

    /// Returns the reading at a temperature.
    #[must_use]
    pub fn code(&self, celsius: Celsius) -> AdcCode {
        self.divider.code(self.platinum.ohms(celsius))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Resistances of a PT100, ohms, from the tables of IEC 60751.
    #[test]
    fn the_standard_s_table_is_met() {
        for (celsius, ohms) in [
            (-200.0, 18.52),
            (-100.0, 60.26),
            (-50.0, 80.31),
            (0.0, 100.0),
            (25.0, 109.73),
            (100.0, 138.51),
            (200.0, 175.86),
            (400.0, 247.09),
            (850.0, 390.48),
        ] {
            let there = Platinum::PT100.ohms(Celsius(celsius)).0;
            assert!((there - ohms).abs() < 0.006, "{there} Ohm at {celsius} C, not {ohms}");
        }
    }

    #[test]
    fn one_count_is_as_fine_as_said() {
        for (platinum, finest) in [(Platinum::PT1000, 0.03), (Platinum::PT100, 0.2)] {
            let input = PlatinumInput { platinum, divider: Divider::PRIME };
            let code = input.code(Celsius(0.0)).0;
            let step = input.celsius(AdcCode(code + 1)).unwrap().0 - input.celsius(AdcCode(code)).unwrap().0;
            assert!(step > 0.0 && step < finest, "{step} C");
        }
    }

    #[test]
    fn the_other_sensor_is_a_fault() {
        let room = Celsius(25.0);
        let [hundred, thousand] =
            [Platinum::PT100, Platinum::PT1000].map(|platinum| PlatinumInput { platinum, divider: Divider::PRIME });
        assert_eq!(hundred.celsius(thousand.code(room)), Err(Fault::Open));
        assert_eq!(thousand.celsius(hundred.code(room)), Err(Fault::Shorted));
        assert_eq!(thousand.celsius(AdcCode(0)), Err(Fault::Shorted));
        assert_eq!(thousand.celsius(AdcCode::FULL_SCALE), Err(Fault::Open));
    }

    proptest! {
        #[test]
        fn a_temperature_survives_the_resistance(celsius in -199.9_f32..849.9, r0 in 50.0_f32..2_000.0) {
            let platinum = Platinum { r0: Ohms(r0) };
            let back = platinum.celsius(platinum.ohms(Celsius(celsius))).unwrap();
            prop_assert!((back.0 - celsius).abs() < 1e-3, "{} for {}", back, celsius);
        }

        #[test]
        fn more_resistance_is_hotter(first in -200.0_f32..850.0, second in -200.0_f32..850.0) {
            prop_assume!(first < second - 1e-3);
            prop_assert!(Platinum::PT100.ohms(Celsius(first)) < Platinum::PT100.ohms(Celsius(second)));
        }

        #[test]
        fn every_code_gives_a_temperature_of_the_range_or_a_fault(code: u16, thousand: bool) {
            let platinum = if thousand { Platinum::PT1000 } else { Platinum::PT100 };
            let input = PlatinumInput { platinum, divider: Divider::PRIME };
            match input.celsius(AdcCode(code)) {
                Ok(celsius) => prop_assert!((-200.001..=850.001).contains(&celsius.0)),
                Err(Fault::Open) => prop_assert!(AdcCode(code) >= input.code(Celsius(849.0))),
                Err(Fault::Shorted) => prop_assert!(AdcCode(code) <= input.code(Celsius(-199.0))),
            }
        }
    }
}

//! Sensors known by name, with names, numbers and index of Smoothieware configurations; coefficients are fits
//! to the makers' resistance tables.

use super::{Curve, Divider, Thermistor};
use units::{Celsius, Ohms};

/// A sensor known by name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuiltIn {
    /// Name in configurations. A name may stand twice: once as Steinhart-Hart, later as beta.
    pub name: &'static str,
    /// Number for M305 P: from 1 for Steinhart-Hart, from 129 for beta.
    pub index: u8,
    /// Part number of the maker, if known.
    pub part: &'static str,
    /// Equation of resistance over temperature.
    pub law: Law,
    /// Nominal resistance at 25 C.
    pub r0: Ohms,
    /// Divider for which the sensor is meant.
    pub divider: Divider,
}

/// Equation of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// Coefficients of 1, ln R and (ln R)^3.
    SteinhartHart([f64; 3]),
    /// Beta of the beta equation, kelvin.
    Beta(f64),
}

impl BuiltIn {
    /// Finds the sensor of this name; the Steinhart-Hart entry, which comes first, unless only beta is
    /// wanted.
    #[must_use]
    pub fn named(name: &str, only_beta: bool) -> Option<&'static Self> {
        BUILT_IN.iter().find(|entry| entry.name == name && (entry.is_beta() || !only_beta))
    }

    /// Returns whether the sensor is given by its beta.
    #[must_use]
    pub const fn is_beta(&self) -> bool {
        matches!(self.law, Law::Beta(_))
    }

    /// Returns the sensor's beta, kelvin; `None` if it has Steinhart-Hart coefficients.
    #[must_use]
    pub const fn beta(&self) -> Option<f64> {
        match self.law {
            Law::Beta(kelvin) => Some(kelvin),
            Law::SteinhartHart(_) => None,
        }
    }

    /// Returns the curve of resistance over temperature.
    #[must_use]
    pub fn curve(&self) -> Curve {
        match self.law {
            Law::SteinhartHart(coefficients) => Curve::from_table(coefficients),
            // The table's numbers are in range (tested), so the fallback is never taken.
            Law::Beta(beta) => Curve::from_beta(self.r0, Celsius(25.0), beta).unwrap_or(Curve::from_table([0.0; 3])),
        }
    }

    /// Returns the sensor in the divider it is meant for.
    #[must_use]
    pub fn thermistor(&self) -> Thermistor {
        Thermistor::new(self.curve(), self.divider, self.r0)
    }
}

const fn steinhart_hart(index: u8, name: &'static str, part: &'static str, coefficients: [f64; 3]) -> BuiltIn {
    let law = Law::SteinhartHart(coefficients);
    BuiltIn { name, index, part, law, r0: Ohms(100_000.0), divider: Divider::PRIME }
}

const fn beta(index: u8, name: &'static str, part: &'static str, beta_kelvin: f64) -> BuiltIn {
    BuiltIn { name, index, part, law: Law::Beta(beta_kelvin), r0: Ohms(100_000.0), divider: Divider::PRIME }
}

/// Every sensor known by name; the more exact description of a name comes first.
pub const BUILT_IN: &[BuiltIn] = &[
    steinhart_hart(
        1,
        "EPCOS100K",
        "EPCOS B57540G0104F000",
        [7.223_783_003_193_46e-4, 2.163_018_520_545_78e-4, 9.264_102_563_570_2e-8],
    ),
    steinhart_hart(2, "Vishay100K", "Vishay NTCS0603E3104FXT", [7.022_607_370e-4, 2.209_155_484e-4, 7.101_626_461e-8]),
    steinhart_hart(
        3,
        "Honeywell100K",
        "Honeywell 135-104LAG-J01",
        [5.961_531_859_284_25e-4, 2.313_331_927_383_35e-4, 6.195_340_043_067_38e-8],
    ),
    steinhart_hart(
        4,
        "Semitec",
        "ATC Semitec 104GT-2",
        [8.112_901_601_454_59e-4, 2.113_557_891_442_65e-4, 7.176_147_304_638_48e-8],
    ),
    steinhart_hart(
        5,
        "Honeywell-QAD",
        "Honeywell 135-104QAD-J01",
        [8.273_392_995_009_86e-4, 2.087_864_272_088_99e-4, 8.055_952_823_322_77e-8],
    ),
    steinhart_hart(
        6,
        "Semitec-104NT4",
        "ATC Semitec 104NT-4-R025H42G",
        [7.971_106_097_102_17e-4, 2.134_331_443_812_7e-4, 6.533_898_755_4e-8],
    ),
    beta(129, "EPCOS100K", "EPCOS B57540G0104F000", 4_066.0),
    beta(130, "RRRF100K", "RRRF 100K", 3_960.0),
    BuiltIn {
        name: "RRRF10K",
        index: 131,
        part: "RRRF 10K",
        law: Law::Beta(3_964.0),
        r0: Ohms(10_000.0),
        divider: Divider { pull_up: Ohms(1_600.0), parallel: Some(Ohms(680.0)) },
    },
    beta(132, "Honeywell100K", "Honeywell 135-104LAG-J01", 3_974.0),
    beta(133, "Semitec", "ATC Semitec 104GT-2", 4_267.0),
    beta(134, "HT100K", "HT 100K", 3_990.0),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sensor_is_near_room_temperature_at_its_nominal_resistance() {
        for entry in BUILT_IN {
            let celsius = entry.curve().celsius(entry.r0);
            assert!((celsius.0 - 25.0).abs() < 1.0, "{} reads {celsius}", entry.name);
        }
    }

    #[test]
    fn a_name_in_both_tables_means_the_precise_entry_unless_beta_is_asked_for() {
        let law = |name, only_beta| BuiltIn::named(name, only_beta).map(|entry| entry.law);
        assert!(matches!(law("Semitec", false), Some(Law::SteinhartHart(_))));
        assert_eq!(law("Semitec", true), Some(Law::Beta(4_267.0)));
        assert_eq!(law("semitec", false), None);
    }

    #[test]
    fn both_descriptions_of_a_name_agree_where_beta_holds() {
        for exact in BUILT_IN.iter().filter(|entry| !entry.is_beta()) {
            let Some(rough) = BUILT_IN.iter().find(|entry| entry.is_beta() && entry.name == exact.name) else {
                continue;
            };
            let ohms = exact.curve().ohms(Celsius(80.0));
            let difference = rough.curve().celsius(ohms).0 - 80.0;
            assert!(difference.abs() < 3.0, "{} differs by {difference}", exact.name);
        }
    }

    #[test]
    fn published_points_of_the_104gt_are_met() {
        let curve = Thermistor::built_in("semitec").unwrap().curve;
        // ATC Semitec 104GT-2 resistance table.
        for (celsius, ohms) in [(20.0, 126_800.0), (150.0, 1_360.0), (300.0, 80.65)] {
            let read = curve.celsius(Ohms(ohms));
            assert!((read.0 - celsius).abs() < 2.0, "{read} for {celsius}");
        }
    }

    #[test]
    fn indices_are_unique_and_say_the_kind() {
        for (place, entry) in BUILT_IN.iter().enumerate() {
            assert_eq!(entry.index >= 129, entry.is_beta(), "{}", entry.name);
            assert!(BUILT_IN[place + 1..].iter().all(|other| other.index != entry.index));
        }
    }
}

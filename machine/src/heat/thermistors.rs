//! Built-in thermistors by the names that Smoothieware configurations use.
//!
//! Coefficients as published in Smoothieware's predefined tables, fitted to the makers' resistance tables.

use units::Ohms;

use super::sensor::Curve;

/// A built-in thermistor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuiltIn {
    /// The name in configurations.
    pub name: &'static str,
    /// Its curve.
    pub curve: Curve,
    /// Resistance at 25 C.
    pub r0: Ohms,
    /// Resistor in parallel on the board this entry was made for; 0 for none.
    pub r1_parallel: Ohms,
    /// Pull-up of the board this entry was made for.
    pub r2_pull_up: Ohms,
}

const fn steinhart_hart(name: &'static str, c1: f64, c2: f64, c3: f64) -> BuiltIn {
    let curve = Curve::SteinhartHart([c1, c2, c3]);
    BuiltIn { name, curve, r0: Ohms(100_000.0), r1_parallel: Ohms(0.0), r2_pull_up: Ohms(4_700.0) }
}

const fn beta(name: &'static str, beta_k: f64) -> BuiltIn {
    let curve = Curve::Beta(beta_k);
    BuiltIn { name, curve, r0: Ohms(100_000.0), r1_parallel: Ohms(0.0), r2_pull_up: Ohms(4_700.0) }
}

/// Steinhart-Hart entries; searched first.
pub const STEINHART_HART: [BuiltIn; 6] = [
    steinhart_hart("EPCOS100K", 7.22378300319346e-4, 2.16301852054578e-4, 9.2641025635702e-8),
    steinhart_hart("Vishay100K", 7.022607370e-4, 2.209155484e-4, 7.101626461e-8),
    steinhart_hart("Honeywell100K", 5.96153185928425e-4, 2.31333192738335e-4, 6.19534004306738e-8),
    steinhart_hart("Semitec", 8.11290160145459e-4, 2.11355789144265e-4, 7.17614730463848e-8),
    steinhart_hart("Honeywell-QAD", 8.27339299500986e-4, 2.08786427208899e-4, 8.05595282332277e-8),
    steinhart_hart("Semitec-104NT4", 7.97110609710217e-4, 2.1343314438127e-4, 6.5338987554e-8),
];

/// Beta entries.
pub const BETA: [BuiltIn; 6] = [
    beta("EPCOS100K", 4_066.0),
    beta("RRRF100K", 3_960.0),
    BuiltIn {
        name: "RRRF10K",
        curve: Curve::Beta(3_964.0),
        r0: Ohms(10_000.0),
        r1_parallel: Ohms(680.0),
        r2_pull_up: Ohms(1_600.0),
    },
    beta("Honeywell100K", 3_974.0),
    beta("Semitec", 4_267.0),
    beta("HT100K", 3_990.0),
];

/// Finds an entry; the Steinhart-Hart one first unless only beta entries are wanted.
#[must_use]
pub fn find(name: &str, only_beta: bool) -> Option<&'static BuiltIn> {
    let precise = STEINHART_HART.iter().filter(|_| !only_beta);
    precise.chain(&BETA).find(|entry| entry.name == name)
}

/// Steinhart-Hart coefficients through three points of (Celsius, ohm). With l = ln R and y = 1/T:
/// g2 = (y2-y1)/(l2-l1), g3 = (y3-y1)/(l3-l1), c3 = (g3-g2)/(l3-l2)/(l1+l2+l3), c2 = g2 - c3(l1^2+l1 l2+l2^2),
/// c1 = y1 - (c2 + l1^2 c3) l1.
#[must_use]
pub fn coefficients_through(points: [(f64, f64); 3]) -> [f64; 3] {
    let [(l1, y1), (l2, y2), (l3, y3)] = points.map(|(celsius, ohms)| (libm::log(ohms), 1.0 / (celsius + 273.15)));
    let g2 = (y2 - y1) / (l2 - l1);
    let g3 = (y3 - y1) / (l3 - l1);
    let c3 = (g3 - g2) / ((l3 - l2) * (l1 + l2 + l3));
    let c2 = g2 - c3 * (l1 * l1 + l1 * l2 + l2 * l2);
    let c1 = y1 - (c2 + l1 * l1 * c3) * l1;
    [c1, c2, c3]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fitted_curve_passes_through_its_three_points() {
        let points = [(25.0, 100_000.0), (150.0, 1_641.9), (250.0, 226.15)];
        let [c1, c2, c3] = coefficients_through(points);
        for (celsius, ohms) in points {
            let l = libm::log(ohms);
            let fitted = 1.0 / (c1 + c2 * l + c3 * l * l * l) - 273.15;
            assert!((fitted - celsius).abs() < 1e-6, "{ohms} Ohm gives {fitted}, not {celsius}");
        }
    }

    #[test]
    fn every_entry_is_nominal_at_25_celsius() {
        for entry in STEINHART_HART.iter().filter(|entry| entry.name != "Honeywell-QAD") {
            let Curve::SteinhartHart([c1, c2, c3]) = entry.curve else { unreachable!("table of one kind") };
            let l = libm::log(f64::from(entry.r0.0));
            let celsius = 1.0 / (c1 + c2 * l + c3 * l * l * l) - 273.15;
            assert!((celsius - 25.0).abs() < 2.0, "{}: {celsius}", entry.name);
        }
    }

    #[test]
    fn a_name_in_both_tables_means_the_precise_entry_unless_beta_is_asked_for() {
        assert!(matches!(find("Semitec", false).unwrap().curve, Curve::SteinhartHart(_)));
        assert!(matches!(find("Semitec", true).unwrap().curve, Curve::Beta(_)));
        assert!(find("semitec", false).is_none());
    }
}

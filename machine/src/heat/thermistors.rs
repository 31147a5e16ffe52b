//! Thermistors by the names that configurations use (the table is in `drivers`), and curves through three points.

use drivers::thermistor::{BUILT_IN, BuiltIn, Law};

use super::sensor::Curve;

/// The curve of the sensor with this name; the Steinhart-Hart one, which comes first, unless only beta is wanted.
#[must_use]
pub fn find(name: &str, only_beta: bool) -> Option<Curve> {
    let wanted = |entry: &&BuiltIn| entry.name == name && (entry.is_beta() || !only_beta);
    BUILT_IN.iter().find(wanted).map(|entry| match entry.law {
        Law::SteinhartHart(coefficients) => Curve::SteinhartHart(coefficients),
        Law::Beta(kelvin) => Curve::Beta(kelvin),
    })
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
    fn a_name_in_both_tables_means_the_precise_entry_unless_beta_is_asked_for() {
        assert!(matches!(find("Semitec", false), Some(Curve::SteinhartHart(_))));
        assert_eq!(find("Semitec", true), Some(Curve::Beta(4_267.0)));
        assert_eq!(find("semitec", false), None);
    }
}

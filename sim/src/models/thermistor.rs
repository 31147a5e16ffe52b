//! A thermistor behind the board's divider: 4.7 kOhm to 3.3 V, then a unity buffer (no load on the divider).

use board_facts::wiring::THERMISTOR_PULL_UP_OHMS as PULL_UP_OHMS;

/// The divider's supply, volts: also the converter's reference, so ratios are exact.
pub const REFERENCE_VOLTS: f64 = board_facts::wiring::ANALOG_REFERENCE_VOLTS;
const ZERO_CELSIUS_K: f64 = 273.15;

/// Dependence of resistance on temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Curve {
    /// R = R25 exp(B (1/T - 1/T25)).
    Beta {
        /// Nominal resistance of the part, ohms.
        r25_ohms: f64,
        /// Temperature of the nominal resistance, degrees Celsius (25 for nearly all).
        t25_c: f64,
        /// Material constant B, kelvin.
        beta_k: f64,
    },
    /// 1/T = c1 + c2 ln R + c3 (ln R)^3.
    SteinhartHart {
        /// The three coefficients, for ohms and kelvin.
        coefficients: [f64; 3],
    },
    /// Resistance rising linearly: R = R0 (1 + alpha T), T in degrees Celsius (PT100, PT1000).
    Linear {
        /// Resistance at 0 degrees Celsius, ohms.
        r0_ohms: f64,
        /// Temperature coefficient, 1/K.
        alpha_per_k: f64,
    },
    /// Platinum by the table of IEC 60751, straight between its points, which is close enough (0.2 C).
    Platinum {
        /// Resistance at 0 degrees Celsius, ohms.
        r0_ohms: f64,
    },
    /// An amplifier that drives the input against any pull-up: volts at 0 degrees Celsius, and for each
    /// degree.
    Amplifier {
        /// Volts at 0 degrees Celsius.
        at_zero: f64,
        /// Volts for each degree.
        per_k: f64,
    },
}

/// Ohms of a PT100 every 50 degrees Celsius from -50 to 400 (IEC 60751, table 1).
const PT100_FROM_MINUS_50: [f64; 10] = [80.31, 100.0, 119.40, 138.51, 157.33, 175.86, 194.10, 212.05, 229.72, 247.09];

fn platinum_share(celsius: f64) -> f64 {
    let at = (celsius + 50.0) / 50.0;
    let piece = at.floor().clamp(0.0, 8.0);
    let [low, high] = [0, 1].map(|next| PT100_FROM_MINUS_50[piece as usize + next] / 100.0);
    low + (high - low) * (at - piece)
}

impl Curve {
    /// The makers' points (degrees Celsius, ohms) of parts that configurations know by name.
    const PARTS: [(&str, [(f64, f64); 3]); 3] = [
        // EPCOS B57560G104F, by its data sheet.
        ("EPCOS100K", [(25.0, 100_000.0), (150.0, 1_641.9), (250.0, 226.15)]),
        // ATC Semitec 104GT-2, by its data sheet.
        ("Semitec", [(20.0, 126_800.0), (150.0, 1_360.0), (300.0, 80.65)]),
        // ATC Semitec 104NT-4-R025H42G, by its data sheet.
        ("Semitec-104NT4", [(25.0, 100_000.0), (160.0, 1_074.0), (300.0, 82.78)]),
    ];

    /// Returns the curve of a part that a configuration names, from its maker's data; `None` for parts
    /// without any here.
    #[must_use]
    pub fn of_part(name: &str) -> Option<Self> {
        Self::PARTS.iter().find(|(part, _)| *part == name).map(|&(_, points)| Self::through(points))
    }

    /// Returns the Steinhart-Hart curve through three points of (degrees Celsius, ohms).
    #[must_use]
    pub fn through(points: [(f64, f64); 3]) -> Self {
        let l = points.map(|(_, ohms)| ohms.ln());
        let y = points.map(|(celsius, _)| 1.0 / (celsius + ZERO_CELSIUS_K));
        let slope = |n: usize| (y[n] - y[0]) / (l[n] - l[0]);
        let c3 = (slope(2) - slope(1)) / ((l[2] - l[1]) * (l[0] + l[1] + l[2]));
        let c2 = slope(1) - c3 * (l[0] * l[0] + l[0] * l[1] + l[1] * l[1]);
        let c1 = y[0] - (c2 + l[0] * l[0] * c3) * l[0];
        Self::SteinhartHart { coefficients: [c1, c2, c3] }
    }

    /// Returns the resistance in ohms at a temperature in degrees Celsius.
    #[must_use]
    pub fn ohms(&self, celsius: f64) -> f64 {
        let kelvin = celsius + ZERO_CELSIUS_K;
        match *self {
            Self::Beta { r25_ohms, t25_c, beta_k } => {
                r25_ohms * (beta_k * (1.0 / kelvin - 1.0 / (t25_c + ZERO_CELSIUS_K))).exp()
            }
            Self::Linear { r0_ohms, alpha_per_k } => r0_ohms * (1.0 + alpha_per_k * celsius),
            Self::Platinum { r0_ohms } => r0_ohms * platinum_share(celsius),
            // The resistance is chosen for which the divider gives the amplifier's voltage.
            Self::Amplifier { at_zero, per_k } => {
                let volts = (at_zero + per_k * celsius).clamp(0.0, REFERENCE_VOLTS - 1e-9);
                PULL_UP_OHMS * volts / (REFERENCE_VOLTS - volts)
            }
            Self::SteinhartHart { coefficients: [c1, c2, 0.0] } => ((1.0 / kelvin - c1) / c2).exp(),
            // Cardano's formula for ln R: c3 x^3 + c2 x + (c1 - 1/T) = 0 has one real root for c2, c3 > 0.
            Self::SteinhartHart { coefficients: [c1, c2, c3] } => {
                let half = (c1 - 1.0 / kelvin) / c3 / 2.0;
                let third = c2 / c3 / 3.0;
                let root = (third.powi(3) + half * half).sqrt();
                ((root - half).cbrt() - (root + half).cbrt()).exp()
            }
        }
    }
}

/// Fault of a sensor's wires.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wiring {
    /// Sensor without a fault.
    #[default]
    Sound,
    /// Not connected: the input is pulled to the supply.
    Open,
    /// Sensor shorted to ground.
    Shorted,
    /// Shorted to the supply.
    ToSupply,
}

/// Voltage at the converter for a sensor at this temperature.
#[must_use]
pub fn divider_volts(curve: &Curve, celsius: f64, wiring: Wiring) -> f64 {
    match wiring {
        Wiring::Open | Wiring::ToSupply => REFERENCE_VOLTS,
        Wiring::Shorted => 0.0,
        Wiring::Sound => {
            let ohms = curve.ohms(celsius);
            REFERENCE_VOLTS * ohms / (ohms + PULL_UP_OHMS)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_passes_through_its_points() {
        for (part, points) in Curve::PARTS {
            let curve = Curve::of_part(part).expect("in the table");
            for (celsius, ohms) in points {
                let there = curve.ohms(celsius);
                assert!((there / ohms - 1.0).abs() < 1e-6, "{part}: {there} Ohm at {celsius} C, not {ohms}");
            }
        }
    }

    #[test]
    fn resistance_falls_as_temperature_rises() {
        let beta = Curve::Beta { r25_ohms: 1e5, t25_c: 25.0, beta_k: 4_066.0 };
        for curve in [beta, Curve::of_part("EPCOS100K").expect("in the table")] {
            let volts = |celsius| divider_volts(&curve, celsius, Wiring::Sound);
            for celsius in -10..300 {
                assert!(volts(f64::from(celsius)) > volts(f64::from(celsius + 1)));
            }
        }
    }

    #[test]
    fn broken_wires_read_as_the_rails() {
        let curve = Curve::of_part("Semitec").expect("in the table");
        assert_eq!(divider_volts(&curve, 200.0, Wiring::Open), 3.3);
        assert_eq!(divider_volts(&curve, 200.0, Wiring::Shorted), 0.0);
    }
}

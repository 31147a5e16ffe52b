//! Thermistor curve by the equation of J. S. Steinhart and S. R. Hart, "Calibration curves for thermistors",
//! Deep-Sea Research 15 (1968): 1/T = c1 + c2 ln R + c3 (ln R)^3, R in ohms, T in kelvin.

use units::{Celsius, Ohms};

const ZERO_CELSIUS_K: f64 = 273.15;

/// Steinhart-Hart coefficients. A beta curve is one with c3 = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    c1: f64,
    c2: f64,
    c3: f64,
}

/// Reason why numbers make no thermistor curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveError {
    /// A coefficient, resistance or temperature that is not a number in its range.
    OutOfRange,
    /// Resistance must fall as temperature rises, and no two points may be the same.
    NotFalling,
}

impl CurveError {
    /// Returns the message for the user.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::OutOfRange => "resistances must be above 0 Ohm, temperatures above -273.15 C, beta above 0",
            Self::NotFalling => "resistance must fall as temperature rises, over three different temperatures",
        }
    }
}

impl Curve {
    /// Creates a curve from the three coefficients.
    ///
    /// # Errors
    /// Coefficients under which resistance would not fall with temperature: c2 must be above 0, c3 not below.
    pub fn from_coefficients([c1, c2, c3]: [f64; 3]) -> Result<Self, CurveError> {
        if !(c1.is_finite() && c2.is_finite() && c3.is_finite()) {
            return Err(CurveError::OutOfRange);
        }
        if c2 <= 0.0 || c3 < 0.0 {
            return Err(CurveError::NotFalling);
        }
        Ok(Self { c1, c2, c3 })
    }

    /// Creates a curve from nominal resistance, its temperature, and beta in kelvin: 1/T = 1/T0 + ln(R/R0) /
    /// beta.
    ///
    /// # Errors
    /// Numbers out of range.
    pub fn from_beta(r0: Ohms, t0: Celsius, beta_kelvin: f64) -> Result<Self, CurveError> {
        let (ohms, kelvin) = point(r0, t0)?;
        if !(beta_kelvin > 0.0 && beta_kelvin.is_finite()) {
            return Err(CurveError::OutOfRange);
        }
        Ok(Self { c1: 1.0 / kelvin - libm::log(ohms) / beta_kelvin, c2: 1.0 / beta_kelvin, c3: 0.0 })
    }

    /// Creates a curve through three points, by the usual solution of the three linear equations with divided
    /// differences. Points that bend the wrong way (c3 below 0) are rounding of a beta curve: beta of the
    /// outer two then.
    ///
    /// # Errors
    /// Points that do not fall.
    pub fn from_points(mut points: [(Celsius, Ohms); 3]) -> Result<Self, CurveError> {
        units::sort_short(&mut points, |a, b| a.0.0.total_cmp(&b.0.0));
        let mut l = [0.0; 3];
        let mut y = [0.0; 3];
        for (index, (celsius, ohms)) in points.into_iter().enumerate() {
            let (ohms, kelvin) = point(ohms, celsius)?;
            l[index] = libm::log(ohms);
            y[index] = 1.0 / kelvin;
        }
        if !(l[0] > l[1] && l[1] > l[2] && y[0] > y[1] && y[1] > y[2]) {
            return Err(CurveError::NotFalling);
        }
        let slope_2 = (y[1] - y[0]) / (l[1] - l[0]);
        let slope_3 = (y[2] - y[0]) / (l[2] - l[0]);
        let c3 = (slope_3 - slope_2) / ((l[2] - l[1]) * (l[0] + l[1] + l[2]));
        let c2 = slope_2 - c3 * (l[0] * l[0] + l[0] * l[1] + l[1] * l[1]);
        let c1 = y[0] - (c2 + l[0] * l[0] * c3) * l[0];
        if c3 >= 0.0 && c2 > 0.0 {
            return Self::from_coefficients([c1, c2, c3]);
        }
        let c2 = (y[2] - y[0]) / (l[2] - l[0]);
        Self::from_coefficients([y[0] - c2 * l[0], c2, 0.0])
    }

    pub(super) const fn from_table([c1, c2, c3]: [f64; 3]) -> Self {
        Self { c1, c2, c3 }
    }

    /// Returns c1, c2 and c3.
    #[must_use]
    pub const fn coefficients(&self) -> [f64; 3] {
        [self.c1, self.c2, self.c3]
    }

    /// Returns the temperature at a resistance above 0.
    #[must_use]
    pub fn celsius(&self, thermistor: Ohms) -> Celsius {
        let ln = libm::log(f64::from(thermistor.0));
        let inverse_kelvin = self.c1 + ln * (self.c2 + self.c3 * ln * ln);
        Celsius((1.0 / inverse_kelvin - ZERO_CELSIUS_K) as f32)
    }

    /// Returns the resistance at a temperature above absolute zero. With x = ln R this is the real root of c3
    /// x^3 + c2 x + (c1 - 1/T) = 0 (Cardano; one real root, since c2 > 0 and c3 > 0).
    #[must_use]
    pub fn ohms(&self, celsius: Celsius) -> Ohms {
        let missing = self.c1 - 1.0 / (f64::from(celsius.0) + ZERO_CELSIUS_K);
        let ln = if self.c3 == 0.0 {
            -missing / self.c2
        } else {
            let (p, q) = (self.c2 / self.c3 / 3.0, missing / self.c3 / 2.0);
            let root = libm::sqrt(q * q + p * p * p);
            libm::cbrt(root - q) - libm::cbrt(root + q)
        };
        Ohms(libm::exp(ln) as f32)
    }
}

fn point(ohms: Ohms, celsius: Celsius) -> Result<(f64, f64), CurveError> {
    let (ohms, kelvin) = (f64::from(ohms.0), f64::from(celsius.0) + ZERO_CELSIUS_K);
    let sane = ohms > 0.0 && ohms.is_finite() && kelvin > 0.0 && kelvin.is_finite();
    if sane { Ok((ohms, kelvin)) } else { Err(CurveError::OutOfRange) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// EPCOS B57560G104F as its resistance table gives it.
    const EPCOS_POINTS: [(Celsius, Ohms); 3] =
        [(Celsius(25.0), Ohms(100_000.0)), (Celsius(150.0), Ohms(1_641.9)), (Celsius(250.0), Ohms(226.15))];

    #[test]
    fn a_curve_goes_through_its_points() {
        let curve = Curve::from_points(EPCOS_POINTS).unwrap();
        for (celsius, ohms) in EPCOS_POINTS {
            assert!((curve.celsius(ohms).0 - celsius.0).abs() < 1e-3, "{celsius}");
        }
    }

    #[test]
    fn beta_holds_at_its_nominal_point() {
        let curve = Curve::from_beta(Ohms(100_000.0), Celsius(25.0), 3_974.0).unwrap();
        assert!((curve.celsius(Ohms(100_000.0)).0 - 25.0).abs() < 1e-4);
        // Beta between 25 and 85 C by its definition.
        let ohms_85 = 100_000.0 * (3_974.0_f64 * (1.0 / 358.15 - 1.0 / 298.15)).exp();
        assert!((curve.celsius(Ohms(ohms_85 as f32)).0 - 85.0).abs() < 1e-3);
    }

    proptest! {
        #[test]
        fn resistance_and_temperature_undo_each_other(
            beta in 2_500.0_f64..5_000.0, c3 in 0.0_f64..1.5e-7, celsius in -20.0_f32..320.0,
        ) {
            let [c1, c2, _] = Curve::from_beta(Ohms(100_000.0), Celsius(25.0), beta).unwrap().coefficients();
            let curve = Curve::from_coefficients([c1, c2, c3]).unwrap();
            let back = curve.celsius(curve.ohms(Celsius(celsius)));
            prop_assert!((back.0 - celsius).abs() < 0.01, "{} for {}", back, celsius);
        }

        #[test]
        fn three_points_in_any_order_make_one_curve(order in Just([0_usize, 1, 2]).prop_shuffle()) {
            let shuffled = [EPCOS_POINTS[order[0]], EPCOS_POINTS[order[1]], EPCOS_POINTS[order[2]]];
            prop_assert_eq!(Curve::from_points(shuffled), Curve::from_points(EPCOS_POINTS));
        }

        #[test]
        fn points_make_a_falling_curve_or_an_error(
            t in prop::array::uniform3(-50.0_f32..400.0), r in prop::array::uniform3(1.0_f32..1e6), low in 0.0_f32..300.0,
        ) {
            let points = [0, 1, 2].map(|index| (Celsius(t[index]), Ohms(r[index])));
            if let Ok(curve) = Curve::from_points(points) {
                prop_assert!(curve.ohms(Celsius(low)) >= curve.ohms(Celsius(low + 1.0)));
            }
        }
    }

    #[test]
    fn numbers_that_make_no_thermistor_are_refused() {
        assert_eq!(Curve::from_beta(Ohms(0.0), Celsius(25.0), 3_950.0), Err(CurveError::OutOfRange));
        assert_eq!(Curve::from_beta(Ohms(1.0), Celsius(-300.0), 3_950.0), Err(CurveError::OutOfRange));
        assert_eq!(Curve::from_beta(Ohms(1e5), Celsius(25.0), f64::NAN), Err(CurveError::OutOfRange));
        assert_eq!(Curve::from_coefficients([7e-4, -2e-4, 1e-7]), Err(CurveError::NotFalling));
        let same = (Celsius(25.0), Ohms(1e5));
        assert_eq!(Curve::from_points([same; 3]), Err(CurveError::NotFalling));
        let rising = [(Celsius(0.0), Ohms(100.0)), (Celsius(50.0), Ohms(119.0)), (Celsius(100.0), Ohms(138.5))];
        assert_eq!(Curve::from_points(rising), Err(CurveError::NotFalling));
    }
}

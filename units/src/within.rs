//! Numbers within bounds, without a panic.

/// Returns a number, or the bound that it is beyond; what is no number stays none. The library's `clamp`
/// panics where bounds are crossed or no numbers, which brings the printing of any number along; here the
/// upper bound counts.
#[must_use]
pub fn within<T: PartialOrd>(number: T, least: T, most: T) -> T {
    let number = if number < least { least } else { number };
    if number > most { most } else { number }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn agrees_with_the_library(number: f64, one: f64, other: f64) {
            prop_assume!(one <= other);
            prop_assert_eq!(within(number, one, other).to_bits(), number.clamp(one, other).to_bits());
        }
    }

    #[test]
    fn no_bounds_panic() {
        assert!(within(f64::NAN, 0.0, 1.0).is_nan());
        assert_eq!(within(0.5, f64::NAN, f64::NAN), 0.5);
        assert_eq!(within(0.5, 1.0, 0.0), 0.0);
    }
}

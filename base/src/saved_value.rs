//! Numbers of saved settings, with the decimals that they need to read back.

use core::fmt;

/// Value with at least so many decimals, more where they are needed to read it back.
#[derive(Clone, Copy, Debug)]
pub struct Value(pub f64, pub usize);

impl Value {
    /// Share of a value by which another may differ and be the same: half of single precision's last place,
    /// in which Smoothieware calculates.
    const SAME: f64 = 6e-8;
    const MOST_DECIMALS: usize = 9;
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(value, least) = *self;
        // Powers of ten up to nine are exact.
        let lost = |decimals: usize| {
            let scale = (0..decimals).fold(1.0, |scale, _| scale * 10.0);
            libm::fabs(libm::round(value * scale) / scale - value)
        };
        let enough = (least..Self::MOST_DECIMALS).find(|decimals| lost(*decimals) <= libm::fabs(value) * Self::SAME);
        write!(f, "{value:.*}", enough.unwrap_or(Self::MOST_DECIMALS))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn printed(value: f64, least: usize) -> std::string::String {
        std::format!("{}", Value(value, least))
    }

    #[test]
    fn round_values_read_as_smoothieware_writes_them() {
        assert_eq!(printed(100.0, 5), "100.00000");
        assert_eq!(printed(-0.25, 2), "-0.25");
        assert_eq!(printed(f64::from(0.4_f32), 4), "0.4000");
        assert_eq!(printed(0.0, 2), "0.00");
    }

    #[test]
    fn others_get_the_decimals_they_need() {
        assert_eq!(printed(0.125, 2), "0.125");
        assert_eq!(printed(0.012_345_678, 5), "0.012345678");
        assert_eq!(printed(50.0 / 3.0, 5), "16.666667");
    }

    proptest! {
        #[test]
        fn what_is_printed_reads_back(value in -100_000.0..100_000.0_f64, least in 2..6_usize) {
            let read: f64 = printed(value, least).parse().unwrap();
            prop_assert!((read - value).abs() <= 1e-9 + value.abs() * 6e-8, "{value} came back as {read}");
        }
    }
}

//! Conversions between floats and wide integers, made of 32-bit ones.
//!
//! A Cortex-M7 converts between `f64` and 32-bit integers in one instruction; for wider ones it calls a
//! library of a hundred instructions. All of these give what the plain cast gives, to the last bit.

/// Two to the power of 32.
const TWO_32: f64 = 4_294_967_296.0;

/// The greatest whole number that is not above; saturates.
#[must_use]
#[inline]
pub fn floor_i32(x: f64) -> i32 {
    let cut = x as i32;
    if f64::from(cut) > x { cut.saturating_sub(1) } else { cut }
}

/// The least whole number that is not below; saturates.
#[must_use]
#[inline]
pub fn ceil_i32(x: f64) -> i32 {
    let cut = x as i32;
    if f64::from(cut) < x { cut.saturating_add(1) } else { cut }
}

/// Converts as `value as f64` does.
#[must_use]
#[inline]
pub fn float_of_u64(value: u64) -> f64 {
    f64::from((value >> 32) as u32) * TWO_32 + f64::from(value as u32)
}

/// Converts as `value as f64` does.
#[must_use]
#[inline]
pub fn float_of_i64(value: i64) -> f64 {
    f64::from((value >> 32) as i32) * TWO_32 + f64::from(value as u32)
}

/// Rounds to the nearest multiple of 2^-24, halves upwards, and gives it in that unit. Exact while |x| is
/// below 2^28; saturates.
#[must_use]
#[inline]
pub fn fixed_24(x: f64) -> i64 {
    let whole = floor_i32(x);
    let part = (x - f64::from(whole)) * 16_777_216.0 + 0.5;
    (i64::from(whole) << 24) + i64::from(part as i32)
}

/// Converts as `(x * 2^32) as u128` does, below 2^64.
#[must_use]
#[inline]
pub fn fixed_32(x: f64) -> u128 {
    let high = (x * (1.0 / TWO_32)) as u32;
    let low = x - f64::from(high) * TWO_32;
    let whole = low as u32;
    let part = ((low - f64::from(whole)) * TWO_32) as u32;
    (u128::from(high) << 64) | u128::from((u64::from(whole) << 32) | u64::from(part))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_000))]

        #[test]
        fn conversions_give_what_casts_give(unsigned: u64, shift in 0_u32..64, x in -1e9..1e9_f64, small in -3.0..3.0_f64) {
            let (unsigned, signed) = (unsigned >> shift, unsigned as i64 >> shift);
            prop_assert_eq!(float_of_u64(unsigned).to_bits(), (unsigned as f64).to_bits());
            prop_assert_eq!(float_of_i64(signed).to_bits(), (signed as f64).to_bits());
            for x in [x, small] {
                prop_assert_eq!(f64::from(floor_i32(x)), x.floor());
                prop_assert_eq!(f64::from(ceil_i32(x)), x.ceil());
                prop_assert_eq!(fixed_32(x), (x * TWO_32) as u128);
            }
        }

        #[test]
        fn a_fixed_position_is_the_nearest(steps in -2.6e8..2.6e8_f64, small in -3.0..3.0_f64) {
            for steps in [steps, small] {
                // Both the product and the half are exact: 28 bits and 24 more.
                prop_assert_eq!(fixed_24(steps), (steps * 16_777_216.0 + 0.5).floor() as i64);
            }
        }
    }

    #[test]
    fn nonsense_becomes_nothing() {
        assert_eq!([fixed_32(f64::NAN), fixed_32(-1.0)], [0, 0]);
        assert_eq!([floor_i32(1e300), ceil_i32(-1e300)], [i32::MAX, i32::MIN]);
    }
}

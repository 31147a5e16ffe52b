//! Roots and comparisons, fast on the board and the same to the last bit everywhere.
//!
//! **Square root.** The Cortex-M7 has an instruction for it, which safe Rust without `std` cannot reach;
//! `libm` does without, in 85 instructions. So a board lends its own ([`use_square_root`]). IEEE 754 asks
//! both for the correctly rounded result: nothing else changes.
//!
//! **Cube root.** The FPU multiplies double numbers but cannot fuse or take cube roots. `libm`'s is correctly
//! rounded by fused multiply-adds, which it has to make of integers there: 570 instructions, and the plan of
//! jerk-limited moves takes one for each block of look-ahead. The one here takes a fifth and gives the same
//! number: the last step adds to an approximation a correction that is exact to many more digits than are
//! kept.

use once_cell::race::OnceRef;

/// Board's function for square roots; `libm` is used without it.
static SQUARE_ROOT: OnceRef<'static, fn(f64) -> f64> = OnceRef::new();

/// Makes `root` take all square roots, which must round correctly (IEEE 754, 5.4.1). The first call counts;
/// before it, and without it, `libm` does.
pub fn use_square_root(root: &'static fn(f64) -> f64) {
    // A second one would give the same bits.
    let _first = SQUARE_ROOT.set(root);
}

/// The lesser of two numbers, the same on every machine (`f64::min` may treat zeros of either sign as it
/// likes).
#[inline]
pub(crate) fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The greater of two numbers.
#[inline]
pub(crate) fn greatest(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The square root, correctly rounded.
#[inline(always)]
pub(crate) fn square_root(x: f64) -> f64 {
    match SQUARE_ROOT.get() {
        Some(root) => root(x),
        None => libm::sqrt(x),
    }
}

/// The product of two numbers as a sum of two: rounded, and what rounding took off (T. J. Dekker, "A
/// floating-point technique for extending the available precision", 1971). For numbers of ordinary size.
fn exact_product(a: f64, b: f64) -> (f64, f64) {
    /// Splits 53 bits into 26 and 27.
    const SPLITTER: f64 = 134_217_729.0;
    let split = |number: f64| {
        let scaled = SPLITTER * number;
        let high = scaled - (scaled - number);
        (high, number - high)
    };
    let product = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    (product, al * bl - (((product - ah * bh) - al * bh) - ah * bl))
}

/// The cube root of a number that is not negative. Correctly rounded within 1e-90 to 1e90, far beyond any
/// quantity of a machine; `libm`'s elsewhere.
pub(crate) fn cube_root(x: f64) -> f64 {
    if !(1e-90..=1e90).contains(&x) {
        return libm::cbrt(x);
    }
    // A third of the exponent, and of the mantissa along with it: right to 6 %. The constant added is two
    // thirds of the exponents' bias, less what makes the errors at both ends alike.
    let upper = (x.to_bits() >> 32) as u32 / 3 + 0x2A9F_7893;
    let mut y = f64::from_bits(u64::from(upper) << 32);
    // Halley: each step cubes the error.
    for _ in 0..3 {
        let cube = y * y * y;
        y *= (cube + x + x) / (cube + cube + x);
    }
    // A Newton step, its residual in twice the digits.
    let (square, square_rest) = exact_product(y, y);
    let (cube, cube_rest) = exact_product(square, y);
    let residual = (x - cube) - (cube_rest + square_rest * y);
    y + residual / (3.0 * square)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn it_is_the_correctly_rounded_cube_root(mantissa in 1.0..10.0_f64, exponent in -89..89_i32) {
            let x = mantissa * 10.0_f64.powi(exponent);
            prop_assert_eq!(cube_root(x).to_bits(), libm::cbrt(x).to_bits(), "of {}", x);
        }

        #[test]
        fn cubes_of_whole_numbers_have_whole_roots(root in 0_u32..200_000) {
            let x = f64::from(root) * f64::from(root) * f64::from(root);
            prop_assert_eq!(cube_root(x), f64::from(root));
        }
    }

    #[test]
    fn numbers_of_any_size_have_one() {
        for x in [0.0, f64::MIN_POSITIVE, 1e-300, 1e-91, 1e91, 1e300, f64::MAX, f64::INFINITY] {
            assert_eq!(cube_root(x), libm::cbrt(x));
        }
        assert!(cube_root(f64::NAN).is_nan());
    }
}

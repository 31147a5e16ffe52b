//! Decimal numbers, `[+-]digits[.digits]`, rounded to the nearest `f64`.
//!
//! `E` is an axis in G-code, so there is no exponent. A number of up to 15 digits (every number a slicer
//! writes) is an exact integer divided by an exact power of ten: one rounding, so the result is the nearest
//! `f64` (Clinger 1990, "How to read floating point numbers accurately"). Longer ones take the exact
//! way of `crate::decimal`.

/// Powers of ten that an `f64` holds exactly.
pub(crate) const POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];
/// Integers up to here are exact in an `f64`.
pub(crate) const EXACT: u64 = 1 << 53;
/// Greatest number of digits that always fit 32 bits.
pub(crate) const SHORT: usize = 9;

/// Reason for which digits are not a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flaw {
    NoDigits,
    SecondPoint,
}

/// Whether a number can begin with this byte.
pub(crate) const fn starts(byte: u8) -> bool {
    matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.')
}

/// The number at the start of `bytes` and its length. Every word of a move has one.
#[inline]
pub(crate) fn parse(bytes: &[u8]) -> Result<(f64, usize), Flaw> {
    let negative = bytes.first() == Some(&b'-');
    let sign = usize::from(negative || bytes.first() == Some(&b'+'));
    let text = bytes.get(sign..).unwrap_or(&[]);
    // The mantissa is not used if more digits than fit are read.
    let (mut mantissa, whole) = digits_behind(0, text);
    let (mut length, mut decimals) = (whole, 0);
    if text.get(whole) == Some(&b'.') {
        (mantissa, decimals) = digits_behind(mantissa, text.get(whole + 1..).unwrap_or(&[]));
        length += 1 + decimals;
        if text.get(length) == Some(&b'.') {
            return Err(Flaw::SecondPoint);
        }
    }
    let digits = whole + decimals;
    let magnitude = match POWERS_OF_TEN.get(decimals) {
        _ if digits == 0 => return Err(Flaw::NoDigits),
        // The M7 converts 32 bits in one instruction, 64 in a library call.
        Some(power) if digits <= SHORT => f64::from(mantissa) / power,
        _ => long(text.get(..length).unwrap_or(&[]), decimals).ok_or(Flaw::NoDigits)?,
    };
    Ok((if negative { -magnitude } else { magnitude }, sign + length))
}

/// The digits at the start of `bytes` put behind those of a mantissa, which may wrap, and how many there are.
/// A loop of its own for each side of the point takes a third of the instructions of one that looks for it.
#[inline(always)]
fn digits_behind(mut mantissa: u32, bytes: &[u8]) -> (u32, usize) {
    let mut length = 0;
    for &byte in bytes {
        let digit = byte.wrapping_sub(b'0');
        if digit >= 10 {
            break;
        }
        mantissa = mantissa.wrapping_mul(10).wrapping_add(u32::from(digit));
        length += 1;
    }
    (mantissa, length)
}

/// A number of many digits.
#[cold]
fn long(text: &[u8], decimals: usize) -> Option<f64> {
    let digits = text.iter().filter(|byte| **byte != b'.');
    let mantissa = digits
        .into_iter()
        .try_fold(0_u64, |mantissa, byte| mantissa.checked_mul(10)?.checked_add(u64::from(byte.wrapping_sub(b'0'))));
    match (mantissa, POWERS_OF_TEN.get(decimals)) {
        (Some(mantissa), Some(power)) if mantissa <= EXACT => Some(mantissa as f64 / power),
        _ => exact(text),
    }
}

fn exact(digits: &[u8]) -> Option<f64> {
    core::str::from_utf8(digits).ok().and_then(crate::decimal::read_f64)
}

/// The whole number at the start of `bytes`, with an optional sign, and its length.
pub(crate) fn parse_integer(bytes: &[u8]) -> Option<(i32, usize)> {
    let negative = bytes.first() == Some(&b'-');
    let sign = usize::from(negative || bytes.first() == Some(&b'+'));
    let (magnitude, length) = parse_digits(bytes.get(sign..)?)?;
    let magnitude = i32::try_from(magnitude).ok()?;
    Some((if negative { -magnitude } else { magnitude }, sign + length))
}

/// The digits at the start of `bytes` and how many there are.
pub(crate) fn parse_digits(bytes: &[u8]) -> Option<(u32, usize)> {
    let mut value = 0_u32;
    let mut length = 0;
    for &byte in bytes.iter().take_while(|byte| byte.is_ascii_digit()) {
        value = value.checked_mul(10)?.checked_add(u32::from(byte - b'0'))?;
        length += 1;
    }
    (length > 0).then_some((value, length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_number_printed_reads_back_as_itself(bits in any::<u64>()) {
            let x = f64::from_bits(bits);
            prop_assume!(x.is_finite());
            let text = format!("{x}");
            let (y, length) = parse(text.as_bytes()).unwrap();
            prop_assert_eq!(y.to_bits(), x.to_bits());
            prop_assert_eq!(length, text.len());
        }

        #[test]
        fn digits_are_read_as_the_standard_library_reads_them(text in "[+-]?([0-9]{1,25}(\\.[0-9]{0,25})?|\\.[0-9]{1,25})") {
            let (ours, length) = parse(text.as_bytes()).unwrap();
            prop_assert_eq!(ours.to_bits(), text.parse::<f64>().unwrap().to_bits());
            prop_assert_eq!(length, text.len());
        }

        #[test]
        fn any_other_byte_ends_a_number(
            text in "[0-9]{1,9}(\\.[0-9]{0,5})?",
            end in any::<u8>().prop_filter("ends it", |byte| !matches!(byte, b'0'..=b'9' | b'.')),
            behind in proptest::collection::vec(any::<u8>(), 0..8),
        ) {
            let (value, length) = parse(text.as_bytes()).unwrap();
            let line = [text.as_bytes(), &[end], &behind].concat();
            let (beside, same_length) = parse(&line).unwrap();
            prop_assert_eq!((beside.to_bits(), same_length), (value.to_bits(), length));
        }

        #[test]
        fn any_bytes_give_a_number_or_a_flaw(bytes in proptest::collection::vec(any::<u8>(), 0..60)) {
            if let Ok((x, length)) = parse(&bytes) {
                prop_assert!(x.is_finite() && length <= bytes.len());
            }
            let _ = parse_integer(&bytes);
        }
    }

    #[test]
    fn the_letter_after_a_number_ends_it() {
        assert_eq!(parse(b"1E5"), Ok((1.0, 1)));
        assert_eq!(parse(b"-.5Y2"), Ok((-0.5, 3)));
        assert_eq!(parse(b"+7. "), Ok((7.0, 3)));
    }

    #[test]
    fn signs_and_points_alone_are_no_numbers() {
        for text in ["", "-", "+", ".", "-.", "--1", "+-1", "x"] {
            assert_eq!(parse(text.as_bytes()), Err(Flaw::NoDigits), "{text}");
        }
        assert_eq!(parse(b"1.2.3"), Err(Flaw::SecondPoint));
    }

    #[test]
    fn whole_numbers_that_do_not_fit_are_refused() {
        assert_eq!(parse_integer(b"-1 M110"), Some((-1, 2)));
        assert_eq!(parse_integer(b"2147483647"), Some((i32::MAX, 10)));
        assert_eq!(parse_integer(b"2147483648"), None);
        assert_eq!(parse_digits(b"99999999999"), None);
        assert_eq!(parse_digits(b""), None);
    }
}

//! Our reader beside the standard library's.

use super::{read_f32, read_f64};
use proptest::prelude::*;

/// Fails unless a text is the same to both.
fn compare(text: &str) -> Result<(), TestCaseError> {
    let (ours, theirs) = (read_f64(text), text.parse::<f64>().ok());
    let is_nan = theirs.is_some_and(f64::is_nan) && ours.is_some_and(f64::is_nan);
    prop_assert!(is_nan || ours.map(f64::to_bits) == theirs.map(f64::to_bits), "{text}: {ours:?}, not {theirs:?}");
    let (ours, theirs) = (read_f32(text), text.parse::<f32>().ok());
    let is_nan = theirs.is_some_and(f32::is_nan) && ours.is_some_and(f32::is_nan);
    prop_assert!(is_nan || ours.map(f32::to_bits) == theirs.map(f32::to_bits), "{text}: {ours:?}, not {theirs:?}");
    Ok(())
}

/// The digits of a number halfway between a double and the next, all of them.
fn halfway(bits: u64) -> String {
    let x = f64::from_bits(bits);
    let mut digits = Vec::new();
    let (mantissa, exponent) = match bits >> 52 & 0x7FF {
        0 => (bits & ((1 << 52) - 1), -1074),
        field => (bits & ((1 << 52) - 1) | 1 << 52, field as i32 - 1075),
    };
    // Twice the significand and one, over a power of two: digits one by one.
    let mut number = vec![0_u8];
    for digit in (2 * mantissa + 1).to_string().bytes() {
        number.push(digit - b'0');
    }
    let scale = |number: &mut Vec<u8>, factor: u8| {
        let mut carry = 0;
        for digit in number.iter_mut().rev() {
            let sum = u32::from(*digit) * u32::from(factor) + carry;
            *digit = (sum % 10) as u8;
            carry = sum / 10;
        }
        while carry > 0 {
            number.insert(0, (carry % 10) as u8);
            carry /= 10;
        }
    };
    let power = exponent - 1;
    for _ in 0..power.unsigned_abs() {
        scale(&mut number, if power < 0 { 5 } else { 2 });
    }
    assert!(x.is_finite());
    digits.extend(number.iter().map(|digit| char::from(digit + b'0')));
    let digits: String = digits.into_iter().collect();
    if power < 0 { format!("{digits}e{power}") } else { digits }
}

proptest! {
    #[test]
    fn numbers_are_those_of_the_library(
        text in "[+-]?[0-9]{0,25}(\\.[0-9]{0,25})?([eE][+-]?[0-9]{1,3})?",
    ) {
        compare(&text)?;
    }

    #[test]
    fn what_people_write_is_read_as_by_the_library(text in "-?[0-9]{1,7}(\\.[0-9]{0,9})?") {
        compare(&text)?;
    }

    #[test]
    fn numbers_printed_read_back(bits in any::<u64>(), short in any::<u32>()) {
        for text in [format!("{:e}", f64::from_bits(bits)), format!("{}", f64::from_bits(bits))] {
            compare(&text)?;
        }
        compare(&format!("{}", f32::from_bits(short)))?;
    }

    #[test]
    fn any_text_is_taken_or_refused_as_by_the_library(text in "[-+.eE0-9infatyINFx ]{0,12}") {
        compare(&text)?;
    }

}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn ties_are_decided_by_the_last_of_hundreds_of_digits(
        bits in any::<u64>(), small in 0_u64..1 << 54, zeros in 0_usize..60,
    ) {
        for bits in [bits & (u64::MAX >> 1), small] {
            prop_assume!(f64::from_bits(bits).is_finite());
            let tie = halfway(bits);
            compare(&tie)?;
            let (digits, exponent) = tie.split_once('e').unwrap_or((&tie, "0"));
            let exponent: i32 = exponent.parse().unwrap();
            let below: String = format!("{}4{}", &digits[..digits.len() - 1], "9".repeat(zeros));
            let above: String = format!("{digits}{}1", "0".repeat(zeros));
            compare(&format!("{below}e{}", exponent - zeros as i32))?;
            compare(&format!("{above}e{}", exponent - zeros as i32 - 1))?;
        }
    }

    #[test]
    fn ties_between_short_numbers_are_decided_once(bits in 0_u32..0x7F80_0000, below in any::<bool>()) {
        let x = f64::from(f32::from_bits(bits));
        let tie = x + (f64::from(f32::from_bits(bits + 1)) - x) / 2.0;
        prop_assume!(tie.is_finite());
        compare(&format!("{tie:e}"))?;
        let beside = f64::from_bits(tie.to_bits() + u64::from(!below) - u64::from(below));
        compare(&format!("{beside:e}"))?;
    }
}

#[test]
fn the_ends_of_the_range_are_those_of_the_library() {
    let texts = [
        "1.7976931348623157e308",
        "1.7976931348623158e308",
        "1.7976931348623159e308",
        "1e309",
        "1e310",
        "1e999999999999999",
        "4.9406564584124654e-324",
        "2.4703282292062327e-324",
        "2.4703282292062328e-324",
        "1e-323",
        "1e-324",
        "1e-325",
        "1e-99999999999999999999",
        "0e999999999",
        "-0",
        "-0.0e5",
        "00000000000000000000000000000000001",
        "9007199254740993",
        "3.4028235e38",
        "3.4028236e38",
        "3.40282357e38",
        "1.4e-45",
        "7e-46",
        "7.1e-46",
        "1.1754943e-38",
        "1e23",
        "8.5e22",
        "",
        "+",
        "-",
        ".",
        "e5",
        ".e5",
        "1e",
        "1e+",
        "+-1",
        "1.2.3",
        "1 ",
        " 1",
        "1_0",
        "0x1",
        "INF",
        "-infinity",
        "NaN",
        "in",
        "16777217",
        "16777217.0000000000000000000000000001",
        "123456789.123456789",
        ".5",
        "5.",
        "5.e1",
    ];
    for text in texts {
        compare(text).unwrap();
    }
    let long = [format!("0.{}1", "0".repeat(2_000)), format!("1{}", "0".repeat(400)), format!("{}.5", "9".repeat(900))];
    let scaled = [format!("{}e-1000", "7".repeat(1_200)), format!("0.{}3e1500", "0".repeat(1_499))];
    for text in long.iter().chain(&scaled) {
        compare(text).unwrap();
    }
}

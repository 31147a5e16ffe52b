//! Decimal texts to the nearest binary numbers, ties to even: the texts that the standard library takes, and
//! the numbers that it makes of them.
//!
//! The library's reader is made for megabytes of numbers and brings 16 kB of code and powers of five. Here a
//! number of up to 15 digits is one division, as in `crate::number`, and a longer one, which hardly anybody
//! writes, a long division.

mod big;
#[cfg(test)]
mod tests;

use crate::number::{EXACT, POWERS_OF_TEN};
use big::Big;

/// A binary format.
struct Format {
    /// Bits of the significand.
    bits: u32,
    /// Exponents of the least bit, of the smallest numbers and of the greatest.
    exponents: (i32, i32),
    /// Greatest integer of a quick division or multiplication, and of the power of ten in it.
    quick: (u64, i64),
}

const F64: Format = Format { bits: 53, exponents: (-1074, 971), quick: (EXACT, 22) };
/// Divided as `f64`: with operands of 24 bits, rounding twice is as good as once.
const F32: Format = Format { bits: 24, exponents: (-149, 104), quick: (1 << 24, 10) };

/// Digits that can decide: a place halfway between two numbers has at most 767 of them.
const MOST_DIGITS: i64 = 770;
/// Numbers of so many digits before the point are infinite.
const HUGE: i64 = 310;
/// Numbers below this power of ten are nothing.
const TINY: i64 = -324;
/// Exponents are read up to here, and all beyond are alike.
const FAR: i64 = 1 << 40;

/// A magnitude as it was read.
enum Reading {
    Number(f64),
    /// The number's bits, in the format that was asked for.
    Bits(u64),
}

/// Reads a number as `str::parse` does: with a sign, a point and an exponent, or `inf` and `nan`.
#[must_use]
pub fn read_f64(text: &str) -> Option<f64> {
    let (sign, magnitude) = sign(text.as_bytes());
    Some(match read(magnitude, &F64)? {
        Reading::Number(number) => sign * number,
        Reading::Bits(bits) => sign * f64::from_bits(bits),
    })
}

/// Reads a number as `str::parse` does, rounded once.
#[must_use]
pub fn read_f32(text: &str) -> Option<f32> {
    let (sign, magnitude) = sign(text.as_bytes());
    Some(match read(magnitude, &F32)? {
        Reading::Number(number) => (sign * number) as f32,
        Reading::Bits(bits) => sign as f32 * f32::from_bits(bits as u32),
    })
}

fn sign(text: &[u8]) -> (f64, &[u8]) {
    match text {
        [b'-', rest @ ..] => (-1.0, rest),
        [b'+', rest @ ..] => (1.0, rest),
        _ => (1.0, text),
    }
}

fn read(magnitude: &[u8], format: &Format) -> Option<Reading> {
    let Some(decimal) = Decimal::scan(magnitude) else {
        return word(magnitude).map(Reading::Number);
    };
    let quick = decimal.quick(format).map(Reading::Number);
    quick.or_else(|| Some(Reading::Bits(decimal.round(format))))
}

/// What is no number and yet has a value.
fn word(text: &[u8]) -> Option<f64> {
    let is = |word: &str| text.eq_ignore_ascii_case(word.as_bytes());
    match () {
        () if is("inf") || is("infinity") => Some(f64::INFINITY),
        () if is("nan") => Some(f64::NAN),
        () => None,
    }
}

/// Digits, with a point among them or without, times a power of ten.
struct Decimal<'a> {
    digits: &'a [u8],
    exponent: i64,
}

impl<'a> Decimal<'a> {
    fn scan(text: &'a [u8]) -> Option<Self> {
        let digits_of = |text: &[u8]| text.iter().take_while(|byte| byte.is_ascii_digit()).count();
        let whole = digits_of(text);
        let mut length = whole;
        let mut decimals = 0;
        if text.get(whole) == Some(&b'.') {
            decimals = digits_of(text.get(whole + 1..)?);
            length += 1 + decimals;
        }
        if whole + decimals == 0 {
            return None;
        }
        let (digits, rest) = text.split_at_checked(length)?;
        let exponent = match rest {
            [] => 0,
            [b'e' | b'E', rest @ ..] => exponent(rest)?,
            _ => return None,
        };
        Some(Self { digits, exponent: exponent - i64::try_from(decimals).ok()? })
    }

    fn digits(&self) -> impl Iterator<Item = u32> {
        self.digits.iter().filter(|byte| **byte != b'.').map(|byte| u32::from(byte.wrapping_sub(b'0')))
    }

    /// The number, if one division or multiplication of exact numbers gives it.
    fn quick(&self, format: &Format) -> Option<f64> {
        let (most, power) = format.quick;
        let mantissa =
            self.digits().try_fold(0_u64, |sum, digit| sum.checked_mul(10)?.checked_add(u64::from(digit)))?;
        if mantissa > most || self.exponent.abs() > power {
            return None;
        }
        let power = POWERS_OF_TEN.get(usize::try_from(self.exponent.unsigned_abs()).ok()?)?;
        Some(if self.exponent < 0 { mantissa as f64 / power } else { mantissa as f64 * power })
    }

    /// The bits of the nearest number.
    fn round(&self, format: &Format) -> u64 {
        let mut number = Big::from(0);
        let mut exponent = self.exponent;
        let mut count = 0;
        let mut has_more = false;
        for digit in self.digits().skip_while(|digit| *digit == 0) {
            if count < MOST_DIGITS {
                number.scale(10, digit);
                count += 1;
            } else {
                has_more |= digit > 0;
                exponent += 1;
            }
        }
        match count + exponent {
            _ if count == 0 => 0,
            order if order <= TINY => 0,
            order if order > HUGE => format.infinity(),
            _ => format.nearest(number, exponent, has_more),
        }
    }
}

/// The exponent that a text is.
fn exponent(text: &[u8]) -> Option<i64> {
    let (sign, digits) = sign(text);
    let is_number = !digits.is_empty() && digits.iter().all(u8::is_ascii_digit);
    let magnitude = digits.iter().fold(0, |sum, byte| (sum * 10 + i64::from(byte.wrapping_sub(b'0'))).min(FAR));
    is_number.then_some(if sign < 0.0 { -magnitude } else { magnitude })
}

impl Format {
    fn infinity(&self) -> u64 {
        let (least, most) = self.exponents;
        ((most - least + 2) as u64) << (self.bits - 1)
    }

    /// The bits nearest to a number times a power of ten, or, if there are more digits, to a little more.
    fn nearest(&self, mut above: Big, exponent: i64, has_more: bool) -> u64 {
        let mut below = Big::from(1);
        for _ in 0..exponent.unsigned_abs() {
            if exponent < 0 { below.scale(10, 0) } else { above.scale(10, 0) }
        }
        // The quotient gets two or three bits more than a significand.
        let (least, _) = self.exponents;
        let unit = (above.bits() - below.bits() - self.bits as i32 - 2).max(least - 2);
        if unit < 0 {
            above.shift(unit.unsigned_abs())
        } else {
            below.shift(unit.unsigned_abs())
        }
        let quotient = above.divide(&mut below, self.bits + 3);
        let length = (u64::BITS - quotient.leading_zeros()) as i32;
        let dropped = (length - self.bits as i32).max(least - unit);
        let half = 1 << (dropped - 1);
        let rest = quotient & (2 * half - 1);
        let significand = quotient >> dropped;
        let is_above = has_more || !above.is_zero();
        let is_up = rest > half || rest == half && (is_above || significand & 1 == 1);
        // The significand's first bit counts the exponent up by one, as the format has it.
        let field = ((unit + dropped - least) as u64) << (self.bits - 1);
        (field + significand + u64::from(is_up)).min(self.infinity())
    }
}

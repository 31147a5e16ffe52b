//! Numbers of JSON, read digit by digit.

use crate::limits::NUMBER_BYTES;

/// Number as it was written: digits, and a power of ten.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Number {
    is_negative: bool,
    digits: u64,
    /// Power of ten that the digits are to be multiplied by.
    power: i32,
    /// Whether digits were dropped.
    is_rounded: bool,
}

impl Number {
    /// Returns the number, if it is a whole one within the range of the type.
    #[must_use]
    pub fn as_i64(self) -> Option<i64> {
        let mut digits = self.digits;
        if self.is_rounded {
            return None;
        }
        for _ in 0..self.power.unsigned_abs() {
            if digits == 0 {
                break;
            }
            digits = if self.power > 0 {
                digits.checked_mul(10)?
            } else if digits.is_multiple_of(10) {
                digits / 10
            } else {
                return None;
            };
        }
        if self.is_negative { 0_i64.checked_sub_unsigned(digits) } else { digits.try_into().ok() }
    }

    /// Returns the number, the nearest one but for the last bit where it is not whole and has more than 15
    /// digits or a power beyond 22. Always finite.
    #[must_use]
    pub fn as_f64(self) -> f64 {
        if let Some(whole) = self.as_i64().filter(|whole| *whole != 0) {
            return whole as f64;
        }
        let mut value = self.digits as f64;
        let mut left = self.power.unsigned_abs();
        while left > 0 && value != 0.0 {
            let now = left.min(300);
            let scale = power_of_ten(now);
            value = if self.power > 0 { value * scale } else { value / scale };
            left -= now;
        }
        if self.is_negative { -value } else { value }
    }
}

/// Returns a power of ten, exact up to 22.
fn power_of_ten(power: u32) -> f64 {
    const POWERS: [f64; 9] = [1e1, 1e2, 1e4, 1e8, 1e16, 1e32, 1e64, 1e128, 1e256];
    let set = POWERS.iter().enumerate().filter(|(bit, _)| power >> bit & 1 != 0);
    set.fold(1.0, |product, (_, power)| product * power)
}

/// Place in the grammar of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Sign,
    Zero,
    Digits,
    Point,
    Fraction,
    Exponent,
    ExponentSign,
    Power,
}

/// Reader of a number.
#[derive(Clone, Copy, Debug)]
pub struct Reader {
    place: Place,
    number: Number,
    bytes: u8,
    exponent: i32,
    is_small: bool,
}

impl Reader {
    /// Begins with the first character. None if no number begins with it.
    pub fn begin(byte: u8) -> Option<Self> {
        let place = match byte {
            b'-' => Place::Sign,
            b'0' => Place::Zero,
            b'1'..=b'9' => Place::Digits,
            _ => return None,
        };
        let digits = if byte == b'-' { 0 } else { u64::from(byte - b'0') };
        let number = Number { is_negative: byte == b'-', digits, power: 0, is_rounded: false };
        Some(Self { place, number, bytes: 1, exponent: 0, is_small: false })
    }

    /// Takes the next character. False if it belongs to no number.
    pub fn push(&mut self, byte: u8) -> bool {
        let next = match (self.place, byte) {
            (Place::Sign, b'0') => Place::Zero,
            (Place::Sign, b'1'..=b'9') | (Place::Digits, b'0'..=b'9') => Place::Digits,
            (Place::Zero | Place::Digits, b'.') => Place::Point,
            (Place::Point | Place::Fraction, b'0'..=b'9') => Place::Fraction,
            (Place::Zero | Place::Digits | Place::Fraction, b'e' | b'E') => Place::Exponent,
            (Place::Exponent, b'+' | b'-') => Place::ExponentSign,
            (Place::Exponent | Place::ExponentSign | Place::Power, b'0'..=b'9') => Place::Power,
            _ => return false,
        };
        self.place = next;
        self.bytes = self.bytes.saturating_add(1);
        match next {
            Place::Digits | Place::Fraction => self.digit(byte - b'0', next == Place::Fraction),
            Place::Power => self.exponent = (self.exponent * 10 + i32::from(byte - b'0')).min(10_000),
            Place::ExponentSign => self.is_small = byte == b'-',
            Place::Sign | Place::Zero | Place::Point | Place::Exponent => {}
        }
        true
    }

    fn digit(&mut self, digit: u8, is_fraction: bool) {
        let number = &mut self.number;
        match number.digits.checked_mul(10).and_then(|digits| digits.checked_add(u64::from(digit))) {
            Some(digits) if !number.is_rounded => {
                number.digits = digits;
                number.power -= i32::from(is_fraction);
            }
            _ => {
                number.is_rounded = true;
                number.power += i32::from(!is_fraction);
            }
        }
    }

    /// Returns whether the number has become too long.
    pub const fn is_too_long(&self) -> bool {
        self.bytes > NUMBER_BYTES
    }

    /// Ends the number. None if it cannot end here, or if it is out of range.
    pub fn end(&self) -> Option<Number> {
        if !matches!(self.place, Place::Zero | Place::Digits | Place::Fraction | Place::Power) {
            return None;
        }
        let power = self.number.power + if self.is_small { -self.exponent } else { self.exponent };
        let number = Number { power, ..self.number };
        number.as_f64().is_finite().then_some(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Option<Number> {
        let (first, rest) = text.as_bytes().split_first()?;
        let mut reader = Reader::begin(*first)?;
        rest.iter().all(|byte| reader.push(*byte)).then(|| reader.end())?
    }

    #[test]
    fn whole_numbers_are_exact() {
        for (text, number) in [
            ("0", Some(0)),
            ("-0", Some(0)),
            ("9223372036854775807", Some(i64::MAX)),
            ("-9223372036854775808", Some(i64::MIN)),
            ("9223372036854775808", None),
            ("18446744073709551616", None),
            ("99999999999999999999", None),
            ("1.0", Some(1)),
            ("-12.50e1", Some(-125)),
            ("1e18", Some(1_000_000_000_000_000_000)),
            ("1e19", None),
            ("1e300", None),
            ("0e300", Some(0)),
            ("1.5", None),
            ("1e-1", None),
            ("10e-1", Some(1)),
            ("92233720368547758075e-1", None),
        ] {
            assert_eq!(read(text).expect(text).as_i64(), number, "{text}");
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for text in [
            "",
            "-",
            "+1",
            ".5",
            "1.",
            "1.e1",
            "01",
            "-01",
            "1e",
            "1e+",
            "1e1.0",
            "0x1",
            "1e400",
            "NaN",
            "--1",
            "1e99999999999",
        ] {
            assert_eq!(read(text), None, "{text}");
        }
    }

    #[test]
    fn numbers_are_the_nearest_ones() {
        for text in [
            "0",
            "1",
            "-1.5",
            "0.1",
            "12.345",
            "123456789012345",
            "1e22",
            "1e-22",
            "3.0e-5",
            "200.0",
            "1E+2",
            "0.000001",
            "15e1",
            "15e-1",
            "1e2",
            "5e-324",
            "1e-400",
            "0.30000000000000004",
        ] {
            assert_eq!(read(text).expect(text).as_f64(), text.parse::<f64>().unwrap(), "{text}");
        }
        for text in [
            "1.7976931348623157e308",
            "123456789012345678901234567890",
            "3.14159265358979323846264338327",
            "1e-300",
            "-9e200",
        ] {
            let (ours, exact) = (read(text).expect(text).as_f64(), text.parse::<f64>().unwrap());
            assert!(((ours - exact) / exact).abs() < 1e-15, "{text}: {ours} {exact}");
        }
    }
}

//! Digits of numbers: whole ones in any base, real ones exactly.
//!
//! A real number is a whole number times a power of two, so it has an end in decimal too: all its digits are
//! made, nine to a word, and rounded where they are cut. Nothing is rounded twice.

use crate::chars;

/// A word holds so many digits.
const DIGITS: i32 = 9;
const BASE: u32 = 1_000_000_000;
/// Words of the greatest whole part, 309 digits, and one for a carry.
const UNITS: usize = 36;
/// Words behind the point: the smallest number has 1074 digits there.
const WORDS: usize = UNITS + 1 + 120;

/// Digits of a whole number.
pub struct Integer {
    bytes: [u8; 64],
    first: usize,
}

impl Integer {
    /// The digits of a number in a base of up to 16.
    pub fn new(mut value: u64, base: u64) -> Self {
        let mut integer = Self { bytes: [b'0'; 64], first: 64 };
        while integer.first > 0 && (value > 0 || integer.first == 64) {
            integer.first -= 1;
            let digit = (value % base) as u8;
            if let Some(byte) = integer.bytes.get_mut(integer.first) {
                *byte = if digit < 10 { b'0' + digit } else { b'a' + digit - 10 };
            }
            value /= base;
        }
        integer
    }

    /// The digits as text.
    pub fn text(&mut self) -> &str {
        core::str::from_utf8(self.bytes.get(self.first..).unwrap_or_default()).unwrap_or_default()
    }
}

/// Unit of a power of ten within its word.
fn unit(power: i32) -> u32 {
    10_u32.pow(power.rem_euclid(DIGITS) as u32)
}

/// Decimal digits of a real number without its sign.
#[derive(Clone)]
pub struct Decimal {
    words: [u32; WORDS],
    first: usize,
    end: usize,
}

impl Decimal {
    /// All digits of a number, which is not infinite.
    pub fn new(value: f64) -> Self {
        let bits = value.to_bits();
        let field = (bits >> 52 & 0x7ff) as i32;
        let fraction = bits & ((1 << 52) - 1);
        let (mut mantissa, mut exponent) =
            if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) };
        if mantissa != 0 {
            let zeros = mantissa.trailing_zeros();
            mantissa >>= zeros;
            exponent += zeros as i32;
        }
        let mut decimal = Self { words: [0; WORDS], first: UNITS, end: UNITS + 1 };
        let base = u64::from(BASE);
        decimal.set(UNITS, (mantissa % base) as u32);
        decimal.set(UNITS - 1, (mantissa / base) as u32);
        decimal.first = UNITS - 1;
        while exponent > 0 {
            let shift = exponent.min(29);
            decimal.double(shift as u32);
            exponent -= shift;
        }
        while exponent < 0 {
            let shift = (-exponent).min(9);
            decimal.halve(shift as u32);
            exponent += shift;
        }
        decimal.skip_zeros();
        decimal
    }

    fn get(&self, index: usize) -> u32 {
        self.words.get(index).copied().unwrap_or(0)
    }

    fn set(&mut self, index: usize, word: u32) {
        if let Some(place) = self.words.get_mut(index) {
            *place = word;
        }
    }

    fn skip_zeros(&mut self) {
        while self.first < self.end && self.get(self.first) == 0 {
            self.first += 1;
        }
    }

    fn double(&mut self, shift: u32) {
        let mut carry = 0;
        for index in (self.first..self.end).rev() {
            let value = (u64::from(self.get(index)) << shift) + carry;
            self.set(index, (value % u64::from(BASE)) as u32);
            carry = value / u64::from(BASE);
        }
        if carry > 0 {
            self.first -= 1;
            self.set(self.first, carry as u32);
        }
    }

    fn halve(&mut self, shift: u32) {
        let mut carry = 0;
        for index in self.first..self.end {
            let word = self.get(index);
            self.set(index, (word >> shift) + carry);
            carry = (BASE >> shift) * (word & ((1 << shift) - 1));
        }
        if carry > 0 && self.end < WORDS {
            self.set(self.end, carry);
            self.end += 1;
        }
    }

    /// Power of ten of the first digit; none for zero.
    pub fn leading(&self) -> Option<i32> {
        let word = self.get(self.first);
        (self.first < self.end && word > 0).then(|| DIGITS * (UNITS as i32 - self.first as i32) + word.ilog10() as i32)
    }

    /// Power of ten of the last digit that is not 0.
    pub fn trailing(&self) -> i32 {
        let mut end = self.end;
        while end > self.first && self.get(end - 1) == 0 {
            end -= 1;
        }
        let mut word = self.get(end.saturating_sub(1));
        let mut power = DIGITS * (UNITS as i32 - end as i32 + 1);
        while word > 0 && word.is_multiple_of(10) {
            word /= 10;
            power += 1;
        }
        power
    }

    /// The digit of a power of ten.
    pub fn digit(&self, power: i32) -> u8 {
        let index = UNITS as i32 - power.div_euclid(DIGITS);
        let is_there = index >= self.first as i32 && index < self.end as i32;
        let word = if is_there { self.get(index as usize) } else { 0 };
        b'0' + (word.checked_div(unit(power)).unwrap_or(0) % 10) as u8
    }

    /// Rounds so that the digit of this power of ten is the last; halves go to the even digit.
    pub fn round(&mut self, power: i32) {
        let index = UNITS as i32 - power.div_euclid(DIGITS);
        if index >= self.end as i32 {
            return;
        }
        if index < 1 || self.leading().is_none_or(|leading| power > leading + 1) {
            self.first = self.end;
            return;
        }
        let index = index as usize;
        while self.first > index {
            self.first -= 1;
            self.set(self.first, 0);
        }
        let unit = unit(power);
        let word = self.get(index);
        let rest = word.checked_rem(unit).unwrap_or(0);
        let (part, half, next) =
            if unit > 1 { (rest, unit / 2, index + 1) } else { (self.get_in(index + 1), BASE / 2, index + 2) };
        let has_more = (next..self.end).any(|index| self.get(index) > 0);
        let is_odd = word.checked_div(unit).unwrap_or(0) % 2 == 1;
        let is_up = part > half || part == half && (has_more || is_odd);
        self.set(index, word - rest + if is_up { unit } else { 0 });
        self.end = index + 1;
        let mut place = index;
        while self.get(place) >= BASE && place > 0 {
            self.set(place, self.get(place) - BASE);
            place -= 1;
            if place < self.first {
                self.first = place;
                self.set(place, 0);
            }
            self.set(place, self.get(place) + 1);
        }
        self.skip_zeros();
    }

    fn get_in(&self, index: usize) -> u32 {
        if index < self.end { self.get(index) } else { 0 }
    }
}

/// The shortest digits that read back as the number, and the power of ten of the first.
pub struct Shortest {
    bytes: [u8; 32],
    /// Number of digits that are used.
    pub count: usize,
    /// Power of ten of the first digit.
    pub power: i32,
}

impl Shortest {
    /// The digits of a number, which is not infinite; its sign does not count.
    pub fn new(value: f64) -> Self {
        let value = libm::fabs(value);
        let Some(leading) = Decimal::new(value).leading() else {
            return Self { bytes: [b'0'; 32], count: 1, power: 0 };
        };
        let least = if value < f64::MIN_POSITIVE { 1 } else { 15 };
        let mut shortest = Self::of(value, leading, least);
        for count in least + 1..=17 {
            if shortest.read() == Some(value) {
                break;
            }
            shortest = Self::of(value, leading, count);
        }
        shortest
    }

    /// So many digits of a number, without zeros at their end.
    fn of(value: f64, leading: i32, count: i32) -> Self {
        let mut decimal = Decimal::new(value);
        decimal.round(leading - count + 1);
        let power = decimal.leading().unwrap_or(0);
        let mut shortest = Self { bytes: [b'0'; 32], count: 0, power };
        for place in (decimal.trailing()..=power).rev() {
            if let Some(byte) = shortest.bytes.get_mut(shortest.count) {
                *byte = decimal.digit(place);
                shortest.count += 1;
            }
        }
        shortest
    }

    /// The digits, without zeros at their end.
    pub fn digits(&self) -> &[u8] {
        self.bytes.get(..self.count).unwrap_or_default()
    }

    fn read(&self) -> Option<f64> {
        let exponent = self.power - self.count as i32 + 1;
        read(self.digits(), exponent)
    }
}

/// Product, unless it is beyond 64 bits.
#[inline(never)]
pub fn product(a: i64, b: i64) -> Option<i64> {
    a.checked_mul(b)
}

/// The negative of the number that digits are, of which there is one more; none for other characters.
#[inline(never)]
pub fn negative(digits: &[u8], base: u32) -> Option<i64> {
    if digits.is_empty() || !(2..=36).contains(&base) {
        return None;
    }
    let mut value = 0;
    for byte in digits {
        let digit = chars::digit(*byte, base)?;
        value = product(value, i64::from(base))?.checked_sub(i64::from(digit))?;
    }
    Some(value)
}

/// The number nearest to digits times a power of ten.
pub fn read(digits: &[u8], exponent: i32) -> Option<f64> {
    let mut text: heapless::String<64> = heapless::String::new();
    text.push_str(core::str::from_utf8(digits).ok()?).ok()?;
    text.push_str(if exponent < 0 { "e-" } else { "e" }).ok()?;
    text.push_str(Integer::new(u64::from(exponent.unsigned_abs()), 10).text()).ok()?;
    gcode::read_f64(&text)
}

/// A number rounded to a place behind the point (before it if negative), as Python's `round` does it.
pub fn rounded(value: f64, decimals: i32) -> f64 {
    if !value.is_finite() || decimals > 340 {
        return value;
    }
    let mut decimal = Decimal::new(libm::fabs(value));
    decimal.round(-decimals.max(-330));
    let Some(leading) = decimal.leading() else { return libm::copysign(0.0, value) };
    let mut digits = [b'0'; 32];
    let trailing = decimal.trailing().max(leading - 31);
    for (byte, power) in digits.iter_mut().zip((trailing..=leading).rev()) {
        *byte = decimal.digit(power);
    }
    let count = (leading - trailing + 1) as usize;
    let read = read(digits.get(..count).unwrap_or_default(), trailing);
    read.map_or(value, |read| libm::copysign(read, value))
}

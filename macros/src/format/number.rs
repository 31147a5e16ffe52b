//! Numbers by a form.

use super::{Spec, align};
use crate::digits::{Decimal, Integer};
use crate::fault::{About, Fault, Result, Words};
use crate::memory::Memory;
use crate::run::print::{write_exponent, write_float};

fn sign(memory: &mut Memory<'_>, is_negative: bool, spec: &Spec) {
    match (is_negative, spec.sign) {
        (true, _) => memory.push_byte(b'-'),
        (false, sign @ (b'+' | b' ')) => memory.push_byte(sign),
        _ => (),
    }
}

/// Appends digits with a comma or a `_` between groups of three.
fn grouped(memory: &mut Memory<'_>, count: i32, comma: u8, digit: impl Fn(i32) -> u8) {
    for place in (0..count).rev() {
        memory.push_byte(digit(place));
        if comma != 0 && place > 0 && place % 3 == 0 {
            memory.push_byte(comma);
        }
    }
}

/// Appends a whole number by a form: `d x X o b c`.
pub fn write_int(memory: &mut Memory<'_>, value: i64, spec: &Spec) -> Result<()> {
    let from = memory.top;
    if spec.form == b'c' {
        let char = u32::try_from(value).ok().and_then(char::from_u32);
        let Some(char) = char else { return Err(memory.fault(Words::NoCharacter)) };
        memory.push_char(char);
        align(memory, from, 0, spec, b'<');
        return Ok(());
    }
    let (base, prefix): (u64, &[u8]) = match spec.form {
        b'x' => (16, b"0x"),
        b'X' => (16, b"0X"),
        b'o' => (8, b"0o"),
        b'b' => (2, b"0b"),
        _ => (10, b""),
    };
    sign(memory, value < 0, spec);
    if spec.is_alternate {
        memory.push_bytes(prefix);
    }
    let prefix = memory.top - from;
    let mut digits = Integer::new(value.unsigned_abs(), base);
    let digits = digits.text().as_bytes();
    let count = digits.len();
    let digit = |place: i32| {
        let byte = digits.get(count - 1 - place as usize).copied().unwrap_or(b'0');
        if spec.form == b'X' { byte.to_ascii_uppercase() } else { byte }
    };
    memory.push_chars('0', spec.precision.unwrap_or(0).saturating_sub(count));
    grouped(memory, count as i32, spec.comma, digit);
    align(memory, from, prefix, spec, b'>');
    Ok(())
}

/// Appends a real number by a form: `f F e E g G %`, or none.
pub fn write_real(memory: &mut Memory<'_>, value: f64, spec: &Spec) -> Result<()> {
    let from = memory.top;
    let is_negative = value.is_sign_negative() && !value.is_nan();
    sign(memory, is_negative, spec);
    let prefix = memory.top - from;
    let value = libm::fabs(value);
    let precision = spec.precision.unwrap_or(6) as i32;
    if !value.is_finite() {
        memory.push_bytes(if value.is_nan() { b"nan" } else { b"inf" });
        if spec.form == b'%' {
            memory.push_byte(b'%');
        }
    } else {
        match spec.form {
            b'f' | b'F' => fixed(memory, value, precision, spec),
            b'%' => {
                fixed(memory, value * 100.0, precision, spec);
                memory.push_byte(b'%');
            }
            b'e' | b'E' => exponential(memory, &mut Decimal::new(value), precision, spec.is_alternate),
            b'g' | b'G' => general(memory, value, precision.max(1), spec, false),
            0 if spec.precision.is_none() && spec.comma == 0 => write_float(memory, value),
            0 => general(memory, value, spec.precision.map_or(17, |precision| precision.max(1) as i32), spec, true),
            form => {
                let words = Words::FormMisfit;
                return Err(Fault::with(memory, words, About::Byte(form)));
            }
        }
    }
    if spec.form.is_ascii_uppercase() {
        memory.make_upper(from);
    }
    align(memory, from, prefix, spec, b'>');
    Ok(())
}

fn fixed(memory: &mut Memory<'_>, value: f64, decimals: i32, spec: &Spec) {
    let mut decimal = Decimal::new(value);
    decimal.round(-decimals);
    places(memory, &decimal, decimals, spec)
}

/// Appends the digits before the point and so many behind it.
fn places(memory: &mut Memory<'_>, decimal: &Decimal, decimals: i32, spec: &Spec) {
    let whole = decimal.leading().unwrap_or(0).max(0) + 1;
    grouped(memory, whole, spec.comma, |place| decimal.digit(place));
    if decimals > 0 || spec.is_alternate {
        memory.push_byte(b'.');
    }
    (1..=decimals).for_each(|place| memory.push_byte(decimal.digit(-place)));
}

fn exponential(memory: &mut Memory<'_>, decimal: &mut Decimal, decimals: i32, has_point: bool) {
    if let Some(leading) = decimal.leading() {
        decimal.round(leading - decimals);
    }
    let leading = decimal.leading().unwrap_or(0);
    memory.push_byte(decimal.digit(leading));
    if decimals > 0 || has_point {
        memory.push_byte(b'.');
    }
    (1..=decimals).for_each(|place| memory.push_byte(decimal.digit(leading - place)));
    write_exponent(memory, leading)
}

/// So many digits, in the shorter of both ways; without a form a point stays in any case.
fn general(memory: &mut Memory<'_>, value: f64, digits: i32, spec: &Spec, is_plain: bool) {
    let mut decimal = Decimal::new(value);
    if let Some(leading) = decimal.leading() {
        decimal.round(leading - digits + 1);
    }
    let leading = decimal.leading().unwrap_or(0);
    let last = if decimal.leading().is_none() { 0 } else { decimal.trailing() };
    let is_short =
        leading >= -4 && if is_plain { leading < digits - 1 || digits > 16 && leading < 16 } else { leading < digits };
    if is_short {
        let most = digits - 1 - leading;
        let decimals =
            if spec.is_alternate { most } else { (-last).max(i32::from(is_plain)).min(most.max(i32::from(is_plain))) };
        return places(memory, &decimal, decimals.max(0), spec);
    }
    let decimals = if spec.is_alternate { digits - 1 } else { (leading - last).max(0) };
    exponential(memory, &mut decimal, decimals, spec.is_alternate)
}

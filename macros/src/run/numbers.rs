//! Arithmetic, and numbers from texts, by Python's rules.

use super::{Run, wrong};
use crate::code::Op;
use crate::digits::{negative, product};
use crate::fault::{Fault, Result, Words};
use crate::memory::Memory;
use crate::number::{Number, float, number};
use crate::value::{Seq, Value, types};

/// Result of an operator with two sides.
pub fn calculate(run: &mut Run<'_, '_>, op: Op, a: Value, b: Value) -> Result<Value> {
    if let (Some(first), Some(second)) = (number(&run.memory, a), number(&run.memory, b)) {
        if matches!(op, Op::Divide | Op::FloorDivide | Op::Modulo) && float(second) == 0.0 {
            return run.memory.fail(Words::ZeroDivision);
        }
        return match (first, second) {
            (Number::Int(a), Number::Int(b)) => integers(&mut run.memory, op, a, b),
            (a, b) => floats(&run.memory, op, float(a), float(b)),
        };
    }
    if a.is_undefined() || b.is_undefined() {
        return Err(wrong(&run.memory, Words::WantsNumber, if a.is_undefined() { a } else { b }));
    }
    match op {
        Op::Add => add(run, a, b),
        Op::Multiply => repeat(run, a, b),
        _ => Err(no_number(&run.memory, a, b)),
    }
}

/// The fault that one of two values is no number.
fn no_number(memory: &Memory<'_>, a: Value, b: Value) -> Fault {
    wrong(memory, Words::WantsNumber, if number(memory, a).is_some() { b } else { a })
}

fn integers(memory: &mut Memory<'_>, op: Op, a: i64, b: i64) -> Result<Value> {
    let result = match op {
        Op::Add => a.checked_add(b),
        Op::Subtract => a.checked_sub(b),
        Op::Multiply => product(a, b),
        Op::FloorDivide => divided(a, b).map(|(quotient, _)| quotient),
        Op::Modulo => divided(a, b).map(|(_, rest)| rest),
        Op::Power if b >= 0 => whole_power(a, b),
        _ => return floats(memory, op, a as f64, b as f64),
    };
    match result {
        Some(int) => Ok(memory.int(int)),
        None => memory.fail(Words::Overflow),
    }
}

/// Power that is not negative, unless it is beyond 64 bits.
pub fn whole_power(a: i64, power: i64) -> Option<i64> {
    if matches!(a, -1..=1) && power > 0 {
        return Some(if power % 2 == 0 { a * a } else { a });
    }
    let mut result = 1;
    for _ in 0..power {
        result = product(result, a)?;
    }
    Some(result)
}

/// Quotient rounded down, and the rest that has the sign of the divisor.
pub fn divided(a: i64, b: i64) -> Option<(i64, i64)> {
    let (quotient, rest) = (a.checked_div(b)?, a.checked_rem(b)?);
    let is_up = rest != 0 && (rest < 0) != (b < 0);
    Some(if is_up { (quotient - 1, rest + b) } else { (quotient, rest) })
}

fn floats(memory: &Memory<'_>, op: Op, a: f64, b: f64) -> Result<Value> {
    Ok(Value::float(match op {
        Op::Add => a + b,
        Op::Subtract => a - b,
        Op::Multiply => a * b,
        Op::Divide => a / b,
        Op::FloorDivide => floor_division(a, b).0,
        Op::Modulo => floor_division(a, b).1,
        _ => return power(memory, a, b),
    }))
}

/// Quotient rounded down, and the rest that has the sign of the divisor.
fn floor_division(a: f64, b: f64) -> (f64, f64) {
    let mut rest = libm::fmod(a, b);
    let mut quotient = (a - rest) / b;
    if rest == 0.0 {
        rest = libm::copysign(0.0, b);
    } else if (b < 0.0) != (rest < 0.0) {
        rest += b;
        quotient -= 1.0;
    }
    if quotient == 0.0 {
        return (libm::copysign(0.0, a / b), rest);
    }
    let whole = libm::floor(quotient);
    (if quotient - whole > 0.5 { whole + 1.0 } else { whole }, rest)
}

fn power(memory: &Memory<'_>, a: f64, b: f64) -> Result<Value> {
    if a == 0.0 && b < 0.0 {
        return memory.fail(Words::ZeroDivision);
    }
    if a < 0.0 && a.is_finite() && b.is_finite() && b != libm::trunc(b) {
        return memory.fail(Words::WholePower);
    }
    // Where one rounding does, the result is exact to the last digit, as that of the desk is.
    let result = match b {
        2.0 => a * a,
        0.5 if a > 0.0 => libm::sqrt(a),
        _ => libm::pow(a, b),
    };
    if result.is_infinite() && a.is_finite() && b.is_finite() {
        return memory.fail(Words::Overflow);
    }
    Ok(Value::float(result))
}

fn add(run: &mut Run<'_, '_>, a: Value, b: Value) -> Result<Value> {
    if let (Some(a), Some(b)) = (a.text(), b.text()) {
        return Ok(run.join_two(a, b));
    }
    let kind = sequence_kind(a);
    match (kind, sequence_kind(b)) {
        (Some(kind), Some(other)) if kind == other => {
            let sum = run.list_of(kind, a)?;
            let Some(head) = sum.head() else { return Ok(sum) };
            for index in 0..run.iterate(b)? {
                let element = run.element(b, index)?;
                run.append(head, element);
            }
            Ok(sum)
        }
        _ => {
            let has_text = a.text().is_some() || b.text().is_some();
            let words = if has_text { Words::AddToText } else { Words::WantsNumber };
            let is_first = number(&run.memory, a).is_some() || a.text().is_some();
            Err(wrong(&run.memory, words, if is_first { b } else { a }))
        }
    }
}

/// Whether a value is a list or tuple, and which.
pub fn sequence_kind(value: Value) -> Option<Seq> {
    if value.is(types::LIST) {
        return Some(Seq::List);
    }
    value.is(types::TUPLE).then_some(Seq::Tuple)
}

fn repeat(run: &mut Run<'_, '_>, a: Value, b: Value) -> Result<Value> {
    let (value, count) = match (run.memory.whole(a), run.memory.whole(b)) {
        (_, Some(count)) => (a, count),
        (Some(count), _) => (b, count),
        _ => return Err(no_number(&run.memory, a, b)),
    };
    if let Some(text) = value.text() {
        let from = run.memory.top;
        if text.len() > 0 {
            let mut left = count;
            while left > 0 && !run.memory.is_full {
                run.memory.push_text(text);
                left -= 1;
            }
        }
        return Ok(Value::str(run.memory.text_since(from)));
    }
    let Some(kind) = sequence_kind(value) else { return Err(wrong(&run.memory, Words::WantsNumber, value)) };
    let head = run.memory.new_list();
    let length = run.iterate(value)?;
    let mut left = if length == 0 { 0 } else { count };
    while left > 0 && !run.memory.is_full {
        left -= 1;
        for index in 0..length {
            let element = run.element(value, index)?;
            run.append(head, element);
        }
    }
    Ok(Value::seq(kind, head))
}

/// A number without the `_` between digits; none if they stand elsewhere or the text is too long.
fn plain(text: &str) -> Option<heapless::String<64>> {
    let mut plain = heapless::String::new();
    let bytes = text.as_bytes();
    for (index, byte) in bytes.iter().enumerate() {
        let is_digit = |at: Option<usize>| at.and_then(|at| bytes.get(at)).is_some_and(u8::is_ascii_alphanumeric);
        if *byte != b'_' {
            plain.push(char::from(*byte)).ok()?;
        } else if !is_digit(index.checked_sub(1)) || !is_digit(index.checked_add(1)) {
            return None;
        }
    }
    text.is_ascii().then_some(plain)
}

/// A text as a real number, as Python's `float` reads it.
pub fn read_float(text: &str) -> Option<f64> {
    let plain = plain(crate::chars::trim(text))?;
    gcode::read_f64(&plain)
}

/// A text as a whole number in a base, as Python's `int` reads it; none if it is none or beyond 64 bits.
pub fn read_int(text: &str, base: u32) -> Option<i64> {
    let plain = plain(crate::chars::trim(text))?;
    let (is_negative, digits) = match plain.as_bytes() {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        rest => (false, rest),
    };
    let (base, digits) = match digits {
        [b'0', b'x' | b'X', rest @ ..] if matches!(base, 16 | 0) => (16, rest),
        [b'0', b'o' | b'O', rest @ ..] if matches!(base, 8 | 0) => (8, rest),
        [b'0', b'b' | b'B', rest @ ..] if matches!(base, 2 | 0) => (2, rest),
        rest => (if base == 0 { 10 } else { base }, rest),
    };
    let value = negative(digits, base)?;
    if is_negative { Some(value) } else { value.checked_neg() }
}

/// A real number cut to a whole one.
pub fn truncate(float: f64) -> Option<i64> {
    let whole = libm::trunc(float);
    const LIMIT: f64 = (1_u64 << 63) as f64;
    (-LIMIT..LIMIT).contains(&whole).then_some(whole as i64)
}

//! Equality, order and membership, by Python's rules.

use core::cmp::Ordering;

use super::{Run, undefined, wrong};
use crate::environment::Kind;
use crate::fault::{Fault, Result, Words, fail};
use crate::value::{DEEPEST, Map, Seq, TOO_DEEP, Value};

/// Words about a value that a dict cannot have as a key.
pub const NO_KEY: Words = &"this cannot be the key of a dict";

/// A value as a number, if it is one.
#[derive(Clone, Copy, Debug)]
pub enum Number {
    Int(i64),
    Float(f64),
}

/// The number that a value is; truth values are 0 and 1.
pub fn number(value: Value) -> Option<Number> {
    match value {
        Value::Bool(is) => Some(Number::Int(i64::from(is))),
        Value::Int(int) => Some(Number::Int(int)),
        Value::Float(float) => Some(Number::Float(float)),
        _ => None,
    }
}

fn order_numbers(a: Number, b: Number) -> Option<Ordering> {
    match (a, b) {
        (Number::Int(a), Number::Int(b)) => Some(a.cmp(&b)),
        (Number::Float(a), Number::Float(b)) => a.partial_cmp(&b),
        (Number::Int(a), Number::Float(b)) => order_mixed(a, b),
        (Number::Float(a), Number::Int(b)) => order_mixed(b, a).map(Ordering::reverse),
    }
}

/// Order of a whole and a real number, exactly.
fn order_mixed(a: i64, b: f64) -> Option<Ordering> {
    const LIMIT: f64 = (1_u64 << 63) as f64;
    if b.is_nan() {
        return None;
    }
    if b >= LIMIT {
        return Some(Ordering::Less);
    }
    if b < -LIMIT {
        return Some(Ordering::Greater);
    }
    let whole = libm::trunc(b);
    let rest = if b > whole {
        Ordering::Less
    } else if b < whole {
        Ordering::Greater
    } else {
        Ordering::Equal
    };
    Some(a.cmp(&(whole as i64)).then(rest))
}

/// A list or tuple as both memory and machine may have it: whether it is a tuple.
fn sequence(value: Value) -> Option<bool> {
    match value {
        Value::Seq(Seq::List, _) => Some(false),
        Value::Seq(Seq::Tuple, _) => Some(true),
        Value::Object(object) => match object.kind {
            Kind::List => Some(false),
            Kind::Tuple => Some(true),
            Kind::Lookup | Kind::Dict => None,
        },
        _ => None,
    }
}

fn is_dict(value: Value) -> bool {
    match value {
        Value::Map(Map::Dict, _) => true,
        Value::Object(object) => object.kind == Kind::Dict,
        _ => false,
    }
}

/// Whether two values are equal.
pub fn equal(run: &mut Run<'_, '_>, a: Value, b: Value, depth: u8) -> Result<bool> {
    if depth == 0 {
        return fail(TOO_DEEP);
    }
    if let (Some(a), Some(b)) = (number(a), number(b)) {
        return Ok(order_numbers(a, b) == Some(Ordering::Equal));
    }
    if let (Some(is_tuple), Some(other)) = (sequence(a), sequence(b)) {
        return if is_tuple == other { equal_elements(run, a, b, depth) } else { Ok(false) };
    }
    if is_dict(a) && is_dict(b) {
        return equal_dicts(run, a, b, depth);
    }
    Ok(match (a, b) {
        (Value::Undefined(_), Value::Undefined(_)) | (Value::None, Value::None) => true,
        (Value::Str(a), Value::Str(b)) => run.memory.bytes(a) == run.memory.bytes(b),
        (Value::Range(_), Value::Range(_)) => equal_ranges(run, a, b)?,
        (Value::Seq(kind, a), Value::Seq(other, b)) => kind == other && a == b,
        (Value::Map(kind, a), Value::Map(other, b)) => kind == other && a == b,
        (Value::Function(a), Value::Function(b)) => a == b,
        (Value::Object(a), Value::Object(b)) => a == b,
        _ => false,
    })
}

fn equal_elements(run: &mut Run<'_, '_>, a: Value, b: Value, depth: u8) -> Result<bool> {
    let (length, other) = (run.length(a), run.length(b));
    if length != other {
        return Ok(false);
    }
    for index in 0..length.unwrap_or(0) {
        let (a, b) = (run.element(a, index)?, run.element(b, index)?);
        if !equal(run, a, b, depth - 1)? {
            return Ok(false);
        }
    }
    Ok(true)
}

fn equal_ranges(run: &mut Run<'_, '_>, a: Value, b: Value) -> Result<bool> {
    let length = run.length(a);
    if length != run.length(b) {
        return Ok(false);
    }
    let last = length.unwrap_or(0);
    let ends = [0, last.saturating_sub(1)];
    for index in ends.into_iter().take(last) {
        let (a, b) = (run.element(a, index)?, run.element(b, index)?);
        if !equal(run, a, b, 1)? {
            return Ok(false);
        }
    }
    Ok(true)
}

fn equal_dicts(run: &mut Run<'_, '_>, a: Value, b: Value, depth: u8) -> Result<bool> {
    let length = run.length(a);
    if length != run.length(b) {
        return Ok(false);
    }
    for index in 0..length.unwrap_or(0) {
        let (key, value) = run.entry(a, index)?;
        let other = run.item(b, key)?;
        if matches!(other, Value::Undefined(_)) || !equal(run, value, other, depth - 1)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Order of two values; none where they have none, as with numbers that are none. Fails for other types.
pub fn order(run: &mut Run<'_, '_>, a: Value, b: Value, depth: u8) -> Result<Option<Ordering>> {
    if depth == 0 {
        return fail(TOO_DEEP);
    }
    if let (Some(a), Some(b)) = (number(a), number(b)) {
        return Ok(order_numbers(a, b));
    }
    match (a, b) {
        (Value::Str(a), Value::Str(b)) => return Ok(Some(run.memory.bytes(a).cmp(run.memory.bytes(b)))),
        (Value::Undefined(name), _) | (_, Value::Undefined(name)) => return Err(undefined(&run.memory, name)),
        _ => {}
    }
    if sequence(a).is_none() || sequence(a) != sequence(b) {
        let words: Words = match (a, b) {
            (Value::Str(_), _) | (_, Value::Str(_)) => {
                &"a string and this have no order: make a number of the string with |int or |float"
            }
            _ => &"these have no order: compare numbers with numbers and strings with strings",
        };
        let subject = if matches!(a, Value::Str(_)) { b } else { a };
        return Err(Fault::of(&run.memory, words, subject.kind()));
    }
    let (length, other) = (run.length(a).unwrap_or(0), run.length(b).unwrap_or(0));
    for index in 0..length.min(other) {
        let (a, b) = (run.element(a, index)?, run.element(b, index)?);
        if !equal(run, a, b, depth - 1)? {
            return order(run, a, b, depth - 1);
        }
    }
    Ok(Some(length.cmp(&other)))
}

/// Whether a value is in a list, in a string, or a key of a dict.
pub fn contains(run: &mut Run<'_, '_>, value: Value, holder: Value) -> Result<bool> {
    match holder {
        Value::Str(text) => {
            let Value::Str(part) = value else {
                return Err(wrong(&run.memory, &"only a string can be in a string: put |string behind it", value));
            };
            Ok(crate::chars::find(run.memory.text(text), run.memory.text(part), 0).is_some())
        }
        Value::Map(Map::Dict, head) => {
            if !is_hashable(run, value) {
                return Err(wrong(&run.memory, NO_KEY, value));
            }
            Ok(run.find(head, value)?.is_some())
        }
        Value::Object(object) if matches!(object.kind, Kind::Lookup | Kind::Dict) => match value {
            Value::Str(name) => Ok(run.member(object, name)?.is_some()),
            _ if object.kind == Kind::Dict && !is_hashable(run, value) => Err(wrong(&run.memory, NO_KEY, value)),
            _ => Ok(false),
        },
        Value::Range(at) if number(value).is_some() => {
            let whole = match number(value) {
                Some(Number::Int(int)) => int,
                Some(Number::Float(float)) if float as i64 as f64 == float => float as i64,
                _ => return Ok(false),
            };
            let [start, end, step] = run.range(at);
            let is_within = if step > 0 { whole >= start && whole < end } else { whole <= start && whole > end };
            Ok(is_within && whole.abs_diff(start).is_multiple_of(step.unsigned_abs()))
        }
        _ => {
            for index in 0..run.iterate(holder)? {
                let element = run.element(holder, index)?;
                if equal(run, element, value, DEEPEST)? {
                    return Ok(true);
                }
            }
            run.use_up(holder);
            Ok(false)
        }
    }
}

/// Whether a value can be the key of a dict.
pub fn is_hashable(run: &Run<'_, '_>, value: Value) -> bool {
    match value {
        Value::Map(Map::Dict, _) | Value::Seq(Seq::List | Seq::Keys | Seq::Items, _) => false,
        Value::Object(object) => matches!(object.kind, Kind::Lookup | Kind::Tuple),
        Value::Seq(Seq::Tuple, head) => {
            let block = run.memory.block(head);
            let is_plain = |index| {
                let part = run.memory.value(block.data + index * crate::value::SIZE);
                !matches!(part, Value::Map(..) | Value::Seq(Seq::List, _))
            };
            (0..block.len).all(is_plain)
        }
        _ => true,
    }
}

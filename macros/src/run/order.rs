//! Equality, order and membership, by Python's rules.

use core::cmp::Ordering;

use super::{Run, wrong};
use crate::environment::Kind;
use crate::fault::{Fault, Result, Words};
use crate::number::{Number, number};
use crate::value::{DEEPEST, Map, Seq, Value, View, tag, types};

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

/// Whether two values are equal.
pub fn equal(run: &mut Run<'_, '_>, a: Value, b: Value, depth: u8) -> Result<bool> {
    if depth == 0 {
        return run.memory.fail(Words::TooDeep);
    }
    if let (Some(a), Some(b)) = (number(&run.memory, a), number(&run.memory, b)) {
        return Ok(order_numbers(a, b) == Some(Ordering::Equal));
    }
    if let (Some(a), Some(b)) = (a.text(), b.text()) {
        return Ok(run.memory.bytes(a) == run.memory.bytes(b));
    }
    let are = |types| a.is(types) && b.is(types);
    if are(types::LIST) || are(types::TUPLE) {
        return equal_elements(run, a, b, depth);
    }
    if are(types::DICT) {
        return equal_dicts(run, a, b, depth);
    }
    if are(types::RANGE) {
        return equal_ranges(run, a, b);
    }
    Ok(are(types::UNDEFINED) || a.words() == b.words() && !a.is(types::LOOP | 1 << tag::METHOD))
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
        if matches!(other.view(), View::Undefined(_)) || !equal(run, value, other, depth - 1)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Order of two values; none where they have none, as with numbers that are none. Fails for other types.
pub fn order(run: &mut Run<'_, '_>, a: Value, b: Value, depth: u8) -> Result<Option<Ordering>> {
    if depth == 0 {
        return run.memory.fail(Words::TooDeep);
    }
    if let (Some(a), Some(b)) = (number(&run.memory, a), number(&run.memory, b)) {
        return Ok(order_numbers(a, b));
    }
    if let (Some(a), Some(b)) = (a.text(), b.text()) {
        return Ok(Some(run.memory.bytes(a).cmp(run.memory.bytes(b))));
    }
    if a.is_undefined() || b.is_undefined() {
        return Err(wrong(&run.memory, Words::NoOrder, if a.is_undefined() { a } else { b }));
    }
    let are = |types| a.is(types) && b.is(types);
    if !are(types::LIST) && !are(types::TUPLE) {
        let words: Words = if a.text().is_some() || b.text().is_some() { Words::TextOrder } else { Words::NoOrder };
        let subject = if a.text().is_some() { b } else { a };
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
    match holder.view() {
        View::Str(text) => {
            let Some(part) = value.text() else {
                return Err(wrong(&run.memory, Words::WantsText, value));
            };
            Ok(crate::chars::find(run.memory.text(text), run.memory.text(part), 0).is_some())
        }
        View::Map(Map::Dict, head) => {
            if !is_hashable(run, value) {
                return Err(wrong(&run.memory, Words::NotHashable, value));
            }
            Ok(run.find(head, value)?.is_some())
        }
        View::Object(object) if matches!(object.kind, Kind::Lookup | Kind::Dict) => match value.view() {
            View::Str(name) => Ok(!run.member(object, name)?.is_undefined()),
            _ if object.kind == Kind::Dict && !is_hashable(run, value) => {
                Err(wrong(&run.memory, Words::NotHashable, value))
            }
            _ => Ok(false),
        },
        View::Range(at) if number(&run.memory, value).is_some() => {
            let whole = match number(&run.memory, value) {
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
    match value.view() {
        View::Map(Map::Dict, _) | View::Seq(Seq::List | Seq::Keys | Seq::Items, _) => false,
        View::Object(object) => matches!(object.kind, Kind::Lookup | Kind::Tuple),
        View::Seq(Seq::Tuple, head) => {
            let is_plain = |index| {
                let part = run.memory.element(head, index);
                !part.is(types::DICT | types::NAMESPACE | types::LIST)
            };
            (0..run.memory.count(head)).all(is_plain)
        }
        _ => true,
    }
}

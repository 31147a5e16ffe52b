//! Tests of Jinja2: `value is defined`.

use core::cmp::Ordering;

use crate::arguments::{Arguments, needed};
use crate::chars;
use crate::code::Op;
use crate::environment::Kind;
use crate::fault::{Result, fail};
use crate::names::{self, Test};
use crate::run::order::{contains, equal, number, order};
use crate::run::{Run, numbers};
use crate::value::{DEEPEST, Map, Seq, Value};

/// Whether a test holds.
pub fn check(run: &mut Run<'_, '_>, test: u8, value: Value, arguments: Arguments) -> Result<bool> {
    let Some((test, parameters)) = Test::from_number(test) else { return fail(&"there is no such test") };
    let [first, ..] = arguments.bind(run, parameters)?;
    Ok(match test {
        Test::Defined => !matches!(value, Value::Undefined(_)),
        Test::Undefined => matches!(value, Value::Undefined(_)),
        Test::None => matches!(value, Value::None),
        Test::Boolean => matches!(value, Value::Bool(_)),
        Test::False => matches!(value, Value::Bool(false)),
        Test::True => matches!(value, Value::Bool(true)),
        Test::Integer => matches!(value, Value::Int(_)),
        Test::Float => matches!(value, Value::Float(_)),
        Test::Number => number(value).is_some(),
        Test::Text => matches!(value, Value::Str(_)),
        Test::Mapping => is_mapping(value),
        Test::Sequence => is_sequence(value),
        Test::Iterable => run.is_iterable(value),
        Test::Callable => matches!(value, Value::Function(_) | Value::Method),
        Test::Escaped => false,
        Test::IsFilter | Test::Known => {
            let Value::Str(name) = value else { return Ok(false) };
            let name = run.memory.text(name);
            if test == Test::IsFilter { names::filter(name).is_some() } else { names::test(name).is_some() }
        }
        Test::Lower | Test::Upper => {
            let text = run.text_of(value)?;
            has_case(run.memory.text(text), test == Test::Upper)
        }
        Test::Odd | Test::Even | Test::DivisibleBy => {
            let divisor = if test == Test::DivisibleBy { needed(first)? } else { Value::Int(2) };
            let rest = match value {
                Value::Str(text) => crate::format::percent(run, text, divisor)?,
                _ => numbers::calculate(run, Op::Modulo, value, divisor)?,
            };
            equal(run, rest, Value::Int(i64::from(test == Test::Odd)), DEEPEST)?
        }
        Test::SameAs => same(value, needed(first)?),
        Test::In => contains(run, value, needed(first)?)?,
        Test::Equal => equal(run, value, needed(first)?, DEEPEST)?,
        Test::Unequal => !equal(run, value, needed(first)?, DEEPEST)?,
        Test::Greater | Test::AtLeast | Test::Less | Test::AtMost => {
            let order = order(run, value, needed(first)?, DEEPEST)?;
            match test {
                Test::Greater => order == Some(Ordering::Greater),
                Test::AtLeast => matches!(order, Some(Ordering::Greater | Ordering::Equal)),
                Test::Less => order == Some(Ordering::Less),
                _ => matches!(order, Some(Ordering::Less | Ordering::Equal)),
            }
        }
    })
}

fn is_mapping(value: Value) -> bool {
    match value {
        Value::Map(Map::Dict, _) => true,
        Value::Object(object) => object.kind == Kind::Dict,
        _ => false,
    }
}

fn is_sequence(value: Value) -> bool {
    match value {
        Value::Str(_) | Value::Seq(Seq::List | Seq::Tuple, _) | Value::Map(Map::Dict, _) | Value::Range(_) => true,
        Value::Object(object) => object.kind != Kind::Lookup,
        Value::Undefined(_) => true,
        _ => false,
    }
}

fn same(value: Value, other: Value) -> bool {
    match (value, other) {
        (Value::None, Value::None) => true,
        (Value::Bool(a), Value::Bool(b)) => a == b,
        (Value::Int(a), Value::Int(b)) => a == b,
        (Value::Str(a), Value::Str(b)) => a == b,
        (Value::Seq(_, a), Value::Seq(_, b)) | (Value::Map(_, a), Value::Map(_, b)) => a == b,
        (Value::Object(a), Value::Object(b)) => a == b,
        _ => false,
    }
}

/// Whether a text has letters, and all are in upper or in lower case.
pub fn has_case(text: &str, is_upper: bool) -> bool {
    let mut has_letter = false;
    for char in text.chars() {
        let (upper, lower) = (chars::upper(char), chars::lower(char));
        if upper != lower {
            has_letter = true;
            if char != if is_upper { upper } else { lower } {
                return false;
            }
        }
    }
    has_letter
}

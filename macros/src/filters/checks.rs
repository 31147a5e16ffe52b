//! Tests of Jinja2: `value is defined`.

use core::cmp::Ordering;

use crate::arguments::{Arguments, needed};
use crate::chars;
use crate::code::Op;
use crate::environment::Kind;
use crate::fault::Result;
use crate::names::{self, Test};
use crate::run::order::{contains, equal, number, order};
use crate::run::{Run, numbers};
use crate::value::{DEEPEST, Map, Seq, Value, View};

/// Whether a test holds.
pub fn check(run: &mut Run<'_, '_>, test: u8, value: Value, arguments: Arguments) -> Result<bool> {
    let Some((test, parameters)) = Test::from_number(test) else { return run.memory.fail(&"there is no such test") };
    let [first, ..] = arguments.bind(run, parameters)?;
    Ok(match test {
        Test::Defined => !matches!(value.view(), View::Undefined(_)),
        Test::Undefined => matches!(value.view(), View::Undefined(_)),
        Test::None => matches!(value.view(), View::None),
        Test::Boolean => matches!(value.view(), View::Bool(_)),
        Test::False => matches!(value.view(), View::Bool(false)),
        Test::True => matches!(value.view(), View::Bool(true)),
        Test::Integer => matches!(value.view(), View::Int(_)),
        Test::Float => matches!(value.view(), View::Float(_)),
        Test::Number => number(&run.memory, value).is_some(),
        Test::Text => matches!(value.view(), View::Str(_)),
        Test::Mapping => is_mapping(value),
        Test::Sequence => is_sequence(value),
        Test::Iterable => run.is_iterable(value),
        Test::Callable => matches!(value.view(), View::Function(_) | View::Method),
        Test::Escaped => false,
        Test::IsFilter | Test::Known => {
            let View::Str(name) = value.view() else { return Ok(false) };
            let name = run.memory.text(name);
            if test == Test::IsFilter { names::filter(name).is_some() } else { names::test(name).is_some() }
        }
        Test::Lower | Test::Upper => {
            let text = run.text_of(value)?;
            has_case(run.memory.text(text), test == Test::Upper)
        }
        Test::Odd | Test::Even | Test::DivisibleBy => {
            let divisor = if test == Test::DivisibleBy { needed(run, first)? } else { Value::small(2) };
            let rest = match value.view() {
                View::Str(text) => crate::format::percent(run, text, divisor)?,
                _ => numbers::calculate(run, Op::Modulo, value, divisor)?,
            };
            equal(run, rest, Value::small(i32::from(test == Test::Odd)), DEEPEST)?
        }
        Test::SameAs => same(value, needed(run, first)?),
        Test::In => contains(run, value, needed(run, first)?)?,
        Test::Equal => equal(run, value, needed(run, first)?, DEEPEST)?,
        Test::Unequal => !equal(run, value, needed(run, first)?, DEEPEST)?,
        Test::Greater | Test::AtLeast | Test::Less | Test::AtMost => {
            let order = order(run, value, needed(run, first)?, DEEPEST)?;
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
    match value.view() {
        View::Map(Map::Dict, _) => true,
        View::Object(object) => object.kind == Kind::Dict,
        _ => false,
    }
}

fn is_sequence(value: Value) -> bool {
    match value.view() {
        View::Str(_) | View::Seq(Seq::List | Seq::Tuple, _) | View::Map(Map::Dict, _) | View::Range(_) => true,
        View::Object(object) => object.kind != Kind::Lookup,
        View::Undefined(_) => true,
        _ => false,
    }
}

fn same(value: Value, other: Value) -> bool {
    match (value.view(), other.view()) {
        (View::None, View::None) => true,
        (View::Bool(a), View::Bool(b)) => a == b,
        (View::Int(a), View::Int(b)) => a == b,
        (View::Str(a), View::Str(b)) => a == b,
        (View::Seq(_, a), View::Seq(_, b)) | (View::Map(_, a), View::Map(_, b)) => a == b,
        (View::Object(a), View::Object(b)) => a == b,
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

//! Tests of Jinja2: `value is defined`.

use core::cmp::Ordering;

use crate::arguments::{Arguments, needed};
use crate::chars;
use crate::code::Op;
use crate::fault::Result;
use crate::names::{Filter, Test, find, parameters};
use crate::run::order::{contains, equal, order};
use crate::run::{Run, numbers};
use crate::value::{DEEPEST, Value, View, tag, types};

/// Whether a test holds.
pub fn check(run: &mut Run<'_, '_>, test: u8, value: Value, arguments: Arguments) -> Result<bool> {
    let [first, ..] = arguments.bind(run, parameters(Test::NAMES, test))?;
    let test = Test::from_number(test);
    Ok(match test {
        Test::Defined => !matches!(value.view(), View::Undefined(_)),
        Test::Undefined => matches!(value.view(), View::Undefined(_)),
        Test::None => value.is_none(),
        Test::Boolean => value.is(types::BOOL),
        Test::False => value.words() == Value::bool(false).words(),
        Test::True => value.words() == Value::bool(true).words(),
        Test::Integer => value.is(types::INT),
        Test::Float => value.is(types::FLOAT),
        Test::Number => value.is(types::NUMBER),
        Test::Text => matches!(value.view(), View::Str(_)),
        Test::Mapping => value.is(types::DICT),
        Test::Sequence => value.is(types::INDEXED | types::DICT | types::UNDEFINED),
        Test::Iterable => run.is_iterable(value),
        Test::Callable => matches!(value.view(), View::Function(_) | View::Method),
        Test::Escaped => false,
        Test::IsFilter | Test::Known => {
            let Some(name) = value.text() else { return Ok(false) };
            let table = if test == Test::IsFilter { Filter::NAMES } else { Test::NAMES };
            find(table, run.memory.bytes(name)).is_some()
        }
        Test::Lower | Test::Upper => {
            let text = run.text_of(value)?;
            has_case(run.memory.text(text), test == Test::Upper)
        }
        Test::Odd | Test::Even | Test::DivisibleBy => {
            let divisor = if test == Test::DivisibleBy { needed(run, first)? } else { Value::small(2) };
            let rest = match value.text() {
                Some(text) => crate::format::percent(run, text, divisor)?,
                None => numbers::calculate(run, Op::Modulo, value, divisor)?,
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

/// Whether two values are one: lists and dicts by their places, and no real numbers.
fn same(value: Value, other: Value) -> bool {
    value.words() == other.words() && !value.is(types::FLOAT | types::RANGE | 1 << tag::LONG | types::CALLABLE)
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

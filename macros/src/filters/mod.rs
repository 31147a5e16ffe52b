//! Filters of Jinja2: `value|name(arguments)`.

mod checks;
mod each;
mod order;
mod pretty;
pub mod sequences;
pub mod strings;

pub use checks::{check, has_case};

use crate::arguments::{Arguments, text, whole};
use crate::digits;
use crate::fault::{Result, Words};
use crate::memory::Text;
use crate::names::{Filter, parameters};
use crate::number::{Number, number as number_of};
use crate::run::{Run, numbers, undefined, wrong};
use crate::value::{Value, View, types};

/// Result of a filter.
pub fn apply(run: &mut Run<'_, '_>, number: u8, value: Value, arguments: Arguments) -> Result<Value> {
    let filter = Filter::from_number(number);
    let names = parameters(Filter::NAMES, number);
    if names == b"*" {
        return match filter {
            Filter::Format => format(run, value, arguments),
            _ => each::apply(run, filter, value, arguments),
        };
    }
    let bound = arguments.bind(run, names)?;
    let [first, second, third, _] = bound;
    match filter {
        Filter::Abs => absolute(run, value),
        Filter::Default => {
            let is_strict = second.is_some_and(|second| run.truth(second));
            let is_missing = matches!(value.view(), View::Undefined(_)) || is_strict && !run.truth(value);
            if !is_missing { Ok(value) } else { first.map_or_else(|| Ok(run.str("")), Ok) }
        }
        Filter::Int => integer(run, value, first, second),
        Filter::Float => float(run, value, first),
        Filter::Round => round(run, value, first, second),
        Filter::Text => run.text_of(value).map(Value::str),
        Filter::Attr => attribute(run, value, first),
        Filter::Pprint => pretty::pretty(run, value),
        Filter::Length => match run.length(value) {
            Some(length) if !value.is(types::ONCE | types::LOOKUP) => Ok(Value::count(length)),
            _ => Err(wrong(&run.memory, Words::NoLength, value)),
        },
        Filter::Min | Filter::Max | Filter::Sort | Filter::DictSort | Filter::Unique => {
            order::apply(run, filter, value, &bound)
        }
        Filter::Lower | Filter::Upper | Filter::Capitalize | Filter::Title | Filter::Trim | Filter::Replace => {
            strings::apply(run, filter, value, &bound)
        }
        Filter::Center | Filter::Indent | Filter::Truncate | Filter::WordCount => {
            strings::apply(run, filter, value, &bound)
        }
        _ => sequences::apply(run, filter, value, [first, second, third]),
    }
}

fn absolute(run: &mut Run<'_, '_>, value: Value) -> Result<Value> {
    match number_of(&run.memory, value) {
        Some(Number::Int(int)) => match int.checked_abs() {
            Some(int) => Ok(run.memory.int(int)),
            None => run.memory.fail(Words::Overflow),
        },
        Some(Number::Float(float)) => Ok(Value::float(libm::fabs(float))),
        None => Err(wrong(&run.memory, Words::WantsNumber, value)),
    }
}

#[inline(never)]
fn integer(run: &mut Run<'_, '_>, value: Value, default: Option<Value>, base: Option<Value>) -> Result<Value> {
    let default = default.unwrap_or(Value::small(0));
    let base = base.map_or(Ok(10), |base| whole(run, base))?;
    let base = u32::try_from(base).unwrap_or(1);
    match value.view() {
        View::Str(text) => {
            let string = run.memory.text(text);
            if let Some(int) = numbers::read_int(string, base) {
                return Ok(run.memory.int(int));
            }
            match numbers::read_float(string) {
                Some(float) if float.is_finite() => truncate(run, float),
                _ => Ok(default),
            }
        }
        View::Undefined(name) => Err(undefined(&run.memory, name)),
        _ => match number_of(&run.memory, value) {
            Some(Number::Int(int)) => Ok(run.memory.int(int)),
            Some(Number::Float(float)) if float.is_nan() => Ok(default),
            Some(Number::Float(float)) => truncate(run, float),
            None => Ok(default),
        },
    }
}

/// A real number cut to a whole one.
fn truncate(run: &mut Run<'_, '_>, float: f64) -> Result<Value> {
    match numbers::truncate(float) {
        Some(int) => Ok(run.memory.int(int)),
        None => run.memory.fail(Words::Overflow),
    }
}

fn float(run: &mut Run<'_, '_>, value: Value, default: Option<Value>) -> Result<Value> {
    let default = default.unwrap_or(Value::float(0.0));
    match value.view() {
        View::Str(text) => Ok(numbers::read_float(run.memory.text(text)).map_or(default, Value::float)),
        View::Undefined(name) => Err(undefined(&run.memory, name)),
        _ => Ok(match number_of(&run.memory, value) {
            Some(Number::Int(int)) => Value::float(int as f64),
            Some(Number::Float(float)) => Value::float(float),
            None => default,
        }),
    }
}

#[inline(never)]
fn round(run: &mut Run<'_, '_>, value: Value, precision: Option<Value>, method: Option<Value>) -> Result<Value> {
    let precision = precision.map_or(Ok(0), |precision| whole(run, precision))?.clamp(-400, 400) as i32;
    let method = method.map_or(&b"common"[..], |method| run.memory.bytes(method.text().unwrap_or_default()));
    let Some(number) = number_of(&run.memory, value) else {
        return Err(wrong(&run.memory, Words::WantsNumber, value));
    };
    let float = match number {
        Number::Int(int) => int as f64,
        Number::Float(float) => float,
    };
    match (method, number) {
        (b"common", Number::Int(int)) => round_integer(run, int, precision),
        (b"common", Number::Float(float)) => Ok(Value::float(digits::rounded(float, precision))),
        (b"ceil" | b"floor", _) => {
            let power = (0..precision.unsigned_abs()).fold(1.0, |power, _| power * 10.0);
            let scaled = if precision < 0 { float * (1.0 / power) } else { float * power };
            let whole = if method == b"ceil" { libm::ceil(scaled) } else { libm::floor(scaled) };
            Ok(Value::float(if precision < 0 { whole / (1.0 / power) } else { whole / power }))
        }
        _ => run.memory.fail(Words::RoundMethod),
    }
}

/// A whole number rounded to tens, hundreds and so on, halves to the even digit.
fn round_integer(run: &mut Run<'_, '_>, int: i64, precision: i32) -> Result<Value> {
    if precision >= 0 {
        return Ok(run.memory.int(int));
    }
    let Some(unit) = numbers::whole_power(10, i64::from(precision.unsigned_abs())) else { return Ok(Value::small(0)) };
    let Some((down, rest)) = numbers::divided(int, unit) else { return Ok(Value::small(0)) };
    let is_up = rest > unit / 2 || rest == unit / 2 && down % 2 != 0;
    match digits::product(down + i64::from(is_up), unit) {
        Some(int) => Ok(run.memory.int(int)),
        None => run.memory.fail(Words::Overflow),
    }
}

/// `value|attr("name")`: an attribute, and no member of a dict.
fn attribute(run: &mut Run<'_, '_>, value: Value, name: Option<Value>) -> Result<Value> {
    let name = text(run, name)?;
    if value.is(types::NAMESPACE | types::LOOP) { run.attribute(value, name) } else { Ok(Value::undefined(name)) }
}

#[inline(never)]
fn format(run: &mut Run<'_, '_>, value: Value, arguments: Arguments) -> Result<Value> {
    let text: Text = run.text_of(value)?;
    let positions = arguments.positions(run);
    if positions > 0 && positions < arguments.count {
        return run.memory.fail(Words::TooManyArguments);
    }
    let values = if positions == 0 && arguments.count > 0 {
        let map = run.map(crate::value::Map::Dict, arguments.count);
        let Some(head) = map.head() else { return Ok(map) };
        for index in 0..arguments.count {
            if let Some((name, value)) = arguments.named(run, index) {
                run.put(head, Value::str(name), value)?;
            }
        }
        map
    } else {
        let head = run.memory.new_block(positions, crate::value::SIZE);
        for index in 0..positions {
            let value = run.memory.at(arguments.first + index);
            run.append(head, value);
        }
        Value::seq(crate::value::Seq::Tuple, head)
    };
    crate::format::percent(run, text, values)
}

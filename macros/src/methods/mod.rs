//! Methods of strings, lists and dicts.

pub mod dicts;
mod lists;
mod strings;

use crate::arguments::Arguments;
use crate::environment::Kind;
use crate::fault::{Fault, Result};
use crate::memory::Text;
use crate::run::{Run, undefined, wrong};
use crate::value::{Map, Seq, Value};

/// Names of the methods of a value, and of each method's arguments.
fn methods(value: Value) -> &'static [(&'static str, &'static str)] {
    match value {
        Value::Str(_) => strings::METHODS,
        Value::Map(Map::Dict, _) => dicts::METHODS,
        Value::Seq(Seq::List, _) => lists::METHODS,
        Value::Seq(Seq::Tuple, _) => lists::OF_TUPLES,
        Value::Float(_) => &[("is_integer", "")],
        Value::Object(object) => match object.kind {
            Kind::Dict => dicts::METHODS,
            Kind::List => lists::METHODS,
            Kind::Tuple => lists::OF_TUPLES,
            Kind::Lookup => &[],
        },
        _ => &[],
    }
}

/// Whether a name is that of a method of a value.
pub fn is_method(name: &str, value: Value) -> bool {
    methods(value).iter().any(|(known, _)| *known == name)
}

/// Result of a method.
pub fn call(run: &mut Run<'_, '_>, value: Value, name: Text, arguments: Arguments) -> Result<Value> {
    match value {
        Value::Undefined(missing) => return Err(undefined(missing)),
        Value::Loop(place) => return of_loop(run, place, name, arguments),
        _ => {}
    }
    let word = run.memory.text(name);
    let Some((word, parameters)) = methods(value).iter().copied().find(|(known, _)| *known == word) else {
        let attribute = run.attribute(value, name)?;
        if let Value::Function(number) = attribute {
            return crate::functions::call(run, number, arguments);
        }
        if let Value::Undefined(missing) = attribute {
            return Err(undefined(missing));
        }
        return Err(wrong("this cannot be called", attribute));
    };
    if parameters == "*" {
        return strings::format(run, value, arguments);
    }
    if (word, value.kind()) == ("update", "dict") {
        return dicts::update(run, value, arguments);
    }
    let bound = arguments.bind(run, parameters)?;
    match value {
        Value::Str(text) => strings::call(run, text, word, bound),
        Value::Float(float) => Ok(Value::Bool(float.is_finite() && libm::trunc(float) == float)),
        Value::Map(..) => dicts::call(run, value, word, bound),
        Value::Object(object) if object.kind == Kind::Dict => dicts::call(run, value, word, bound),
        _ => lists::call(run, value, word, bound),
    }
}

fn of_loop(run: &mut Run<'_, '_>, place: u16, name: Text, arguments: Arguments) -> Result<Value> {
    if !run.memory.is(name, "cycle") {
        return Err(Fault::about("a loop has cycle and no other function", name));
    }
    let count = arguments.positions(run);
    if count == 0 {
        return Err(Fault::new("cycle wants values to take turns"));
    }
    let (turn, _) = run.turn(place);
    arguments.position(run, turn as usize % count).ok_or(Fault::new("cycle wants values without names"))
}

/// An argument that has to be given.
fn needed(argument: Option<Value>) -> Result<Value> {
    argument.ok_or(Fault::new("an argument of the function is missing"))
}

/// The fault that something of the machine's would be changed.
fn fixed() -> Fault {
    Fault::new("values of the printer cannot be changed: make a copy with |list, or dict(...), first")
}

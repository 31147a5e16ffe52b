//! Methods of strings, lists and dicts.

pub mod dicts;
mod lists;
mod strings;

use crate::arguments::Arguments;
use crate::environment::Kind;
use crate::fault::{Fault, Result};
use crate::memory::Text;
use crate::method_names::methods;
use crate::run::{Run, undefined, wrong};
use crate::value::{Value, View};

/// Result of a method.
pub fn call(run: &mut Run<'_, '_>, value: Value, name: Text, arguments: Arguments) -> Result<Value> {
    match value.view() {
        View::Undefined(missing) => return Err(undefined(&run.memory, missing)),
        View::Loop(place) => return of_loop(run, place, name, arguments),
        _ => {}
    }
    let word = run.memory.text(name);
    let Some((word, parameters)) = methods(value).iter().copied().find(|(known, _)| *known == word) else {
        let attribute = run.attribute(value, name)?;
        if let View::Function(number) = attribute.view() {
            return crate::functions::call(run, number, arguments);
        }
        if let View::Undefined(missing) = attribute.view() {
            return Err(undefined(&run.memory, missing));
        }
        return Err(wrong(&run.memory, &"this cannot be called", attribute));
    };
    if parameters == "*" {
        return strings::format(run, value, arguments);
    }
    if (word, value.kind()) == ("update", "dict") {
        return dicts::update(run, value, arguments);
    }
    let bound = arguments.bind(run, parameters)?;
    match value.view() {
        View::Str(text) => strings::call(run, text, word, &bound),
        View::Float(float) => Ok(Value::bool(float.is_finite() && libm::trunc(float) == float)),
        View::Map(..) => dicts::call(run, value, word, &bound),
        View::Object(object) if object.kind == Kind::Dict => dicts::call(run, value, word, &bound),
        _ => lists::call(run, value, word, &bound),
    }
}

fn of_loop(run: &mut Run<'_, '_>, place: u16, name: Text, arguments: Arguments) -> Result<Value> {
    if !run.memory.is(name, "cycle") {
        return Err(Fault::about(&run.memory, &"a loop has cycle and no other function", name));
    }
    let count = arguments.positions(run);
    if count == 0 {
        return Err(run.memory.fault(&"cycle wants values to take turns"));
    }
    let (turn, _) = run.turn(place);
    arguments.position(run, turn as usize % count).ok_or(run.memory.fault(&"cycle wants values without names"))
}

//! Methods of strings, lists and dicts.

pub mod dicts;
mod lists;
mod strings;

use crate::arguments::Arguments;
use crate::fault::{Fault, Result, Words};
use crate::memory::Text;
use crate::names::{self, OfDict, OfList, OfString};
use crate::run::{Run, undefined, wrong};
use crate::value::{Value, View, types};

/// Result of a method.
#[inline(never)]
pub fn call(run: &mut Run<'_, '_>, value: Value, name: Text, arguments: Arguments) -> Result<Value> {
    match value.view() {
        View::Undefined(missing) => return Err(undefined(&run.memory, missing)),
        View::Loop(place) => return of_loop(run, place, name, arguments),
        _ => {}
    }
    let Some(method) = names::method(value, run.memory.bytes(name)) else {
        let attribute = run.attribute(value, name)?;
        if let View::Function(number) = attribute.view() {
            return crate::functions::call(run, number, arguments);
        }
        return Err(wrong(&run.memory, Words::NotCallable, attribute));
    };
    let parameters = names::parameters(names::methods(value), method);
    if parameters == b"*" {
        return match value.text() {
            Some(text) => crate::format::braces(run, text, &arguments),
            None => dicts::update(run, value, arguments),
        };
    }
    let bound = arguments.bind(run, parameters)?;
    if let Some(text) = value.text() {
        return strings::call(run, text, OfString::from_number(method), &bound);
    }
    if value.is(types::DICT) {
        return dicts::call(run, value, OfDict::from_number(method), &bound);
    }
    if let Some(float) = value.as_float() {
        return Ok(Value::bool(float.is_finite() && libm::trunc(float) == float));
    }
    lists::call(run, value, OfList::from_number(method), &bound)
}

fn of_loop(run: &mut Run<'_, '_>, place: u16, name: Text, arguments: Arguments) -> Result<Value> {
    if !run.memory.is(name, "cycle") {
        return Err(Fault::about(&run.memory, Words::LoopOnlyCycles, name));
    }
    let count = arguments.positions(run);
    if count == 0 {
        return Err(run.memory.fault(Words::ArgumentMissing));
    }
    let (turn, _) = run.turn(place);
    arguments.position(run, turn as usize % count).ok_or(run.memory.fault(Words::ArgumentMissing))
}

//! Filters that do something with each element: `map`, `select` and `reject`.

use super::sequences::path_of;
use super::{apply as apply_filter, check};
use crate::arguments::Arguments;
use crate::fault::{Fault, Result, Words};
use crate::memory::Text;
use crate::names::{self, Filter, Test};
use crate::run::Run;
use crate::value::{Seq, Value, View};

/// Result of a filter that takes another filter or a test.
#[inline(never)]
pub fn apply(run: &mut Run<'_, '_>, filter: Filter, value: Value, arguments: Arguments) -> Result<Value> {
    let head = run.memory.new_list();
    let length = if run.truth(value) { run.iterate(value)? } else { 0 };
    let is_map = filter == Filter::Map;
    for index in 0..length {
        let element = run.element(value, index)?;
        if is_map {
            let mapped = map(run, element, arguments)?;
            run.append(head, mapped);
        } else if select(run, filter, element, arguments)? {
            run.append(head, element);
        }
    }
    run.use_up(value);
    Ok(Value::seq(Seq::Once, head))
}

fn name(run: &Run<'_, '_>, arguments: Arguments) -> Result<Option<Text>> {
    match arguments.position(run, 0) {
        None => Ok(None),
        Some(value) if value.text().is_some() => Ok(value.text()),
        Some(_) => run.memory.fail(Words::NameInQuotes),
    }
}

fn map(run: &mut Run<'_, '_>, element: Value, arguments: Arguments) -> Result<Value> {
    if let Some(name) = name(run, arguments)? {
        let Some(number) = names::find(Filter::NAMES, run.memory.bytes(name)) else {
            return Err(Fault::about(&run.memory, Words::NoFilter, name));
        };
        if number == Filter::Map as u8 || number == Filter::Select as u8 {
            return run.memory.fail(Words::MapOfMap);
        }
        return apply_filter(run, number, element, arguments.rest());
    }
    let [attribute, default, ..] = arguments.bind(run, b"attribute default")?;
    let Some(attribute) = attribute else { return run.memory.fail(Words::ArgumentMissing) };
    let found = path_of(run, element, attribute)?;
    let is_missing = matches!(found.view(), View::Undefined(_));
    Ok(default.filter(|default| is_missing && !default.is_none()).unwrap_or(found))
}

fn select(run: &mut Run<'_, '_>, filter: Filter, element: Value, arguments: Arguments) -> Result<bool> {
    let (mut subject, mut arguments) = (element, arguments);
    if matches!(filter, Filter::SelectAttr | Filter::RejectAttr) {
        let Some(path) = arguments.position(run, 0) else { return run.memory.fail(Words::ArgumentMissing) };
        subject = path_of(run, element, path)?;
        arguments = arguments.rest();
    }
    let holds = match name(run, arguments)? {
        None => run.truth(subject),
        Some(name) => {
            let Some(number) = names::find(Test::NAMES, run.memory.bytes(name)) else {
                return Err(Fault::about(&run.memory, Words::NoTest, name));
            };
            check(run, number, subject, arguments.rest())?
        }
    };
    Ok(holds == matches!(filter, Filter::Select | Filter::SelectAttr))
}

//! Methods of dicts, and how dicts are filled.

use crate::arguments::{Arguments, Bound, needed};
use crate::fault::{Result, Words};
use crate::names::OfDict;
use crate::run::containers::fixed;
use crate::run::{Run, order, wrong};
use crate::value::{Map, SIZE, Seq, Value};

/// Result of a method of a dict.
#[inline(never)]
pub fn call(run: &mut Run<'_, '_>, dict: Value, method: OfDict, bound: &Bound) -> Result<Value> {
    let [first, second, ..] = *bound;
    match method {
        OfDict::Get => Ok(member(run, dict, needed(run, first)?)?.unwrap_or(second.unwrap_or(Value::NONE))),
        OfDict::Item => match member(run, dict, needed(run, first)?)? {
            Some(value) => Ok(value),
            None => run.memory.fail(Words::NoKey),
        },
        OfDict::Contains => order::contains(run, needed(run, first)?, dict).map(Value::bool),
        OfDict::Length => Ok(Value::count(run.length(dict).unwrap_or(0))),
        OfDict::Keys => parts(run, dict, Seq::Keys),
        OfDict::Values => parts(run, dict, Seq::Values),
        OfDict::Items => crate::filters::sequences::pairs(run, dict).map(|head| Value::seq(Seq::Items, head)),
        OfDict::Copy => copy(run, dict),
        _ => change(run, dict, method, bound),
    }
}

fn member(run: &mut Run<'_, '_>, dict: Value, key: Value) -> Result<Option<Value>> {
    if let Some(object) = dict.as_object() {
        let Some(name) = key.text() else { return Ok(None) };
        return run.kept_member(object, name).map(|member| (!member.is_undefined()).then_some(member));
    }
    let Some(head) = dict.head() else { return Ok(None) };
    if !order::is_hashable(run, key) {
        return Err(wrong(&run.memory, Words::NotHashable, key));
    }
    Ok(run.find(head, key)?.map(|at| run.memory.value(at + SIZE)))
}

fn parts(run: &mut Run<'_, '_>, dict: Value, kind: Seq) -> Result<Value> {
    let head = run.memory.new_list();
    for index in 0..run.length(dict).unwrap_or(0) {
        let (key, value) = run.entry(dict, index)?;
        run.append(head, if kind == Seq::Keys { key } else { value });
    }
    Ok(Value::seq(kind, head))
}

fn copy(run: &mut Run<'_, '_>, dict: Value) -> Result<Value> {
    let map = run.map(Map::Dict, 0);
    if let Some(head) = map.head() {
        run.put_all(head, dict)?;
    }
    Ok(map)
}

/// Methods that change the dict.
#[inline(never)]
fn change(run: &mut Run<'_, '_>, dict: Value, method: OfDict, bound: &Bound) -> Result<Value> {
    let [first, second, ..] = *bound;
    let Some(head) = dict.head() else { return Err(fixed(run)) };
    let count = run.memory.count(head);
    match method {
        OfDict::Set => {
            run.put_kept(head, needed(run, first)?, needed(run, second)?)?;
            Ok(Value::NONE)
        }
        OfDict::SetDefault => {
            let (key, default) = (needed(run, first)?, second.unwrap_or(Value::NONE));
            if let Some(value) = member(run, dict, key)? {
                return Ok(value);
            }
            run.put_kept(head, key, default)?;
            Ok(default)
        }
        OfDict::Clear => {
            run.memory.set_count(head, 0);
            Ok(Value::NONE)
        }
        OfDict::PopItem => {
            let Some(last) = count.checked_sub(1) else { return run.memory.fail(Words::NoKey) };
            let (key, value) = run.entry(dict, last)?;
            run.memory.set_count(head, last);
            Ok(run.seq(Seq::Tuple, &[key, value]))
        }
        _ => {
            let Some(at) = run.find(head, needed(run, first)?)? else {
                return second.map_or_else(|| run.memory.fail(Words::NoKey), Ok);
            };
            let value = run.memory.value(at + SIZE);
            let end = run.memory.place(head, count, 2 * SIZE);
            run.memory.rotate(at, end, 2 * SIZE);
            run.memory.set_count(head, count - 1);
            Ok(value)
        }
    }
}

/// `dict.update(...)`: from another dict, from pairs, and by names.
pub fn update(run: &mut Run<'_, '_>, dict: Value, arguments: Arguments) -> Result<Value> {
    let Some(head) = dict.head() else { return Err(fixed(run)) };
    fill(run, head, arguments)?;
    run.keep();
    Ok(Value::NONE)
}

/// Fills a dict as `dict(...)` and `update(...)` do.
pub fn fill(run: &mut Run<'_, '_>, head: u16, arguments: Arguments) -> Result<()> {
    let positions = arguments.positions(run);
    if positions > 1 {
        return run.memory.fail(Words::TooManyArguments);
    }
    if let Some(from) = arguments.position(run, 0) {
        run.put_all(head, from)?;
    }
    for index in positions..arguments.count {
        if let Some((name, value)) = arguments.named(run, index) {
            run.put(head, Value::str(name), value)?;
        }
    }
    Ok(())
}

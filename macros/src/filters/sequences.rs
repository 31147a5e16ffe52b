//! Filters of lists and dicts.

use crate::arguments::{needed, whole};
use crate::code::Op;
use crate::fault::{Result, Words};
use crate::memory::Text;
use crate::names::Filter;
use crate::run::{Run, numbers, wrong};
use crate::value::{Seq, Value, View, types};

/// Result of a filter of lists and dicts.
#[inline(never)]
pub fn apply(run: &mut Run<'_, '_>, filter: Filter, value: Value, bound: [Option<Value>; 3]) -> Result<Value> {
    let [first, second, _] = bound;
    match filter {
        Filter::List => run.list_of(Seq::List, value),
        Filter::First => end(run, value, false),
        Filter::Last => {
            if matches!(value.view(), View::Seq(Seq::Once, _)) {
                return Err(wrong(&run.memory, Words::WantsList, value));
            }
            end(run, value, true)
        }
        Filter::Join => {
            let values = match second {
                None => value,
                Some(path) if path.is_none() => value,
                Some(path) => attributes(run, value, path)?,
            };
            let between = match first {
                None => Text::default(),
                Some(between) => run.text_of(between)?,
            };
            run.join(values, between, false)
        }
        Filter::Sum => sum(run, value, first, second),
        Filter::Random => random(run, value),
        Filter::Reverse => reverse(run, value),
        Filter::Items => items(run, value),
        Filter::Batch => batch(run, value, whole(run, needed(run, first)?)?, second),
        _ => slices(run, value, whole(run, needed(run, first)?)?, second),
    }
}

fn end(run: &mut Run<'_, '_>, value: Value, is_last: bool) -> Result<Value> {
    match run.iterate(value)? {
        0 => Ok(Value::MISSING),
        length => run.element(value, if is_last { length - 1 } else { 0 }),
    }
}

/// The attribute of each element.
fn attributes(run: &mut Run<'_, '_>, values: Value, path: Value) -> Result<Value> {
    let head = run.memory.new_list();
    for index in 0..run.iterate(values)? {
        let element = run.element(values, index)?;
        let found = path_of(run, element, path)?;
        run.append(head, found);
    }
    run.use_up(values);
    Ok(Value::seq(Seq::List, head))
}

/// The value at the end of a path with points: names, and numbers as indices.
pub fn path_of(run: &mut Run<'_, '_>, value: Value, path: Value) -> Result<Value> {
    let Some(path) = path.text() else { return run.item(value, path) };
    let mut value = value;
    let mut rest = path;
    loop {
        let string = run.memory.text(rest);
        let end = crate::chars::place_of(string, b'.').unwrap_or(string.len());
        let name = rest.part(0, end);
        let is_number = end > 0 && run.memory.bytes(name).iter().all(u8::is_ascii_digit);
        let key = match numbers::read_int(run.memory.text(name), 10) {
            Some(index) if is_number => run.memory.int(index),
            _ => Value::str(name),
        };
        value = run.item(value, key)?;
        if end >= rest.len() {
            return Ok(value);
        }
        rest = rest.rest(end + 1);
    }
}

fn sum(run: &mut Run<'_, '_>, value: Value, path: Option<Value>, start: Option<Value>) -> Result<Value> {
    let mut total = start.unwrap_or(Value::small(0));
    if matches!(total.view(), View::Str(_)) {
        return run.memory.fail(Words::AddToText);
    }
    for index in 0..run.iterate(value)? {
        let mut element = run.element(value, index)?;
        if let Some(path) = path
            && !path.is_none()
        {
            element = path_of(run, element, path)?;
        }
        total = numbers::calculate(run, Op::Add, total, element)?;
    }
    run.use_up(value);
    Ok(total)
}

fn random(run: &mut Run<'_, '_>, value: Value) -> Result<Value> {
    if !value.is(types::INDEXED) {
        return Err(wrong(&run.memory, Words::WantsList, value));
    }
    match run.iterate(value)? {
        0 => Ok(Value::MISSING),
        length => {
            let index = run.machine.random(length).min(length - 1);
            run.element(value, index)
        }
    }
}

fn reverse(run: &mut Run<'_, '_>, value: Value) -> Result<Value> {
    let length = run.iterate(value)?;
    if let Some(text) = value.text() {
        let from = run.memory.top;
        for index in (0..length).rev() {
            let part = run.character(text, index);
            run.memory.push_text(part);
        }
        return Ok(Value::str(run.memory.text_since(from)));
    }
    let head = run.memory.new_list();
    for index in (0..length).rev() {
        let element = run.element(value, index)?;
        run.append(head, element);
    }
    run.use_up(value);
    let kind = if matches!(value.view(), View::Seq(Seq::Once, _)) { Seq::List } else { Seq::Once };
    Ok(Value::seq(kind, head))
}

/// Pairs of key and value of a dict.
pub fn pairs(run: &mut Run<'_, '_>, value: Value) -> Result<u16> {
    let head = run.memory.new_list();
    for index in 0..run.length(value).unwrap_or(0) {
        let (key, part) = run.entry(value, index)?;
        let pair = run.seq(Seq::Tuple, &[key, part]);
        run.append(head, pair);
    }
    Ok(head)
}

fn items(run: &mut Run<'_, '_>, value: Value) -> Result<Value> {
    if !value.is(types::DICT | types::UNDEFINED) {
        return Err(wrong(&run.memory, Words::WantsDict, value));
    }
    pairs(run, value).map(|head| Value::seq(Seq::Once, head))
}

fn batch(run: &mut Run<'_, '_>, value: Value, count: i64, fill: Option<Value>) -> Result<Value> {
    let fill = fill.filter(|fill| !fill.is_none());
    let all = run.memory.new_list();
    let length = run.iterate(value)?;
    let mut index = 0;
    while index < length {
        let head = run.memory.new_list();
        loop {
            let element = run.element(value, index)?;
            run.append(head, element);
            index += 1;
            if index >= length || run.memory.count(head) as i64 == count {
                break;
            }
        }
        while let Some(fill) = fill
            && (run.memory.count(head) as i64) < count
            && !run.memory.is_full
        {
            run.append(head, fill);
        }
        run.append(all, Value::seq(Seq::List, head));
    }
    run.use_up(value);
    Ok(Value::seq(Seq::Once, all))
}

fn slices(run: &mut Run<'_, '_>, value: Value, count: i64, fill: Option<Value>) -> Result<Value> {
    let fill = fill.filter(|fill| !fill.is_none());
    let length = run.iterate(value)? as i64;
    let all = run.memory.new_list();
    let Some((each, extra)) = numbers::divided(length, count) else {
        return run.memory.fail(Words::ZeroStep);
    };
    let mut index = 0;
    for slice in 0..count {
        if run.memory.is_full {
            break;
        }
        let head = run.memory.new_list();
        for _ in 0..each + i64::from(slice < extra) {
            let element = run.element(value, index)?;
            run.append(head, element);
            index += 1;
        }
        if let Some(fill) = fill
            && slice >= extra
        {
            run.append(head, fill);
        }
        run.append(all, Value::seq(Seq::List, head));
    }
    run.use_up(value);
    Ok(Value::seq(Seq::Once, all))
}

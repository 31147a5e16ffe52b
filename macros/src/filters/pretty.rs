//! `pprint`: values as text of at most 80 columns, dicts in the order of their keys.

use core::cmp::Ordering;

use crate::fault::Result;
use crate::run::{Run, order};
use crate::value::{DEEPEST, Map, SIZE, Seq, Value, View, types};

/// Columns of a line.
const WIDTH: usize = 80;

/// A value as `pprint` writes it.
pub fn pretty(run: &mut Run<'_, '_>, value: Value) -> Result<Value> {
    let value = run.settle(value, DEEPEST)?;
    let value = arrange(run, value, DEEPEST)?;
    let from = run.memory.top;
    write(run, value, 0, 0, DEEPEST)?;
    Ok(Value::str(run.memory.text_since(from)))
}

/// A copy with all dicts in the order of their keys.
fn arrange(run: &mut Run<'_, '_>, value: Value, depth: u8) -> Result<Value> {
    if depth == 0 {
        return run.memory.fail(crate::fault::Words::TooDeep);
    }
    match value.view() {
        View::Map(Map::Dict, head) => {
            let map = run.map(Map::Dict, run.memory.count(head));
            let Some(sorted) = map.head() else { return Ok(map) };
            for index in 0..run.memory.count(head) {
                let (key, part) = run.entry(value, index)?;
                let part = arrange(run, part, depth - 1)?;
                run.put(sorted, key, part)?;
                move_up(run, map, sorted, index)?;
            }
            Ok(map)
        }
        View::Seq(kind @ (Seq::List | Seq::Tuple), head) => {
            let sorted = run.memory.new_block(run.memory.count(head), SIZE);
            for index in 0..run.memory.count(head) {
                let part = run.element(value, index)?;
                let part = arrange(run, part, depth - 1)?;
                run.append(sorted, part);
            }
            Ok(Value::seq(kind, sorted))
        }
        _ => Ok(value),
    }
}

/// Moves the last entry of a dict before those with greater keys.
fn move_up(run: &mut Run<'_, '_>, map: Value, head: u16, last: usize) -> Result<()> {
    let (key, _) = run.entry(map, last)?;
    let mut place = last;
    while place > 0 {
        let (before, _) = run.entry(map, place - 1)?;
        // Keys without an order among them go by the names of their types; that of `None` has a capital.
        let order = order::order(run, key, before, DEEPEST).unwrap_or_else(|_| {
            let name = |value: Value| (!value.is_none(), value.kind());
            Some(name(key).cmp(&name(before)))
        });
        if order != Some(Ordering::Less) {
            break;
        }
        place -= 1;
    }
    let first = run.memory.place(head, 0, 2 * SIZE);
    let at = |index: usize| first + index * 2 * SIZE;
    run.memory.rotate(at(place), at(last + 1), (last - place) * 2 * SIZE);
    Ok(())
}

/// Appends a value that begins in a column, with room for what follows it.
fn write(run: &mut Run<'_, '_>, value: Value, column: usize, after: usize, depth: u8) -> Result<()> {
    let from = run.memory.top;
    run.write_repr(value, depth)?;
    let width = crate::chars::count(run.memory.text(run.memory.text_since(from)));
    let length = match value.head() {
        Some(head) if value.is(types::DICT | types::LIST | types::TUPLE) => run.memory.count(head),
        _ => 0,
    };
    if width + column + after <= WIDTH || length == 0 {
        return Ok(());
    }
    run.memory.top = from;
    let (begin, end) = if value.is(types::DICT) {
        ("{", "}")
    } else if value.is(types::TUPLE) {
        ("(", if length == 1 { ",)" } else { ")" })
    } else {
        ("[", "]")
    };
    run.memory.push_bytes(begin.as_bytes());
    for index in 0..length {
        if index > 0 {
            run.memory.push_bytes(b",\n");
            run.memory.push_chars(' ', column + 1);
        }
        let after = if index + 1 == length { after + end.len() } else { 1 };
        let mut start = column + 1;
        let part = if value.is(types::DICT) {
            let (key, part) = run.entry(value, index)?;
            let from = run.memory.top;
            run.write_repr(key, depth - 1)?;
            run.memory.push_bytes(b": ");
            start += crate::chars::count(run.memory.text(run.memory.text_since(from)));
            part
        } else {
            run.element(value, index)?
        };
        write(run, part, start, after, depth - 1)?;
    }
    run.memory.push_bytes(end.as_bytes());
    Ok(())
}

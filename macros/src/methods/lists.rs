//! Methods of lists and tuples.

use crate::arguments::{Bound, needed};
use crate::fault::{Result, fail};
use crate::filters::strings::whole;
use crate::memory::Block;
use crate::run::containers::fixed;
use crate::run::{Run, order};
use crate::value::{DEEPEST, SIZE, Seq, Value};

/// Result of a method of a list or tuple.
pub fn call(run: &mut Run<'_, '_>, list: Value, name: &'static str, bound: &Bound) -> Result<Value> {
    let [first, second, ..] = *bound;
    match name {
        "index" | "count" => return search(run, list, needed(first)?, name == "count"),
        "copy" => return run.list_of(Seq::List, list),
        "__len__" => return Ok(Value::Int(run.length(list).unwrap_or(0) as i64)),
        "__getitem__" => {
            let key = needed(first)?;
            return match run.item(list, key)? {
                Value::Undefined(_) => fail(&"the list has no element of this number"),
                element => Ok(element),
            };
        }
        _ => {}
    }
    let Value::Seq(Seq::List, head) = list else { return Err(fixed()) };
    let block = run.memory.block(head);
    match name {
        "append" => append(run, head, needed(first)?)?,
        "extend" => {
            let more = needed(first)?;
            for index in 0..run.iterate(more)? {
                let element = run.element(more, index)?;
                append(run, head, element)?;
            }
            run.use_up(more);
        }
        "insert" => {
            let (at, value) = (place(whole(run, needed(first)?)?, block.len, true)?, needed(second)?);
            append(run, head, value)?;
            let data = run.memory.block(head).data;
            run.memory.rotate(data + at * SIZE, data + (block.len + 1) * SIZE, (block.len - at) * SIZE);
        }
        "pop" => return remove_at(run, head, whole(run, first.unwrap_or(Value::Int(-1)))?),
        "remove" => {
            let Value::Int(at) = search(run, list, needed(first)?, false)? else { return Ok(Value::None) };
            remove_at(run, head, at)?;
        }
        "reverse" => {
            for index in 0..block.len / 2 {
                let places = [index, block.len - 1 - index].map(|index| block.data + index * SIZE);
                let [a, b] = places.map(|at| run.memory.value(at));
                run.memory.set_value(places[0], b);
                run.memory.set_value(places[1], a);
            }
        }
        "clear" => run.memory.set_block(head, Block { len: 0, ..block }),
        "__setitem__" => {
            let (at, value) = (place(whole(run, needed(first)?)?, block.len, false)?, needed(second)?);
            run.memory.set_value(block.data + at * SIZE, value);
            run.keep();
        }
        _ => return fail(&"this function of lists is not known: use the filter sort"),
    }
    Ok(Value::None)
}

/// Appends a value that stays when the statement is over.
fn append(run: &mut Run<'_, '_>, head: u16, value: Value) -> Result<()> {
    let before = run.memory.block(head);
    run.append(head, value)?;
    let is_new = before.room != run.memory.block(head).room;
    if is_new || value.lies_behind(run.memory.keep, run.memory.pool) {
        run.keep();
    }
    Ok(())
}

/// Place of an element by its number, from the end if negative.
fn place(index: i64, length: usize, may_be_outside: bool) -> Result<usize> {
    let length = length as i64;
    let place = if index < 0 { index.saturating_add(length) } else { index };
    if may_be_outside {
        return Ok(place.max(0).min(length) as usize);
    }
    if place < 0 || place >= length {
        return fail(&"the list has no element of this number");
    }
    Ok(place as usize)
}

fn remove_at(run: &mut Run<'_, '_>, head: u16, index: i64) -> Result<Value> {
    let block = run.memory.block(head);
    let at = place(index, block.len, false)?;
    let value = run.memory.value(block.data + at * SIZE);
    run.memory.rotate(block.data + at * SIZE, block.data + block.len * SIZE, SIZE);
    run.memory.set_block(head, Block { len: block.len - 1, ..block });
    Ok(value)
}

fn search(run: &mut Run<'_, '_>, list: Value, value: Value, counts: bool) -> Result<Value> {
    let mut count = 0;
    for index in 0..run.iterate(list)? {
        let element = run.element(list, index)?;
        if order::equal(run, element, value, DEEPEST)? {
            if !counts {
                return Ok(Value::Int(index as i64));
            }
            count += 1;
        }
    }
    if counts { Ok(Value::Int(count)) } else { fail(&"the value is not in the list: ask with in before") }
}

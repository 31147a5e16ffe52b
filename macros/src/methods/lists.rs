//! Methods of lists and tuples.

use crate::arguments::{Bound, needed, whole};
use crate::fault::{Result, Words};
use crate::names::OfList;
use crate::run::containers::fixed;
use crate::run::{Run, order};
use crate::value::{DEEPEST, SIZE, Seq, Value, View};

/// Result of a method of a list or tuple.
#[inline(never)]
pub fn call(run: &mut Run<'_, '_>, list: Value, method: OfList, bound: &Bound) -> Result<Value> {
    let [first, second, ..] = *bound;
    match method {
        OfList::Index | OfList::Count => return search(run, list, needed(run, first)?, method == OfList::Count),
        OfList::Copy => return run.list_of(Seq::List, list),
        OfList::Length => return Ok(Value::count(run.length(list).unwrap_or(0))),
        OfList::Get => {
            let key = needed(run, first)?;
            let element = run.item(list, key)?;
            return if element.is_undefined() { run.memory.fail(Words::NoElement) } else { Ok(element) };
        }
        _ => {}
    }
    let View::Seq(Seq::List, head) = list.view() else { return Err(fixed(run)) };
    let count = run.memory.count(head);
    match method {
        OfList::Append => append(run, head, needed(run, first)?)?,
        OfList::Extend => {
            let more = needed(run, first)?;
            for index in 0..run.iterate(more)? {
                let element = run.element(more, index)?;
                append(run, head, element)?;
            }
            run.use_up(more);
        }
        OfList::Insert => {
            let (at, value) = (place(run, whole(run, needed(run, first)?)?, count, true)?, needed(run, second)?);
            append(run, head, value)?;
            let data = run.memory.place(head, 0, SIZE);
            run.memory.rotate(data + at * SIZE, data + (count + 1) * SIZE, (count - at) * SIZE);
        }
        OfList::Pop => return remove_at(run, head, whole(run, first.unwrap_or(Value::small(-1)))?),
        OfList::Remove => {
            let at = search(run, list, needed(run, first)?, false)?.as_short().unwrap_or(0);
            remove_at(run, head, at)?;
        }
        OfList::Reverse => {
            for index in 0..count / 2 {
                let places = [index, count - 1 - index].map(|index| run.memory.place(head, index, SIZE));
                let [a, b] = places.map(|at| run.memory.value(at));
                run.memory.set_value(places[0], b);
                run.memory.set_value(places[1], a);
            }
        }
        OfList::Clear => run.memory.set_count(head, 0),
        OfList::Set => {
            let (at, value) = (place(run, whole(run, needed(run, first)?)?, count, false)?, needed(run, second)?);
            let place = run.memory.place(head, at, SIZE);
            run.memory.set_value(place, value);
            run.keep();
        }
        _ => return run.memory.fail(Words::ListSort),
    }
    Ok(Value::NONE)
}

/// Appends a value that stays when the statement is over.
fn append(run: &mut Run<'_, '_>, head: u16, value: Value) -> Result<()> {
    let before = run.memory.block(head);
    run.append(head, value);
    let is_new = before.room != run.memory.block(head).room;
    if is_new || value.lies_behind(run.memory.keep, run.memory.pool) {
        run.keep();
    }
    Ok(())
}

/// Place of an element by its number, from the end if negative.
fn place(run: &Run<'_, '_>, index: i64, length: usize, may_be_outside: bool) -> Result<usize> {
    let length = length as i64;
    let place = if index < 0 { index.saturating_add(length) } else { index };
    if may_be_outside {
        return Ok(place.max(0).min(length) as usize);
    }
    if place < 0 || place >= length {
        return run.memory.fail(Words::NoElement);
    }
    Ok(place as usize)
}

fn remove_at(run: &mut Run<'_, '_>, head: u16, index: i64) -> Result<Value> {
    let count = run.memory.count(head);
    let at = place(run, index, count, false)?;
    let value = run.memory.element(head, at);
    let (from, to) = (run.memory.place(head, at, SIZE), run.memory.place(head, count, SIZE));
    run.memory.rotate(from, to, SIZE);
    run.memory.set_count(head, count - 1);
    Ok(value)
}

fn search(run: &mut Run<'_, '_>, list: Value, value: Value, counts: bool) -> Result<Value> {
    let mut count = 0;
    for index in 0..run.iterate(list)? {
        let element = run.element(list, index)?;
        if order::equal(run, element, value, DEEPEST)? {
            if !counts {
                return Ok(Value::count(index));
            }
            count += 1;
        }
    }
    if counts { Ok(Value::count(count)) } else { run.memory.fail(Words::NotInList) }
}

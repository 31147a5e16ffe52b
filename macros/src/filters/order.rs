//! Filters that compare elements: the least, the greatest, sorted, each once.

use core::cmp::Ordering;

use super::sequences::{pairs, path_of};
use crate::arguments::Bound;
use crate::chars::Case;
use crate::fault::{Result, Words};
use crate::memory::Text;
use crate::names::Filter;
use crate::run::{Run, order, wrong};
use crate::value::{DEEPEST, SIZE, Seq, Value, types};

/// Rule by which elements are compared.
#[derive(Clone, Copy, Debug)]
struct Rule {
    path: Option<Value>,
    minds_case: bool,
    /// Whether equal elements need no order, as Jinja2 has it where it sorts lists.
    is_lenient: bool,
}

/// Result of a filter that compares.
#[inline(never)]
pub fn apply(run: &mut Run<'_, '_>, filter: Filter, value: Value, bound: &Bound) -> Result<Value> {
    let [first, second, third, _] = *bound;
    let mut truth = |value: Option<Value>| value.is_some_and(|value| run.truth(value));
    match filter {
        Filter::Min | Filter::Max => {
            let rule = Rule { path: second, minds_case: truth(first), is_lenient: false };
            extreme(run, value, rule, filter == Filter::Max)
        }
        Filter::Unique => {
            let rule = Rule { path: second, minds_case: truth(first), is_lenient: false };
            unique(run, value, rule)
        }
        Filter::Sort => {
            let is_reverse = truth(first);
            let rule = Rule { path: third, minds_case: truth(second), is_lenient: true };
            let list = run.list_of(Seq::List, value)?;
            sort(run, list, rule, is_reverse)
        }
        _ => {
            let rule = Rule { path: None, minds_case: truth(first), is_lenient: false };
            let is_reverse = truth(third);
            sort_dict(run, value, rule, second, is_reverse)
        }
    }
}

impl Rule {
    /// The value by which an element is compared.
    fn key(self, run: &mut Run<'_, '_>, element: Value) -> Result<Value> {
        let key = match self.path {
            None => element,
            Some(path) if path.is_none() => element,
            Some(path) => match path.text() {
                Some(paths) if run.memory.bytes(paths).contains(&b',') => return self.keys(run, element, paths),
                _ => path_of(run, element, path)?,
            },
        };
        self.fold(run, key)
    }

    /// A tuple of what several paths lead to.
    fn keys(self, run: &mut Run<'_, '_>, element: Value, paths: Text) -> Result<Value> {
        let head = run.memory.new_list();
        let mut rest = paths;
        loop {
            let end = crate::chars::place_of(run.memory.text(rest), b',').unwrap_or(rest.len());
            let key = path_of(run, element, Value::str(rest.part(0, end)))?;
            let key = self.fold(run, key)?;
            run.append(head, key);
            if end == rest.len() {
                return Ok(Value::seq(Seq::Tuple, head));
            }
            rest = rest.rest(end + 1);
        }
    }

    fn fold(self, run: &mut Run<'_, '_>, key: Value) -> Result<Value> {
        match key.text() {
            Some(text) if !self.minds_case => Ok(run.change(text, Case::Lower)),
            _ => Ok(key),
        }
    }
}

fn extreme(run: &mut Run<'_, '_>, value: Value, rule: Rule, is_greatest: bool) -> Result<Value> {
    let length = run.iterate(value)?;
    if length == 0 {
        return Ok(Value::MISSING);
    }
    let mut best = run.element(value, 0)?;
    let mut best_key = rule.key(run, best)?;
    for index in 1..length {
        let element = run.element(value, index)?;
        let key = rule.key(run, element)?;
        let wanted = if is_greatest { Ordering::Greater } else { Ordering::Less };
        if order::order(run, key, best_key, DEEPEST)? == Some(wanted) {
            (best, best_key) = (element, key);
        }
    }
    run.use_up(value);
    Ok(best)
}

/// Sorts a list in its place: equal elements keep their order.
fn sort(run: &mut Run<'_, '_>, list: Value, rule: Rule, is_reverse: bool) -> Result<Value> {
    let Some(head) = list.head() else { return Ok(list) };
    let first = run.memory.place(head, 0, SIZE);
    let at = |index: usize| first + index * SIZE;
    let wanted = if is_reverse { Ordering::Greater } else { Ordering::Less };
    for end in 1..run.memory.count(head) {
        let top = run.memory.top;
        let element = run.memory.value(at(end));
        let key = rule.key(run, element)?;
        let mut place = end;
        while place > 0 {
            let before = run.memory.value(at(place - 1));
            let before_key = rule.key(run, before)?;
            let is_equal = rule.is_lenient && order::equal(run, key, before_key, DEEPEST)?;
            if is_equal || order::order(run, key, before_key, DEEPEST)? != Some(wanted) {
                break;
            }
            run.memory.set_value(at(place), before);
            place -= 1;
        }
        run.memory.set_value(at(place), element);
        run.memory.top = top;
    }
    Ok(list)
}

fn sort_dict(run: &mut Run<'_, '_>, value: Value, rule: Rule, by: Option<Value>, is_reverse: bool) -> Result<Value> {
    if !value.is(types::DICT) {
        return Err(wrong(&run.memory, Words::WantsDict, value));
    }
    let index = match by.map_or(&b"key"[..], |by| run.memory.bytes(by.text().unwrap_or_default())) {
        b"key" => 0,
        b"value" => 1,
        _ => return run.memory.fail(Words::KeyOrValue),
    };
    let head = pairs(run, value)?;
    let rule = Rule { path: Some(Value::small(index)), ..rule };
    sort(run, Value::seq(Seq::List, head), rule, is_reverse)
}

fn unique(run: &mut Run<'_, '_>, value: Value, rule: Rule) -> Result<Value> {
    let (head, seen) = (run.memory.new_list(), run.memory.new_block(0, SIZE));
    for index in 0..run.iterate(value)? {
        let element = run.element(value, index)?;
        let key = rule.key(run, element)?;
        if !order::is_hashable(run, key) {
            return Err(wrong(&run.memory, Words::NotHashable, key));
        }
        if !order::contains(run, key, Value::seq(Seq::List, seen))? {
            run.append(seen, key);
            run.append(head, element);
        }
    }
    run.use_up(value);
    Ok(Value::seq(Seq::Once, head))
}

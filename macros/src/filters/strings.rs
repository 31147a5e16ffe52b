//! Filters that change or measure strings.

use crate::arguments::{Bound, needed, optional_text, whole};
use crate::chars::{self, Case, Sides};
use crate::fault::{Result, Words};
use crate::memory::Text;
use crate::names::Filter;
use crate::run::{Run, wrong};
use crate::value::Value;

/// Result of a filter of strings.
pub fn apply(run: &mut Run<'_, '_>, filter: Filter, value: Value, bound: &Bound) -> Result<Value> {
    let [first, second, third, _] = *bound;
    let text = run.text_of(value)?;
    match filter {
        Filter::Lower => Ok(run.change(text, Case::Lower)),
        Filter::Upper => Ok(run.change(text, Case::Upper)),
        Filter::Capitalize => Ok(run.change(text, Case::Capital)),
        Filter::Title => Ok(run.change(text, Case::Words)),
        Filter::Trim => {
            let set = optional_text(run, first)?;
            Ok(Value::str(run.strip(text, set, Sides::Both)))
        }
        Filter::Replace => {
            let old = run.text_of(needed(run, first)?)?;
            let new = run.text_of(needed(run, second)?)?;
            let count = third.filter(|count| !count.is_none()).map_or(Ok(-1), |count| whole(run, count))?;
            Ok(run.replace(text, old, new, count))
        }
        Filter::Center => {
            let width = whole(run, first.unwrap_or(Value::small(80)))?;
            Ok(center(run, text, width, ' '))
        }
        Filter::WordCount => {
            let mut count = 0;
            let mut was_word = false;
            for char in run.memory.text(text).chars() {
                let is_word = chars::is_word(char) || char == '_';
                count += usize::from(is_word && !was_word);
                was_word = is_word;
            }
            Ok(Value::count(count))
        }
        Filter::Indent => indent(run, value, [first, second, third]),
        _ => truncate(run, value, bound),
    }
}

/// A string in the middle of a width; an odd blank goes where Python puts it.
pub fn center(run: &mut Run<'_, '_>, text: Text, width: i64, fill: char) -> Value {
    let length = crate::chars::count(run.memory.text(text));
    let width = usize::try_from(width).unwrap_or(0);
    let missing = width.saturating_sub(length);
    let left = missing / 2 + (missing & width & 1);
    run.pad(text, (left, missing - left), fill)
}

fn indent(run: &mut Run<'_, '_>, value: Value, [width, first, blank]: [Option<Value>; 3]) -> Result<Value> {
    let Some(text) = value.text() else { return Err(wrong(&run.memory, Words::WantsText, value)) };
    let width = width.unwrap_or(Value::small(4));
    let indention = match width.text() {
        Some(text) => text,
        None => {
            let from = run.memory.top;
            let width = usize::try_from(whole(run, width)?).unwrap_or(0);
            run.memory.push_chars(' ', width);
            run.memory.text_since(from)
        }
    };
    let (first, blank) = (first.unwrap_or(Value::bool(false)), blank.unwrap_or(Value::bool(false)));
    let (first, blank) = (run.truth(first), run.truth(blank));
    let lines = run.split_lines(text);
    let count = run.iterate(lines)?.max(1);
    let from = run.memory.top;
    for index in 0..count {
        let line = if run.length(lines) == Some(0) {
            Text::default()
        } else {
            run.element(lines, index)?.text().unwrap_or_default()
        };
        if index > 0 {
            run.memory.push_byte(b'\n');
        }
        if if index == 0 { first } else { blank || line.len() > 0 } {
            run.memory.push_text(indention);
        }
        run.memory.push_text(line);
    }
    if run.memory.text(text).ends_with('\n') {
        run.memory.push_byte(b'\n');
        if blank {
            run.memory.push_text(indention);
        }
    }
    Ok(Value::str(run.memory.text_since(from)))
}

fn truncate(run: &mut Run<'_, '_>, value: Value, bound: &Bound) -> Result<Value> {
    let [length, kill, end, leeway] = *bound;
    let length = whole(run, length.unwrap_or(Value::small(255)))?;
    let leeway = whole(run, leeway.unwrap_or(Value::small(5)))?;
    let end = match end {
        None => run.str("..."),
        Some(end) => end,
    };
    let Some(end) = end.text() else { return Err(wrong(&run.memory, Words::WantsText, end)) };
    let rest = length - crate::chars::count(run.memory.text(end)) as i64;
    if rest < 0 || leeway < 0 {
        return run.memory.fail(Words::TruncateLength);
    }
    if run.length(value).is_some_and(|count| count as i64 <= length + leeway) {
        return Ok(value);
    }
    let Some(text) = value.text() else { return Err(wrong(&run.memory, Words::WantsText, value)) };
    let string = run.memory.text(text);
    let cut = chars::place(string, rest as usize);
    let mut kept = text.part(0, cut);
    if !kill.is_some_and(|kill| run.truth(kill))
        && let Some(blank) = run.memory.bytes(kept).iter().rposition(|byte| *byte == b' ')
    {
        kept = kept.part(0, blank);
    }
    Ok(run.join_two(kept, end))
}

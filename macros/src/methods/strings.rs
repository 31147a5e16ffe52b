//! Methods of strings, as Python has them.

use crate::arguments::{Bound, needed, optional_text as optional, text as string, whole};
use crate::chars::{self, Case, Sides};
use crate::fault::{Result, Words};
use crate::filters::strings::center;
use crate::memory::Text;
use crate::names::OfString;
use crate::run::{Run, wrong};
use crate::value::{Seq, Value, View};

/// Result of a method of a string.
#[inline(never)]
pub fn call(run: &mut Run<'_, '_>, text: Text, method: OfString, bound: &Bound) -> Result<Value> {
    let [first, second, third, _] = *bound;
    match method {
        OfString::Split => run.split(text, optional(run, first)?, whole(run, second.unwrap_or(Value::small(-1)))?),
        OfString::RSplit => {
            split_from_end(run, text, optional(run, first)?, whole(run, second.unwrap_or(Value::small(-1)))?)
        }
        OfString::SplitLines => Ok(run.split_lines(text)),
        OfString::StartsWith | OfString::EndsWith => {
            has_end(run, text, needed(run, first)?, method == OfString::StartsWith).map(Value::bool)
        }
        OfString::Lower => Ok(run.change(text, Case::Lower)),
        OfString::Upper => Ok(run.change(text, Case::Upper)),
        OfString::Capitalize => Ok(run.change(text, Case::Capital)),
        OfString::Title => Ok(run.change(text, Case::Title)),
        OfString::SwapCase => Ok(run.change(text, Case::Swapped)),
        OfString::Strip | OfString::LStrip | OfString::RStrip => {
            let sides = match method {
                OfString::LStrip => Sides::Left,
                OfString::RStrip => Sides::Right,
                _ => Sides::Both,
            };
            Ok(Value::str(run.strip(text, optional(run, first)?, sides)))
        }
        OfString::Replace => Ok(run.replace(
            text,
            string(run, first)?,
            string(run, second)?,
            whole(run, third.unwrap_or(Value::small(-1)))?,
        )),
        OfString::Join => run.join(needed(run, first)?, text, true),
        OfString::ZFill => fill_zeros(run, text, whole(run, needed(run, first)?)?),
        OfString::LJust | OfString::RJust | OfString::Center => justify(run, text, method, first, second),
        OfString::RemovePrefix => {
            let part = string(run, first)?;
            let has = run.memory.text(text).starts_with(run.memory.text(part));
            Ok(Value::str(if has { text.rest(part.len()) } else { text }))
        }
        OfString::RemoveSuffix => {
            let part = string(run, first)?;
            let has = run.memory.text(text).ends_with(run.memory.text(part));
            Ok(Value::str(if has { text.part(0, text.len() - part.len()) } else { text }))
        }
        OfString::Partition | OfString::RPartition => {
            partition(run, text, string(run, first)?, method == OfString::RPartition)
        }
        OfString::Find | OfString::RFind | OfString::Index | OfString::Count => {
            search(run, text, method, string(run, first)?)
        }
        _ => Ok(Value::bool(is_kind(run.memory.text(text), method))),
    }
}

fn is_kind(text: &str, method: OfString) -> bool {
    let holds = |char: char| match method {
        OfString::IsDigit => char.is_ascii_digit(),
        OfString::IsAlpha => chars::is_word(char) && !char.is_ascii_digit(),
        OfString::IsAlnum => chars::is_word(char),
        _ => chars::is_blank(char),
    };
    match method {
        OfString::IsUpper | OfString::IsLower => crate::filters::has_case(text, method == OfString::IsUpper),
        _ => !text.is_empty() && text.chars().all(holds),
    }
}

fn search(run: &mut Run<'_, '_>, text: Text, method: OfString, part: Text) -> Result<Value> {
    let (string, part) = (run.memory.text(text), run.memory.text(part));
    let found = match method {
        OfString::Count if part.is_empty() => return Ok(Value::count(chars::count(string) + 1)),
        OfString::Count => {
            let next = |at: usize| chars::find(string, part, at).map(|at| at + part.len());
            let places = core::iter::successors(next(0), |at| next(*at));
            return Ok(Value::count(places.count()));
        }
        OfString::RFind => chars::find_last(string, part),
        _ => chars::find(string, part, 0),
    };
    match found {
        Some(at) => Ok(Value::count(crate::chars::count(string.get(..at).unwrap_or_default()))),
        None if method == OfString::Index => run.memory.fail(Words::NotInList),
        None => Ok(Value::small(-1)),
    }
}

fn has_end(run: &mut Run<'_, '_>, text: Text, end: Value, is_start: bool) -> Result<bool> {
    let is = |run: &Run<'_, '_>, end: Text| {
        let (string, end) = (run.memory.text(text), run.memory.text(end));
        if is_start { string.starts_with(end) } else { string.ends_with(end) }
    };
    match end.view() {
        View::Str(end) => Ok(is(run, end)),
        View::Seq(Seq::Tuple, _) => {
            for index in 0..run.iterate(end)? {
                let element = run.element(end, index)?;
                if is(run, string(run, Some(element))?) {
                    return Ok(true);
                }
            }
            Ok(false)
        }
        _ => Err(wrong(&run.memory, Words::WantsText, end)),
    }
}

fn split_from_end(run: &mut Run<'_, '_>, text: Text, separator: Option<Text>, most: i64) -> Result<Value> {
    if most < 0 {
        return run.split(text, separator, most);
    }
    let Some(separator) = separator else { return run.memory.fail(Words::EmptySeparator) };
    let all = run.split(text, Some(separator), -1)?;
    let extra = run.length(all).unwrap_or(0) as i64 - 1 - most;
    if extra <= 0 {
        return Ok(all);
    }
    let mut end = 0;
    for index in 0..=extra {
        if let Some(part) = run.element(all, index as usize)?.text() {
            end = part.at() + part.len() - text.at();
        }
    }
    let list = run.seq(Seq::List, &[Value::str(text.part(0, end))]);
    let Some(head) = list.head() else { return Ok(list) };
    for index in extra + 1..=extra + most {
        let part = run.element(all, index as usize)?;
        run.append(head, part);
    }
    Ok(list)
}

fn fill_zeros(run: &mut Run<'_, '_>, text: Text, width: i64) -> Result<Value> {
    let string = run.memory.text(text);
    let has_sign = string.starts_with(['-', '+']);
    let missing = usize::try_from(width).unwrap_or(0).saturating_sub(crate::chars::count(string));
    let sign = usize::from(has_sign);
    let from = run.memory.top;
    run.memory.push_text(text.part(0, sign));
    run.memory.push_chars('0', missing);
    run.memory.push_text(text.rest(sign));
    Ok(Value::str(run.memory.text_since(from)))
}

fn justify(
    run: &mut Run<'_, '_>,
    text: Text,
    method: OfString,
    width: Option<Value>,
    fill: Option<Value>,
) -> Result<Value> {
    let width = whole(run, needed(run, width)?)?;
    let mut fill_char = ' ';
    if let Some(fill) = optional(run, fill)? {
        let mut chars = run.memory.text(fill).chars();
        let (Some(char), None) = (chars.next(), chars.next()) else {
            return run.memory.fail(Words::OneCharacter);
        };
        fill_char = char;
    }
    let length = crate::chars::count(run.memory.text(text));
    let missing = usize::try_from(width).unwrap_or(0).saturating_sub(length);
    match method {
        OfString::LJust => Ok(run.pad(text, (0, missing), fill_char)),
        OfString::RJust => Ok(run.pad(text, (missing, 0), fill_char)),
        _ => Ok(center(run, text, width, fill_char)),
    }
}

fn partition(run: &mut Run<'_, '_>, text: Text, separator: Text, from_end: bool) -> Result<Value> {
    let (string, part) = (run.memory.text(text), run.memory.text(separator));
    if part.is_empty() {
        return run.memory.fail(Words::EmptySeparator);
    }
    let found = if from_end { chars::find_last(string, part) } else { chars::find(string, part, 0) };
    let empty = text.part(0, 0);
    let parts = match found {
        Some(at) => [text.part(0, at), separator, text.rest(at + separator.len())],
        None if from_end => [empty, empty, text],
        None => [text, empty, empty],
    };
    Ok(run.seq(Seq::Tuple, &parts.map(Value::str)))
}

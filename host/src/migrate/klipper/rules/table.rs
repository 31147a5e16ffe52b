//! Rules for the options of a section that need no thought: one line each.

use super::super::account::{Class, Verdict};
use super::super::migration::{Migration, text};
use super::super::source::truth;

/// Rule for one option.
#[derive(Clone, Copy)]
pub enum Rule {
    /// Becomes this section's key, in the instance that the table is applied to.
    To(&'static str, &'static str, Change),
    /// Needs nothing, with the reason.
    Needless(&'static str),
    /// Nothing does the same: the reason, and the nearest thing.
    Refused(&'static str, &'static str),
    /// Says what Velvet does anyway; any other value is refused with the reason and the nearest thing.
    Only(&'static str, &'static str, &'static str),
}

/// Change of a value on its way.
#[derive(Clone, Copy)]
pub enum Change {
    /// None: a word.
    Word,
    /// A number times this.
    Times(f64),
    /// A number times this, as a whole number.
    Whole(f64),
    /// A truth value.
    Truth,
    /// Numbers with commas.
    Numbers,
}

/// A number as it is.
pub const NUMBER: Change = Change::Times(1.0);

/// Length of a line in the configuration.
const LONGEST_LINE: usize = 96;

/// Writes the line that carries out an option's template: the option itself where it is one plain line.
/// Returns whether there is such a line.
pub fn template(m: &mut Migration<'_>, section: usize, option: &str, target: (&'static str, &str, &str)) -> bool {
    let Some(script) = m.section(section).get(option).map(str::to_owned) else { return false };
    let named = format!("RUN_TEMPLATE SECTION=\"{}\" OPTION={option}", m.section(section).name);
    match one_line(&script) {
        Some("") => m.needless(section, option, "there is nothing in it"),
        Some(line) => m.put(section, option, target, line),
        None if named.len() <= LONGEST_LINE => {
            m.put_for(section, option, target, named, "its template is read from printer.cfg");
        }
        None => m.refuse(section, option, "the line that names its template is too long", "a shorter name"),
    }
    m.written(target).is_some()
}

/// Returns a script that is a single plain line.
fn one_line(script: &str) -> Option<&str> {
    let mut lines = script.lines().map(str::trim).filter(|line| !line.is_empty());
    let first = lines.next().unwrap_or("");
    let is_plain = lines.next().is_none() && !first.contains(['{', '}', '#', '|']) && first.len() <= LONGEST_LINE;
    is_plain.then_some(first)
}

/// Applies rules to the options of a section that are there and have no verdict yet.
pub fn apply(m: &mut Migration<'_>, section: usize, instance: &str, rows: &[(&str, Rule)]) {
    for (option, rule) in rows {
        let Some(value) = m.section(section).get(option).filter(|_| !m.is_judged(section, option)) else { continue };
        match *rule {
            Rule::To(to, key, change) => convert(m, section, option, (to, instance, key), change, value),
            Rule::Needless(why) => m.needless(section, option, why),
            Rule::Refused(why, nearest) => m.refuse(section, option, why, nearest),
            Rule::Only(same, why, nearest) => match alike(value, same) {
                true => m.judge(section, option, Verdict::new(Class::Converted, "Velvet does so anyway")),
                false => m.refuse(section, option, why, nearest),
            },
        }
    }
}

/// Returns whether two values say the same: as numbers, as truth values or as words.
fn alike(value: &str, other: &str) -> bool {
    let numbers = [value, other].map(super::super::source::number);
    let truths = [value, other].map(truth);
    match (numbers, truths) {
        ([Some(a), Some(b)], _) => (a - b).abs() < 1e-9,
        (_, [Some(a), Some(b)]) => a == b,
        _ => value.eq_ignore_ascii_case(other),
    }
}

fn convert(
    m: &mut Migration<'_>,
    section: usize,
    option: &str,
    target: (&'static str, &str, &str),
    change: Change,
    value: &str,
) {
    match change {
        Change::Word => m.put(section, option, target, value.to_lowercase()),
        Change::Times(factor) => m.scaled(section, option, target, factor),
        Change::Whole(factor) => {
            if let Some(number) = m.number(section, option) {
                m.put(section, option, target, text((number * factor).round()));
            }
        }
        Change::Truth => match truth(value) {
            Some(truth) => m.put(section, option, target, truth.to_string()),
            None => m.refuse(section, option, "this is neither true nor false", "correct it"),
        },
        Change::Numbers => match super::super::source::numbers(value) {
            Some(all) => {
                let all: Vec<String> = all.into_iter().map(text).collect();
                m.put(section, option, target, all.join(","));
            }
            None => m.refuse(section, option, "this is no list of numbers", "correct it"),
        },
    }
}

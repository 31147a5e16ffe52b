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

//! Suggestions for names that the schema does not have.

use crate::diagnostic::Severity;
use crate::schema::{Form, SECTIONS, Section, Setting, Support, by_v1_name, instance_of};
use crate::text::{cut, nearest};
use core::fmt;
use heapless::String;

/// Returns where the settings of a section of Klipper are.
pub(crate) fn klipper_section(name: &str) -> Option<&'static str> {
    let first = name.split([' ', '_']).next().filter(|first| !first.is_empty())?;
    let of_klipper = |row: &Setting| {
        let section = row.klipper_section.text();
        !section.is_empty() && (section == name || section.split(['_', ' ']).next() == Some(first))
    };
    SECTIONS.iter().find(|section| section.settings.iter().any(&of_klipper)).map(|section| section.name)
}

/// Returns the section most like this name.
pub(crate) fn section(name: &str) -> Option<&'static str> {
    nearest(name.trim(), SECTIONS.iter().map(|section| section.name))
}

/// Whether Velvet acts on anything in a section.
pub(crate) fn is_supported(section: &Section) -> bool {
    section.settings.iter().any(|row| *row.support == Support::Now)
}

/// Returns the severity of an unknown key, and advice. A near miss is an error: the machine would run with
/// another value than the one written. Any other key is a leftover, which Smoothieware ignores too.
pub(crate) fn key(section: &Section, key: &str, is_common: bool) -> (Severity, String<160>) {
    if !is_supported(section) {
        let fix =
            format_args!("nothing of this section is supported yet, and more such lines are not listed; delete it");
        return (Severity::Warning, cut(fix));
    }
    let alike = |row: &&Setting| row.is_common == is_common;
    let near = nearest(key, section.settings.iter().filter(alike).map(|row| row.key));
    if let Some(meant) = near.filter(|meant| !is_longer_name(key, meant)) {
        return (Severity::Error, cut(format_args!("did you mean {meant}?")));
    }
    if let Some(row) = section.settings.iter().find(|row| row.key == key) {
        let prefix = if row.is_common { "common" } else { "name" };
        return (Severity::Error, cut(format_args!("write {prefix}.{key}")));
    }
    match home_of(key) {
        Some((home, row)) => {
            let name = Written(home, row, instance_of(row.v1, key));
            (Severity::Error, cut(format_args!("it belongs to [{}], as {name}", home.name)))
        }
        None => (Severity::Warning, cut(format_args!("it is ignored; delete the line"))),
    }
}

/// `1_release` is another name than `release`, not a slip of the keyboard.
fn is_longer_name(key: &str, meant: &str) -> bool {
    key.strip_suffix(meant).is_some_and(|before| before.ends_with('_'))
        || key.strip_prefix(meant).is_some_and(|behind| behind.starts_with('_'))
}

/// Returns the greatest number to write that is no more than the value.
pub(crate) fn at_most(value: f64) -> f64 {
    let scale = if value < 100.0 { 100.0 } else { 1.0 };
    // Rates are far from the largest whole number.
    let cut = (value * scale) as u64;
    // The product may have been rounded up.
    let cut = if cut as f64 / scale > value { cut.saturating_sub(1) } else { cut };
    cut as f64 / scale
}

/// Returns the greatest current to write that is no more than the value.
pub(crate) fn at_most_amps(value: f32) -> f32 {
    (value * 100.0) as u32 as f32 / 100.0
}

/// Returns the least number to write that is no less than the value.
pub(crate) fn at_least(value: f64) -> f64 {
    let scale = if value < 100.0 { 100.0 } else { 1.0 };
    let cut = at_most(value);
    if cut < value { ((cut * scale + 0.5) as u64 + 1) as f64 / scale } else { cut }
}

/// Advice for a value that was meant in another unit.
pub(crate) struct OtherUnit {
    pub(crate) unit: &'static str,
    pub(crate) value: f64,
    pub(crate) is_low: bool,
}

impl fmt::Display for OtherUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (other, factor) = match (self.unit, self.is_low) {
            ("mm/min", true) => ("mm/s", 60.0),
            ("mm/s", false) => ("mm/min", 1.0 / 60.0),
            ("mA", true) => ("A", 1_000.0),
            ("A", false) => ("mA", 1.0 / 1_000.0),
            ("mOhm", true) => ("Ohm", 1_000.0),
            (unit, _) => return write!(f, "check the unit: this one is in {unit}"),
        };
        // Two decimals say enough about a slip of the unit.
        let meant = (self.value * factor * 100.0 + 0.5) as u64;
        let (whole, cents) = (meant / 100, meant % 100);
        write!(f, "this one is in {}: for {} {other} write {whole}", self.unit, self.value)?;
        match (cents, cents % 10) {
            (0, _) => Ok(()),
            (_, 0) => write!(f, ".{}", cents / 10),
            _ => write!(f, ".{cents:02}"),
        }
    }
}

/// Advice on the place of a key without a section, or of a setting of the previous generation.
pub(crate) struct Home<'a>(pub(crate) &'a str);

impl fmt::Display for Home<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match home_of(self.0) {
            Some((section, row)) => {
                let name = Written(section, row, instance_of(row.v1, self.0));
                write!(f, "write it under [{}] as {name}", section.name)
            }
            None => f.write_str("put it under its [section]"),
        }
    }
}

/// A setting, formatted as the beginning of its line.
struct Written<'a>(&'a Section, &'a Setting, Option<&'a str>);

impl fmt::Display for Written<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(section, row, instance) = self;
        match section.form {
            Form::Plain => f.write_str(row.key),
            Form::Keyed(_) => f.write_str(instance.unwrap_or("name")),
            Form::Named(_) if row.is_common => write!(f, "common.{}", row.key),
            Form::Named(_) => write!(f, "{}.{}", instance.unwrap_or("name"), row.key),
        }
    }
}

/// Returns the section and setting that a Smoothieware v1 name, or a bare key, stands for.
fn home_of(key: &str) -> Option<(&'static Section, &'static Setting)> {
    let rows = || SECTIONS.iter().flat_map(|section| section.settings.iter().map(move |row| (section, row)));
    by_v1_name(key).map(|(section, row, _)| (section, row)).or_else(|| {
        // A bare key counts only when a single section has it.
        let mut found = rows().filter(|(_, row)| row.key == key);
        found.next().filter(|_| found.next().is_none())
    })
}

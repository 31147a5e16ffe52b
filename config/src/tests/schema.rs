//! Tests of the schema's consistency.

use crate::diagnostic::Severity;
use crate::schema::*;
use crate::setting::value::{self, Value};
use crate::{BoardId, MachineConfig, parse};
use std::collections::BTreeSet;
use std::format;
use std::string::{String, ToString};

fn rows() -> impl Iterator<Item = (&'static Section, &'static Setting)> {
    SECTIONS.iter().flat_map(|section| section.settings.iter().map(move |row| (section, row)))
}

/// The row of `[section] key`, where the key may begin with `<axis>`, `<name>` or `common`.
pub(super) fn row_of(name: &str) -> Option<&'static Setting> {
    let (name, key) = name.strip_prefix('[')?.split_once("] ")?;
    let (_, section) = section(name)?;
    let place = match section.form {
        Form::Plain => section.position(key, false),
        Form::Keyed(_) => (key.starts_with("<name>")).then_some(0),
        Form::Named(_) => {
            let (instance, key) = key.split_once('.')?;
            section.position(key, instance == "common")
        }
    };
    section.settings.get(place?)
}

#[test]
fn no_section_or_setting_is_there_twice() {
    let names: BTreeSet<_> = SECTIONS.iter().map(|section| section.name).collect();
    assert_eq!(names.len(), SECTIONS.len());
    for section in SECTIONS {
        let keys: BTreeSet<_> = section.settings.iter().map(|row| (row.key, row.is_common)).collect();
        assert_eq!(keys.len(), section.settings.len(), "[{}]", section.name);
        // The checks look settings up by key alone.
        let bare: BTreeSet<_> = section.settings.iter().map(|row| row.key).collect();
        assert_eq!(bare.len(), section.settings.len(), "[{}]", section.name);
    }
    assert!(SECTIONS.len() <= 128 && SECTIONS.iter().all(|section| section.settings.len() < 256));
}

#[test]
fn every_default_is_a_value_of_its_setting() {
    for (section, row) in rows() {
        let mut texts: std::vec::Vec<_> = row.by_name.0.iter().map(|&(_, text)| text).collect();
        if let Fallback::Value(text) = row.fallback() {
            texts.push(text);
        }
        for text in texts {
            let may_be_unset = text.is_empty() && matches!(row.kind, Kind::Word(..));
            let read = value::parse(&row.kind, text);
            assert!(read.is_ok() || may_be_unset, "[{}] {} = {text}: {read:?}", section.name, row.key);
        }
    }
}

#[test]
fn every_setting_says_what_it_is_for() {
    for (section, row) in rows() {
        assert!(
            row.docs.summary.len() > 6 && row.docs.summary.ends_with('.'),
            "[{}] {}: {}",
            section.name,
            row.key,
            row.docs.summary
        );
        assert!(section.docs.summary.ends_with('.'));
    }
}

/// Two different texts the setting takes.
fn two_values(row: &Setting) -> (String, String) {
    let (a, b) = match row.kind {
        Kind::Bool => ("true".to_string(), "false".to_string()),
        Kind::Integer(&(low, high)) => (format!("{}", low.max(0)), format!("{}", high.min(low.max(0) + 3))),
        Kind::Number(&(low, high)) => {
            // Values that no "zero means none" rule throws together.
            let from = if high > 1.5 { low.max(1.5) } else { 0.5 * (low + high) };
            (format!("{from}"), format!("{}", (from + 1.25).min(high)))
        }
        Kind::Numbers(3) => ("1,2,3".into(), "4,5,6".into()),
        Kind::Numbers(2) => ("1,2".into(), "4,5".into()),
        Kind::Numbers(..) => ("1,2,3,4,5,6".into(), "6,5,4,3,2,1".into()),
        Kind::Places(..) => ("1,2, 3,4".into(), "5,6 7,8 9,1".into()),
        Kind::Word(words) => (words.0[0].into(), words.0[words.0.len() - 1].into()),
        Kind::Text(..) if row.key == "color_order" => ("RGB".into(), "GRBW".into()),
        Kind::Text(64) if row.key == "key" => ("0f".repeat(32), "10".repeat(32)),
        // Names, and addresses too.
        Kind::Text(..) => ("1.2.3.4".into(), "4.3.2.1".into()),
        Kind::Command => ("M1".into(), "G2.3".into()),
        Kind::Registers => ("1,2,3,4,5".into(), "5,4,3,2,1".into()),
        Kind::Axes => ("XYZ".into(), "ZYX".into()),
        Kind::Voltage => ("ADC3_0,2".into(), "ADC3_1,3".into()),
        Kind::Pin(PinRole::Pwm) => ("PWM1_1".into(), "PWM1_2".into()),
        Kind::Pin(PinRole::Thermistor) => ("ADC1_4".into(), "ADC1_5".into()),
        Kind::Pin(..) => ("PJ1".into(), "PJ5".into()),
    };
    (a, b)
}

/// The description, in full, after one setting is stored.
fn stored(section: &Section, row: &Setting, text: &str) -> String {
    let mut config = MachineConfig::default();
    let place = section.instances().map_or(0, |instances| {
        let name = if (instances.create)(&mut config, "beta").is_ok() { "beta" } else { "" };
        (instances.find)(&config, name).unwrap_or(0)
    });
    let value = value::parse(&row.kind, text).unwrap_or_else(|flaw| panic!("{} = {text}: {flaw:?}", row.key));
    let setting = section.position(row.key, row.is_common).unwrap();
    (section.store)(&mut config, place, setting, &value);
    format!("{config:?}")
}

/// No setter is forgotten, and none stores a constant.
#[test]
fn every_supported_setting_changes_the_description() {
    for (section, row) in rows() {
        let (a, b) = two_values(row);
        // A word without an alternative differs from none.
        let only = matches!(row.kind, Kind::Word(Words([_])))
            && stored(section, row, &a) != std::format!("{:?}", MachineConfig::default());
        let differs = only || stored(section, row, &a) != stored(section, row, &b);
        let is_read = *row.support == Support::Now;
        // The switches of functions to come may be stored or not.
        if is_read {
            assert!(differs, "[{}] {}: {a} and {b} are stored alike", section.name, row.key);
        } else {
            assert!(!matches!(value::parse(&row.kind, &a), Ok(Value::Voltage(..))));
        }
    }
}

/// The switch of every function that is missing is refused when it is used, whatever its other settings say.
#[test]
fn every_setting_that_is_not_supported_is_refused_by_name() {
    let mut count = 0;
    for (section, row) in rows() {
        let Support::NotYet { severity, advice } = *row.support else { continue };
        count += 1;
        let (a, b) = two_values(row);
        let used = if row.default_for("") == Some(a.as_str()) { b } else { a };
        let (prefix, instance) = match section.form {
            Form::Named(_) if row.is_common => ("common.", "alpha."),
            Form::Named(_) => ("alpha.", "alpha."),
            _ => ("", ""),
        };
        // A function that is not enabled, or a driver without a motor, asks for nothing.
        let has_switch = row.key != "enable" && section.settings.iter().any(|row| row.key == "enable");
        let enable = if has_switch { format!("{instance}enable = true\n") } else { String::new() };
        let driver = if section.name == "tmc2660" { "tmc2660" } else { "tmc2590" };
        let text =
            format!("[{}]\n{prefix}{} = {used}\n{enable}[actuator]\nalpha.driver = {driver}\n", section.name, row.key);
        let mut findings: std::vec::Vec<crate::Diagnostic> = std::vec::Vec::new();
        parse(text.as_bytes(), BoardId::Prime2590, &mut findings);
        let finding = findings.iter().find(|finding| finding.reason == "not supported yet");
        let finding = finding.unwrap_or_else(|| panic!("{text}: {findings:?}"));
        let is_fatal = severity == Severity::Error && section.scope == crate::Scope::Machine;
        let severity = if is_fatal { Severity::Fatal } else { severity };
        assert_eq!((finding.line, finding.severity, finding.fix.as_str()), (2, severity, advice), "{text}");
    }
    assert!(count > 0);
}

/// Every function that is missing has something that is refused, so nothing of it is passed over in silence.
#[test]
fn a_missing_function_cannot_be_asked_for_unnoticed() {
    for section in SECTIONS {
        let dormant = section.settings.iter().filter(|row| *row.support == Support::Dormant).count();
        let has_switch = section.settings.iter().any(|row| matches!(row.support, Support::NotYet { .. }));
        // Leveling strategies are asked for by [zprobe] leveling.
        let is_asked_for_elsewhere = ["strategy"].iter().any(|word| section.name.ends_with(word));
        assert!(dormant == 0 || has_switch || is_asked_for_elsewhere, "[{}]", section.name);
    }
}

//! The table against Smoothieware v2's settings: same names, defaults, units and bounds, or a stated
//! difference.

use super::schema::row_of;
use crate::schema::*;
use crate::setting::value;
use std::collections::{BTreeMap, BTreeSet};
use std::format;
use std::string::{String, ToString};
use std::vec::Vec;

const FACTS: &str = include_str!("../../tests/smoothieware-settings.txt");

struct Fact {
    name: &'static str,
    default: &'static str,
    unit: &'static str,
    least: &'static str,
    most: &'static str,
}

fn facts() -> impl Iterator<Item = Fact> {
    FACTS.lines().filter(|line| !line.starts_with('#')).map(|line| {
        let mut parts = line.split('|').map(str::trim);
        let [name, _, default, unit, least, most] = core::array::from_fn(|_| parts.next().unwrap_or(""));
        Fact { name, default, unit, least, most }
    })
}

fn row(name: &str) -> &'static Setting {
    row_of(name).unwrap_or_else(|| panic!("no row for {name}"))
}

/// Settings whose default differs from Smoothieware's, and the reasons.
const OTHER_DEFAULTS: &[(&str, &str)] = &[
    ("[motion control] mm_max_arc_error", "arcs stay arcs unless chords are asked for"),
    ("[drillingcycles] enable", "canned cycles are part of the language: no hole stays undrilled unseen"),
    ("[endstops] common.corexy_homing", "follows arm_solution: a corexy cannot home otherwise"),
    ("[endstops] common.delta_homing", "follows arm_solution"),
    ("[endstops] common.rdelta_homing", "follows arm_solution"),
    ("[endstops] common.scara_homing", "follows arm_solution"),
    ("[endstops] <name>.axis", "must be written: an endstop of no axis is a mistake"),
    ("[current control] <name>.current", "must be written"),
    ("[general] config-override", "on with grbl_mode: what a sender sets is to outlive the reset"),
    ("[temperature control] <name>.windup", "a heat-up at full output is not to overshoot"),
    ("[network] hostname", "the machine is found as velvet.local"),
    ("[laser] default_power", "0 with grbl_mode: nothing burns by an S that nobody wrote"),
    ("[laser] proportional_power", "off with grbl_mode, where M3 is constant and M4 follows the speed"),
    ("[switch] <name>.output_type", "must be written; an output of no type does nothing"),
];

/// Defaults that the facts give in words and the schema derives.
const IN_WORDS: &[&str] = &[
    "[endstops] <name>.homing_position",
    "[endstops] common.move_to_origin_after_home",
    "[pwm1] frequency",
    "[pwm2] frequency",
    "[tmc2590] <axis>.max_current",
    "[temperature control] <name>.set_and_wait_m_code",
    "[temperature control] <name>.set_m_code",
    "[motion control] must_be_homed",
    "[motion control] delta_segments_per_second",
    "[switch] <name>.startup_value",
    "[temperature control] <name>.i_max",
    "[temperature control] <name>.runaway_cooling_timeout",
];

/// `hotend T, bed B, others ?`: defaults by instance, the rest under an empty name.
fn by_name(text: &str) -> BTreeMap<String, String> {
    let parts: Vec<(&str, &str)> = text.split(", ").filter_map(|part| part.split_once(' ')).collect();
    let is_list = text.contains(", ") && parts.len() == text.split(", ").count();
    if is_list || row_like(text) {
        parts.iter().map(|(n, v)| (if *n == "others" { "" } else { n }.to_string(), v.to_string())).collect()
    } else {
        BTreeMap::from([(String::new(), text.to_string())])
    }
}

/// Returns whether the text names a single instance, as in `vmotor ADC3_5`.
fn row_like(text: &str) -> bool {
    text.split_once(' ').is_some_and(|(name, value)| name == "vmotor" && !value.contains(' '))
}

#[test]
fn every_default_is_smoothiewares_or_its_difference_is_stated() {
    let (mut stated, mut wrong) = (BTreeSet::new(), Vec::new());
    for fact in facts() {
        let row = row(fact.name);
        if OTHER_DEFAULTS.iter().any(|(name, _)| *name == fact.name) || IN_WORDS.contains(&fact.name) {
            stated.insert(fact.name);
            continue;
        }
        for (instance, text) in by_name(fact.default) {
            let ours = row.default_for(&instance).unwrap_or("(none)");
            // "none" stands for an empty text, no numbers for zeros, "253 minus index" for a rule.
            let same = ours == text
                || (ours.is_empty() && text == "none")
                || (ours == "none" && text.is_empty())
                || (ours.is_empty() && matches!(row.kind, Kind::Numbers(..)) && text.chars().all(|c| "0,".contains(c)))
                || (text.starts_with("253 minus") && matches!(row.fallback(), Fallback::Derived))
                || matches!((value::parse(&row.kind, ours), value::parse(&row.kind, &text)), (Ok(a), Ok(b)) if a == b);
            if !same {
                wrong.push(format!("{} {instance}: ours is {ours}, Smoothieware's {text}", fact.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert_eq!(stated.len(), OTHER_DEFAULTS.len() + IN_WORDS.len(), "a stated difference is none any more");
}

/// Two ways to write one unit.
const SAME_UNITS: &[(&str, &str)] =
    &[("segments/s", "1/s"), ("ohm", "Ohm"), ("blocks", "moves"), ("percent", "%"), ("C and ohm", "C,Ohm")];
/// Units that say nothing about a number.
const NO_UNITS: &[&str] = &["PWM steps", "S units", "segments", "fraction", "points", "0-255 or percent"];

#[test]
fn every_unit_is_smoothiewares() {
    let mut wrong = Vec::new();
    for fact in facts() {
        let ours = row(fact.name).unit.text();
        let same = fact.unit == ours
            || SAME_UNITS.contains(&(fact.unit, ours))
            || (ours.is_empty() && NO_UNITS.contains(&fact.unit))
            || (fact.unit.is_empty() && ours.len() < 6);
        if !same {
            wrong.push(format!("{}: ours is '{ours}', Smoothieware's '{}'", fact.name, fact.unit));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Settings with a range wider or narrower than Smoothieware's, and the reasons.
const OTHER_BOUNDS: &[(&str, &str)] = &[
    ("[system] step_pulse_us", "steps are not bound to a tick of 5 us"),
    ("[system] step_frequency", "there is no step tick"),
    ("[planner] z_junction_deviation", "every value below 0 is as junction_deviation"),
    ("[current control] <name>.current", "0 is the least that the driver can give, and told"),
    ("[button box] common.poll_frequency_hz", "what is beyond 1 to 100 is limited and told"),
    (
        "[planner] planner_queue_size",
        "there is room for 256 moves, 32 of which filters look back on: what is beyond 4 to 224 is limited and told",
    ),
];

#[test]
fn every_bound_is_smoothiewares_or_its_difference_is_stated() {
    let mut wrong = Vec::new();
    for fact in facts() {
        let (low, high) = match row(fact.name).kind {
            Kind::Integer(&(low, high)) => (low as f64, high as f64),
            Kind::Number(&range) => range,
            _ => continue,
        };
        let stated = OTHER_BOUNDS.iter().any(|(name, _)| *name == fact.name);
        let least = if fact.least == ">0" { 0.0 } else { fact.least.parse().unwrap_or(f64::NEG_INFINITY) };
        let most: f64 = fact.most.parse().unwrap_or(f64::INFINITY);
        // -1 by default stands for "not given".
        let low = if low == -1.0 && fact.default == "-1" { least.max(-1.0) } else { low };
        let within = low >= least && high <= most && (fact.least != ">0" || low > 0.0);
        if within == stated {
            wrong.push(format!("{}: ours {low} to {high}, Smoothieware's {least} to {most}", fact.name));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// List of settings that work, are refused, or only belong to something refused: a file that shrinks.
const COVERAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/support.txt");

#[test]
fn the_list_of_what_is_refused_is_the_one_in_the_repository() {
    let mut lists: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for fact in facts() {
        let list = match row(fact.name).support {
            Support::Now => "consumed",
            Support::NotYet { .. } => "refused when used",
            Support::Needless { .. } => "without effect, and said to be",
            Support::Dormant => "part of something refused",
        };
        lists.entry(list).or_default().push(fact.name.to_string());
    }
    let total: usize = lists.values().map(Vec::len).sum();
    assert_eq!(total, 315);
    let mut text = format!(
        "Of Smoothieware's {total} settings, what Velvet acts on. VELVET_WRITE=1 cargo test -p config writes this list.\n"
    );
    for (title, names) in &lists {
        text += &format!("\n{} {title}:\n", names.len());
        names.iter().for_each(|name| text += &format!("  {name}\n"));
    }
    if std::env::var_os("VELVET_WRITE").is_some() {
        std::fs::write(COVERAGE, &text).unwrap();
    }
    assert_eq!(std::fs::read_to_string(COVERAGE).unwrap(), text);
}

/// The facts themselves, when they are at hand: `VELVET_FACTS=settings.toml`, a table of `[[setting]]` with
/// `section`, `key`, `default`.
#[test]
fn the_embedded_facts_are_the_original_ones() {
    let Some(path) = std::env::var_os("VELVET_FACTS") else { return };
    let text = std::fs::read_to_string(path).unwrap();
    let value = |block: &str, key: &str| {
        let line = block.lines().find_map(|line| line.strip_prefix(key)?.trim_start().strip_prefix('=')).unwrap_or("");
        line.trim().trim_matches('"').to_string()
    };
    let original: Vec<(String, String)> = text
        .split("[[setting]]")
        .skip(1)
        .map(|block| (format!("[{}] {}", value(block, "section"), value(block, "key")), value(block, "default")))
        .collect();
    let ours: Vec<(String, String)> = facts().map(|fact| (fact.name.to_string(), fact.default.to_string())).collect();
    assert_eq!(ours, original);
}

//! The history page: every committed ledger and the present one, drawn. One file that needs no network.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::{Value, json};

use super::figures::{Ledger, RATES};

const TEMPLATE: &str = include_str!("../../assets/history.html");
/// The chart library that the report of a run is drawn with too.
const PARTS: [(&str, &str); 2] = [
    ("uplot.css", include_str!("../../../host/assets/vendor/uPlot.min.css")),
    ("uplot.js", include_str!("../../../host/assets/vendor/uPlot.iife.min.js")),
];

/// Figures drawn together: a heading, its meaning, and the keys, by how they begin.
const GROUPS: [(&str, &str, &[&str]); 13] = [
    ("Step interrupt", "instructions for each step, by motors", &["emit_per_step"]),
    (
        "Step feed",
        "instructions for each step, by motors; and with the interrupt's for three",
        &["feed_per_step", "per_step_total"],
    ),
    (
        "Solving, plain",
        "instructions for each step, by kinematics; and on an uneven bed",
        &["solve_per_step_*_plain", "solve_per_step_*_levelled"],
    ),
    (
        "Solving, with shapers and pressure advance",
        "instructions for each step, by kinematics; smooth: limited in jerk too",
        &["solve_per_step_*_shaped", "solve_per_step_*_smooth"],
    ),
    ("Sustained rate", "steps a second, three axes, all else running", &["sustained_steps_per_s"]),
    ("Lines a second", "short G1 lines at 400 million instructions a second", &["lines_per_s"]),
    (
        "Lines and blocks",
        "instructions",
        &["line_", "block_", "plan_", "expression_", "called_line_", "turn_", "look_ahead_"],
    ),
    ("Memory", "bytes", &["ram_", "flash_", "itcm_", "dtcm_"]),
    ("Interrupts", "instructions of one run", &["step_interrupt_", "masked_", "console_", "heat_"]),
    ("Longest runs of the step feed", "instructions", &["feed_run_"]),
    ("Step error", "nanoseconds from where the oracle puts a step", &["step_error_"]),
    ("Hold", "microseconds from the byte to the first slower step", &["hold_"]),
    ("Loading a configuration, load, queue", "as the names say", &["config_load", "sustained_load", "queue_depth"]),
];

/// A ledger with the commit it belongs to.
pub struct State {
    id: String,
    date: String,
    pub ledger: Ledger,
}

/// Writes the page of all ledgers.
pub fn write(root: &Path, now: &Ledger, page: &Path) -> Result<()> {
    let states = states(root, now)?;
    let data = data(&states).to_string().replace("</", "<\\/");
    let mut text = TEMPLATE.to_owned();
    for (name, part) in PARTS.into_iter().chain([("data", data.as_str())]) {
        text = text.replacen(&format!("{{{{{name}}}}}"), part, 1);
    }
    if let Some(folder) = page.parent() {
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    fs::write(page, text).with_context(|| page.display().to_string())
}

/// The committed ledgers, oldest first, and the present one.
pub fn states(root: &Path, now: &Ledger) -> Result<Vec<State>> {
    let mut states = committed(root)?;
    if states.last().is_none_or(|state| state.ledger != *now) {
        states.push(State { id: "now".into(), date: "now".into(), ledger: now.clone() });
    }
    Ok(states)
}

/// The ledgers that git knows, oldest first; none where there is no git.
fn committed(root: &Path) -> Result<Vec<State>> {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).current_dir(root).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let log = git(&["log", "--reverse", "--format=%h %cs", "--", "bench/ledger.json"]).unwrap_or_default();
    let state = |line: &str| {
        let (id, date) = line.split_once(' ')?;
        let ledger = serde_json::from_str(&git(&["show", &format!("{id}:bench/ledger.json")])?).ok()?;
        Some(State { id: id.into(), date: date.into(), ledger })
    };
    Ok(log.lines().filter_map(state).collect())
}

fn data(states: &[State]) -> Value {
    let mut keys: Vec<&String> = states.iter().flat_map(|state| state.ledger.keys()).collect();
    keys.sort();
    keys.dedup();
    let values: serde_json::Map<String, Value> = keys
        .iter()
        .map(|&key| (key.clone(), states.iter().map(|state| state.ledger.get(key).copied()).collect()))
        .collect();
    let groups: Vec<Value> = GROUPS
        .iter()
        .map(|(title, about, patterns)| {
            let keys: Vec<&&String> =
                keys.iter().filter(|key| patterns.iter().any(|pattern| fits(key, pattern))).collect();
            json!({ "title": title, "about": about, "keys": keys })
        })
        .filter(|group| group["keys"].as_array().is_some_and(|keys| !keys.is_empty()))
        .collect();
    let commits: Vec<Value> = states.iter().map(|state| json!({ "id": state.id, "date": state.date })).collect();
    json!({ "commits": commits, "groups": groups, "values": values, "rates": RATES })
}

/// A pattern is the key's beginning, or its beginning and its end with `*` between.
fn fits(key: &str, pattern: &str) -> bool {
    match pattern.split_once('*') {
        Some((begin, end)) => key.starts_with(begin) && key.ends_with(end),
        None => key.starts_with(pattern),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_state_has_a_value_or_a_gap_of_every_key() {
        let ledger = |entries: &[(&str, f64)]| entries.iter().map(|(key, value)| ((*key).to_owned(), *value)).collect();
        let state = |id: &str, ledger| State { id: id.into(), date: "2026-01-01".into(), ledger };
        let states = [state("a", ledger(&[("ram_bytes", 1.0)])), state("b", ledger(&[("flash_bytes", 2.0)]))];
        let data = data(&states);
        assert_eq!(data["values"]["ram_bytes"], json!([1.0, null]));
        assert_eq!(
            data["groups"],
            json!([{ "title": "Memory", "about": "bytes", "keys": ["flash_bytes", "ram_bytes"] }])
        );
    }

    #[test]
    fn a_pattern_may_have_a_middle() {
        assert!(fits("solve_per_step_polar_plain", "solve_per_step_*_plain"));
        assert!(!fits("solve_per_step_polar_shaped", "solve_per_step_*_plain") && fits("ram_bytes", "ram_"));
    }

    #[test]
    fn the_template_has_a_slot_for_each_part() {
        for (name, _) in PARTS.into_iter().chain([("data", "")]) {
            assert_eq!(TEMPLATE.matches(&format!("{{{{{name}}}}}")).count(), 1, "{name}");
        }
    }
}

//! The ledger as the tables of `docs/performance.md`, for who reads the page rather than the file.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use super::figures::{Ledger, read};
use super::machines::KINDS;

const PAGE: &str = "docs/performance.md";
const BEGIN: &str = "<!-- figures: from bench/ledger.json, written by `make bench` -->\n";
const END: &str = "<!-- end of figures -->\n";

/// Subject of a row, the keys of its figures, and their unit.
type Row = (&'static str, &'static [&'static str], &'static str);

const ROWS: [Row; 26] = [
    (
        "step interrupt per step: 1, 3, 4, 6 motors",
        &["emit_per_step_1", "emit_per_step_3", "emit_per_step_4", "emit_per_step_6"],
        "instructions",
    ),
    (
        "feed per step: 1, 3, 4, 6 motors",
        &["feed_per_step_1", "feed_per_step_3", "feed_per_step_4", "feed_per_step_6"],
        "instructions",
    ),
    ("both, three motors, fast machine", &["per_step_total"], "instructions"),
    ("three axes sustained", &["sustained_steps_per_s"], "steps/s"),
    ("load at that rate", &["sustained_load_percent"], "% of the processor"),
    ("queue ahead at worst, at that rate", &["queue_depth_ms"], "ms"),
    ("longest masked window", &["masked_window_max_instructions"], "instructions"),
    (
        "a line; a block; the longest planner pass; looking ahead at a line",
        &["line_instructions", "block_instructions", "plan_pass_max_instructions", "look_ahead_instructions"],
        "instructions",
    ),
    (
        "a line, a block, the longest pass with jerk, shapers and pressure advance",
        &["line_instructions_smooth", "block_instructions_smooth", "plan_pass_max_instructions_smooth"],
        "instructions",
    ),
    (
        "longest run of the feed over short lines, without and with these",
        &["feed_run_max_lines_instructions", "feed_run_max_lines_instructions_smooth"],
        "instructions",
    ),
    ("short lines, without and with these", &["lines_per_s", "lines_per_s_smooth"], "lines/s"),
    ("heat control at 2 kHz", &["heat_percent"], "% of the processor"),
    (
        "its longest tick, and heat safety's look in it",
        &["heat_tick_max_instructions", "heat_guard_max_instructions"],
        "instructions",
    ),
    (
        "USB interrupt, both ports flooded: median, 99 of 100, longest",
        &["usb_interrupt_median_instructions", "usb_interrupt_p99_instructions", "usb_interrupt_max_instructions"],
        "instructions",
    ),
    ("all of USB meanwhile", &["usb_percent"], "% of the processor"),
    (
        "the network, quiet; with a cable full of pings and questions",
        &["network_quiet_percent", "network_flood_percent"],
        "% of the processor",
    ),
    ("longest turn of the network", &["network_turn_max_instructions"], "instructions"),
    ("step error, max; rms", &["step_error_max_ns", "step_error_rms_ns"], "ns"),
    ("hold; hold, shaped", &["hold_latency_us", "hold_latency_shaped_us"], "us"),
    (
        "step interrupt and feed per step, three motors, a laser lit",
        &["emit_per_step_3_laser", "feed_per_step_3_laser"],
        "instructions",
    ),
    ("3,000 pixels of 0.05 mm as moves at 500 mm/s", &["laser_3000_pixels_s"], "s"),
    ("the worst of their edges", &["laser_edge_max_um"], "um"),
    ("pixels of 0.02 mm from the card, the slowest row", &["laser_pixels_per_s"], "pixels/s"),
    ("hold to the laser's last light", &["laser_hold_dark_us"], "us"),
    ("start; reading a configuration of 300 lines", &["start_ms", "config_load_ms"], "ms"),
    ("flash; DTCM; ITCM; other RAM", &["flash_bytes", "dtcm_bytes", "itcm_bytes", "ram_bytes"], "bytes"),
];

/// Writes the ledger's figures into the page.
pub fn write(root: &Path, ledger: &Ledger) -> Result<()> {
    let path = root.join(PAGE);
    let page = fs::read_to_string(&path).context(PAGE)?;
    fs::write(&path, with(&page, ledger)?).context(PAGE)
}

/// Whether the page has the figures of the ledger that lies there.
pub fn check(root: &Path) -> Result<()> {
    let page = fs::read_to_string(root.join(PAGE)).context(PAGE)?;
    let is_true = with(&page, &of(root)?)? == page;
    ensure!(is_true, "{PAGE} has other figures than bench/ledger.json: cargo run -p xtask -- figures");
    Ok(())
}

fn of(root: &Path) -> Result<Ledger> {
    read(&root.join("bench/ledger.json")).context("bench/ledger.json")
}

/// The page with these figures.
fn with(page: &str, ledger: &Ledger) -> Result<String> {
    let (before, rest) = page.split_once(BEGIN).with_context(|| format!("no {BEGIN}"))?;
    let (_, after) = rest.split_once(END).with_context(|| format!("no {END}"))?;
    Ok(format!("{before}{BEGIN}\n{}\n{}\n{END}{after}", figures(ledger)?, kinematics(ledger)?))
}

fn figures(ledger: &Ledger) -> Result<String> {
    let mut table = String::from("| | | |\n|---|---|---|\n");
    for (about, keys, unit) in ROWS {
        let figures: Vec<String> = keys.iter().map(|key| figure(ledger, key)).collect::<Result<_>>()?;
        writeln!(table, "| {about} | {} | {unit} |", figures.join("; "))?;
    }
    Ok(table)
}

/// Cost of solving for each kinematics, and with the step interrupt of three motors on top.
fn kinematics(ledger: &Ledger) -> Result<String> {
    let emit = number(ledger, "emit_per_step_3")?;
    let mut table = String::from("| kinematics | plain | shaped | shaped and played |\n|---|---|---|---|\n");
    for kind in &KINDS {
        let of = |how: &str| number(ledger, &format!("solve_per_step_{}_{how}", kind.word));
        let (plain, shaped) = (of("plain")?, of("shaped")?);
        writeln!(table, "| {} | {plain:.1} | {shaped:.1} | {:.1} |", kind.word, shaped + emit)?;
    }
    Ok(table)
}

fn number(ledger: &Ledger, key: &str) -> Result<f64> {
    ledger.get(key).copied().with_context(|| format!("the ledger has no {key}"))
}

/// A number as a person reads it: thousands apart, and no more places than say something.
fn figure(ledger: &Ledger, key: &str) -> Result<String> {
    let value = number(ledger, key)?;
    if value < 1_000.0 {
        return Ok(format!("{}", (value * 100.0).round() / 100.0));
    }
    let digits = format!("{value:.0}");
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ledger() -> Ledger {
        read(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../bench/ledger.json"))).expect("a ledger")
    }

    #[test]
    fn figures_are_written_for_a_person() {
        let ledger = [("a", 1_725_472.0), ("b", 0.237_99), ("c", 55.1), ("d", 999.0), ("e", 1_000.4)];
        let ledger: Ledger = ledger.map(|(key, value)| (key.to_owned(), value)).into();
        let text: Vec<String> = ["a", "b", "c", "d", "e"].map(|key| figure(&ledger, key).expect("a figure")).into();
        assert_eq!(text, ["1,725,472", "0.24", "55.1", "999", "1,000"]);
        assert!(figure(&ledger, "f").is_err());
    }

    #[test]
    fn what_stands_between_the_marks_is_replaced_and_nothing_else() {
        let page = format!("before\n{BEGIN}stale\n{END}after\n");
        let new = with(&page, &ledger()).expect("a page");
        assert!(new.starts_with("before\n") && new.ends_with("after\n") && !new.contains("stale"), "{new}");
        assert_eq!(with(&new, &ledger()).expect("a page"), new);
        assert!(with("no marks", &ledger()).is_err());
    }
}

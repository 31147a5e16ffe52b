//! A laser in the ledger: what steps cost with it, how fast pixels burn and where, how soon a hold is dark.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use super::board::{Bench, FEED, Job, Measured};
use super::figures::Ledger;
use super::jobs;
use super::machines::Machines;

/// Pixels of the row of moves, and their width in mm: every other one is lit.
const MOVES: usize = 3_000;
const MOVE_MM: f64 = 0.05;
/// Pixels of a row of raster lines, pixels of a line, their width in mm, and rows: each pixel has another
/// power than the one before.
const PIXELS: usize = 3_000;
const OF_A_LINE: usize = 30;
const PIXEL_MM: f64 = 0.02;
const ROWS: usize = 4;
/// The hold comes in the middle of its line, at these moments of the step feed's period.
const HOLD_AFTER: u64 = 6_000;
const DELAYS_US: [u64; 5] = [0, 100, 200, 300, 400];
/// The laws of power, in the words of the program.
const LAWS: [&str; 2] = ["M3", "M4"];

/// The sample laser at 500 mm/s and 3000 mm/s^2.
fn engraver(root: &Path) -> Result<String> {
    let path = root.join("config/samples/laser.ini");
    let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let faster = [("= 12000", "= 30000"), ("acceleration = 1500", "acceleration = 3000")];
    let plain = [("must_be_homed = true", "must_be_homed = false"), ("grbl_mode = true", "grbl_mode = false")];
    Ok(faster.iter().chain(&plain).fold(text, |text, (piece, instead)| text.replace(piece, instead)))
}

/// A row of moves, as senders write pixels.
fn moves() -> String {
    let mut job = String::from("M3 S0\nG1 F30000\n");
    for pixel in 1..=MOVES {
        // Writing to a string cannot fail.
        let _ = writeln!(job, "G1 X{:.2} S{}", pixel as f64 * MOVE_MM, 500 * (pixel % 2));
    }
    job + "M5\n"
}

/// Rows there and back in raster lines, with leads.
fn raster() -> String {
    let mut job = String::from("M4 S0\nG1 F30000\n");
    let width = PIXEL_MM * PIXELS as f64;
    for row in 0..ROWS {
        let (first, sign, end) = if row % 2 == 0 { (50.0, 1.0, 100.0 + width) } else { (50.0 + width, -1.0, 0.0) };
        let _ = writeln!(job, "G1 X{first} S0");
        for line in 1..=PIXELS / OF_A_LINE {
            let powers: Vec<String> =
                (0..OF_A_LINE).map(|pixel| (100 + (pixel * 37 + line) % 800).to_string()).collect();
            let x = first + sign * PIXEL_MM * (line * OF_A_LINE) as f64;
            let _ = writeln!(job, "G1 X{x:.2} S{}", powers.join(":"));
        }
        let _ = writeln!(job, "G1 X{end} S0");
    }
    job + "M5\n"
}

/// Adds the laser's rows.
pub fn measure(root: &Path, bench: &Bench<'_>, machines: &Machines, ledger: &mut Ledger) -> Result<()> {
    let engraver = engraver(root)?;
    let with_laser = format!("{}[laser]\nenable = true\npwm_pin = PWM2_1\n", machines.fast);
    let mut list = vec![
        Job::new("laser-steps", &with_laser, format!("M3 S1\n{}", jobs::steps(3, 1.0))),
        Job::new("laser-moves", &engraver, moves()),
        Job::new("laser-raster", &engraver, raster()),
    ];
    let held = |law: &str, delay_us: u64| format!("laser-{law}-{delay_us}");
    for (law, delay_us) in LAWS.iter().flat_map(|law| DELAYS_US.map(|delay_us| (law, delay_us))) {
        let job = format!("{law} S500\nG1 X150 F6000\nM5\n");
        list.push(Job::new(held(law, delay_us), &engraver, job).held_after(HOLD_AFTER, delay_us));
    }
    let results = bench.run(list)?;
    let mut enter = |key: &str, number: f64, digits: i32| {
        let scale = 10_f64.powi(digits);
        ledger.insert(key.into(), (number * scale).round() / scale);
    };
    let steps = results.of("laser-steps")?;
    enter("emit_per_step_3_laser", steps.emitting()? / steps.steps()?, 1);
    enter("feed_per_step_3_laser", steps.moving(FEED)? / steps.steps()?, 1);
    let moves = results.of("laser-moves")?;
    enter("laser_3000_pixels_s", moves.seconds_moving()?, 3);
    enter("laser_edge_max_um", worst_edge_mm(bench, moves)? * 1e3, 1);
    enter("laser_pixels_per_s", pixels_per_s(&powers(results.of("laser-raster")?)?)?, 0);
    let mut dark_us = 0.0_f64;
    for (law, delay_us) in LAWS.iter().flat_map(|law| DELAYS_US.map(|delay_us| (law, delay_us))) {
        let run = results.of(&held(law, delay_us))?;
        dark_us = dark_us.max(dark_after_us(&powers(run)?, run.number(&["held_ns"])? as u64)?);
    }
    enter("laser_hold_dark_us", dark_us, 1);
    Ok(())
}

/// Changes of the laser's power in a run: times in nanoseconds, and duties.
fn powers(run: &Measured) -> Result<Vec<(u64, u16)>> {
    let path = run.out.join("power.csv");
    let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let change = |line: &str| {
        let (time_ns, duty) = line.split_once(',')?;
        Some((time_ns.parse().ok()?, duty.parse().ok()?))
    };
    text.lines().skip(1).map(|line| change(line).with_context(|| line.to_owned())).collect()
}

/// Greatest distance of an edge from its place, mm, as `velvet laser` tells it.
fn worst_edge_mm(bench: &Bench<'_>, run: &Measured) -> Result<f64> {
    let output = Command::new(bench.velvet).arg("laser").arg(&run.out).output();
    let output = output.with_context(|| bench.velvet.display().to_string())?;
    let text = String::from_utf8_lossy(&output.stdout);
    ensure!(output.status.success(), "velvet laser: {}", text.trim());
    let line = text.lines().find_map(|line| line.strip_prefix("worst edge: ")).context("no worst edge")?;
    let numbers = line.split([' ', ',']).filter_map(|word| word.parse::<f64>().ok());
    numbers.take(2).reduce(f64::max).context("no distance")
}

/// The slowest row's pixels for a second.
fn pixels_per_s(changes: &[(u64, u16)]) -> Result<f64> {
    let rows: Vec<_> = changes.split_inclusive(|(_, duty)| *duty == 0).collect();
    ensure!(rows.len() == ROWS && rows.iter().all(|row| row.len() == PIXELS + 1), "not every pixel was burnt");
    let rate = |row: &&[(u64, u16)]| PIXELS as f64 * 1e9 / (row[PIXELS].0 - row[0].0) as f64;
    rows.iter().map(rate).reduce(f64::min).context("no rows")
}

/// Microseconds from a hold to the last light before the machine goes on.
fn dark_after_us(changes: &[(u64, u16)], held_ns: u64) -> Result<f64> {
    let dark = changes.iter().find(|(time_ns, duty)| *time_ns >= held_ns && *duty == 0);
    Ok((dark.context("the hold is not dark")?.0 - held_ns) as f64 * 1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slowest_row_counts_and_every_pixel_must_be_there() {
        let row = |from_ns: u64, each_ns: u64| {
            (0..=PIXELS as u64).map(move |n| (from_ns + n * each_ns, u16::from(n < PIXELS as u64) * (1 + n as u16 % 2)))
        };
        let rows: Vec<_> = (0..ROWS as u64).flat_map(|n| row(n << 32, 40_000 + 10_000 * u64::from(n == 1))).collect();
        assert_eq!(pixels_per_s(&rows).expect("rows").round(), 20_000.0);
        assert!(pixels_per_s(&rows[1..]).is_err());
    }

    #[test]
    fn a_hold_is_dark_from_the_first_change_to_none_on() {
        let changes = [(100_000, 9), (250_000, 0), (300_000, 9), (900_000, 0)];
        assert_eq!(dark_after_us(&changes, 200_000).ok(), Some(50.0));
        assert!(dark_after_us(&changes[..1], 200_000).is_err());
    }
}

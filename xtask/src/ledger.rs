//! The performance ledger: what the release image costs, in instructions counted on the virtual board and in bytes.
//!
//! Small jobs are made up so that each answers one question; the difference of two jobs isolates what they differ in.
//! Instructions are exact and repeatable. They are not cycles: a Cortex-M7 issues up to two a cycle from TCM, and waits for
//! flash, buses and divisions. Only silicon can tell that factor.

mod config;
mod jobs;
mod table;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use crate::memory;

/// Flat numbers by name.
pub type Ledger = BTreeMap<String, f64>;

/// A number may grow by this share before it counts as a regression.
const TOLERANCE: f64 = 0.02;

/// The tasks, by the interrupts that run them (`firmware/src/main.rs`).
const STEP: &str = "TIM2";
const FEED: &str = "TIM6_DAC";
const HEAT: &str = "TIM7";
const BYTES: &str = "USART2";
/// Software tasks: one of these runs the planner, the other the slow watch.
const SOFTWARE: [&str; 2] = ["LPTIM1", "LPTIM2"];

/// Measures, prints, compares with the committed ledger, and writes `bench/ledger.json`.
pub fn run(root: &Path, elf: &Path, virtual_prime: &Path) -> Result<()> {
    let ledger = measure(root, elf, virtual_prime)?;
    let path = root.join("bench/ledger.json");
    let before = committed(root).or_else(|| read(&path));
    table::print(&ledger, before.as_ref());
    fs::write(&path, serde_json::to_string_pretty(&ledger)? + "\n").with_context(|| path.display().to_string())?;
    let worse = regressions(&ledger, before.as_ref());
    ensure!(worse.is_empty(), "grew by more than {:.0} %: {}", TOLERANCE * 100.0, worse.join(", "));
    Ok(())
}

fn measure(root: &Path, elf: &Path, virtual_prime: &Path) -> Result<Ledger> {
    let bench = Bench { root, elf, virtual_prime, scratch: root.join("out/bench") };
    let mut ledger = Ledger::new();
    for motors in [1, 3, 4] {
        let run = bench.job(&format!("steps-{motors}"), &jobs::steps(motors))?;
        let steps = run.number(&["summary", "edges"])?;
        let emit = run.total(STEP)? / steps;
        let solve = run.total(FEED)? / steps;
        ledger.insert(format!("emit_per_step_{motors}"), round(emit));
        ledger.insert(format!("feed_per_step_{motors}"), round(solve));
        if motors == 3 {
            ledger.insert("solve_per_step_cartesian_plain".into(), round(solve));
            ledger.insert("per_step_total".into(), round(emit + solve));
            for statistic in ["min", "median", "p99", "max"] {
                let count = run.number(&["functions", STEP, statistic])?;
                ledger.insert(format!("step_interrupt_{statistic}"), count);
            }
            ledger.insert("feed_run_max_instructions".into(), run.number(&["functions", FEED, "max"])?);
            ledger.insert("heat_tick_max_instructions".into(), run.number(&["functions", HEAT, "max"])?);
        }
    }
    let (few, many) =
        (bench.job("lines-few", &jobs::lines(jobs::FEW))?, bench.job("lines-many", &jobs::lines(jobs::MANY))?);
    let lines = (jobs::MANY - jobs::FEW) as f64;
    let dispatcher = (many.dispatcher()? - few.dispatcher()?) / lines;
    let planner = (many.software()? - few.software()?) / lines;
    ledger.insert("line_instructions".into(), round(dispatcher));
    ledger.insert("plan_instructions_per_block".into(), round(planner));
    ledger.insert("console_byte_max_instructions".into(), many.number(&["functions", BYTES, "max"])?);

    config::measure(root, elf, virtual_prime, &bench.scratch.join("config"), &mut ledger)?;
    let image = fs::read(elf).with_context(|| elf.display().to_string())?;
    let mut ram = 0;
    for (region, bytes) in memory::used(&image)? {
        match region {
            "itcm" | "flash" | "dtcm" => {
                ledger.insert(format!("{region}_bytes"), bytes as f64);
            }
            _ => ram += bytes,
        }
    }
    ledger.insert("ram_bytes".into(), ram as f64);
    Ok(ledger)
}

fn round(number: f64) -> f64 {
    (number * 10.0).round() / 10.0
}

/// Where the pieces are.
struct Bench<'a> {
    root: &'a Path,
    elf: &'a Path,
    virtual_prime: &'a Path,
    scratch: PathBuf,
}

/// What a job gave: the virtual board's counts, and the run's summary.
struct Measured {
    counts: Value,
    summary: Value,
}

impl Bench<'_> {
    fn job(&self, name: &str, gcode: &str) -> Result<Measured> {
        let out = self.scratch.join(name);
        fs::create_dir_all(&out).with_context(|| out.display().to_string())?;
        let job = self.scratch.join(format!("{name}.gcode"));
        fs::write(&job, gcode).with_context(|| job.display().to_string())?;
        eprintln!("measuring {name}");
        let functions = [STEP, FEED, HEAT, BYTES].into_iter().chain(SOFTWARE).collect::<Vec<_>>().join(",");
        let output = Command::new(self.virtual_prime)
            .arg("bench")
            .arg("--elf")
            .arg(self.elf)
            .arg("--config")
            .arg(self.root.join("bench/config.ini"))
            .arg("--gcode")
            .arg(&job)
            .arg("--out")
            .arg(&out)
            .args(["--function", &functions])
            .output()
            .with_context(|| self.virtual_prime.display().to_string())?;
        if !output.status.success() {
            bail!("{name}: {}", String::from_utf8_lossy(&output.stderr).trim());
        }
        let counts = serde_json::from_slice(&output.stdout).with_context(|| format!("{name}: the counts"))?;
        let summary = fs::read(out.join("summary.json")).with_context(|| format!("{name}: the summary"))?;
        let summary: Value = serde_json::from_slice(&summary).with_context(|| format!("{name}: the summary"))?;
        ensure!(
            summary["board"].as_array().is_none_or(Vec::is_empty),
            "{name}: the board complains: {}",
            summary["board"]
        );
        Ok(Measured { counts, summary })
    }
}

impl Measured {
    fn number(&self, path: &[&str]) -> Result<f64> {
        let (root, rest) = match path {
            ["summary", rest @ ..] => (&self.summary, rest),
            _ => (&self.counts, path),
        };
        let value = rest.iter().fold(root, |value, key| &value[key]);
        value.as_f64().with_context(|| format!("no number {}", path.join(".")))
    }

    fn total(&self, function: &str) -> Result<f64> {
        self.number(&["functions", function, "total"])
    }

    fn software(&self) -> Result<f64> {
        SOFTWARE.into_iter().map(|function| self.total(function)).sum()
    }

    /// What no counted task executed: consoles and dispatcher.
    fn dispatcher(&self) -> Result<f64> {
        let tasks: Result<f64> = [STEP, FEED, HEAT, BYTES].into_iter().map(|function| self.total(function)).sum();
        Ok(self.number(&["instructions"])? - tasks? - self.software()?)
    }
}

fn read(path: &Path) -> Option<Ledger> {
    serde_json::from_slice(&fs::read(path).ok()?).ok()
}

/// The ledger of the last commit: the file in the work tree may be this machine's own last run.
fn committed(root: &Path) -> Option<Ledger> {
    let output = Command::new("git").args(["show", "HEAD:bench/ledger.json"]).current_dir(root).output().ok()?;
    serde_json::from_slice(&output.stdout).ok()
}

fn regressions(now: &Ledger, before: Option<&Ledger>) -> Vec<String> {
    let Some(before) = before else { return Vec::new() };
    now.iter()
        .filter_map(|(name, &value)| {
            let &old = before.get(name)?;
            (value > old * (1.0 + TOLERANCE)).then(|| format!("{name} {old} -> {value}"))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ledger(entries: &[(&str, f64)]) -> Ledger {
        entries.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
    }

    #[test]
    fn only_growth_beyond_the_tolerance_is_a_regression() {
        let before = ledger(&[("a", 100.0), ("b", 100.0), ("gone", 1.0)]);
        let now = ledger(&[("a", 101.9), ("b", 102.1), ("new", 5.0)]);
        assert_eq!(regressions(&now, Some(&before)), ["b 100 -> 102.1"]);
        assert!(regressions(&now, None).is_empty());
        assert!(regressions(&ledger(&[("a", 50.0)]), Some(&before)).is_empty());
    }
}

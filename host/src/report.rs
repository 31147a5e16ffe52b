//! `velvet report`: one self-contained page about a run. `velvet summary`: the same findings as text.

mod account;
mod arc;
mod checks;
mod edges;
mod follow;
pub mod laser;
mod machine;
mod marks;
pub mod page;
mod path;
mod pixels;
mod power;
mod program;
pub mod rows;
mod run;
mod slow;
mod spent;
mod times;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::plot::{Curve, draw};
use account::Account;
use checks::{Check, Evidence, Verdict};
use edges::Executed;
use machine::Machine;
use path::Samples;
use program::{Beginning, Program};
use run::Run;

/// Where the configuration and the program of a run lie, when not in its folder.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Sources {
    /// Configuration the run used [default: OUT/config.ini]
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// G-code the run executed [default: OUT/job.gcode]
    #[arg(long, value_name = "FILE")]
    gcode: Option<PathBuf>,
}

/// Run that was read and checked.
pub struct Report {
    run: Run,
    executed: Executed,
    samples: Samples,
    machine: Result<Machine, String>,
    program: Result<Program, String>,
    account: Account,
    checks: Vec<Check>,
    title: String,
}

/// Quantities that [`Report::plot`] draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Quantity {
    /// Speed of the tool
    Speed,
    /// Speed of the filament
    Filament,
    /// Every heater's temperature
    Temperature,
    /// Supply voltages
    Supply,
    /// Processor load
    Load,
}

/// Sampling period of positions, seconds; longer in a job of hours, to keep memory bounded.
const SAMPLE_S: f64 = 0.001;
const MOST_SAMPLES: f64 = 2e6;

impl Report {
    /// Reads a run's folder.
    pub fn read(out: &Path, sources: &Sources) -> Result<Self> {
        let run = Run::read(out)?;
        let config = sources.config.clone().unwrap_or_else(|| found(out, "config.ini"));
        let gcode = sources.gcode.clone().unwrap_or_else(|| found(out, "job.gcode"));
        let machine = Machine::read(&config).map_err(|error| format!("{error:#}"));
        let beginning = machine.as_ref().map_or_else(|_| Beginning::default(), |machine| machine.beginning);
        let program = Program::read(&gcode, beginning).map_err(|error| format!("{error:#}"));
        let period_s = SAMPLE_S.max(run.summary.virtual_seconds / MOST_SAMPLES);
        let executed = Executed::read(&out.join("steps.csv"), (period_s * 1e9) as u64)?;
        let title = title(&gcode, program.as_ref().ok());
        Ok(Self::new(run, executed, machine, program, period_s, title))
    }

    fn new(
        run: Run,
        executed: Executed,
        machine: Result<Machine, String>,
        program: Result<Program, String>,
        period_s: f64,
        title: String,
    ) -> Self {
        let samples = match &machine {
            Ok(machine) => {
                let anchor = program.as_ref().ok().and_then(|program| {
                    checks::anchor(&executed, machine, program).map(|anchor| anchor.origin(machine, program))
                });
                // A machine that does not home counts from its position at power-on.
                let origin = anchor.unwrap_or_else(|| machine.steps([0.0; 3]));
                Samples::take(&executed, machine, &origin, &machine.filament(), period_s)
            }
            Err(_) => Samples { period_s, points: vec![[0.0; 4]] },
        };
        let end_s = run.summary.virtual_seconds;
        let known = machine.as_ref().ok();
        let account = Account::of(&executed, &samples, known, program.as_ref().ok(), end_s);
        let evidence = Evidence {
            run: &run,
            executed: &executed,
            samples: &samples,
            closeness: account.closeness,
            machine: machine.as_ref().map_err(Clone::clone),
            program: program.as_ref().map_err(Clone::clone),
        };
        let checks = checks::all(&evidence);
        Self { account, checks, run, executed, samples, machine, program, title }
    }

    /// Returns whether no check failed.
    pub fn passes(&self) -> bool {
        self.checks.iter().all(|check| check.verdict != Verdict::Fail)
    }

    /// Writes `report.html` into the folder.
    pub fn write_page(&self, out: &Path) -> Result<PathBuf> {
        let path = out.join("report.html");
        std::fs::write(&path, page::render(self)).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(path)
    }

    /// Draws a quantity over time, as text.
    pub fn plot(&self, quantity: Quantity) -> String {
        let of_samples = |name: &str, of: &dyn Fn(usize) -> f64| {
            let stride = self.samples.points.len().div_ceil(2_000).max(1);
            let places = (0..self.samples.points.len()).step_by(stride);
            let time: Vec<f64> = places.clone().map(|index| index as f64 * self.samples.period_s).collect();
            let values: Vec<_> = places.map(|index| Some(of(index))).collect();
            draw(&Curve { name, time: &time, values: &values })
        };
        let of_telemetry = |suffix: &'static str, unit: &str| {
            let Some(table) = &self.run.telemetry else { return "no telemetry recorded\n".to_owned() };
            let curves = table
                .ending(suffix)
                .map(|(name, values)| draw(&Curve { name: &format!("{name} {unit}"), time: &table.time_s, values }));
            curves.collect()
        };
        match quantity {
            Quantity::Speed => of_samples("tool mm/s", &|index| self.samples.speed(index)),
            Quantity::Filament => of_samples("filament mm/s", &|index| self.samples.filament_speed(index)),
            Quantity::Temperature => of_telemetry("_c", "C"),
            Quantity::Supply => of_telemetry("_v", "V"),
            Quantity::Load => of_telemetry("cpu_load", "CPU load"),
        }
    }

    /// Returns the findings as lines of text.
    pub fn text(&self) -> String {
        let summary = &self.run.summary;
        let edges: u64 = self.executed.edges.iter().sum();
        let mut text = format!(
            "{}: {:.1} s on the machine's clock, {} lines, {edges} step edges\n",
            self.title, summary.virtual_seconds, summary.lines
        );
        for check in &self.checks {
            let mark = match check.verdict {
                Verdict::Pass => "pass",
                Verdict::Fail => "FAIL",
                Verdict::Skipped => "  - ",
            };
            text += &format!("  {mark}  {}: {}\n", check.what, check.found);
        }
        text + &self.account.text(summary.starved_at_s.as_deref())
    }
}

/// Finds a file of a run's folder: the copies that the native runner makes lie on its card.
fn found(out: &Path, name: &str) -> PathBuf {
    let on_card = out.join("card").join(name);
    if on_card.is_file() { on_card } else { out.join(name) }
}

/// Returns the program's own title, or the name of its file.
fn title(gcode: &Path, program: Option<&Program>) -> String {
    let named = program.and_then(|program| program.title.clone());
    let file = gcode.file_stem().map(|name| name.to_string_lossy().into_owned());
    named.or(file).unwrap_or_else(|| "Run".to_owned())
}

#[cfg(test)]
mod fake;

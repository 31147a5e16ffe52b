//! `velvet run`: a job on this computer, in virtual time, without an emulator. The same machine code as on
//! the board; what the image does is shown by the virtual board.

use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow};
use clap::ValueEnum;
use config::BoardId;
use sim::models::tmc26x;
use sim::runner::{self, Job};
use sim::world::TimedFault;

use crate::progress::Progress;

/// Which driver chips the board carries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Chip {
    /// TMC2590
    #[default]
    Tmc2590,
    /// TMC2660
    Tmc2660,
}

impl Chip {
    /// Returns the board with this chip.
    pub const fn board(self) -> BoardId {
        match self {
            Self::Tmc2590 => BoardId::Prime2590,
            Self::Tmc2660 => BoardId::Prime2660,
        }
    }

    /// Returns the model of the chip.
    const fn model(self) -> tmc26x::Chip {
        match self {
            Self::Tmc2590 => tmc26x::Chip::Tmc2590,
            Self::Tmc2660 => tmc26x::Chip::Tmc2660,
        }
    }
}

/// Reads a time in seconds, returns nanoseconds.
fn seconds(text: &str) -> Result<u64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds.is_finite() => Ok((seconds * 1e9) as u64),
        _ => Err("a time above 0 s is needed".to_owned()),
    }
}

/// Job, and the machine that it is made on.
#[derive(Clone, Debug, clap::Args)]
pub struct JobOptions {
    /// Configuration of the machine
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// Job to execute
    #[arg(long, value_name = "FILE")]
    gcode: PathBuf,
    /// Give up after this much virtual time
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    until: Option<u64>,
    /// Driver chips of the board
    #[arg(long, value_enum, default_value_t)]
    drivers: Chip,
    /// Something that goes wrong, and when
    #[arg(long, value_name = "FAULT", value_parser = TimedFault::parse, long_help = sim::world::SPELLING)]
    fault: Vec<TimedFault>,
}

impl JobOptions {
    /// Returns the job for the native runner, with the folder of its run.
    pub fn job(&self, out: &Path, verify: bool) -> Job {
        Job {
            config: self.config.clone(),
            gcode: self.gcode.clone(),
            out: out.to_owned(),
            until_ns: self.until,
            chip: self.drivers.model(),
            faults: self.fault.clone(),
            verify,
        }
    }
}

/// What `velvet run` takes.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    #[command(flatten)]
    job: JobOptions,
    /// Folder for what the run leaves
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Compare every step edge with the ideal trajectory
    #[arg(long)]
    verify: bool,
}

/// Runs the job; returns whether it ended without halt and error, and prints the reason if not.
pub fn run(options: &Options) -> Result<bool> {
    let job = options.job.job(&options.out, options.verify);
    let mut progress = Progress::new();
    let outcome = runner::run(&job, &mut |share| progress.show(share)).map_err(|reason| anyhow!(reason));
    progress.clear();
    let outcome = outcome?;
    for error in &outcome.errors {
        println!("{error}");
    }
    if let Some(reason) = &outcome.halted {
        println!("halted: {reason}");
    }
    if let Some(error) = outcome.step_error {
        println!("step times against the oracle: at most {:.1} ns off, rms {:.2} ns", error.max_ns, error.rms_ns);
    }
    if outcome.succeeded() {
        println!("{} lines done", outcome.lines);
    }
    Ok(outcome.succeeded())
}

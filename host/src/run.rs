//! `velvet run`: a job on this computer, in virtual time, without an emulator. The same machine code as on the board;
//! what the image does is shown by the virtual board.

use std::io::{IsTerminal, Write};
use std::path::PathBuf;

use anyhow::{Result, anyhow, bail};
use clap::ValueEnum;
use sim::models::tmc26x;
use sim::runner::{self, Job};
use sim::world::TimedFault;

/// Which driver chips the board carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Chip {
    /// TMC2590
    Tmc2590,
    /// TMC2660
    Tmc2660,
}

/// What `velvet run` takes.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// Configuration of the machine
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// Job to execute
    #[arg(long, value_name = "FILE")]
    gcode: PathBuf,
    /// Folder for what the run leaves
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Give up after this much virtual time
    #[arg(long, value_name = "SECONDS")]
    until: Option<f64>,
    /// Driver chips of the board
    #[arg(long, value_enum, default_value = "tmc2590")]
    drivers: Chip,
    /// Something that goes wrong, and when
    #[arg(long, value_name = "FAULT", value_parser = TimedFault::parse, long_help = sim::world::SPELLING)]
    fault: Vec<TimedFault>,
    /// Compare every step edge with the ideal trajectory
    #[arg(long)]
    verify: bool,
}

/// Runs the job; whether it ended without halt and error. The reason is printed when it did not.
pub fn run(options: &Options) -> Result<bool> {
    let until_ns = match options.until {
        Some(seconds) if seconds > 0.0 && seconds.is_finite() => Some((seconds * 1e9) as u64),
        Some(seconds) => bail!("--until {seconds}: a time above 0 s is needed"),
        None => None,
    };
    let job = Job {
        config: options.config.clone(),
        gcode: options.gcode.clone(),
        out: options.out.clone(),
        until_ns,
        chip: match options.drivers {
            Chip::Tmc2590 => tmc26x::Chip::Tmc2590,
            Chip::Tmc2660 => tmc26x::Chip::Tmc2660,
        },
        faults: options.fault.clone(),
        verify: options.verify,
    };
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

/// Percentage on a terminal; nothing in a log file.
struct Progress {
    shown: Option<u32>,
    terminal: bool,
}

impl Progress {
    fn new() -> Self {
        Self { shown: None, terminal: std::io::stderr().is_terminal() }
    }

    fn show(&mut self, share: f64) {
        let percent = (100.0 * share) as u32;
        if self.terminal && self.shown != Some(percent) {
            eprint!("\r{percent:3} %");
            // A terminal that does not take it shows it later; nothing depends on it.
            let _ = std::io::stderr().flush();
            self.shown = Some(percent);
        }
    }

    fn clear(&self) {
        if self.shown.is_some() {
            eprint!("\r      \r");
        }
    }
}

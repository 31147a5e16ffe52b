//! `velvet verify`: every step edge of a run against the ideal trajectory of its job.
//!
//! The run may come from anything that writes `steps.csv`: the virtual board, another image on it, a logic
//! analyser. The trajectory is that of the native runner, and the oracle measures each step's distance from
//! it.

use std::path::PathBuf;

use anyhow::{Result, anyhow};
use sim::output;
use sim::runner::{self, Job};
use sim::world::TimedFault;

use crate::progress::Progress;
use crate::report::rows::{self, Rows};
use crate::run::Chip;

/// What `velvet verify` takes.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// The run's folder
    out: PathBuf,
    /// Configuration of the machine
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// Job that was executed
    #[arg(long, value_name = "FILE")]
    gcode: PathBuf,
    /// Give up planning after this much virtual time
    #[arg(long, value_name = "SECONDS", value_parser = crate::run::seconds)]
    until: Option<u64>,
    /// Driver chips of the board
    #[arg(long, value_enum, default_value = "tmc2590")]
    drivers: Chip,
    /// Something that went wrong in the run, and when
    #[arg(long, value_name = "FAULT", value_parser = TimedFault::parse, long_help = sim::world::SPELLING)]
    fault: Vec<TimedFault>,
}

/// Compares the run, and writes the result into its summary; returns whether it moved as planned, and
/// prints the reason if not.
pub fn verify(options: &Options) -> Result<bool> {
    let job = Job {
        config: options.config.clone(),
        gcode: options.gcode.clone(),
        out: options.out.clone(),
        until_ns: options.until,
        chip: options.drivers.model(),
        faults: options.fault.clone(),
        verify: true,
    };
    let mut progress = Progress::new();
    let result = runner::verify(&job, &mut |share| progress.show(share), &mut || {
        let rows = rows::open(&options.out.join("steps.csv")).map_err(|error| format!("{error:#}"))?;
        Ok(Rows::of(rows).map(|edge| edge.map_err(|error| error.to_string())))
    });
    progress.clear();
    output::add_verification(&options.out, &result).map_err(|reason| anyhow!(reason))?;
    match result {
        Ok(error) => {
            println!("step times against the oracle: at most {:.1} ns off, rms {:.2} ns", error.max_ns, error.rms_ns)
        }
        Err(reason) => {
            println!("not verified: {reason}");
            return Ok(false);
        }
    }
    Ok(true)
}

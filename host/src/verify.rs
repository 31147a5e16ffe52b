//! `velvet verify`: every step edge of a run against the ideal trajectory of its job.
//!
//! The run may come from anything that writes `steps.csv`: the virtual board, another image on it, a logic
//! analyser. The trajectory is that of the native runner, and the oracle measures each step's distance from
//! it.

use std::path::PathBuf;

use anyhow::{Result, anyhow};
use sim::output::{self, StepError};
use sim::runner::{self, Job};

use crate::progress::Progress;
use crate::report::rows::{self, Rows};
use crate::run::JobOptions;

/// What `velvet verify` takes.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// The run's folder
    out: PathBuf,
    #[command(flatten)]
    job: JobOptions,
}

/// Compares every edge of the run in the job's folder with the plan; an error says why it could not be.
pub fn compare(job: &Job, progress: &mut Progress) -> Result<StepError, String> {
    runner::verify(job, &mut |share| progress.show(share), &mut || {
        let rows = rows::open(&job.out.join("steps.csv")).map_err(|error| format!("{error:#}"))?;
        Ok(Rows::of(rows).map(|edge| edge.map_err(|error| error.to_string())))
    })
}

/// Compares the run, and writes the result into its summary; returns whether it moved as planned, and
/// prints the reason if not.
pub fn verify(options: &Options) -> Result<bool> {
    let job = options.job.job(&options.out, true);
    let mut progress = Progress::new();
    let result = compare(&job, &mut progress);
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

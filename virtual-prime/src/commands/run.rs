//! Subcommand `virtual-prime run`: a job, headless, to its end.

use std::path::PathBuf;

use clap::Args;

use super::job::{JobOptions, Study, play};

/// Options of `run`.
#[derive(Args)]
pub struct Options {
    #[command(flatten)]
    job: JobOptions,
    /// Directory for the run's files.
    #[arg(long)]
    out: PathBuf,
}

/// Runs the job; progress goes to standard error.
///
/// # Errors
/// Why the job did not go through, or that the board has something to complain about our own image.
pub fn run(options: &Options) -> Result<(), String> {
    let outcome = play(&options.job, &Study::default(), &options.out)?.outcome;
    outcome.board.iter().for_each(|line| eprintln!("board: {line}"));
    if let Some(reason) = outcome.halted.or_else(|| outcome.errors.into_iter().next()) {
        return Err(reason);
    }
    match outcome.board.len() {
        count if count > 0 && !options.job.foreign => Err(format!("{count} complaints of the board")),
        _ => Ok(()),
    }
}

//! `virtual-prime bench`: how many instructions functions take while a job runs.

use std::path::PathBuf;

use clap::Args;

use super::job::{JobOptions, play};

/// Options of `bench`.
#[derive(Args)]
pub struct Options {
    #[command(flatten)]
    job: JobOptions,
    /// Functions to count, by symbol or by a name within a mangled one.
    #[arg(long, required = true, value_delimiter = ',')]
    function: Vec<String>,
    /// Directory for the run's files; a temporary one when not given.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Runs the job and prints one JSON object on standard output.
///
/// # Errors
/// When the job did not go through: its counts would mean nothing.
pub fn run(options: &Options) -> Result<(), String> {
    let scratch = std::env::temp_dir().join(format!("virtual-prime-bench-{}", std::process::id()));
    let out = options.out.as_ref().unwrap_or(&scratch);
    let finished = play(&options.job, &options.function, out)?;
    if options.out.is_none() {
        // Left-over files in the system's temporary directory harm nobody.
        let _ = std::fs::remove_dir_all(&scratch);
    }
    if let Some(reason) = finished.outcome.halted.or_else(|| finished.outcome.errors.into_iter().next()) {
        return Err(reason);
    }
    let records = finished.records.lock();
    let rows: Vec<String> = options
        .function
        .iter()
        .map(|name| {
            let mut counts = records.calls.get(name).map(|calls| calls.instructions.clone()).unwrap_or_default();
            counts.sort_unstable();
            format!("    {name:?}: {}", row(&counts))
        })
        .collect();
    println!("{{");
    println!("  \"virtual_seconds\": {:.6},", finished.virtual_ns as f64 * 1e-9);
    println!("  \"instructions\": {},", finished.instructions);
    println!("  \"lines\": {},", finished.outcome.lines);
    println!("  \"functions\": {{\n{}\n  }}\n}}", rows.join(",\n"));
    Ok(())
}

/// The distribution of a function's counts, sorted. One that was never called has none.
fn row(counts: &[u32]) -> String {
    let (Some(min), Some(max)) = (counts.first(), counts.last()) else { return "{\"calls\": 0}".into() };
    let at = |share: f64| counts[((counts.len() - 1) as f64 * share) as usize];
    let total: u64 = counts.iter().map(|&count| u64::from(count)).sum();
    format!(
        "{{\"calls\": {}, \"min\": {min}, \"median\": {}, \"p99\": {}, \"max\": {max}, \"total\": {total}}}",
        counts.len(),
        at(0.5),
        at(0.99)
    )
}

//! Subcommand `virtual-prime bench`: cost of a job to the image, in instructions.

use std::ops::Range;
use std::path::PathBuf;

use clap::Args;
use virtual_prime::instruments::{Call, Probe, Recorded};

use super::job::{Finished, JobOptions, Study, play};
use super::network_load::Load;

/// Lead of the step feed: calls that belong to a motion begin so long before its first step.
const AHEAD_NS: u64 = 2_000_000;
/// Margin at both ends of the motion without samples of the queue, which fills at the beginning and empties
/// at the end.
const SETTLED_NS: u64 = 5_000_000;

/// Options of `bench`.
#[derive(Args)]
pub struct Options {
    #[command(flatten)]
    job: JobOptions,
    /// Functions to count, by symbol or by a name within a mangled one.
    #[arg(long, required = true, value_delimiter = ',')]
    function: Vec<String>,
    /// Measure how long interrupts are masked while the machine moves.
    #[arg(long)]
    masked: bool,
    /// Look how far the step queue is written ahead: FUNCTION,VARIABLE,OFFSET, looked at when the function is
    /// entered.
    #[arg(long)]
    queue: Option<String>,
    /// Ask `?` and M105 all the time while the machine moves.
    #[arg(long)]
    flood: bool,
    /// Have a computer at the USB socket say and hear all it can while the machine moves.
    #[arg(long)]
    usb_flood: bool,
    /// Plug in a network, and have this traffic on it while the machine moves.
    #[arg(long)]
    network: Option<Load>,
    /// Type `!` after this many steps, and `~` later.
    #[arg(long)]
    hold_after: Option<u64>,
    /// Type that `!` so much later, in microseconds: where the byte falls between two runs of the step feed.
    #[arg(long, default_value_t = 0, requires = "hold_after")]
    hold_delay_us: u64,
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
    let probe = Probe {
        functions: options.function.clone(),
        masked: options.masked,
        queue: options.queue.clone(),
        ..Probe::default()
    };
    let hold_delay_ns = options.hold_delay_us * 1_000;
    let study = Study {
        probe,
        flood: options.flood,
        usb_flood: options.usb_flood,
        network: options.network,
        hold_after: options.hold_after,
        hold_delay_ns,
    };
    let finished = play(&options.job, &study, out)?;
    if options.out.is_none() {
        // Left-over files in the system's temporary directory harm nobody.
        let _ = std::fs::remove_dir_all(&scratch);
    }
    if let Some(reason) = finished.outcome.halted.iter().chain(&finished.outcome.errors).next() {
        return Err(reason.clone());
    }
    print(&finished, &options.function);
    Ok(())
}

fn print(finished: &Finished, functions: &[String]) {
    let records = finished.records.lock();
    let moving = finished.moving.map_or(0..0, |(first, last)| first.saturating_sub(AHEAD_NS)..last + 1);
    let rows: Vec<String> = functions
        .iter()
        .map(|name| format!("    {name:?}: {}", row(records.calls.get(name).map_or(&[], Vec::as_slice), &moving)))
        .collect();
    println!("{{");
    println!("  \"virtual_seconds\": {:.6},", finished.virtual_ns as f64 * 1e-9);
    println!("  \"instructions\": {},", finished.instructions);
    println!("  \"to_last_step\": {},", to_last_step(&records, &moving));
    println!("  \"lines\": {},", finished.outcome.lines);
    println!("  \"moving\": {},", motion(&records, &moving));
    if let Some(held_ns) = finished.held_ns {
        println!("  \"held_ns\": {held_ns},");
    }
    println!("  \"functions\": {{\n{}\n  }}\n}}", rows.join(",\n"));
}

/// Counts the instructions from power-on to the last step. Until the operator sees that the job has ended,
/// the machine idles for a time that has nothing to do with it.
fn to_last_step(records: &Recorded, moving: &Range<u64>) -> u64 {
    records.calls.values().flatten().filter(|call| call.at_ns < moving.end).map(|call| call.before).max().unwrap_or(0)
}

/// Describes the run from just before the first step to the last step, as JSON.
fn motion(records: &Recorded, moving: &Range<u64>) -> String {
    let began: Vec<u64> = records.calls.values().flatten().filter(within(moving)).map(|call| call.before).collect();
    let instructions = began.iter().max().zip(began.iter().min()).map_or(0, |(last, first)| last - first);
    let mut text =
        format!("{{\"seconds\": {:.6}, \"instructions\": {instructions}", (moving.end - moving.start) as f64 * 1e-9);
    let windows = &records.masking.windows;
    text += &format!(", \"masked_windows_of_run\": {}", windows.len());
    let moving_windows = windows.iter().filter(|window| moving.contains(&window.at_ns));
    if let Some(longest) = moving_windows.max_by_key(|window| window.instructions) {
        text += &format!(", \"masked_max\": {}, \"masked_at\": {}", longest.instructions, longest.address);
    }
    let settled = moving.start + AHEAD_NS + SETTLED_NS..moving.end.saturating_sub(SETTLED_NS);
    let mut ahead: Vec<u64> =
        records.queue.iter().filter(|look| settled.contains(&look.at_ns)).map(|look| look.ahead_ns).collect();
    ahead.sort_unstable();
    if let (Some(least), Some(median)) = (ahead.first(), ahead.get(ahead.len() / 2)) {
        text += &format!(", \"ahead_ns_min\": {least}, \"ahead_ns_median\": {median}");
    }
    text + "}"
}

fn within(moving: &Range<u64>) -> impl Fn(&&Call) -> bool {
    let moving = moving.clone();
    move |call| moving.contains(&call.at_ns)
}

/// Describes the distribution of a function's counts; `moving` are those while the machine moves. A function
/// that was never called has none.
fn row(calls: &[Call], moving: &Range<u64>) -> String {
    let mut counts: Vec<u32> = calls.iter().map(|call| call.instructions).collect();
    counts.sort_unstable();
    let (Some(min), Some(max)) = (counts.first(), counts.last()) else {
        return "{\"calls\": 0, \"first_ns\": 0, \"max\": 0, \"total\": 0, \"to_last_step\": 0, \"moving\": 0}".into();
    };
    let at = |share: f64| counts[((counts.len() - 1) as f64 * share) as usize];
    let sum = |counts: &mut dyn Iterator<Item = u32>| counts.map(u64::from).sum::<u64>();
    let total = sum(&mut counts.iter().copied());
    let before = sum(&mut calls.iter().filter(|call| call.at_ns < moving.end).map(|call| call.instructions));
    let meanwhile = sum(&mut calls.iter().filter(within(moving)).map(|call| call.instructions));
    let first_ns = calls.iter().map(|call| call.at_ns).min().unwrap_or(0);
    format!(
        "{{\"calls\": {}, \"first_ns\": {first_ns}, \"min\": {min}, \"median\": {}, \"p99\": {}, \"max\": {max}, \"total\": {total}, \"to_last_step\": {before}, \"moving\": {meanwhile}}}",
        counts.len(),
        at(0.5),
        at(0.99)
    )
}

//! How soon a hold takes effect: from the byte to the first step that comes later than the motion before
//! would have had it.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

/// The motion before the byte that is taken as steady.
const STEADY_NS: u64 = 20_000_000;
/// So many steps in a row must be late: then it is no jitter.
const IN_A_ROW: usize = 100;

/// Microseconds from `held_ns` to the first slower step of the motor in a run's `steps.csv`.
pub fn latency_us(steps: &Path, motor: &str, held_ns: u64) -> Result<f64> {
    let text = fs::read_to_string(steps).with_context(|| steps.display().to_string())?;
    let times: Vec<u64> = text
        .lines()
        .filter_map(|line| {
            let mut fields = line.split(',');
            let time = fields.next()?.parse().ok()?;
            (fields.next() == Some(motor)).then_some(time)
        })
        .collect();
    let slower = first_slower(&times, held_ns).context("no step was slower after the hold")?;
    Ok((slower - held_ns) as f64 * 1e-3)
}

/// The first step after `held_ns` from which on every step is later than the steady motion before, by more
/// than any step of that motion was.
fn first_slower(times: &[u64], held_ns: u64) -> Option<u64> {
    let held = times.partition_point(|&time| time <= held_ns);
    let steady = &times[times.partition_point(|&time| time + STEADY_NS < held_ns)..held];
    let (&first, &last) = (steady.first()?, steady.last()?);
    let interval = (last - first) as f64 / (steady.len() - 1).max(1) as f64;
    let late = |(index, &time): (usize, &u64)| time as f64 - (first as f64 + index as f64 * interval);
    let jitter = steady.iter().enumerate().map(late).fold(0.0, f64::max);
    let after = &times[held..];
    let is_late = |index: usize| late((steady.len() + index, &after[index])) > jitter;
    (0..after.len().checked_sub(IN_A_ROW)?).find(|&at| (at..at + IN_A_ROW).all(is_late)).map(|at| after[at])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jitter_is_no_hold_and_braking_is() {
        // 100 kHz with 200 ns of jitter for 50 ms; then each interval is 1 us longer than the one before.
        let mut times: Vec<u64> = (0..5_000).map(|step| step * 10_000 + step % 3 * 100).collect();
        assert_eq!(first_slower(&times, 40_000_000), None);
        for extra in 1..=200 {
            times.push(times.last().expect("a step") + 10_000 + extra * 1_000);
        }
        let slower = first_slower(&times, 40_000_000).expect("it brakes");
        assert!((49_990_000..=50_030_000).contains(&slower), "{slower}");
    }
}

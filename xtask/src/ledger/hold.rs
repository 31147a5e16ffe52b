//! Latency of a hold: from the byte to the first step that comes later than the motion before
//! would have had it.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

use super::board::{Bench, Job, Measured};
use super::jobs;
use super::machines::Machines;

/// The hold comes in the middle of its stroke.
const HOLD_AFTER: u64 = 120_000;
/// Where between two runs of the step feed the hold comes: how soon it is felt depends on it, and any change
/// of how long the image takes to start moves it.
const DELAYS_US: [u64; 5] = [0, 100, 200, 300, 400];
/// How far they are apart, and how far two runs at steady speed are: as long as a segment.
const APART_US: u64 = 100;
const PERIOD_US: u64 = 500;
/// Times that the search for the worst moment is halved.
const HALVES: usize = 4;
/// The jobs that are held, and their keys in the ledger.
const HELD: [(&str, &str); 2] = [("hold", "hold_latency_us"), ("hold-shaped", "hold_latency_shaped_us")];

/// The motion before the byte that is taken as steady.
const STEADY_NS: u64 = 20_000_000;
/// So many steps in a row must be late: then it is no jitter.
const IN_A_ROW: usize = 100;

/// The worst there is, by the ledger's key.
pub fn latencies_us(bench: &Bench<'_>, machines: &Machines) -> Result<Vec<(&'static str, f64)>> {
    let names = HELD.map(|(name, _)| name);
    let coarse =
        bench.run(names.iter().flat_map(|name| DELAYS_US.map(|delay_us| job(machines, name, delay_us))).collect())?;
    let mut worst = Vec::new();
    for name in names {
        let latencies: Vec<(u64, f64)> =
            DELAYS_US.into_iter().map(|at| Ok((at, of_run(coarse.of(&held(name, at))?)?))).collect::<Result<_>>()?;
        worst.push(Worst::of(&latencies));
    }
    for _ in 0..HALVES {
        let jobs = names.iter().zip(&worst).map(|(name, worst)| job(machines, name, worst.between())).collect();
        let results = bench.run(jobs)?;
        for (name, worst) in names.iter().zip(&mut worst) {
            worst.narrow(of_run(results.of(&held(name, worst.between()))?)?);
        }
    }
    Ok(HELD.iter().zip(worst).map(|((_, key), worst)| (*key, worst.latency_us)).collect())
}

/// The worst moment so far. The later the byte comes, the sooner it is felt, until it misses a run of the
/// step feed and waits for the next: the worst moment of all is the first of those that miss it.
struct Worst {
    latency_us: f64,
    /// The hold misses that run.
    missed_us: u64,
    /// The last that is known not to.
    in_time_us: u64,
}

impl Worst {
    /// The worst of moments [`APART_US`] from each other, all round the period.
    fn of(latencies: &[(u64, f64)]) -> Self {
        let &(at, latency_us) = latencies.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(&(0, 0.0));
        let missed_us = at + PERIOD_US;
        Self { latency_us, missed_us, in_time_us: missed_us - APART_US }
    }

    const fn between(&self) -> u64 {
        self.in_time_us.midpoint(self.missed_us)
    }

    /// The latency at the moment between the two.
    fn narrow(&mut self, latency_us: f64) {
        if latency_us > self.latency_us {
            (self.latency_us, self.missed_us) = (latency_us, self.between());
        } else {
            self.in_time_us = self.between();
        }
    }
}

fn held(job: &str, delay_us: u64) -> String {
    format!("{job}-{delay_us}")
}

fn job(machines: &Machines, name: &str, delay_us: u64) -> Job {
    let (config, gcode) = if name == "hold" {
        (machines.fast.clone(), jobs::stroke())
    } else {
        (machines.looking_far_ahead(), jobs::line_of_filament())
    };
    Job::new(held(name, delay_us), &config, gcode).held_after(HOLD_AFTER, delay_us)
}

fn of_run(run: &Measured) -> Result<f64> {
    latency_us(&run.out.join("steps.csv"), "alpha", run.number(&["held_ns"])? as u64)
}

/// Microseconds from `held_ns` to the first slower step of the motor in a run's `steps.csv`.
fn latency_us(steps: &Path, motor: &str, held_ns: u64) -> Result<f64> {
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
    fn the_worst_moment_is_found_between_two_runs_of_the_feed() {
        // A run at 130 us: what comes up to then is felt 400 us behind it.
        let latency_us = |at: u64| ((130 + 2 * PERIOD_US - at) % PERIOD_US + 400) as f64;
        let mut worst = Worst::of(&DELAYS_US.map(|at| (at, latency_us(at))));
        assert_eq!(worst.latency_us, 830.0);
        for _ in 0..HALVES {
            worst.narrow(latency_us(worst.between()));
        }
        assert!((893.0..900.0).contains(&worst.latency_us), "{}", worst.latency_us);
    }

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

//! The checks of a run: against its program, against itself, and against the rules of a safe end.

use super::account::Closeness;
use super::edges::{Executed, Stop};
use super::machine::Machine;
use super::path::Samples;
use super::power::Change;
use super::program::Program;
use super::run::Run;
use serde::Serialize;
use units::{Actuator, MAX_ACTUATORS};

/// Greatest error of the filament moved, mm.
const FILAMENT_TOLERANCE_MM: f64 = 0.01;
/// Greatest distance of the executed path from the programmed one, mm: half a step on each axis and the
/// error of sampling.
const PATH_TOLERANCE_MM: f64 = 0.05;
/// Lateness from which an edge counts as late, ns, as in the firmware.
const LATE_NS: f64 = 250.0;

/// Reason for not checking the ways between objects.
const LEFT_OUT: &str = "an object is left out, and the machine finds its own way to the next one";

/// Outcome of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Passed: the run is as it should be.
    Pass,
    /// Failed: the run is not as it should be.
    Fail,
    /// Not checked; the finding says why.
    Skipped,
}

/// Row of the table of checks.
#[derive(Clone, Debug, Serialize)]
pub struct Check {
    /// Subject of the check.
    pub what: &'static str,
    /// Outcome of the check.
    pub verdict: Verdict,
    /// Finding of the check, in words.
    pub found: String,
}

fn check(what: &'static str, passes: bool, found: String) -> Check {
    Check { what, verdict: if passes { Verdict::Pass } else { Verdict::Fail }, found }
}

fn skipped(what: &'static str, why: &str) -> Check {
    Check { what, verdict: Verdict::Skipped, found: why.to_owned() }
}

/// Everything there is to look at. Missing evidence makes checks skipped, with the reason.
pub struct Evidence<'a> {
    /// The files of the run's folder.
    pub run: &'a Run,
    /// Step edges of the run.
    pub executed: &'a Executed,
    /// Positions at even times.
    pub samples: &'a Samples,
    /// Distance from the program's path, if the samples could be laid along it.
    pub closeness: Option<Closeness>,
    /// The machine, or the reason for not knowing it.
    pub machine: Result<&'a Machine, String>,
    /// The program, or the reason for not knowing it.
    pub program: Result<&'a Program, String>,
}

/// Returns all checks, in the order a person asks.
pub fn all(evidence: &Evidence<'_>) -> Vec<Check> {
    let summary = &evidence.run.summary;
    let halted = summary.halted.as_deref();
    let mut checks = vec![
        check("The job ended without a halt", halted.is_none(), halted.unwrap_or("ran to its end").to_owned()),
        check("No errors were reported", summary.errors.is_empty(), listed(&summary.errors, "none")),
    ];
    checks.push(final_position(evidence));
    checks.push(filament(evidence));
    checks.push(path(evidence));
    checks.push(heaters_off(evidence.run));
    checks.extend(laser_off(&evidence.run.power));
    checks.push(lost_motion(evidence.run));
    checks.push(step_times(evidence));
    checks.extend(summary.timing_faults.map(|faults| {
        check("Every direction was set in time for its step", faults == 0, format!("{faults} steps too early"))
    }));
    checks.extend(trace_is_whole(evidence));
    checks.push(match &summary.board {
        None => skipped("The emulated board had no complaint", "not run on the virtual board"),
        Some(complaints) => {
            let complaints: Vec<String> = complaints.iter().map(complaint).collect();
            check("The emulated board had no complaint", complaints.is_empty(), listed(&complaints, "none"))
        }
    });
    checks
}

fn laser_off(power: &[Change]) -> Option<Check> {
    let Change { time_ns, duty } = *power.last()?;
    let found = match duty {
        0.0 => format!("since {:.3} s", time_ns as f64 * 1e-9),
        _ => format!("burns at {:.0} % since {:.3} s", 100.0 * duty, time_ns as f64 * 1e-9),
    };
    Some(check("The laser is off at the end", duty == 0.0, found))
}

fn complaint(value: &serde_json::Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

fn listed(items: &[String], none: &str) -> String {
    match items {
        [] => none.to_owned(),
        [one] => one.clone(),
        [first, second] => format!("{first}; {second}"),
        [first, second, ..] => format!("{first}; {second}; and {} more", items.len() - 2),
    }
}

/// Origin of the program's coordinates, in steps from power-on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// The stop where homing ended.
    pub stop: Stop,
    /// Worst distance of a motor from the program's end, steps.
    pub worst_steps: f64,
    /// Motor with the worst distance.
    pub worst: Actuator,
}

/// Finds the stop after homing: of all stops, the one from which the motors went on to end at the program's
/// end. No other place fits three motors at once but by an error of the run. If homing stops at that place
/// more than once, the stop counts after which the motors made as many steps as the program has. Without
/// homing the run's beginning counts.
pub fn anchor(executed: &Executed, machine: &Machine, program: &Program) -> Option<Anchor> {
    // Motors rest on whole steps.
    let from = machine.steps(program.path().first()?.at).map(f64::round);
    let to = machine.steps(program.end());
    let asked = program_steps(machine, program);
    let begin = Stop::default();
    let stops = if program.homes { executed.stops.as_slice() } else { std::slice::from_ref(&begin) };
    let candidates = stops.iter().map(|stop| {
        let mut anchor = Anchor { stop: *stop, worst_steps: 0.0, worst: Actuator::Alpha };
        let mut surplus = 0.0;
        for motor in PRIMARY {
            let index = motor as usize;
            let off = (executed.net_steps[index] - stop.steps[index]) as f64 - (to[index] - from[index]);
            let off = machine.within_a_turn(motor, off);
            if off.abs() > anchor.worst_steps.abs() {
                (anchor.worst, anchor.worst_steps) = (motor, off);
            }
            surplus += ((executed.edges[index] - stop.edges[index]) as f64 - asked[index]).abs();
        }
        (anchor, surplus)
    });
    let order = |(anchor, surplus): &(Anchor, f64)| (anchor.worst_steps.abs().round(), *surplus);
    let nearest = candidates.min_by(|a, b| order(a).partial_cmp(&order(b)).unwrap_or(std::cmp::Ordering::Equal));
    nearest.map(|(anchor, _)| anchor)
}

impl Anchor {
    /// Returns each motor's position at power-on, in steps of the machine's own count.
    pub fn origin(&self, machine: &Machine, program: &Program) -> [f64; MAX_ACTUATORS] {
        let mut origin = machine.steps(program.path().first().map_or([0.0; 3], |vertex| vertex.at)).map(f64::round);
        origin.iter_mut().zip(self.stop.steps).for_each(|(origin, steps)| *origin -= steps as f64);
        origin
    }
}

const PRIMARY: [Actuator; 3] = [Actuator::Alpha, Actuator::Beta, Actuator::Gamma];

/// Returns the steps that each motor makes along the program's path, either way.
fn program_steps(machine: &Machine, program: &Program) -> [f64; 6] {
    let mut sum = [0.0; 6];
    for pair in program.path().windows(2) {
        let (from, to) = (machine.steps(pair[0].at), machine.steps(pair[1].at));
        for (sum, (from, to)) in sum.iter_mut().zip(from.into_iter().zip(to)) {
            *sum += (to - from).abs();
        }
    }
    sum
}

/// Returns machine, program and anchor, or the reason for having none.
fn anchored<'a>(evidence: &Evidence<'a>) -> Result<(&'a Machine, &'a Program, Anchor), String> {
    let machine = evidence.machine.clone()?;
    let program = evidence.program.clone()?;
    if machine.kinematics.is_none() {
        return Err("the configuration's geometry is that of no machine".to_owned());
    }
    if let Some(unknown) = &program.unknown {
        return Err(format!("the program moves its coordinates in a way this page does not follow ({unknown})"));
    }
    let anchor = anchor(evidence.executed, machine, program).ok_or("the program has no path")?;
    Ok((machine, program, anchor))
}

fn final_position(evidence: &Evidence<'_>) -> Check {
    const WHAT: &str = "X, Y and Z end where the G-code ends, within half a microstep";
    let (_, program, anchor) = match anchored(evidence) {
        Ok(known) => known,
        Err(why) => return skipped(WHAT, &why),
    };
    let [x, y, z] = program.end();
    // The margin covers the rounding of the comparison itself.
    let passes = anchor.worst_steps.abs() <= 0.5 + 1e-6;
    check(
        WHAT,
        passes,
        format!("X{x:.3} Y{y:.3} Z{z:.3}, at most {:.2} steps off ({})", anchor.worst_steps.abs(), anchor.worst.name()),
    )
}

fn filament(evidence: &Evidence<'_>) -> Check {
    const WHAT: &str = "Filament moved is what the G-code asks, within 0.01 mm";
    let (machine, program) = match (evidence.machine.clone(), evidence.program.clone()) {
        (Ok(machine), Ok(program)) => (machine, program),
        (Err(why), _) | (_, Err(why)) => return skipped(WHAT, &why),
    };
    if program.extruded.is_empty() {
        return skipped(WHAT, "the program moves no filament");
    }
    if program.leaves_out {
        return skipped(WHAT, LEFT_OUT);
    }
    let mut found = Vec::new();
    let mut passes = true;
    for (tool, asked) in &program.extruded {
        let Some(motor) = machine.extruder(*tool) else {
            return check(WHAT, false, format!("tool {tool} has no extruder in the configuration"));
        };
        let Some(scale) = machine.steps_per_mm[motor as usize] else {
            return check(WHAT, false, format!("{} has no steps_per_mm", motor.name()));
        };
        let done = evidence.executed.net_steps[motor as usize] as f64 / scale;
        passes &= (done - asked).abs() <= FILAMENT_TOLERANCE_MM;
        found.push(format!("{done:.4} mm moved, {asked:.4} mm asked"));
    }
    check(WHAT, passes, found.join("; "))
}

fn path(evidence: &Evidence<'_>) -> Check {
    const WHAT: &str = "The executed path follows the programmed one, within 0.05 mm";
    let (machine, program, _) = match anchored(evidence) {
        Ok(known) => known,
        Err(why) => return skipped(WHAT, &why),
    };
    if program.leaves_out {
        return skipped(WHAT, LEFT_OUT);
    }
    if machine.shaped || program.rounds_corners {
        return skipped(WHAT, "corners are rounded on purpose, by input shaping or G64");
    }
    if evidence.samples.period_s > 0.002_1 {
        return skipped(WHAT, "the job is too long to hold every millisecond of it");
    }
    match evidence.closeness {
        None => skipped(WHAT, "the program has no path"),
        Some(Closeness { left_at: Some(line), .. }) => check(WHAT, false, format!("it leaves the path at line {line}")),
        Some(Closeness { largest_mm, .. }) => {
            check(WHAT, largest_mm <= PATH_TOLERANCE_MM, format!("at most {largest_mm:.4} mm apart"))
        }
    }
}

fn heaters_off(run: &Run) -> Check {
    const WHAT: &str = "All heaters are off at the end";
    let Some(telemetry) = &run.telemetry else { return skipped(WHAT, "the run has no telemetry") };
    let heaters: Vec<(&str, f64)> = telemetry
        .ending("_duty")
        .filter(|(name, duty)| run.summary.heaters.contains_key(*name) && duty.iter().flatten().any(|duty| *duty > 0.0))
        .filter_map(|(name, duty)| Some((name, last_power(&telemetry.time_s, duty)?)))
        .collect();
    if heaters.is_empty() {
        return check(WHAT, true, "none was ever on".to_owned());
    }
    let on = heaters.iter().filter(|(_, power)| *power > OFF_SHARE);
    let on: Vec<String> = on.map(|(name, power)| format!("{name} at {:.0} %", 100.0 * power)).collect();
    let names: Vec<&str> = heaters.iter().map(|(name, _)| *name).collect();
    check(WHAT, on.is_empty(), if on.is_empty() { names.join(", ") } else { on.join(", ") })
}

/// Greatest share of power at the end that counts as off: telemetry is rounded.
const OFF_SHARE: f64 = 0.01;
/// Telemetry holds a running mean of the power with this time constant
/// (`sim::world::World::heater_mean_duty`).
const MEAN_S: f64 = 1.0;
/// Time at the end over which the last power is averaged, s.
const LAST_S: f64 = 0.5;

/// Returns the mean power over a run's last moments, 0 to 1, without the share of the running mean that
/// stems from the time before.
fn last_power(time_s: &[f64], mean: &[Option<f64>]) -> Option<f64> {
    let mut known = time_s.iter().zip(mean).filter_map(|(time, mean)| Some((*time, (*mean)?)));
    let (end_s, at_end) = known.clone().next_back()?;
    let (begin_s, before) = known.rfind(|(time, _)| *time <= end_s - LAST_S).unwrap_or((end_s - LAST_S, 0.0));
    let remembered = (-(end_s - begin_s) / MEAN_S).exp();
    Some((at_end - before * remembered) / (1.0 - remembered))
}

fn lost_motion(run: &Run) -> Check {
    let lost = run.summary.actuators.iter().filter(|(_, motor)| motor.lost_mm.abs() > 1e-6);
    let lost: Vec<String> = lost.map(|(name, motor)| format!("{name} lost {:.3} mm", motor.lost_mm)).collect();
    check("No carriage ran into its end, no motor stepped without current", lost.is_empty(), listed(&lost, "none"))
}

/// Checks step times. A step may also wait on purpose for its direction to be set up.
fn step_times(evidence: &Evidence<'_>) -> Check {
    const WHAT: &str = "No step edge is later than 250 ns, or than its driver's time to change direction";
    let setup_ns = evidence.machine.clone().map_or(0, |machine| machine.direction_setup_ns);
    match evidence.run.summary.step_error_ns {
        None => skipped(WHAT, "step times were not held against the oracle (VERIFY=1 does)"),
        Some(error) => {
            let passes = error.max <= LATE_NS + f64::from(setup_ns);
            check(WHAT, passes, format!("at most {:.0} ns, rms {:.1} ns", error.max, error.rms))
        }
    }
}

/// Checks that steps.csv, from which the page is drawn, holds the whole run.
fn trace_is_whole(evidence: &Evidence<'_>) -> [Check; 2] {
    let (summary, executed) = (&evidence.run.summary, evidence.executed);
    let edges: u64 = executed.edges.iter().sum();
    let told: u64 = summary.actuators.values().map(|motor| motor.steps).sum();
    let hash = match summary.edge_hash() {
        None => skipped("The trace has the run's edge hash", "the summary has no hash"),
        Some(hash) => {
            check("The trace has the run's edge hash", hash == executed.hash, format!("{:016x}", executed.hash))
        }
    };
    [check("The trace holds every step edge", edges == told, format!("{edges} edges, {told} counted by the run")), hash]
}

#[cfg(test)]
mod tests;

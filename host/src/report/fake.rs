//! A run as a perfect machine would leave it, made from the program itself, for tests of the report.

use super::edges::Executed;
use super::machine::Machine;
use super::program::Program;
use super::run::{ActuatorSummary, HeaterSummary, Run, Summary, Telemetry};
use super::{Report, SAMPLE_S};
use std::fmt::Write;
use units::Actuator;

/// Homes, then prints a square of two layers with a travel between.
pub const PROGRAM: &str = "; Two squares: for tests
M104 S200
G28
G92 E0
G1 X10 Y10 Z0.3 F6000
M83
G1 X30 E1
G1 Y30 E1
G1 X10 E1
G1 Y10 E1
G0 Z0.6
G1 X30 E1
G1 Y30 E1
M104 S0
";

const SPEED_MM_PER_S: f64 = 40.0;

/// An edge: when, which motor, which way.
pub type Edge = (u64, Actuator, i32);

/// The edges of a perfect machine: it homes by 5 mm on each axis from where it was, waits, then follows the
/// program.
pub fn edges(machine: &Machine, program: &Program) -> Vec<Edge> {
    let mut edges = Vec::new();
    let mut now_s = 0.5;
    let homing = [[5.0; 3], [0.0; 3], [0.2; 3], [0.0; 3]];
    for pair in homing.windows(2) {
        now_s = line(machine, &mut edges, now_s, pair[0], pair[1], 0.0) + 0.1;
    }
    now_s += 0.5;
    let total: f64 = program.extruded.values().sum();
    let work: f64 = segments(program).filter(|(_, _, work)| *work).map(|(from, to, _)| length(from, to)).sum();
    for (from, to, works) in segments(program) {
        let fed = if works { total * length(from, to) / work } else { 0.0 };
        now_s = line(machine, &mut edges, now_s, from, to, fed);
    }
    edges.sort_by_key(|edge| edge.0);
    edges
}

fn segments(program: &Program) -> impl Iterator<Item = ([f64; 3], [f64; 3], bool)> {
    program.path().windows(2).map(|pair| (pair[0].at, pair[1].at, pair[1].extrudes))
}

fn length(from: [f64; 3], to: [f64; 3]) -> f64 {
    (0..3).map(|axis| (to[axis] - from[axis]).powi(2)).sum::<f64>().sqrt()
}

/// Edges of one straight move at constant speed; gives the time it ends.
fn line(machine: &Machine, edges: &mut Vec<Edge>, begin_s: f64, from: [f64; 3], to: [f64; 3], fed: f64) -> f64 {
    line_in(machine, edges, [begin_s, length(from, to) / SPEED_MM_PER_S], from, to, fed)
}

/// The same, in a time of its own: when it begins and how long it takes, seconds.
pub fn line_in(
    machine: &Machine,
    edges: &mut Vec<Edge>,
    [begin_s, seconds]: [f64; 2],
    from: [f64; 3],
    to: [f64; 3],
    fed: f64,
) -> f64 {
    let (start, end) = (machine.steps(from), machine.steps(to));
    for motor in [Actuator::Alpha, Actuator::Beta, Actuator::Gamma] {
        pass(edges, motor, begin_s, seconds, start[motor as usize], end[motor as usize]);
    }
    if let (Some(motor), true) = (machine.extruder(0), fed != 0.0) {
        let before: i32 = edges.iter().filter(|edge| edge.1 == motor).map(|edge| edge.2).sum();
        let scale = machine.steps_per_mm[motor as usize].unwrap();
        // Whole steps here; what is left over of a move is under a hundredth of a millimetre.
        pass(edges, motor, begin_s, seconds, f64::from(before), f64::from(before) + (fed * scale).round());
    }
    begin_s + seconds
}

/// Edges where a motor on its straight way passes half steps.
fn pass(edges: &mut Vec<Edge>, motor: Actuator, begin_s: f64, seconds: f64, from: f64, to: f64) {
    let (first, last) = (from.round() as i64, to.round() as i64);
    let way = if last >= first { 1 } else { -1 };
    for step in 0..(last - first).abs() {
        let crossing = first as f64 + way as f64 * (step as f64 + 0.5);
        let share = ((crossing - from) / (to - from)).clamp(0.0, 1.0);
        edges.push((((begin_s + share * seconds) * 1e9) as u64, motor, way));
    }
}

/// Edges as they are read from a run.
pub fn executed(edges: &[Edge]) -> Executed {
    let mut csv = "time_ns,actuator,direction\n".to_owned();
    for (time_ns, motor, direction) in edges {
        writeln!(csv, "{time_ns},{},{direction}", motor.name()).unwrap();
    }
    Executed::parse(csv.as_bytes(), 1_000_000).unwrap()
}

/// The report of these edges.
pub fn report_of(machine: Machine, program: Program, edges: &[Edge]) -> Report {
    let executed = executed(edges);
    let mut summary = Summary { virtual_seconds: executed.end_ns as f64 * 1e-9, lines: 14, ..Summary::default() };
    for motor in Actuator::ALL {
        let steps = executed.edges[motor as usize];
        let row = ActuatorSummary { steps, max_steps_per_s: 3_200.0, ..ActuatorSummary::default() };
        summary.actuators.insert(motor.name().to_owned(), row);
    }
    summary.heaters.insert("hotend".to_owned(), HeaterSummary { final_c: 60.0, max_c: 201.0 });
    summary.edge_hash = format!("{:016x}", executed.hash).into();
    summary.board = Some(Vec::new());
    let telemetry = Telemetry {
        names: ["hotend_c", "hotend_duty", "vmotor_v", "cpu_load"].map(str::to_owned).to_vec(),
        time_s: vec![0.0, 1.0, 2.0],
        columns: vec![
            vec![Some(20.0), Some(200.0), Some(190.0)],
            vec![Some(0.0), Some(0.5), Some(0.5 * (-1.0_f64).exp())],
            vec![Some(24.0); 3],
            vec![Some(0.1); 3],
        ],
    };
    let run = Run { summary, telemetry: Some(telemetry), console: Some("ok\n".to_owned()), power: Vec::new() };
    Report::new(run, executed, Ok(machine), Ok(program), SAMPLE_S, "Two squares".to_owned())
}

/// A perfect run of [`PROGRAM`].
pub fn report() -> Report {
    let machine = Machine::printer();
    let program = Program::parse(PROGRAM.as_bytes(), machine.beginning);
    let edges = edges(&machine, &program);
    report_of(machine, program, &edges)
}

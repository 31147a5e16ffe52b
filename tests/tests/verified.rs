//! Step edges of a board held against the ideal trajectory: what is right passes, and what is wrong is found.

use std::fs;
use std::path::PathBuf;

use sim::output::StepError;
use sim::runner::{InSearches, Job, Mismatch, Plan, plan, run};
use sim::trace::StepEdge;
use units::{Actuator, Direction};

/// Homing with its triggers, lines, an arc, a pause.
const JOB: &str = "M302 S0\nG28\nG92 E0\nG1 X30 Y20 F9000\nG1 X34 Y23 E0.5 F3000\nG3 X40 Y29 I0 J6 E2\nG4 P300\nG1 X20 Y10 Z1 F6000\n";
/// The solver's own distance from the ideal is less, nanoseconds.
const SOLVER_NS: f64 = 30.0;

fn parse(row: &str) -> StepEdge {
    let mut fields = row.split(',');
    let mut next = || fields.next().expect("three fields");
    let time_ns = next().parse().expect("a time");
    let actuator = Actuator::from_name(next()).expect("a motor");
    let direction = if next() == "1" { Direction::Forward } else { Direction::Backward };
    StepEdge { time_ns, actuator, direction }
}

/// The plan of the job on a machine, and the edges that a board would have made of it.
fn job_on(config: &str, name: &str) -> (Plan, Vec<StepEdge>) {
    job_of(JOB, config, name)
}

fn job_of(job: &str, config: &str, name: &str) -> (Plan, Vec<StepEdge>) {
    let lines = job;
    let out = std::env::temp_dir().join(format!("velvet-verified-{name}-{}", std::process::id()));
    fs::create_dir_all(&out).expect("a temporary folder");
    let write = |name: &str, text: &str| -> PathBuf {
        fs::write(out.join(name), text).expect("a file in it");
        out.join(name)
    };
    let job = Job {
        config: write("config.ini", config),
        gcode: write("job.gcode", lines),
        out: out.clone(),
        until_ns: None,
        chip: sim::models::tmc26x::Chip::Tmc2590,
        faults: Vec::new(),
        verify: false,
    };
    let outcome = run(&job, &mut |_| {}).expect("a machine");
    assert!(outcome.succeeded(), "{outcome:?}");
    let edges = fs::read_to_string(out.join("steps.csv")).expect("the run's edges");
    let plan = plan(&job, &[], None, &mut |_| {}).expect("the same machine");
    // A folder left behind harms nobody.
    let _ = fs::remove_dir_all(&out);
    (plan, edges.lines().skip(1).map(parse).collect())
}

#[test]
fn a_levelled_and_skewed_machine_keeps_time() {
    let grid = "\n[cartesian grid leveling strategy]\nx_size = 60\ny_size = 40\ngrid_x_size = 4\ngrid_y_size = 3\n\
                [skew correction]\nxy = 0.01\nyz = -0.02\n[zprobe]\nleveling = cartesian grid\n";
    let levelled =
        format!("G28\nM421 I1 J1 Z0.3\nM421 I2 J1 Z-0.2\nM421 I2 J2 Z0.25\n{JOB}G1 X55 Y35 F9000\nM370\nG1 X0 Y0\n");
    let (plan, edges) = job_of(&levelled, &format!("{}{grid}", scenarios::CARTESIAN), "levelled");
    let right = compare(&plan, &edges).expect("the same motion");
    assert!(right.max_ns < SOLVER_NS, "{right:?}");
    assert!(edges.iter().filter(|edge| edge.actuator == Actuator::Gamma).count() > 500, "Z follows the bed");
}

fn compare(plan: &Plan, edges: &[StepEdge]) -> Result<StepError, Mismatch> {
    plan.compare(edges.iter().copied().map(Ok), InSearches::Count)
}

#[test]
fn a_board_that_begins_later_is_right_and_a_displaced_edge_is_found() {
    let (plan, edges) = job_on(scenarios::CARTESIAN, "cartesian");
    let right = compare(&plan, &edges).expect("the same motion");
    assert!(right.max_ns < SOLVER_NS, "{right:?}");
    // A pause in the program ends sooner or later: where 250 ms pass without an edge.
    let pause = edges.windows(2).position(|pair| pair[1].time_ns - pair[0].time_ns > 250_000_000).expect("G4 P300");
    let mut later = edges.clone();
    later[pause + 1..].iter_mut().for_each(|edge| edge.time_ns += 1_234_567);
    let shifted = compare(&plan, &later).expect("the same motion, later");
    assert!(shifted.max_ns < SOLVER_NS, "{shifted:?}");
    for at in [pause + 1, pause + 700, edges.len() - 2, 17] {
        let mut displaced = edges.clone();
        displaced[at].time_ns += 2_000;
        let found = compare(&plan, &displaced).expect("the same sequence");
        assert!((found.max_ns - 2_000.0).abs() < SOLVER_NS, "edge {at}: {found:?}");
    }
    // Half a motion late is no late beginning.
    let mut stalled = edges.clone();
    stalled[pause + 700..].iter_mut().for_each(|edge| edge.time_ns += 3_000);
    assert!(compare(&plan, &stalled).expect("the same sequence").max_ns > 2_900.0);
}

#[test]
fn another_sequence_of_steps_is_refused_with_its_place() {
    let (plan, edges) = job_on(scenarios::CARTESIAN, "sequence");
    let refused = |edges: &[StepEdge], words: &str| {
        let Mismatch { reason, .. } = compare(&plan, edges).expect_err("another sequence");
        assert!(reason.contains(words), "`{words}` is not in `{reason}`");
    };
    let middle = edges.len() / 2;
    let mut missing = edges.clone();
    missing.remove(middle);
    refused(&missing, "motion");
    refused(&edges[..edges.len() - 1], "end 1 steps before motion");
    let mut backward = edges.clone();
    backward[middle].direction = match backward[middle].direction {
        Direction::Forward => Direction::Backward,
        Direction::Backward => Direction::Forward,
    };
    refused(&backward, "more than a millisecond from where it belongs");
    let mut more = edges.clone();
    let last = *edges.last().expect("edges");
    more.push(StepEdge { time_ns: last.time_ns + 1_000_000, ..last });
    refused(&more, "although all planned motion is done");
}

#[test]
fn filtered_and_curved_motion_is_verified_like_any_other() {
    let shaped = scenarios::CARTESIAN
        .replace("[planner]", "[input shaper]\nshaper_freq_x = 40\nshaper_freq_y = 50\n\n[planner]")
        .replace("hotend.tool_id = 0 ", "hotend.pressure_advance = 0.05\nhotend.tool_id = 0 ");
    assert!(shaped.contains("pressure_advance") && shaped.contains("shaper_freq_y"));
    for (name, config) in [("delta", scenarios::DELTA), ("shaped", &shaped)] {
        let (plan, mut edges) = job_on(config, name);
        let right = compare(&plan, &edges).unwrap_or_else(|wrong| panic!("{name}: {}", wrong.reason));
        assert!(right.max_ns < SOLVER_NS, "{name}: {right:?}");
        let middle = edges.len() / 2;
        edges[middle].time_ns -= 2_000;
        let found = compare(&plan, &edges).expect("the same sequence");
        assert!((found.max_ns - 2_000.0).abs() < SOLVER_NS, "{name}: {found:?}");
    }
}

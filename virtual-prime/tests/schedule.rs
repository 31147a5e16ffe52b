//! The same job gives the same steps: twice on the virtual board, and there as on the native runner.

mod common;

use std::fs;

use common::MS;
use common::velvet::{CONFIG, Plan, SECOND};
use machine::ports::ConsoleId;
use sim::models::tmc26x::Chip;
use sim::runner::{self, Job, Runner, Setup};
use sim::trace::StepEdge;
use units::{Actuator, Direction};

/// A little of everything: homing, heating, lines at several speeds, an arc, extrusion, a stop in between.
const JOB: &str = "M104 S40
G28
G4 P300
G92 E0
G1 X30 Y20 F9000
G1 X34 Y23 E0.5 F3000
G1 X40 Y23.5 E1.1
G1 X40.2 Y23.4
G3 X46.2 Y29.4 I0 J6 E2
G4 P300
G1 X20 Y10 Z1 F6000
M109 S40
G1 X12 Y10.7 E1
M104 S0
";

/// Time after the job within which its last words come, milliseconds.
const PATIENCE_MS: u64 = 60 * SECOND;

/// The job on the virtual board: hash and edges.
fn on_the_board() -> (u64, Vec<StepEdge>) {
    let mut velvet = Plan::new().file("job.g", JOB).start();
    velvet.ask("M23 job.g", SECOND);
    velvet.type_in("M24");
    velvet.hear_until("Done printing file", PATIENCE_MS);
    velvet.world(|world| (world.trace().edge_hash(), world.trace_mut().take()))
}

/// The job on the native runner.
fn on_the_host() -> Vec<StepEdge> {
    let card = std::env::temp_dir().join(format!("velvet-schedule-{}", std::process::id()));
    fs::create_dir_all(&card).expect("a temporary folder");
    fs::write(card.join("config.ini"), CONFIG).expect("a file in it");
    fs::write(card.join("job.g"), JOB).expect("a file in it");
    let mut runner = Runner::new(&Setup::new(&card)).expect("a machine");
    let console = ConsoleId(0);
    runner.run_until(200 * MS);
    runner.command("M23 job.g", SECOND * MS);
    assert!(runner.type_on(console, "M24\n"));
    let mut said = String::new();
    while !said.contains("Done printing file") {
        assert!(runner.now_ns() < PATIENCE_MS * MS, "the job was never done; it said: {said}");
        runner.step();
        said.push_str(&String::from_utf8_lossy(&runner.read_from(console)));
    }
    // A folder left behind harms nobody.
    let _ = fs::remove_dir_all(&card);
    runner.world(|world| world.trace_mut().take())
}

#[test]
fn a_job_run_twice_gives_the_same_edge_hash() {
    let (first, edges) = on_the_board();
    assert!(edges.len() > 10_000, "only {} edges", edges.len());
    assert_eq!(first, on_the_board().0);
}

/// Time since its motion began (nanoseconds), motor, direction.
type Edge = (u64, Actuator, Direction);
type Motion = Vec<Edge>;

/// The step interrupt plays events this close together one after the other; what is later than that it counts as late.
const TOLERANCE_NS: u64 = 250;
/// In homing a move begins when the one before has found its switch. The board stamps that in an interrupt, the runner at
/// the very edge, and a few searches add up.
const HOMING_TOLERANCE_NS: u64 = 2_000;

/// Edges parted where nothing moves for 100 ms: when the next motion begins is the dispatcher's business, what it looks
/// like is not.
fn motions(edges: &[StepEdge]) -> Vec<Motion> {
    let mut motions = Vec::<Motion>::new();
    let (mut began_ns, mut last_ns) = (0, 0);
    for edge in edges {
        if motions.is_empty() || edge.time_ns - last_ns > 100 * MS {
            began_ns = edge.time_ns;
            motions.push(Motion::new());
        }
        last_ns = edge.time_ns;
        motions.last_mut().expect("begun above").push((edge.time_ns - began_ns, edge.actuator, edge.direction));
    }
    motions
}

/// How far a difference is from whole periods of the step feed. Homing is several motions in a row, too close to tell apart
/// here, and each begins when the dispatcher has seen the one before end: a period sooner or later.
fn beside_feed_periods(difference_ns: u64) -> u64 {
    const FEED_PERIOD_NS: u64 = 500_000;
    let beyond = difference_ns % FEED_PERIOD_NS;
    beyond.min(FEED_PERIOD_NS - beyond)
}

/// The board's edges against the oracle, as `make run VERIFY=1` does it: the largest distance in nanoseconds.
fn worst_ns(edges: &[StepEdge]) -> f64 {
    let out = std::env::temp_dir().join(format!("velvet-schedule-oracle-{}", std::process::id()));
    fs::create_dir_all(&out).expect("a temporary folder");
    let job = Job {
        config: out.join("config.ini"),
        gcode: out.join("job.g"),
        out: out.clone(),
        until_ns: None,
        chip: Chip::Tmc2590,
        faults: Vec::new(),
        verify: true,
    };
    fs::write(&job.config, CONFIG).expect("a file in it");
    fs::write(&job.gcode, JOB).expect("a file in it");
    let error = runner::verify(&job, &mut |_| {}, &mut || Ok(edges.iter().copied().map(Ok)));
    // A folder left behind harms nobody.
    let _ = fs::remove_dir_all(&out);
    error.unwrap_or_else(|reason| panic!("{reason}")).max_ns
}

#[test]
fn the_board_steps_as_the_native_runner_and_the_oracle_say() {
    let mut edges = on_the_board().1;
    let worst = worst_ns(&edges);
    assert!(worst < TOLERANCE_NS as f64, "an edge is {worst} ns from where it belongs");
    let (board, host) = (motions(&edges), motions(&on_the_host()));
    let lengths = |motions: &[Motion]| motions.iter().map(Vec::len).collect::<Vec<_>>();
    assert_eq!(lengths(&board), lengths(&host), "edges of each motion");
    for (number, (board, host)) in board.iter().zip(&host).enumerate() {
        // The job begins with homing.
        let homing = number == 0;
        let apart_ns = |b: u64, h: u64| if homing { beside_feed_periods(b.abs_diff(h)) } else { b.abs_diff(h) };
        let tolerance_ns = if homing { HOMING_TOLERANCE_NS } else { TOLERANCE_NS };
        let alike = |(b, h): (&Edge, &Edge)| (b.1, b.2) == (h.1, h.2) && apart_ns(b.0, h.0) <= tolerance_ns;
        let difference = board.iter().zip(host).position(|pair| !alike(pair));
        let shown = difference.map(|at| (at, board[at], host[at]));
        assert_eq!(shown, None, "motion {number}: edge, on the board, on the host");
    }
    // One edge of one motor, two microseconds late, does not escape.
    let middle = edges.len() / 2;
    edges[middle].time_ns += 2_000;
    assert!(worst_ns(&edges) > 2_000.0 - TOLERANCE_NS as f64);
}

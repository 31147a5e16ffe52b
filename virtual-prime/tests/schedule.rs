//! The same job gives the same steps: twice on the virtual board, and there as on the native runner.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::common::MS;
use crate::common::velvet::{CONFIG, Plan, SECOND};
use base::sessions::SessionId;
use sim::models::tmc26x::Chip;
use sim::runner::{self, Job, Runner, Setup};
use sim::trace::StepEdge;
use units::{Actuator, Direction};

/// Job with a little of everything: homing, heating, lines at several speeds, an arc, extrusion, a stop in
/// between.
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

/// Job with lines, arcs, a helix, a spline, rounded corners and short chords in turn, extruding: hard cases
/// of jerk limits and filters.
const CURVES: &str = "G28.3 X30 Y30 Z30
G92 E0
G64 P0.05
G1 X40 Y30 E0.5 F9000
G1 X50 Y38 E1
G2 X56 Y44 I6 J0 E1.6
G1 X60 Y44 E1.8
G5 X70 Y40 I4 J0 P-4 Q2 E2.4
G3 X70 Y40 Z30.4 I-5 J0 E4 P2
G1 X70.3 Y40.1 E4.02
G1 X70.6 Y40.3 E4.04
G1 X70.8 Y40.6 E4.06
G1 X70.9 Y41 E4.08
G1 X71 Y41.5 E4.1
G1 X71 Y60 E5 F12000
G1 E4
G0 X31 Y31
G1 E5
G1 X32 Y60 E6 F6000
";

/// A machine with its job.
struct Case {
    config: String,
    job: String,
}

impl Case {
    fn plain() -> Self {
        Self { config: CONFIG.into(), job: JOB.into() }
    }

    /// Returns a case with a limit of jerk, input shaping and pressure advance.
    fn smooth() -> Self {
        let config = with(&shaped(), &[("planner", "jerk", "100000")]);
        Self { config, job: CURVES.into() }
    }

    /// Returns a case with input shaping and a circle in pieces of a hundredth of a millimetre at 50 mm/s: a
    /// run of the step feed writes for long, while hardly a step is queued. The first line is slow, and the
    /// brake short, so that the plan does not depend on the speed at which lines are read.
    fn fine() -> Self {
        let mut job = String::from("G28.3 X30 Y30 Z30\nM83\nG1 X32 F240\nF3000\n");
        for piece in 1..=400 {
            let turn = TAU * f64::from(piece) / 1_500.0;
            let (x, y) = (30.0 + 2.0 * turn.cos(), 30.0 + 2.0 * turn.sin());
            writeln!(job, "G1 X{x:.4} Y{y:.4} E0.001").expect("a string takes it");
        }
        let settings = [
            ("planner", "planner_queue_size", "64"),
            ("motion control", "default_acceleration", "10000"),
            ("actuator", "alpha.acceleration", "10000"),
            ("actuator", "beta.acceleration", "10000"),
            ("actuator", "delta.acceleration", "10000"),
        ];
        let config = with(&shaped(), &settings);
        Self { config, job }
    }
}

/// Returns a configuration with settings changed.
fn with(config: &str, settings: &[(&str, &str, &str)]) -> String {
    settings.iter().fold(config.to_owned(), |text, (section, key, value)| {
        config::edit::apply(&text, config::edit::Edit { section, key, value: Some(value) })
    })
}

/// Returns a configuration with input shaping and pressure advance.
fn shaped() -> String {
    let settings = [
        ("input shaper", "shaper_type_x", "mzv"),
        ("input shaper", "shaper_freq_x", "50"),
        ("input shaper", "shaper_type_y", "ei"),
        ("input shaper", "shaper_freq_y", "40"),
        ("extruder", "hotend.pressure_advance", "0.04"),
    ];
    with(CONFIG, &settings)
}

/// Time after the job within which its last words come, milliseconds.
const PATIENCE_MS: u64 = 60 * SECOND;

/// Sum of a run: hash of its edges, instructions, virtual time.
type Sum = (u64, u64, u64);

/// Runs the job on the virtual board. Returns its sum and edges.
fn on_the_board(case: &Case) -> (Sum, Vec<StepEdge>) {
    let mut velvet = Plan::new().config(&case.config).file("job.g", &case.job).start();
    velvet.ask("M23 job.g", SECOND);
    velvet.type_in("M24");
    velvet.hear_until("Done printing file", PATIENCE_MS);
    let (instructions, now_ns) = (velvet.bench.vm.instructions(), velvet.bench.vm.now_ns());
    let (hash, edges) = velvet.world(|world| (world.trace().edge_hash(), world.trace_mut().take()));
    ((hash, instructions, now_ns), edges)
}

/// Returns a folder of the call's own.
fn folder(what: &str) -> std::path::PathBuf {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("velvet-schedule-{what}-{}-{number}", std::process::id()));
    fs::create_dir_all(&folder).expect("a temporary folder");
    folder
}

/// Runs the job on the native runner.
fn on_the_host(case: &Case) -> Vec<StepEdge> {
    let card = folder("host");
    fs::write(card.join("config.ini"), &case.config).expect("a file in it");
    fs::write(card.join("job.g"), &case.job).expect("a file in it");
    let mut runner = Runner::new(&Setup::new(&card)).expect("a machine");
    let console = SessionId(0);
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

/// Two boards agree to the instruction: the second board takes its translations over from the first, which
/// made them itself when this test runs alone.
#[test]
fn a_job_run_twice_gives_the_same_edge_hash() {
    let (first, edges) = on_the_board(&Case::plain());
    assert!(edges.len() > 10_000, "only {} edges", edges.len());
    assert_eq!(first, on_the_board(&Case::plain()).0);
}

/// Edge of a motion: time since its start (nanoseconds), motor, direction.
type Edge = (u64, Actuator, Direction);
pub type Motion = Vec<Edge>;

/// Tolerance of edges, ns. The step interrupt plays events this close together one after the other; later
/// events it counts as late.
const TOLERANCE_NS: u64 = 250;

/// Splits edges where nothing moves for 100 ms: the start of the next motion is the executor's business,
/// its shape is not.
pub fn motions(edges: &[StepEdge]) -> Vec<Motion> {
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

/// Compares the board's edges with the oracle, as `make run VERIFY=1` does it. Returns the largest distance
/// in nanoseconds.
fn worst_ns(case: &Case, edges: &[StepEdge]) -> f64 {
    let out = folder("oracle");
    let job = Job {
        config: out.join("config.ini"),
        gcode: out.join("job.g"),
        out: out.clone(),
        until_ns: None,
        chip: Chip::Tmc2590,
        faults: Vec::new(),
        verify: true,
    };
    fs::write(&job.config, &case.config).expect("a file in it");
    fs::write(&job.gcode, &case.job).expect("a file in it");
    let error = runner::verify(&job, &mut |_| {}, &mut || Ok(edges.iter().copied().map(Ok)));
    // A folder left behind harms nobody.
    let _ = fs::remove_dir_all(&out);
    error.unwrap_or_else(|reason| panic!("{reason}")).max_ns
}

#[test]
fn the_board_steps_as_the_native_runner_and_the_oracle_say() {
    let case = Case::plain();
    let mut edges = on_the_board(&case).1;
    assert_alike(&case, &edges, true);
    // Even a single edge of a motor, two microseconds late, is found.
    let middle = edges.len() / 2;
    edges[middle].time_ns += 2_000;
    assert!(worst_ns(&case, &edges) > 2_000.0 - TOLERANCE_NS as f64);
}

#[test]
fn with_jerk_shapers_and_pressure_advance_it_does_so_too() {
    let case = Case::smooth();
    let edges = on_the_board(&case).1;
    assert!(edges.len() > 10_000, "only {} edges", edges.len());
    assert_alike(&case, &edges, false);
}

#[test]
fn with_pieces_shorter_than_a_step_it_is_as_exact() {
    let case = Case::fine();
    let worst = worst_ns(&case, &on_the_board(&case).1);
    assert!(worst < TOLERANCE_NS as f64, "an edge is {worst} ns from where it belongs");
}

/// Address of CMDR of SDMMC1 (RM0399 section 58.10), and the command that writes a block.
const COMMAND: u64 = 0x5200_700C;
const WRITE_BLOCK: u64 = 24;

/// Entries of the journal hold up the executor, and no step: the same edges, to the nanoseconds of an
/// interrupt's delay.
#[test]
fn a_journal_moves_no_step() {
    let made = |with_journal: bool| {
        let plan = Plan::new().file("job.g", CURVES).set("[player] power_loss_period = 1");
        let plan = if with_journal { plan.set("[player] power_loss = true") } else { plan };
        let mut velvet = plan.keeping_writes().watching(COMMAND..COMMAND + 4).start();
        velvet.bench.writes.take();
        velvet.type_in("play /sd/job.g -t");
        velvet.hear_until("Done printing file", PATIENCE_MS);
        // A hold lasts from the first command that writes a block to the last before a pause.
        let (mut held_ns, mut since) = (0, None);
        for pair in velvet.bench.writes.take().windows(2) {
            if pair[0].value & 0x3F == WRITE_BLOCK {
                since = Some(pair[0].at_ns);
            }
            if let Some(began_ns) = since.filter(|_| pair[1].at_ns - pair[0].at_ns > 2 * MS) {
                held_ns = held_ns.max(pair[0].at_ns - began_ns);
                since = None;
            }
        }
        println!("with a journal: {with_journal}; the card was waited for up to {} us at a write", held_ns / 1_000);
        let entries = velvet.block_writes().iter().filter(|write| write.bytes.starts_with(b"VPLJ")).count();
        (entries, velvet.world(|world| world.trace_mut().take()))
    };
    let ((none, without), (entries, with)) = (made(false), made(true));
    assert!(none == 0 && entries > 5, "{none} and {entries} blocks");
    let (without, with) = (motions(&without), motions(&with));
    assert_eq!(without.len(), with.len());
    let mut worst = 0;
    for (without, with) in without.iter().zip(&with) {
        assert_eq!(without.len(), with.len());
        for (without, with) in without.iter().zip(with) {
            assert_eq!((without.1, without.2), (with.1, with.2));
            worst = worst.max(without.0.abs_diff(with.0));
        }
    }
    println!("{entries} blocks of the journal; the farthest edge is {worst} ns away");
    assert!(worst <= TOLERANCE_NS, "{worst} ns");
}

/// Asserts that the board's edges are where the oracle wants them, and the host's edges.
fn assert_alike(case: &Case, edges: &[StepEdge], begins_with_homing: bool) {
    let worst = worst_ns(case, edges);
    assert!(worst < TOLERANCE_NS as f64, "an edge is {worst} ns from where it belongs");
    let (board, host) = (motions(edges), motions(&on_the_host(case)));
    let lengths = |motions: &[Motion]| motions.iter().map(Vec::len).collect::<Vec<_>>();
    assert_eq!(lengths(&board), lengths(&host), "edges of each motion");
    for (number, (board, host)) in board.iter().zip(&host).enumerate() {
        let homing = begins_with_homing && number == 0;
        // In homing a brake begins a slice of trajectory sooner or later, as the switch fires before or after
        // a run of the step feed, and each move begins at such a run: their times are for the oracle to
        // judge, which knows both plans.
        let alike = |(b, h): (&Edge, &Edge)| (b.1, b.2) == (h.1, h.2) && (homing || b.0.abs_diff(h.0) <= TOLERANCE_NS);
        let difference = board.iter().zip(host).position(|pair| !alike(pair));
        let shown = difference.map(|at| (at, board[at], host[at]));
        assert_eq!(shown, None, "motion {number}: edge, on the board, on the host");
    }
}

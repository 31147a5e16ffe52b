//! A halt at each step of each sequence that the machine makes of its own: homing, probing, leveling,
//! alignment, changes of filament and tools, going on with a job, tests of axes.
//!
//! A first run finds the steps of a sequence: a step is whenever a motor starts, stops or turns round, or a
//! heater is switched on or off. For each step the sequence is begun anew and halted there: heaters off,
//! motors without current, halted and nothing else; and after M999 the machine homes and moves as ever, and
//! nothing of the sequence comes back.

use scenarios::{Bench, CARTESIAN, DELTA, Plan};
use sim::models::surface::{Bed, Surface};
use units::Actuator;

/// Sampling interval for a sequence, s.
const SLICE_S: f64 = 0.01;
/// Time within which changes count as one step, s.
const SAME_STEP_S: f64 = 0.03;
/// Time without change after which a sequence has ended, s.
const ENDED_S: f64 = 30.0;
/// Longest duration of a sequence, s.
const LONGEST_S: f64 = 600.0;
/// More steps than this are walked through in strides.
const MOST: usize = 24;
const MOTORS: [Actuator; 4] = [Actuator::Alpha, Actuator::Beta, Actuator::Gamma, Actuator::Delta];
/// The sample mill has no extruder: T and M6 are about the spindle's tool.
const MILL: &str = include_str!("../../config/samples/cnc-mill.ini");

/// A sequence of actions to be halted.
struct Sequence {
    name: &'static str,
    plan: fn() -> Plan,
    /// Prepares the machine for the sequence.
    prepare: fn(&mut Bench),
    /// Line that begins the sequence.
    begin: &'static str,
    /// Lines that the machine can carry out afterwards.
    afterwards: &'static [&'static str],
    /// Least number of steps in the sequence.
    least: usize,
}

/// Returns the places of the carriages; 0 where there is no such motor.
fn places(bench: &Bench) -> [f64; 4] {
    MOTORS.map(|motor| bench.world(|world| world.carriage_mm(motor)).unwrap_or(0.0))
}

/// Returns the machine's activity: the direction of each motor, and whether it heats.
fn doing(bench: &Bench, before: &mut [f64; 4]) -> ([i8; 4], bool) {
    let now = places(bench);
    let mut ways = [0; 4];
    for (way, (now, before)) in ways.iter_mut().zip(now.iter().zip(before.iter())) {
        *way = i8::from(now > before) - i8::from(now < before);
    }
    *before = now;
    (ways, bench.heats())
}

fn begun(sequence: &Sequence) -> Bench {
    let mut bench = (sequence.plan)().start();
    assert!(!bench.greeting().contains("ERROR"), "{}", bench.greeting());
    (sequence.prepare)(&mut bench);
    bench.type_in(sequence.begin);
    bench
}

/// Returns the start of each step, seconds after the start of the sequence.
fn steps(sequence: &Sequence) -> Vec<f64> {
    let mut bench = begun(sequence);
    let start = bench.now_s();
    let (mut before, mut said) = (places(&bench), String::new());
    let (mut steps, mut last, mut changed) = (Vec::<f64>::new(), doing(&bench, &mut before), 0.0);
    loop {
        said += &bench.hear(SLICE_S);
        let (time, now) = (bench.now_s() - start, doing(&bench, &mut before));
        assert!(time < LONGEST_S, "{}: it does not end: {said}", sequence.name);
        if now != last && steps.last().is_none_or(|step| time - step > SAME_STEP_S) {
            steps.push(time);
        }
        if now != last || now.0 != [0; 4] {
            changed = time;
        }
        last = now;
        if time - changed > ENDED_S && !said.is_empty() && !said.contains("ALARM") {
            break;
        }
        assert!(!said.contains("ALARM"), "{}: {said}", sequence.name);
    }
    assert!(steps.len() >= sequence.least, "{}: only {} steps: {said}", sequence.name, steps.len());
    steps
}

fn halt_at(sequence: &Sequence, number: usize, time: f64) {
    let what = format!("{}, step {number} at {time:.2} s", sequence.name);
    let mut bench = begun(sequence);
    bench.hear(time);
    bench.type_in("M112\n");
    let said = bench.hear_until("ALARM", 2.0);
    bench.hear(0.01);
    assert!(!bench.heats(), "{what}: it heats: {said}");
    bench.hear(2.0);
    let edges = bench.world(|world| world.trace().total());
    bench.hear(1.0);
    assert_eq!(bench.world(|world| world.trace().total()), edges, "{what}: something still moves");
    for motor in MOTORS {
        assert!(!bench.is_energised(motor), "{what}: {} has current", motor.name());
    }
    assert!(bench.status().starts_with("<Alarm"), "{what}: {}", bench.status());
    bench.say("M999");
    let said = bench.hear(1.0);
    assert!(bench.status().starts_with("<Idle"), "{what}: {said}{}", bench.status());
    assert!(!bench.moves() && !bench.heats(), "{what}: something of it is left");
    for line in sequence.afterwards {
        let answer = bench.say(line);
        assert!(answer.ends_with("ok\n") && !answer.contains("rror"), "{what}: {line}: {answer}");
    }
    let said = bench.hear(1.0);
    assert!(!said.to_ascii_lowercase().contains("suspend") && !said.contains("rror"), "{what}: {said}");
    assert!(bench.status().starts_with("<Idle"), "{what}: {}", bench.status());
}

fn walk(sequence: &Sequence) {
    let steps = steps(sequence);
    let stride = steps.len().div_ceil(MOST);
    println!("{}: {} steps, every {stride}.", sequence.name, steps.len());
    for (number, time) in steps.iter().enumerate().step_by(stride) {
        halt_at(sequence, number, *time);
    }
}

fn probing() -> Plan {
    Plan::new(CARTESIAN)
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[zprobe] slow_feedrate = 5")
        .set("[zprobe] max_travel = 60")
}

/// A bed that leans a little.
fn lay(bench: &Bench) {
    let bed = Some(Bed::tilted(0.4, [0.002, -0.003]));
    bench.lay(Surface { bed, ..Surface::default() });
}

fn over_the_bed(bench: &mut Bench) {
    lay(bench);
    bench.run(&["G28", "G1 X50 Y60 Z8 F6000", "M400"]);
}

fn homed(bench: &mut Bench) {
    bench.run(&["G28", "G1 X30 Y30 Z10 F6000", "M400"]);
}

const CHANGE: &str = "\n[filament change]\nretract = 2\nlift = 5\npark_x = 3\npark_y = 4\nunload_length = 10\n\
                      load_length = 8\npurge_length = 3\n";

/// A job that changes filament in the middle.
fn changing() -> Plan {
    let part = "G28\nM104 S40\nG92 E0\nG1 X20 Y20 F6000\nG1 X40 E2 F1200\nM600\nG1 X60 E4\nM104 S0\n";
    Plan::new(CARTESIAN).adding(CHANGE).file("part.gcode", part)
}

fn suspended(bench: &mut Bench) {
    bench.say("play /sd/part.gcode");
    bench.hear_until("// Print Suspended", 90.0);
}

fn milling() -> Plan {
    Plan::new(MILL)
        .set("[tool change] before_gcode = G53_G0_Y5")
        .set("[tool change] after_gcode = G53_G0_Y2_G4_P0.1")
        .file("part.nc", "G28.3 X0 Y0 Z0\nG21 G90 G94 F600\nG0 X5\nT1 M6\nG0 X9\n")
}

fn tool_asked_for(bench: &mut Bench) {
    bench.say("play part.nc");
    bench.hear_until("put in tool 1", 20.0);
}

const AS_EVER: &[&str] = &["G28", "G1 X5 F3000", "M400"];

#[test]
fn homing() {
    let nothing = |_: &mut Bench| {};
    let plan = || Plan::new(CARTESIAN);
    walk(&Sequence { name: "G28", plan, prepare: nothing, begin: "G28\n", afterwards: AS_EVER, least: 9 });
    let delta = || Plan::new(DELTA);
    let afterwards: &[&str] = &["G28", "M400"];
    walk(&Sequence { name: "G28 of a delta", plan: delta, prepare: nothing, begin: "G28\n", afterwards, least: 3 });
}

#[test]
fn probing_and_leveling() {
    let begin = "G30\n";
    walk(&Sequence { name: "G30", plan: probing, prepare: over_the_bed, begin, afterwards: AS_EVER, least: 2 });
    let begin = "G38.2 Z-12 F300\n";
    walk(&Sequence { name: "G38.2", plan: probing, prepare: over_the_bed, begin, afterwards: AS_EVER, least: 1 });
    let grid = || {
        let size = ["x_size = 100", "y_size = 80", "grid_x_size = 5", "grid_y_size = 5"];
        let plan = probing().set("[zprobe] leveling = cartesian grid");
        size.iter().fold(plan, |plan, line| plan.set(&format!("[cartesian grid leveling strategy] {line}")))
    };
    walk(&Sequence { name: "G32", plan: grid, prepare: over_the_bed, begin: "G32\n", afterwards: AS_EVER, least: 40 });
}

#[test]
fn screws_are_measured() {
    let screws =
        || probing().set("[bed screws] screws = 30,30 170,30 170,170 30,170").set("[bed screws] thread = CW-M4");
    walk(&Sequence { name: "G35", plan: screws, prepare: over_the_bed, begin: "G35\n", afterwards: AS_EVER, least: 6 });
}

#[test]
fn two_motors_of_z_are_aligned() {
    let gantry = || {
        let slave =
            ["steps_per_mm = 400", "max_rate = 900", "acceleration = 200", "microsteps = 16", "slaved_to = gamma"];
        let plan = probing().set("[extruder] hotend.enable = false").set("[z alignment] motors = -20,100 220,100");
        let plan = plan.set("[z alignment] points = 15,100 185,100");
        slave.iter().fold(plan, |plan, line| plan.set(&format!("[actuator] delta.{line}")))
    };
    let askew = |bench: &mut Bench| {
        over_the_bed(bench);
        let (at_ns, stands) = ((bench.now_s() * 1e9) as u64, bench.carriage(Actuator::Delta));
        bench.world(|world| world.place_carriage(at_ns, Actuator::Delta, stands + 1.0));
    };
    walk(&Sequence { name: "G34", plan: gantry, prepare: askew, begin: "G34\n", afterwards: AS_EVER, least: 12 });
}

#[test]
fn changes_of_filament() {
    let begin = "play /sd/part.gcode\n";
    let nothing = |_: &mut Bench| {};
    let name = "a job that comes to M600";
    walk(&Sequence { name, plan: changing, prepare: nothing, begin, afterwards: AS_EVER, least: 14 });
    let begin = "resume\n";
    let name = "going on behind M600";
    walk(&Sequence { name, plan: changing, prepare: suspended, begin, afterwards: AS_EVER, least: 4 });
}

#[test]
fn changes_of_tools() {
    let afterwards: &[&str] = &["G28.3 X0 Y0 Z0", "G1 X2 F600", "M400"];
    let nothing = |_: &mut Bench| {};
    let begin = "play part.nc\n";
    walk(&Sequence { name: "M6", plan: milling, prepare: nothing, begin, afterwards, least: 3 });
    walk(&Sequence { name: "behind M6", plan: milling, prepare: tool_asked_for, begin: "M24\n", afterwards, least: 2 });
}

#[test]
fn tests_of_axes() {
    let plan = || Plan::new(CARTESIAN);
    for begin in ["test endstop x 3\n", "test speed x 60 100 20\n", "test sweep x 20 22\n"] {
        walk(&Sequence { name: begin.trim_end(), plan, prepare: homed, begin, afterwards: AS_EVER, least: 2 });
    }
}

#[test]
fn a_probe_is_fetched_and_brought_back() {
    let docked = || {
        probing()
            .set("[zprobe] deploy_gcode = G53 G0 Z12 G53 G0 X10 Y70 G53 G0 Y90 G53 G0 Y70")
            .set("[zprobe] stow_gcode = G53 G0 Z12 G53 G0 X10 Y90 G53 G0 X40 G53 G0 Y70")
    };
    let afterwards: &[&str] = &["G28", "M402", "G1 X5 F3000", "M400"];
    walk(&Sequence { name: "fetched", plan: docked, prepare: over_the_bed, begin: "G30\n", afterwards, least: 10 });
}

#[test]
fn paper_tests() {
    let plan = || probing().set("[bed screws] screws = 30,30 170,30 100,170").set("[zprobe] probe_offsets = 20,5,0");
    let begun = |bench: &mut Bench| {
        over_the_bed(bench);
        bench.say("BED_SCREWS_ADJUST");
    };
    for (begin, prepare, least) in [
        ("PROBE_CALIBRATE\n", over_the_bed as fn(&mut Bench), 4),
        ("BED_SCREWS_ADJUST\n", over_the_bed, 3),
        ("TESTZ Z=-0.3\n", begun, 2),
        ("ADJUSTED\n", begun, 3),
        ("ABORT\n", begun, 1),
    ] {
        walk(&Sequence { name: begin.trim_end(), plan, prepare, begin, afterwards: AS_EVER, least });
    }
}

#[test]
fn a_delta_is_calibrated() {
    let plan = || {
        let probe =
            ["enable = true", "probe_pin = PB10^", "calibration = delta", "max_travel = 60", "fast_feedrate = 150"];
        let plan = Plan::new(DELTA).set("[delta calibration strategy] radius = 60");
        probe.iter().fold(plan, |plan, line| plan.set(&format!("[zprobe] {line}")))
    };
    let wrong = |bench: &mut Bench| {
        bench.say("G28");
        bench.say("M666 X0.3");
    };
    let afterwards: &[&str] = &["G28", "M400"];
    walk(&Sequence { name: "G32 S6", plan, prepare: wrong, begin: "G32 S6\n", afterwards, least: 40 });
}

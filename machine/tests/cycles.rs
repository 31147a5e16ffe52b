//! Canned cycles and G93 on the machine: the drill goes where it should, in the time that it should, and a
//! block that is refused moves nothing.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Beta, Gamma};

fn homed(plan: Plan) -> Bench {
    let mut bench = plan.start();
    assert_eq!(bench.say("G28"), "ok\n");
    bench.run(&["G90", "G0 X20 Y20 Z20 F6000", "M400"]);
    bench
}

/// Heights at which the tool turns around, to a tenth of a mm, from this line until it stands; and whether it
/// stood there for more than 0.2 s.
fn turns(bench: &mut Bench, line: &str) -> Vec<(f64, bool)> {
    bench.type_in(&format!("{line}\n"));
    let mut heights: Vec<f64> = vec![bench.carriage(Gamma)];
    let mut last_moved = 0;
    while heights.len() - last_moved < 150 {
        bench.hear(0.005);
        let height = bench.carriage(Gamma);
        if (height - heights[heights.len() - 1]).abs() > 1e-6 {
            last_moved = heights.len();
        }
        heights.push(height);
    }
    heights.truncate(last_moved + 1);
    let (mut turns, mut way, mut stood) = (Vec::new(), 0.0_f64, 0);
    for pair in heights.windows(2) {
        let step = pair[1] - pair[0];
        if step.abs() < 1e-6 {
            stood += 1;
            continue;
        }
        if way != 0.0 && step.signum() != way {
            turns.push(((pair[0] * 10.0).round() / 10.0, stood > 40));
        }
        (way, stood) = (step.signum(), 0);
    }
    turns
}

fn edges(bench: &Bench) -> u64 {
    bench.world(|world| world.trace().total())
}

fn assert_near(actual: f64, expected: f64, what: &str) {
    assert!((actual - expected).abs() < 0.0126, "{what}: {actual}, not {expected}");
}

/// The line is refused with these words, nothing moves, and the position is what it was.
fn refused(bench: &mut Bench, line: &str, why: &str) {
    bench.run(&["M400"]);
    let (before, edges_before) = (bench.say("M114.2"), edges(bench));
    assert_eq!(bench.say(line), format!("error:{why}\n"), "{line}");
    bench.hear(0.5);
    assert_eq!(edges(bench), edges_before, "{line} moves");
    assert_eq!(bench.say("M114.2"), before, "{line}");
    assert!(bench.status().contains("<Idle|"), "{line}");
}

#[test]
fn a_drill_pecks_dwells_and_comes_out_again() {
    let mut bench = homed(Plan::new(CARTESIAN));
    let pecked = turns(&mut bench, "G99 G83 X30 Y40 Z2 R10 Q3.5 F300 P0.3");
    assert_eq!(pecked, [(6.5, false), (10.0, false), (3.0, false), (10.0, false), (2.0, true)]);
    assert_near(bench.carriage(Gamma), 10.0, "R");
    let chips = turns(&mut bench, "G98 G73 X50 Z4 R10 Q4");
    assert_eq!(chips, [(6.0, false), (6.3, false), (4.0, false)]);
    // The series began at 20, and goes on without a code.
    assert_near(bench.carriage(Gamma), 20.0, "where it began");
    assert_eq!(turns(&mut bench, "Y60"), [(6.0, false), (6.3, false), (4.0, false)]);
    assert_near(bench.carriage(Alpha), 50.0, "x");
    assert_near(bench.carriage(Beta), 60.0, "y");
}

#[test]
fn holes_in_a_row_are_all_drilled() {
    let mut bench = homed(Plan::new(CARTESIAN));
    assert_eq!(turns(&mut bench, "G91 G81 X10 Z-5 R-12 L4 F3000"), [(3.0, false), (20.0, false)].repeat(4)[..7]);
    assert_near(bench.carriage(Alpha), 60.0, "x");
    assert_eq!(bench.say("M114.2"), "ok MCS: X:60.0000 Y:20.0000 Z:20.0000\n");
}

#[test]
fn a_block_that_leaves_the_travel_anywhere_is_refused_and_nothing_moves() {
    let mut bench = homed(Plan::new(CARTESIAN));
    let out = |axis: &str, target: &str, end: &str| {
        let small = axis.to_ascii_lowercase();
        let which = if end == "0.000" { "min" } else { "max" };
        format!("machine {axis} {target} is out of travel, which ends at {end} ([soft endstop] {small}_{which})")
    };
    refused(&mut bench, "G99 G81 X30 Z-3 R5", &out("Z", "-3.000", "0.000"));
    refused(&mut bench, "G83 X30 Z-3 R5 Q1", &out("Z", "-3.000", "0.000"));
    refused(&mut bench, "G81 X30 Z3 R205", &out("Z", "205.000", "200.000"));
    refused(&mut bench, "G81 X300 Z3 R5", &out("X", "300.000", "220.000"));
    refused(&mut bench, "G91 G81 X100 Z-3 R-5 L3", &out("X", "320.000", "220.000"));
    // A refused cycle must not become the modal one.
    refused(&mut bench, "X1", "G81 needs Z, column 1");
    bench.run(&["G90", "G81 X30 Z3 R5", "M400"]);
    refused(&mut bench, "X40 Z-1", &out("Z", "-1.000", "0.000"));
    assert_eq!(turns(&mut bench, "X40"), [(3.0, false)]);
}

#[test]
fn what_cannot_be_done_is_refused_by_name_and_words_behind_it_drill_nothing() {
    let mut bench = homed(Plan::new(CARTESIAN));
    bench.run(&["G99 G81 X30 Z3 R5", "M400"]);
    refused(&mut bench, "G83 X40 Z3 R5", "G83 needs Q, column 1");
    refused(&mut bench, "G87 X40 Z3 R5", "G87 needs an oriented spindle stop (not there yet), column 1");
    let none = "no motion code is in force: G0, G1, ... must come first, column 1";
    refused(&mut bench, "X50", none);
    bench.run(&["G81 X30 Z3 R5", "M400"]);
    bench.say("M112");
    bench.hear(0.5);
    bench.say("M999");
    refused(&mut bench, "X50", none);
}

#[test]
fn a_file_drills_and_waits_where_a_word_is_missing() {
    let part = "G28\nG90\nG0 X20 Y20 Z20 F6000\nG98 G81 X30 Y30 Z2 R5 F600\nX40\nG83 X50 Z3 R5\nX60\nG80\n";
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", part).start();
    bench.type_in("M32 part.gcode\n");
    let said = bench.hear_until("error:paused", 60.0);
    assert!(said.contains("G83 needs Q, column 1") && said.contains("line 6 of"), "{said}");
    // Lines read before the faulty one are carried out.
    bench.run(&["M400"]);
    assert_near(bench.carriage(Alpha), 40.0, "x");
    assert_near(bench.carriage(Gamma), 20.0, "z");
    // The file's words are not those of a person who ends it.
    bench.say("abort");
    refused(&mut bench, "X70", "no motion code is in force: G0, G1, ... must come first, column 1");
}

#[test]
fn cycles_that_are_switched_off_are_refused() {
    let mut bench = homed(Plan::new(CARTESIAN).set("[drillingcycles] enable = false"));
    refused(&mut bench, "G81 X30 Z3 R5", "canned cycles are switched off: [drillingcycles] enable, column 1");
    refused(&mut bench, "X40", "canned cycles are switched off: [drillingcycles] enable, column 1");
}

/// Returns the time for which the motors turn during these lines, s.
fn lasts(bench: &mut Bench, lines: &[&str]) -> f64 {
    bench.world(|world| world.trace_mut().take());
    bench.run(lines);
    bench.run(&["M400"]);
    let edges = bench.world(|world| world.trace_mut().take());
    let times = || edges.iter().map(|edge| edge.time_ns);
    let (Some(first), Some(last)) = (times().min(), times().max()) else { panic!("nothing moves") };
    (last - first) as f64 * 1e-9
}

#[test]
fn a_move_of_inverse_time_lasts_as_long_as_it_says() {
    let mut bench = homed(Plan::new(CARTESIAN));
    bench.run(&["G93"]);
    for (lines, seconds) in [
        (&["G1 X50 Y60 F30"][..], 2.0),
        (&["G2 X70 Y60 I10 J0 F40"], 1.5),
        (&["G3 X70 Y60 Z22 I-10 J0 P2 F20"], 3.0),
        (&["G2 X70 Y80 R-11 F60"], 1.0),
        (&["G1 Z21 F60"], 1.0),
        (&["G1 X60 F120", "X50 F60", "X30 F20"], 4.5),
    ] {
        let lasted = lasts(&mut bench, lines);
        // Speeding up and slowing down take their time.
        assert!((lasted - seconds).abs() < 0.03, "{lines:?} lasts {lasted} s");
    }
    assert!(bench.say("$G").contains(" G90 G93 "), "{}", bench.say("$G"));
    refused(&mut bench, "G1 X50", "G93: each such line needs F, 60 for a second, above zero, column 1");
    bench.run(&["G94", "G95"]);
    refused(&mut bench, "G1 X50 F0.1", "G95 needs a spindle encoder (not there yet), column 1");
    assert!(bench.say("$G").contains(" G95 "));
}

#[test]
fn arcs_by_the_place_of_their_centre_go_where_they_should() {
    let mut bench = homed(Plan::new(CARTESIAN));
    bench.run(&["G92 X0 Y0", "G90.1", "G2 X20 Y0 I10 J0 F3000", "M400"]);
    assert_near(bench.carriage(Alpha), 40.0, "x");
    bench.run(&["G3 X10 Y-10 I10 J0", "G91.1", "G3 X20 Y0 I0 J10", "M400"]);
    assert_near(bench.carriage(Alpha), 40.0, "x");
    assert_near(bench.carriage(Beta), 20.0, "y");
}

//! A linear delta: homing its towers, drawing with them, correcting them.

use scenarios::{Bench, DELTA, Plan};
use units::Actuator::{Alpha, Beta, Gamma};

/// Returns the height of the carriages above the tool in the middle of the sample.
fn rise() -> f64 {
    (250.0_f64 * 250.0 - 124.0 * 124.0).sqrt()
}

fn assert_tool(bench: &Bench, expected: [f64; 3]) {
    let tool = bench.world(|world| world.tool_mm());
    for (real, wanted) in tool.into_iter().zip(expected) {
        // A step of a carriage is 0.0125 mm, and moves the tool sideways up to twice as far.
        assert!((real - wanted).abs() < 0.03, "the tool is at {tool:?}, not {expected:?}");
    }
}

#[test]
fn homing_finds_every_tower_and_goes_to_the_middle() {
    let mut bench = Plan::new(DELTA).start();
    assert!(bench.greeting().find("ERROR").is_none(), "{}", bench.greeting());
    bench.run(&["G28", "M400"]);
    assert_tool(&bench, [0.0, 0.0, 245.0]);
    for tower in [Alpha, Beta, Gamma] {
        assert!((bench.carriage(tower) - 245.0 - rise()).abs() < 0.02, "{} at {}", tower.name(), bench.carriage(tower));
        assert!(bench.world(|world| world.lost_mm(tower)) < 1e-9);
    }
    assert_eq!(bench.say("G28.6"), "X:1 Y:1 Z:1 \nok\n");
    let status = bench.status();
    assert!(status.contains("MPos:0.0000,0.0000,245.0000"), "{status}");
}

#[test]
fn lines_and_arcs_are_drawn_where_the_program_says() {
    let mut bench = Plan::new(DELTA).start();
    bench.run(&["G28", "G1 Z10 F12000", "G1 X50 Y-30 F6000", "M400"]);
    assert_tool(&bench, [50.0, -30.0, 10.0]);
    bench.run(&["G3 X-50 Y30 I-50 J30", "M400"]);
    assert_tool(&bench, [-50.0, 30.0, 10.0]);
    bench.run(&["G91", "G1 Z2.5 F600", "G90", "G0 X0 Y85", "M400"]);
    assert_tool(&bench, [0.0, 85.0, 12.5]);
    assert_eq!(bench.world(|world| world.timing_faults()), 0);
}

#[test]
fn a_move_out_of_reach_halts_or_is_refused_as_configured() {
    let mut bench = Plan::new(DELTA).start();
    bench.run(&["G28", "G1 Z100 F12000", "M400"]);
    let answer = bench.say("G1 X200");
    assert!(answer.starts_with("Error: illegal move: it leaves the space the machine can reach\n"), "{answer}");
    bench.assert_safe();
    let plan = Plan::new(DELTA).with("[linear delta]\n", "[linear delta]\nhalt_on_error = false\n");
    let mut bench = plan.start();
    bench.run(&["G28", "G1 Z100 F12000", "M400"]);
    assert_eq!(bench.say("G1 X0 Y-200"), "error:illegal move: it leaves the space the machine can reach\n");
    bench.run(&["G1 X10 Y10", "M400"]);
    assert_tool(&bench, [10.0, 10.0, 100.0]);
}

#[test]
fn trims_make_up_for_switches_that_sit_too_low_or_too_high() {
    let plan = Plan::new(DELTA)
        .with("alpha_trim_mm = 0 ", "alpha_trim_mm = 0.8 ")
        .with("beta_trim_mm = 0\n", "beta_trim_mm = -0.5\n");
    let mut bench = plan.start();
    bench.run(&["G28", "M400"]);
    // 5 mm below the place that the switches mean: a tenth lower than without trims.
    assert_tool(&bench, [0.0, 0.0, 244.9]);
    bench.run(&["G1 X40 Y-20 Z20 F6000", "M400"]);
    assert_tool(&bench, [40.0, -20.0, 20.0]);
    assert_eq!(bench.say("M666 X0.25"), "X: 0.2500 Y: -0.5000 Z: 0.0000\nok\n");
}

#[test]
fn m665_changes_the_arms_and_m500_keeps_them() {
    let mut bench = Plan::new(DELTA).start();
    bench.run(&["G28", "M400"]);
    assert!(bench.say("M665 L251.5 R124.25 Z260").starts_with("L: 251.5000 R: 124.2500 Max Z:  260.000 "), "M665");
    let saved = bench.say("M503");
    for line in ["M665 L251.50000 R124.25000 A0.00000", "M666 X0.00000 Y0.00000 Z0.00000", "M665 Z260.00000"] {
        assert!(saved.contains(line), "{line} is missing: {saved}");
    }
    bench.run(&["G28", "M400"]);
    let status = bench.status();
    assert!(status.contains("MPos:0.0000,0.0000,255.0000"), "{status}");
    assert!(bench.say("M665 L10").contains("error:the geometry of the arm_solution fits no machine"), "too short");
}

#[test]
fn a_tower_without_its_switch_fails_homing_and_leaves_a_delta() {
    let mut bench = Plan::new(DELTA).fault("switch-never:maxy@0").start();
    let answer = bench.say("G28");
    assert!(answer.contains("maxy: endstop was not reached within its travel"), "{answer}");
    bench.say("M999");
    // The kinematics are still those of a delta.
    bench.run(&["G92.4 X0 Y0 Z100"]);
    assert!(bench.say("M665 S50").starts_with("L: 250.0000 R: 124.0000"));
    assert_eq!(bench.say("G28.6"), "X:0 Y:0 Z:0 \nok\n");
}

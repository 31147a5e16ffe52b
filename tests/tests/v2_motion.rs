//! Smoothieware v2's behaviour with rates, offsets and motors that programs written for it rely on.

use scenarios::{Bench, CARTESIAN, COREXY, DELTA, Plan};
use units::Actuator::{Alpha, Delta};

fn start() -> Bench {
    Plan::new(CARTESIAN).start()
}

/// Seconds that a line takes, with what it waits for.
fn took(bench: &mut Bench, line: &str) -> f64 {
    let began = bench.now_s();
    bench.run(&[line, "M400"]);
    bench.now_s() - began
}

// --- rates ---

#[test]
fn with_compliant_seek_rate_g0_is_scaled_by_nobody() {
    for (compliant, scaled) in [("true", 1.0), ("false", 2.0)] {
        let setting = format!("[motion control] compliant_seek_rate = {compliant}");
        let mut bench = Plan::new(CARTESIAN).set(&setting).set("[motion control] default_seek_rate = 600").start();
        bench.run(&["G91", "G1 F600"]);
        let (rapid, feed) = (took(&mut bench, "G0 X20"), took(&mut bench, "G1 X-20"));
        bench.run(&["M220 S50"]);
        assert!((took(&mut bench, "G1 X20") / feed - 2.0).abs() < 0.05, "{compliant}");
        assert!((took(&mut bench, "G0 X-20") / rapid - scaled).abs() < 0.05, "{compliant}");
    }
}

#[test]
fn with_compliant_seek_rate_m121_leaves_the_rate_of_g0() {
    let mut bench = Plan::new(CARTESIAN).set("[motion control] compliant_seek_rate = true").start();
    bench.run(&["G1 F1200", "M120", "M203 S20", "G1 F600", "M121"]);
    assert!(bench.say("M203").contains(" S:20.000000 "));
    assert!(bench.say("$G").contains(" F1200.0000 "));
    let mut bench = start();
    bench.run(&["M120", "G0 F1200", "M121"]);
    assert!(bench.say("M203").contains(" S:150.000000 "), "else it comes back");
}

// --- motors off ---

#[test]
fn motors_that_are_off_leave_no_axis_homed_that_they_move() {
    for (config, line, homed) in [
        (CARTESIAN, "M18 X", "X:0 Y:1 Z:1 \nok\n"),
        (COREXY, "M18 X", "X:0 Y:0 Z:1 \nok\n"),
        (COREXY, "M84 Y E", "X:0 Y:0 Z:1 \nok\n"),
        (COREXY, "M18 Z", "X:1 Y:1 Z:0 \nok\n"),
        (DELTA, "M18 Z", "X:0 Y:0 Z:0 \nok\n"),
        (CARTESIAN, "M18 E", "X:1 Y:1 Z:1 \nok\n"),
        (CARTESIAN, "M18", "X:0 Y:0 Z:0 \nok\n"),
        (CARTESIAN, "M84 S60", "X:0 Y:0 Z:0 \nok\n"),
    ] {
        let mut bench = Plan::new(config).start();
        bench.run(&["G28", line]);
        assert_eq!(bench.say("G28.6"), homed, "{line}");
    }
}

#[test]
fn m18_with_a_time_turns_nothing_off() {
    let mut bench = start();
    bench.run(&["G28"]);
    assert_eq!(bench.say("M18 S60"), "ok\n");
    assert_eq!(bench.say("G28.6"), "X:1 Y:1 Z:1 \nok\n");
}

#[test]
fn homing_that_is_halted_leaves_what_it_was_to_home_unhomed() {
    let mut bench = start();
    bench.run(&["G28", "G1 X80 Y50 Z5 F6000", "M400"]);
    bench.type_in("G28 X\n");
    bench.hear(0.8);
    bench.send(b"\x18");
    bench.hear(1.0);
    bench.say("M999");
    assert_eq!(bench.say("G28.6"), "X:0 Y:1 Z:1 \nok\n");
    let place = format!("ok MCS: X:{:.4} Y:50.0000 Z:5.0000\n", bench.carriage(Alpha));
    assert_eq!(bench.say("M114.2").trim_end(), place.trim_end(), "it has braked, so the others are where they read");
}

// --- what lines are cut into ---

#[test]
fn beside_s_the_u_of_m665_does_not_count() {
    let mut bench = start();
    assert_eq!(bench.say("M665 S100 U2"), "Delta segments set to 100.0000 segs/sec\nok\n");
    assert!(bench.say("M503").contains("\nM665 S100.00000 U0.00000\n"));
}

// --- dwells, arcs, saved settings ---

#[test]
fn g4_keeps_fractions_and_waits_until_all_stands_without_a_time_too() {
    let mut bench = start();
    assert!((took(&mut bench, "G4 S1.25") - 1.25).abs() < 0.02);
    assert!((took(&mut bench, "G4 P250.5") - 0.25).abs() < 0.02);
    let begun = bench.carriage(Alpha);
    bench.run(&["G91", "G1 X20 F1200", "G4 P0"]);
    assert!(!bench.moves() && (bench.carriage(Alpha) - begun - 20.0).abs() < 1e-9);
}

#[test]
fn e_of_an_arc_is_fed_along_it() {
    let mut bench = start();
    let (x, e) = (bench.carriage(Alpha), bench.carriage(Delta));
    bench.run(&["G91", "M83", "G2 X20 I10 E5 F1200", "M400"]);
    assert!((bench.carriage(Alpha) - x - 20.0).abs() < 0.02);
    assert!((bench.carriage(Delta) - e - 5.0).abs() < 0.01, "{}", bench.carriage(Delta) - e);
}

#[test]
fn a_saved_p_beside_e_of_m203_limits_no_axis() {
    let line = "M203 E20 P1\n";
    let plan = Plan::new(CARTESIAN).with("config-override = false", "config-override = true");
    let mut bench = plan.file("config-override", line).start();
    let without = took(&mut start(), "G1 X50 F6000");
    assert!((took(&mut bench, "G1 X50 F6000") - without).abs() < 0.01, "P1 is no greatest speed");
}

// Smoothieware v2: the first by name.
#[test]
fn after_a_reset_the_extruder_of_the_lowest_number_is_in_use_without_its_offset() {
    let mut bench = Plan::new(CARTESIAN)
        .set("[extruder] another.enable = true")
        .set("[extruder] another.tool_id = 1")
        .set("[extruder] another.x_offset = 7")
        .set("[actuator] epsilon.driver = external")
        .set("[actuator] epsilon.steps_per_mm = 400")
        .set("[actuator] epsilon.step_pin = PJ5")
        .set("[actuator] epsilon.dir_pin = PJ1")
        .set("[extruder] hotend.x_offset = 4")
        .start();
    let (x, e) = (bench.carriage(Alpha), bench.carriage(Delta));
    bench.run(&["M83", "G1 E3 F600", "G1 X10 F6000", "M400"]);
    assert!((bench.carriage(Delta) - e - 3.0).abs() < 0.01, "the hot end's motor, {}", bench.greeting());
    assert!((bench.carriage(Alpha) - x - 10.0).abs() < 0.02, "no offset before the first T");
    bench.run(&["T0", "G1 X10", "M400"]);
    assert!((bench.carriage(Alpha) - x - 14.0).abs() < 0.02, "{}", bench.carriage(Alpha) - x);
}

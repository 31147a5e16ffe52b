//! Smoothieware v2's behaviour with rates, offsets and motors that programs written for it rely on.

use scenarios::{Bench, CARTESIAN, COREXY, DELTA, Plan};
use units::Actuator::Alpha;

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

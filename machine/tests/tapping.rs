//! Tapping and boring on the machine: G84, G74, G86 and G88 turn the spindle where they should, nothing
//! stands in a hole that is being tapped, and a tool drawn out by hand is where the program goes on from.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Gamma};

/// A spindle that turns both ways, each by an output of its own: M3 on PWM1_1, M4 on PWM1_2, M5 stops both.
fn spindle(plan: Plan) -> Plan {
    let mut plan = plan.set("[pwm1] frequency = 5000");
    for (name, on, pin) in [("right", "M3", "PWM1_1"), ("left", "M4", "PWM1_2")] {
        for setting in [
            "enable = true".into(),
            format!("input_on_command = {on}"),
            "input_off_command = M5".into(),
            format!("output_pin = {pin}"),
            "output_type = hwpwm".into(),
            "startup_value = 0".into(),
        ] {
            plan = plan.set(&format!("[switch] {name}.{setting}"));
        }
    }
    plan
}

fn homed(plan: Plan) -> Bench {
    let mut bench = spindle(plan).start();
    assert_eq!(bench.say("G28"), "ok\n");
    bench.run(&["G90", "G0 X20 Y20 Z20 F6000", "M400"]);
    bench
}

/// Returns the percent that the spindle turns with: positive as M3 turns it, negative as M4 does.
fn turning(bench: &Bench) -> i32 {
    let [right, left] = [0, 1].map(|channel| bench.world(|world| world.pwm_duty(0, channel)));
    assert!(right == 0.0 || left == 0.0, "both ways at once");
    ((right - left) * 100.0).round() as i32
}

/// Watches the tool and the spindle: how the spindle turns, and which way Z goes, each change once.
fn watch(bench: &mut Bench, seconds: f64) -> Vec<(i32, i8)> {
    let (mut seen, mut before) = (Vec::new(), bench.carriage(Gamma));
    for _ in 0..(seconds / 0.005) as usize {
        bench.hear(0.005);
        let now = bench.carriage(Gamma);
        let way = if (now - before).abs() < 1e-6 { 0 } else { (now - before).signum() as i8 };
        before = now;
        if seen.last() != Some(&(turning(bench), way)) {
            seen.push((turning(bench), way));
        }
    }
    seen
}

#[test]
fn a_tap_goes_out_as_the_spindle_turns_the_other_way() {
    let mut bench = homed(Plan::new(CARTESIAN));
    bench.run(&["M3 S40", "G0 X30 Z8", "M400"]);
    bench.type_in("G99 G84 Z2 R8 F300 P0.5\n");
    let seen = watch(&mut bench, 6.0);
    // Down, turned over, standing for the dwell, out, turned over again.
    let steady: Vec<(i32, i8)> = seen.into_iter().filter(|(_, way)| *way != 0).collect();
    assert_eq!(steady, [(40, -1), (-40, 1)]);
    assert_eq!(turning(&bench), 40);
    assert!((bench.carriage(Gamma) - 8.0).abs() < 0.02);
    // M4 alone would not stop what M3 has started.
    bench.run(&["M5", "M4 S30"]);
    bench.type_in("G74 Z2 R8\n");
    let steady: Vec<(i32, i8)> = watch(&mut bench, 6.0).into_iter().filter(|(_, way)| *way != 0).collect();
    assert_eq!(steady, [(-30, -1), (30, 1)]);
    assert_eq!(turning(&bench), -30);
}

/// Returns the seconds from typing a line until Z is back at its present place.
fn hole(bench: &mut Bench, line: &str) -> f64 {
    let (begun, top) = (bench.now_s(), bench.carriage(Gamma));
    bench.type_in(&format!("{line}\n"));
    bench.hear(0.3);
    while bench.carriage(Gamma) < top - 1e-6 {
        bench.hear(0.01);
        assert!(bench.now_s() - begun < 60.0, "it does not come back");
    }
    let seconds = bench.now_s() - begun;
    bench.hear(0.5);
    seconds
}

#[test]
fn overrides_do_not_count_while_a_thread_is_cut() {
    let mut bench = homed(Plan::new(CARTESIAN));
    bench.run(&["M3 S40", "G0 Z8", "M400"]);
    let plain = hole(&mut bench, "G99 G84 Z2 R8 F300");
    bench.run(&["M220 S50"]);
    let same = hole(&mut bench, "G84 Z2 R8");
    assert!((same - plain).abs() < 0.05 * plain, "{same} s, not {plain}");
    let slow = hole(&mut bench, "G85 Z2 R8");
    assert!(slow > 1.7 * plain, "{slow} s at half speed, {plain} s at full");
    // Overrides that the operator sets meanwhile count afterwards.
    bench.type_in("G84 Z2 R8\n");
    bench.hear(0.5);
    bench.type_in("M220 S100\n");
    bench.hear(3.0);
    let full = hole(&mut bench, "G85 Z2 R8");
    assert!((full - plain).abs() < 0.1 * plain, "{full} s, not {plain}");
}

#[test]
fn a_hold_waits_until_the_tap_is_out_of_the_hole() {
    let mut bench = homed(Plan::new(CARTESIAN));
    bench.run(&["M3 S40", "G0 X20 Z8", "M400"]);
    bench.type_in("G91 G99 G84 X10 Z-6 R0 F300 L2\n");
    bench.hear(0.8);
    bench.send(b"!");
    let heard = bench.hear(0.1);
    assert!(heard.contains("the hold waits until the tap is out of the hole"), "{heard}");
    assert!(!bench.status().contains("<Hold"), "it holds in the hole");
    bench.hear(5.0);
    assert!(bench.status().contains("<Hold"), "{}", bench.status());
    assert!((bench.carriage(Alpha) - 30.0).abs() < 0.02 && (bench.carriage(Gamma) - 8.0).abs() < 0.02);
    assert_eq!(turning(&bench), 40);
    bench.send(b"~");
    bench.hear(6.0);
    assert!((bench.carriage(Alpha) - 40.0).abs() < 0.02 && (bench.carriage(Gamma) - 8.0).abs() < 0.02);
    // A hold that is taken back holds nothing.
    bench.type_in("X10\n");
    bench.hear(0.8);
    bench.send(b"!");
    bench.hear(0.1);
    bench.send(b"~");
    bench.hear(6.0);
    assert!(bench.status().contains("<Idle"), "{}", bench.status());
    assert!((bench.carriage(Alpha) - 50.0).abs() < 0.02);
    // A halt does not wait, and behind it holds act at once.
    bench.type_in("X10\n");
    bench.hear(0.8);
    bench.say("M112");
    bench.hear(0.1);
    assert_eq!(turning(&bench), 0);
    bench.say("M999");
    bench.type_in("G1 X5 F100\n");
    bench.hear(0.5);
    bench.send(b"!");
    bench.hear(0.2);
    assert!(bench.status().contains("<Hold"), "{}", bench.status());
}

#[test]
fn a_bore_is_left_with_the_spindle_standing() {
    let mut bench = homed(Plan::new(CARTESIAN));
    bench.run(&["M3 S40", "G0 Z8", "M400"]);
    bench.type_in("G99 G86 Z2 R8 F300 P0.5\n");
    let steady: Vec<(i32, i8)> = watch(&mut bench, 4.0).into_iter().filter(|(_, way)| *way != 0).collect();
    assert_eq!(steady, [(40, -1), (0, 1)]);
    assert_eq!(turning(&bench), 40);
}

#[test]
fn a_job_that_is_held_behind_a_tap_can_be_aborted_there() {
    let part = "G28\nG90\nG0 X20 Y20 Z8 F6000\nM3 S40\nG99 G84 X30 Z2 R8 F300\nX40\nX50\nG80\n";
    let mut bench = spindle(Plan::new(CARTESIAN).file("part.g", part)).start();
    bench.say("play part.g");
    while turning(&bench) != 40 || bench.carriage(Gamma) > 6.0 {
        bench.hear(0.05);
        assert!(bench.now_s() < 60.0, "it does not tap");
    }
    bench.send(b"!");
    bench.hear(5.0);
    assert!(bench.status().contains("<Hold"), "{}", bench.status());
    assert!((bench.carriage(Gamma) - 8.0).abs() < 0.02);
    let x = bench.carriage(Alpha);
    bench.type_in("abort\n");
    let heard = bench.hear(1.0);
    assert!(heard.contains("Please wait for abort to complete"), "{heard}");
    bench.send(b"~");
    bench.hear(5.0);
    assert!((bench.carriage(Alpha) - x).abs() < 0.02, "{} and then {}", x, bench.carriage(Alpha));
    assert!(bench.status().contains("<Idle"), "{}", bench.status());
    bench.run(&["G0 X5", "M400"]);
}

/// A file that bores two holes by hand, and drills one without a code.
fn by_hand() -> Bench {
    let part = "G28\nG90\nG0 X20 Y20 Z20 F6000\nM3 S40\nG99 G88 X30 Z2 R8 F300 P0.2\nX40\nG80\nG0 X60\n";
    let mut bench = spindle(Plan::new(CARTESIAN).file("part.g", part)).start();
    bench.say("play part.g -t");
    let heard = bench.hear_until("draw the tool out by hand (G88): ~ or M24 goes on", 60.0);
    assert!(!heard.contains("Done"), "{heard}");
    bench.hear(0.5);
    assert!((bench.carriage(Alpha) - 30.0).abs() < 0.02 && (bench.carriage(Gamma) - 2.0).abs() < 0.02);
    assert_eq!(turning(&bench), 0);
    bench
}

#[test]
fn the_operator_draws_the_tool_out() {
    let mut bench = by_hand();
    // Higher than the program would, and to the side.
    bench.run(&["G91", "G1 Z10 F600", "G1 Y1", "G90", "M400"]);
    bench.send(b"~");
    bench.hear_until("draw the tool out by hand", 20.0);
    bench.hear(0.5);
    assert!((bench.carriage(Alpha) - 40.0).abs() < 0.02 && (bench.carriage(Gamma) - 2.0).abs() < 0.02);
    // The operator leaves the way back to the machine: straight up, and on.
    bench.send(b"~");
    let (mut off_the_hole, mut heard) = (false, String::new());
    for _ in 0..800 {
        heard += &bench.hear(0.01);
        off_the_hole |= bench.carriage(Gamma) < 7.9 && (bench.carriage(Alpha) - 40.0).abs() > 0.02;
    }
    assert!(!off_the_hole, "it leaves the hole sideways");
    assert!(heard.contains("Done printing file"), "{heard}");
    // G80 leaves the series to where it began, as Smoothieware does.
    assert!((bench.carriage(Alpha) - 60.0).abs() < 0.02 && (bench.carriage(Gamma) - 20.0).abs() < 0.02);
    assert_eq!(turning(&bench), 40);
}

#[test]
fn a_console_waits_for_the_operator_too() {
    let mut bench = homed(Plan::new(CARTESIAN));
    bench.run(&["M3 S40", "G0 Z8", "M400"]);
    bench.type_in("G99 G88 Z2 R8 F300 P0.2\n");
    let heard = bench.hear_until("draw the tool out by hand (G88): ~ goes on", 20.0);
    assert!(!heard.contains("ok\n"), "{heard}");
    bench.send(b"~");
    bench.hear_until("ok\n", 20.0);
    bench.run(&["M400"]);
    bench.hear(0.1);
    assert!((bench.carriage(Gamma) - 8.0).abs() < 0.02);
    assert_eq!(turning(&bench), 40);
}

#[test]
fn a_job_does_not_go_on_behind_other_holes_or_an_abort() {
    let mut bench = by_hand();
    bench.run(&["G0 Z20", "G81 X100 Z15 R18 F600", "M400"]);
    bench.send(b"~");
    let heard = bench.hear(3.0);
    assert!(heard.contains("other holes were drilled while this one waited (G88)"), "{heard}");
    assert!((bench.carriage(Alpha) - 100.0).abs() < 0.02);
    let mut bench = by_hand();
    bench.say("abort");
    bench.send(b"~");
    bench.hear(3.0);
    assert!((bench.carriage(Alpha) - 30.0).abs() < 0.02 && (bench.carriage(Gamma) - 2.0).abs() < 0.02);
    bench.run(&["G0 Z20", "M400"]);
}

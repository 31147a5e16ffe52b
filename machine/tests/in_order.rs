//! Codes that change how moves are made (M220, M204, M205, M900...) act at their place in the file: on the
//! moves after them, never on those that are planned already.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Delta};

const DIALECTS: [&str; 4] = ["", ";FLAVOR:Marlin\n", "; gcode_flavor = klipper\n", "; gcode_flavor = reprapfirmware\n"];

/// Returns the time that a file takes, s.
fn seconds_of(bench: &mut Bench, name: &str) -> f64 {
    let begun_s = bench.now_s();
    bench.type_in(&format!("play {name} -t\n"));
    let said = bench.hear_until("Done printing file", 60.0);
    assert!(!said.contains("error"), "{said}");
    bench.now_s() - begun_s
}

#[test]
fn m220_in_a_file_scales_what_follows_it() {
    for flavour in DIALECTS {
        // 40 mm at 20, at 40 and at 20 mm/s.
        let file = format!("{flavour}G1 X40 F1200\nM220 B\nM220 S200\nG1 X80\nM220 R\nG1 X120\nM400\n");
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
        let said = bench.say("check part.gcode");
        assert!(said.contains("time: 00:00:05"), "{said}");
        let took_s = seconds_of(&mut bench, "part.gcode");
        assert!((5.0..5.8).contains(&took_s), "{flavour}: {took_s}");
        assert!(bench.say("M220").contains("100.00 %"));
    }
}

#[test]
fn m220_typed_beside_a_file_acts_at_once_and_the_file_does_not_lose_it() {
    let file = "G1 X150 F600\nM220 B\nM220 S200\nG1 X100\nM220 R\nG1 X0\n";
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", file).start();
    let begun_s = bench.now_s();
    bench.type_in("play part.gcode -t\n");
    bench.hear(1.0);
    bench.type_in("M220 S500\n");
    bench.hear_until("Done printing file", 60.0);
    // 10 mm at 10 mm/s, then five times as fast: 140 mm at 50, 50 at 100, 100 at 50.
    let took_s = bench.now_s() - begun_s;
    assert!((6.0..7.2).contains(&took_s), "{took_s}");
}

#[test]
fn m220_that_a_host_sends_between_moves_leaves_those_before_it() {
    let mut bench = Plan::new(CARTESIAN).start();
    let begun_s = bench.now_s();
    for line in ["G1 X40 F1200", "M220 S200", "G1 X80", "M400"] {
        bench.type_in(&format!("{line}\n"));
    }
    bench.hear_until("ok\nok\nok\nok\n", 60.0);
    let took_s = bench.now_s() - begun_s;
    assert!((3.0..3.8).contains(&took_s), "{took_s}");
    assert!(bench.say("M220").contains("200.00 %"));
}

#[test]
fn limits_in_a_file_hold_for_what_follows_them() {
    // The first 20 mm are made without the limit that comes behind them, the others within it.
    for limit in ["M203 X10", "M204 S20", "M201 X20"] {
        let file = format!("G1 X60 F6000\n{limit}\nG1 X80\nM400\n");
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
        let took_s = seconds_of(&mut bench, "part.gcode");
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", &format!("{limit}\nG1 X80 F6000\nM400\n")).start();
        let all_s = seconds_of(&mut bench, "part.gcode");
        assert!(took_s < 0.6 * all_s, "{limit}: {took_s} of {all_s}");
    }
}

/// A way of shallow corners, the n-th from X `from` on, mm each.
fn corners(from: i32, count: i32) -> String {
    (from + 1..=from + count).map(|x| format!("G1 X{x} Y{} F6000\n", if x % 2 == 0 { 0.0 } else { 0.1 })).collect()
}

/// What is said of corners holds for those that are read after it.
#[test]
fn corners_in_a_file_are_taken_as_the_lines_before_them_say() {
    for (flavour, line) in [
        ("", "M205 X0.0001"),
        (";FLAVOR:Marlin\n", "M205 X0.2 Y0.2"),
        (";FLAVOR:Marlin\n", "M205 J0.0001"),
        ("; gcode_flavor = klipper\n", "SET_VELOCITY_LIMIT SQUARE_CORNER_VELOCITY=0.2"),
        ("; gcode_flavor = reprapfirmware\n", "M566 X12 Y12"),
    ] {
        let seconds = |file: String| {
            let mut bench = Plan::new(CARTESIAN).file("part.gcode", &format!("{flavour}{file}M400\n")).start();
            seconds_of(&mut bench, "part.gcode")
        };
        let all = corners(0, 80);
        let (none_s, all_s) = (seconds(all.clone()), seconds(format!("{line}\n{all}")));
        let some_s = seconds(format!("{}{line}\n{}", corners(0, 60), corners(60, 20)));
        // A quarter of the corners is slow.
        let share = (some_s - none_s) / (all_s - none_s);
        assert!(all_s > 1.5 * none_s && (0.15..0.35).contains(&share), "{line}: {none_s} {some_s} {all_s}");
    }
}

/// Pressure advance pushes E ahead by K times its speed, from its line on.
#[test]
fn pressure_advance_in_a_file_begins_at_its_place() {
    for (flavour, line) in [
        ("", "M900 K0.2"),
        ("", "M572 S0.2"),
        (";FLAVOR:Marlin\n", "M900 K0.2"),
        ("; gcode_flavor = reprapfirmware\n", "M572 D0 S0.2"),
        ("; gcode_flavor = klipper\n", "SET_PRESSURE_ADVANCE ADVANCE=0.2"),
    ] {
        let file = format!("{flavour}M83\nG1 X60 E6 F1200\n{line}\nG1 X120 E6\nM400\n");
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
        let before = [Alpha, Delta].map(|motor| bench.carriage(motor));
        let ahead = |bench: &Bench| (bench.carriage(Delta) - before[1]) - 0.1 * (bench.carriage(Alpha) - before[0]);
        bench.type_in("play part.gcode -t\n");
        let mut found = Vec::new();
        for middle in [30.0, 90.0] {
            while bench.carriage(Alpha) - before[0] < middle {
                bench.hear(0.01);
            }
            found.push(ahead(&bench));
        }
        // 0.2 s at 2 mm/s.
        assert!(found[0].abs() < 0.02 && (found[1] - 0.4).abs() < 0.02, "{line}: {found:?}");
        bench.hear_until("Done printing file", 60.0);
    }
}

#[test]
fn flow_in_a_file_scales_what_follows_it() {
    for flavour in DIALECTS {
        let file = format!("{flavour}M83\nG1 X20 E2 F1200\nM221 S50\nG1 X40 E2\nM221 S100\nG1 X60 E2\nM400\n");
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
        let before = [Alpha, Delta].map(|motor| bench.carriage(motor));
        bench.type_in("play part.gcode -t\n");
        for (x, e) in [(20.0, 2.0), (40.0, 3.0), (60.0, 5.0)] {
            while bench.carriage(Alpha) - before[0] < x - 0.1 {
                bench.hear(0.005);
            }
            let fed = bench.carriage(Delta) - before[1];
            assert!((fed - e).abs() < 0.05, "{flavour}: {fed} at X{x}");
        }
        bench.hear_until("Done printing file", 60.0);
    }
}

//! The consoles: every reply is a fact that senders depend on.

use scenarios::{CARTESIAN, Plan};
use units::Actuator::Alpha;

/// Lines and their whole answers, on a machine fresh from boot.
const TRANSCRIPT: &[(&str, &str)] = &[
    ("", "ok\n"),
    ("; a comment", "ok\n"),
    ("G90", "ok\n"),
    ("G1 X5 Y6 F600", "ok\n"),
    ("M400", "ok\n"),
    ("M114", "ok C: X:5.0000 Y:6.0000 Z:0.0000 E:0.0000 \n"),
    ("M114.4", "ok MP: X:5.0000 Y:6.0000 Z:0.0000\n"),
    ("$G", "[GC:G1 G54 G17 G21 G90 G94 G61 M0 M5 M9 T0 F600.0000 S0.0000]\nok\n"),
    ("G6", "ok - G6 ignored\n"),
    ("M9999", "ok - M9999 ignored\n"),
    ("M104.3 S20", "ok - M104.3 ignored\n"),
    ("G1 X1 Y", "// WARNING gcode parse failed Illegal parameter word: Y needs a number, column 7 - G1 X1 Y\nok\n"),
    ("G1 &", "// WARNING gcode parse failed Illegal word: '&' where a letter should be, column 4 - G1 &\nok\n"),
    ("N1 G4 P1*255", "rs N1\n"),
    ("N1 G4 P1*sum", "ok\n"),
    ("N7 G4 P1*sum", "rs N2\n"),
    ("N2 G4 P1*sum", "ok\n"),
    ("N9 M110*sum", "ok\n"),
    ("N10 G4 P1*sum", "ok\n"),
    ("M119", "X_min:0 Y_min:0 Z_min:0 pins- (X:H)PB14:0 ok\n"),
    ("M220", "Speed factor at 100.00 %\nok\n"),
    ("M220 S50", "ok\n"),
    ("M220", "Speed factor at  50.00 %\nok\n"),
    ("M221", "Flow rate at 100.00 %\nok\n"),
    ("M200", "Volumetric extrusion is disabled\nok\n"),
    ("M906", "alpha: 1.20000 Amps\nok\n"),
    ("G28.6", "X:0 Y:0 Z:0 \nok\n"),
    ("nonsense", "error:Unsupported command - nonsense\n"),
    ("$nonsense", "error:Invalid statement\n"),
    ("switch fan", "switch fan is 0\nok\n"),
    ("switch fan on", "switch fan set to: on\nok\n"),
    ("switch fan", "switch fan is 1\nok\n"),
    ("switch pump", "no such switch: pump\nok\n"),
    ("echo hello", "hello\nok\n"),
    ("progress", "Not currently playing\nok\n"),
    ("M23 none.g", "file.open failed: none.g\nok\n"),
    ("$J Q1", "error:bad axis Q1\n"),
    ("$J -r X1 F600", "ok\n"),
    ("T3", "error:no extruder has tool_id 3; there are P0 hotend\n"),
    ("G1 X1 E1 A1", "error:axis A is an extruder: use E, column 10\n"),
];

/// Answers whose text depends on pins of the sample or on chip steps: only their form is compared.
const BY_FORM: [&str; 2] = ["M119", "M906"];

/// Puts the right checksum in place of `*sum`.
fn with_checksum(line: &str) -> String {
    match line.strip_suffix("*sum") {
        Some(body) => format!("{body}*{}", body.bytes().fold(0, |sum, byte| sum ^ byte)),
        None => line.into(),
    }
}

#[test]
fn every_line_is_answered_as_smoothieware_answers_it() {
    let mut bench = Plan::new(CARTESIAN).start();
    for (line, expected) in TRANSCRIPT {
        let answer = bench.say(&with_checksum(line));
        if BY_FORM.contains(line) {
            let head = |text: &str| text.split([':', ' ']).next().map(str::to_owned);
            assert_eq!(head(&answer), head(expected), "{line}");
            assert!(answer.ends_with("ok\n"), "{line}: {answer}");
        } else {
            assert_eq!(&answer, expected, "{line}");
        }
    }
}

#[test]
fn a_status_report_shows_state_positions_and_heaters() {
    let mut bench = Plan::new(CARTESIAN).start();
    assert_eq!(
        bench.status(),
        "<Idle|MPos:0.0000,0.0000,0.0000,0.0000|WPos:0.0000,0.0000,0.0000|F:9000.0,100.0|S:0.00|B:22.0,0.0|P:22.0,0.0|T:22.0,0.0>\n"
    );
    bench.type_in("G1 X50 F3000\n");
    bench.hear(0.3);
    let running = bench.status();
    assert!(running.starts_with("<Run|") && running.contains("|F:3000.0,3000.0,100.0|S:0.0000"), "{running}");
}

#[test]
fn a_feed_hold_brakes_keeps_everything_and_goes_on() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.type_in("G1 X60 F3000\nG1 X80 F3000\n");
    bench.hear(0.5);
    bench.type_in("!");
    bench.hear(0.3);
    let held = bench.carriage(Alpha);
    assert!(bench.status().starts_with("<Hold|"));
    bench.hear(2.0);
    assert_eq!(bench.carriage(Alpha), held, "it moves while held");
    assert!(bench.is_energised(Alpha), "a hold keeps motors on");
    bench.type_in("~");
    bench.hear(3.0);
    assert!(bench.status().starts_with("<Idle|MPos:80.0000"));
}

#[test]
fn ctrl_x_halts_and_m999_releases() {
    let mut bench = Plan::new(CARTESIAN).start();
    let start = bench.carriage(Alpha);
    bench.run(&["M104 S150"]);
    bench.type_in("G1 X60 F3000\n");
    bench.hear(0.4);
    bench.type_in("\x18");
    let said = bench.hear(0.5);
    assert!(said.contains("ALARM: Abort during cycle\n"), "{said}");
    bench.assert_safe();
    assert!(bench.status().starts_with("<Alarm|"));
    assert_eq!(bench.say("M999"), "WARNING: After HALT you should HOME as position is currently unknown\nok\n");
    bench.run(&["G1 X10 F3000", "M400"]);
    let moved = bench.carriage(Alpha) - start;
    assert!((moved - 10.0).abs() < 0.02, "{moved}");
}

#[test]
fn dollar_x_unlocks_at_once() {
    let mut bench = Plan::new(CARTESIAN).start();
    assert_eq!(bench.say("M112"), "ALARM: Emergency stop (M112)\nok\n");
    assert_eq!(bench.say("G1 X1 F600"), "!!\n");
    assert_eq!(bench.say("$X"), "[Caution: Unlocked]\nok\n");
    bench.run(&["G1 X1 F600"]);
}

#[test]
fn a_continuous_jog_runs_until_ctrl_y() {
    let mut bench = Plan::new(CARTESIAN).start();
    let start = bench.carriage(Alpha);
    bench.type_in("$J -c X1 F3000\n");
    bench.hear(1.0);
    bench.type_in("\x19");
    let said = bench.hear(1.0);
    assert_eq!(said, "ok\n");
    let moved = bench.carriage(Alpha) - start;
    assert!((45.0..60.0).contains(&moved), "{moved}");
    assert!(bench.status().starts_with("<Idle|"));
}

#[test]
fn status_is_answered_while_waiting_for_a_temperature() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.type_in("M109 S150\n");
    bench.hear(2.0);
    assert!(bench.status().contains("|T:"));
    bench.type_in("\x18");
    let said = bench.hear(0.5);
    assert!(said.contains("Wait on temperature aborted by kill\n!!\n"), "{said}");
}

//! The table of codes, row by row, on a whole machine.

use std::collections::BTreeSet;

use base::sessions::SessionId;
use program::codes;
use scenarios::{Bench, CARTESIAN, Plan};

/// Codes that act only as the configuration says; the sample has no settings for them.
const NOBODY_S: [&str; 7] = ["M4", "M7", "M8", "M9", "M80", "M81", "M280"];

fn start() -> Bench {
    Plan::new(CARTESIAN)
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[filament detector] enable = true")
        .set("[filament detector] detector_pin = PB7^")
        .set("[leveling strategy] rectangular grid.enable = true")
        .start()
}

/// A code whose function has no arm in `machine/src/features/functions.rs` would be passed over.
#[test]
fn no_row_of_the_table_is_passed_over() {
    let mut passed_over = BTreeSet::new();
    for row in codes::all().filter(|row| !row.is_missing()) {
        let mut bench = start();
        bench.hear(0.05);
        bench.type_in(&format!("{}\n", row.code));
        let heard = bench.hear(0.2);
        if heard.contains("ignored") {
            passed_over.insert(row.code.to_string());
        }
    }
    assert_eq!(passed_over, NOBODY_S.into_iter().map(String::from).collect());
}

#[test]
fn a_file_is_chosen_paused_and_begun_again() {
    let mut bench = Plan::new(CARTESIAN).file("a.g", "G28.3 X0 Y0\nG1 X5 F60\nG1 X0\n").start();
    assert_eq!(bench.say("M21"), "SD card ok\nok\n");
    assert!(bench.say("M23 a.g").contains("File selected"));
    assert_eq!(bench.say("M27"), "SD printing byte 0/28\nok\n");
    bench.run(&["M24"]);
    bench.hear(1.0);
    bench.run(&["M25"]);
    assert!(!bench.hear(20.0).contains("Done"));
    assert!(!bench.moves(), "what was read is made, and no more");
    let said = bench.say("M27");
    assert!(
        said.starts_with("SD printing byte 28/28\n// time left: ") && said.ends_with(" by the planner\nok\n"),
        "{said}"
    );
    bench.run(&["M26"]);
    let said = bench.say("M27");
    assert!(said.starts_with("SD printing byte 0/28\n// time left: 00:00:10 of 00:00:10"), "{said}");
    bench.run(&["M24"]);
    bench.hear_until("Done printing file", 60.0);
}

#[test]
fn where_the_tool_is_now_is_said_in_the_work_coordinates() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.run(&["G28", "G55", "G10 L2 P2 X5"]);
    bench.type_in("G1 X5 F300\n");
    bench.hear(1.0);
    let live: f64 = bench.say("M114.1").split("X:").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!(live > -5.0 && live < 5.0, "{live}");
    assert!(bench.say("M114").starts_with("ok C: X:5.0000"), "where the program has come to");
}

#[test]
fn marlin_s_limits_and_levelling_switch_are_the_machine_s() {
    let mut bench = start();
    bench.run(&["G28", "M201 X500", "M572 D0 S0.05"]);
    assert!(bench.say("M503").contains("M204 S2000.00000 X500.00000"));
    assert_eq!(bench.say("M900"), "K:0.0500 smooth time:0.0400\nok\n");
    assert_eq!(bench.say("M420 S0"), "ok\n");
    assert!(bench.say("M420 S1").contains("no grid"), "there is none to switch on");
}

#[test]
fn settings_are_loaded_from_a_file_by_either_name_of_the_command() {
    for command in ["load other", "config-load other"] {
        let mut bench = Plan::new(CARTESIAN).file("other", "M204 S1234\n").start();
        let heard = bench.say(command);
        assert!(heard.ends_with("ok\n"), "{heard}");
        assert!(bench.say("M503").contains("M204 S1234.00000"), "{command}");
    }
}

#[test]
fn echo_says_what_it_is_told() {
    let mut bench = Plan::new(CARTESIAN).start();
    assert_eq!(bench.say("echo a  b"), "a  b\nok\n");
    assert_eq!(bench.say("echo -n a"), "aok\n");
    let mut silent = Plan::new(CARTESIAN).set("[uart console] enable = false").start();
    assert_eq!(silent.say("echo -1 a"), "error:echo -1: [uart console] is not enabled\n");
    let mut bench = Plan::new(CARTESIAN).set("[uart console] enable = true").set("[uart console] channel = 0").start();
    bench.hear_on(SessionId(1), 0.1);
    assert_eq!(bench.say("echo -n -1 open the vice"), "ok\n");
    assert_eq!(bench.hear_on(SessionId(1), 0.1), "open the vice");
    // Smoothieware v2 says it on every console, as M118 does here.
    assert_eq!(bench.say("echo a b"), "a b\nok\n");
    assert_eq!(bench.hear_on(SessionId(1), 0.1), "");
    assert_eq!(bench.say("M118 a b"), "a b\nok\n");
    assert_eq!(bench.hear_on(SessionId(1), 0.1), "a b\n");
}

/// M203 is in mm/min to RepRapFirmware, in mm/s to Smoothieware.
#[test]
fn a_console_speaks_the_dialect_it_asks_for_and_saved_settings_stay_the_machine_s() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.run(&["M203 X100"]);
    assert!(bench.say("M500").ends_with("ok\n"));
    assert_eq!(bench.say("dialect"), "this console speaks Smoothie's dialect\nok\n");
    assert_eq!(bench.say("dialect rrf"), "this console speaks RepRapFirmware's dialect\nok\n");
    bench.run(&["M203 X6000 Y6000"]);
    assert!(bench.say("M503").contains("M203 X100.00000 Y100.00000"));
    assert!(bench.say("M501").ends_with("ok\n"));
    assert!(bench.say("M503").contains("M203 X100.00000 Y300.00000"), "as it was saved");
    for wrong in ["dialect grbl", "dialect german"] {
        assert!(bench.say(wrong).contains("error:a console speaks smoothie, marlin"), "{wrong}");
    }
    let mut bench = Plan::new(CARTESIAN).set("[general] grbl_mode = true").start();
    assert!(bench.say("dialect marlin").contains("error:"));
}

//! Replies to lines, alarms and resets in the GRBL dialect.

use base::sessions::{ConsoleKind, SessionProfile};
use base::sessions::{Rights, SessionId};
use program::Dialect;
use scenarios::{CARTESIAN, Plan};
use units::Actuator::Alpha;

use super::{BANNER, LOCKED, plan, refused, start};

#[test]
fn every_session_of_the_dialect_is_greeted_with_grbls_banner() {
    let bench = start();
    assert!(bench.greeting().ends_with(&format!("\n{BANNER}")), "{}", bench.greeting());
    let own = SessionProfile {
        kind: ConsoleKind::Memory,
        rights: Rights::Operate,
        dialect: Some(Dialect::Grbl),
        greeting: "hello\n",
    };
    let mut bench = Plan::new(CARTESIAN).visitor(own).start();
    bench.set_open(SessionId(2), true);
    assert_eq!(bench.hear_on(SessionId(2), 0.1), BANNER);
    assert!(bench.greeting().ends_with("Welcome to Smoothie\nok\n"));
}

#[test]
fn whatever_is_sent_is_answered_once() {
    let mut bench = start();
    for line in [
        "",
        "G21",
        "G90 G94",
        "(a comment)",
        "M5",
        "M8",
        "G4 P0.01",
        "$",
        "$G",
        "$#",
        "version",
        "M105",
        "ls",
        "help",
        "M114",
    ] {
        let said = bench.say(line);
        assert!(said.ends_with("ok\n"), "{line}: {said}");
        let answers = said.lines().filter(|said| *said == "ok" || said.starts_with("error")).count();
        assert_eq!(answers, 1, "{line}: {said}");
        assert_eq!(bench.hear(0.05), "", "{line} is answered twice");
        for said in said.lines().filter(|said| *said != "ok") {
            assert!(said.starts_with(['[', '$']), "{line}: {said}");
        }
    }
}

#[test]
fn what_is_refused_has_grbls_number_and_our_reason() {
    let mut bench = start();
    for (line, number) in [
        ("G1 X@", 2),
        ("G1 X", 2),
        ("&", 1),
        ("G1.x", 23),
        ("G999", 20),
        ("G30", 20),
        ("G999 G21", 20),
        ("G0 G1 X1 F100", 21),
        ("G1 X1 X2 F100", 25),
        ("M999999", 23),
        ("$nonsense", 3),
        ("$J", 3),
        ("G10 L2 P77 X1", 29),
        ("G38.2 F100", 26),
        ("N5 G1 X1*77", 27),
    ] {
        refused(&mut bench, line, number);
        assert_eq!(bench.hear(0.05), "", "{line} is answered twice");
    }
    assert!(refused(&mut bench, "G1 X@", 2).contains("column 4"));
    let long = "X1".repeat(200);
    refused(&mut bench, &long, 11);
}

/// A line that is too long comes behind one that takes its time: the answers keep their order.
#[test]
fn a_line_that_is_too_long_is_answered_in_its_turn() {
    let mut bench = start();
    bench.type_in(&format!("G4 P0.3\n{}\nG21\n", "X1".repeat(200)));
    assert_eq!(bench.hear(0.1), "", "the dwell is not over");
    assert_eq!(bench.hear(0.5), "ok\n[MSG:Discarding long line]\nerror:11\nok\n");
}

// --- alarms ---

#[test]
fn what_halts_has_a_number_of_its_own_too() {
    let mut bench = start();
    for (line, number) in [("G1 X1 F-1", 4), ("G2 X5 R1 F100", 33)] {
        let said = bench.say(line);
        assert!(said.contains("\nALARM:3\n") && said.ends_with(&format!("\nerror:{number}\n")), "{line}: {said}");
        assert!(bench.say("$X").ends_with("ok\n"));
    }
    refused(&mut bench, "G28", 10);
    // GRBL stays idle: nothing has moved.
    refused(&mut bench, "G1 X1 F0", 22);
    bench.run(&["G1 X1 F600"]);
}

#[test]
fn an_alarm_has_its_number_and_locks_until_it_is_cleared() {
    let mut bench = start();
    bench.run(&["$H"]);
    let said = bench.say("G1 X9999 F600");
    assert!(said.contains("\nALARM:2\n") && said.ends_with("error:33\n"), "{said}");
    assert!(said.contains("out of travel"), "{said}");
    assert!(bench.status().starts_with("<Alarm|"));
    assert_eq!(bench.say("G0 X1"), "[MSG:'$H'|'$X' to unlock]\nerror:9\n");
    refused(&mut bench, "$J=X1 F100", 8);
    assert_eq!(bench.say("$X"), "[MSG:Caution: Unlocked]\nok\n");
    bench.run(&["G0 X1", "$X"]);
}

#[test]
fn homing_ends_an_alarm() {
    let mut bench = start();
    bench.type_in("G1 X30 F600\n");
    bench.hear(0.5);
    bench.type_in("\x18");
    let said = bench.hear(1.0);
    assert_eq!(said, format!("[MSG:ALARM: Abort during cycle]\nALARM:3\n{BANNER}{LOCKED}"));
    bench.run(&["$H"]);
    assert!(bench.status().starts_with("<Idle|"));
    refused(&mut bench, "$HQ", 3);
    bench.run(&["$HX", "$HZ"]);
}

#[test]
fn each_alarm_has_grbls_number() {
    for (fault, number) in [("switch-never:minx", 9), ("switch-always:minx", 8)] {
        let mut bench = plan().fault(fault).start();
        let said = bench.say("$H");
        assert!(said.contains(&format!("\nALARM:{number}\n")) && said.ends_with("\nerror:9\n"), "{fault}: {said}");
        assert!(said.contains("minx"), "{fault}: {said}");
    }
    let mut bench = start();
    bench.type_in("$H\n");
    bench.hear(0.5);
    bench.type_in("\x18");
    let said = bench.hear(1.0);
    assert!(said.contains("\nALARM:6\n"), "{said}");
    let mut bench = plan().set("[endstops] minx.limit_enable = true").set("[soft endstop] enable = false").start();
    bench.run(&["$H", "G1 X20 F3000", "G4 P0", "G92 X50"]);
    bench.type_in("G1 X0 F3000\n");
    let said = bench.hear(3.0);
    assert!(said.contains("\nALARM:1\n") && said.contains("Hard limit -X was hit"), "{said}");
    let mut bench = plan().set("[zprobe] enable = true").set("[zprobe] probe_pin = PB10^").start();
    bench.run(&["$H", "G1 Z10 F3000"]);
    let said = bench.say("G91 G38.2 Z-1 F300");
    assert!(said.contains("\nALARM:5\n") && said.ends_with("error:9\n"), "{said}");
}

// --- reset ---

#[test]
fn a_reset_at_rest_is_no_alarm_and_forgets_modes_and_lines() {
    let mut bench = start();
    bench.run(&["G91", "G20", "G55"]);
    bench.type_in("G21 (half a li\x18");
    assert_eq!(bench.hear(0.1), BANNER);
    let said = bench.say("$G");
    assert!(said.contains(" G54 ") && said.contains(" G21 ") && said.contains(" G90 "), "{said}");
    assert!(bench.status().starts_with("<Idle|"));
}

/// Senders stop a job by `!` and then Ctrl-X: the machine knows where it is, and needs no homing.
#[test]
fn a_reset_in_a_hold_at_rest_is_no_alarm_and_drops_what_was_to_come() {
    let mut bench = start();
    bench.run(&["$H"]);
    // More than the look-ahead takes: a line waits for its turn.
    let lines: String = (1..90).map(|n| format!("G1 X{} F1000\n", n % 2 * 10 + n)).collect();
    bench.type_in(&lines);
    bench.hear(1.0);
    bench.type_in("!");
    bench.hear(1.0);
    assert!(bench.status().starts_with("<Hold:0|"));
    let place = bench.carriage(Alpha);
    bench.type_in("\x18?");
    let said = bench.hear(1.0);
    assert!(said.starts_with(BANNER) && said[BANNER.len()..].starts_with("<Idle|"), "{said}");
    assert!(bench.is_energised(Alpha) && bench.carriage(Alpha) == place);
    assert_eq!(bench.say("G91"), "ok\n");
    bench.run(&["G1 X1 F600", "G4 P0"]);
    assert!((bench.carriage(Alpha) - place - 1.0).abs() < 0.02, "from {place} to {}", bench.carriage(Alpha));
    // While it still brakes nobody knows where it will stand.
    bench.type_in("G1 X30 F6000\n");
    bench.hear(0.2);
    bench.type_in("!\x18");
    assert!(bench.hear(1.0).contains("\nALARM:3\n"));
}

/// Nothing that was sent before the reset is carried out or answered behind the banner.
#[test]
fn a_reset_drops_what_was_sent_before_it() {
    let mut bench = start();
    bench.type_in("G1 X30 F600\nG4 P5\nG1 X0\nM3 S50\nG1 X5\n");
    bench.hear(0.5);
    bench.type_in("\x18");
    let said = bench.hear(2.0);
    let (_, behind) = said.split_once(BANNER).expect("a banner");
    assert!(behind.lines().all(|line| line.starts_with("[MSG:'$H'|")), "{behind}");
    bench.say("$X");
    let place = bench.carriage(Alpha);
    bench.hear(1.0);
    assert_eq!(bench.carriage(Alpha), place);
}

//! The event log: entries that a machine keeps, as the command `events` lists them.

use base::sessions::SessionId;
use base::sessions::{ConsoleKind, SessionProfile};
use scenarios::{Bench, CARTESIAN, Plan};

/// Returns the answer to `events all`, without its times.
fn events(bench: &mut Bench) -> Vec<String> {
    let answer = bench.say("events all");
    let untimed = |line: &str| match line.strip_prefix("--- ") {
        Some(start) => start.to_owned(),
        None => line.trim_start().split_once(' ').map_or(String::new(), |(_, words)| words.to_owned()),
    };
    answer.lines().filter(|line| *line != "ok").map(untimed).collect()
}

/// Asserts that these lines come in this order, with others between them.
#[track_caller]
fn in_order(events: &[String], expected: &[&str]) {
    let mut rest = events.iter();
    for line in expected {
        assert!(rest.any(|event| event == line), "no {line:?} in its place: {events:#?}");
    }
}

#[test]
fn a_day_of_a_printer() {
    let job = "M104 S60\nG1 X10 F6000\nG1 X20\n";
    let mut bench = Plan::new(CARTESIAN).file("part.g", job).start();
    bench.run(&["G28"]);
    bench.say("play /sd/part.g");
    bench.hear(5.0);
    bench.run(&["M104 S0", "G1 X50 F600"]);
    bench.hear(1.0);
    bench.say("M112");
    bench.say("M999");
    in_order(
        &events(&mut bench),
        &[
            "started: power came",
            "card mounted",
            "state: homing",
            "homed XYZ",
            "job began: /sd/part.g",
            "hotend to reach 60 C",
            "job done",
            "hotend switched off",
            "halted: ALARM: Emergency stop (M112)",
            "the halt was cleared",
        ],
    );
    let read = events(&mut bench).into_iter().find(|event| event.starts_with("config.ini was read in "));
    assert!(read.is_some_and(|read| read.contains(" ms")));
}

#[test]
fn what_watches_writes_before_anybody_is_told() {
    let mut bench = Plan::new(CARTESIAN).fault("driver-prewarn:alpha@1").fault("motor-supply:0@4").start();
    bench.hear(8.0);
    in_order(
        &events(&mut bench),
        &[
            "motor driver X: Overtemperature Prewarning: the driver is above 100 C: lower its current (M906), or cool it",
            "motor supply is off",
        ],
    );
}

#[test]
fn a_heater_that_fails_is_told_with_its_reason() {
    let mut bench = Plan::new(CARTESIAN).fault("thermistor-open:hotend@3").start();
    bench.run(&["M104 S100"]);
    bench.hear(5.0);
    let events = events(&mut bench);
    in_order(&events, &["hotend to reach 100 C"]);
    assert!(
        events
            .iter()
            .any(|event| event.starts_with("halted: ERROR: MINTEMP or MAXTEMP triggered on T: thermistor open")),
        "{events:#?}"
    );
}

#[test]
fn a_configuration_that_cannot_be_used_is_told() {
    let mut bench = Plan::new(CARTESIAN).with("arm_solution", "arm_solutionn").start();
    let kept = events(&mut bench);
    assert!(kept.iter().any(|event| event.starts_with("config.ini ")), "{kept:#?}");
    let mut bench = Plan::new(CARTESIAN).card(sim::runner::CardState::Missing).start();
    assert!(events(&mut bench).iter().any(|event| event.starts_with("config.ini cannot be read: ")));
}

#[test]
fn who_came_and_went_is_told() {
    let visitor = SessionProfile { kind: ConsoleKind::Memory, ..SessionProfile::SERIAL };
    let mut bench = Plan::new(CARTESIAN).visitor(visitor).start();
    bench.set_open(SessionId(2), true);
    bench.hear(0.1);
    bench.set_open(SessionId(2), false);
    bench.hear(0.1);
    in_order(&events(&mut bench), &["somebody came to console 2", "console 2 was left"]);
}

#[test]
fn a_suspended_job_is_told_with_its_lines() {
    let job = "G1 X10 F6000\nM600\nG1 X20\n";
    let mut bench = Plan::new(CARTESIAN).file("part.g", job).start_homed();
    bench.say("play /sd/part.g");
    bench.hear(3.0);
    bench.say("resume");
    bench.hear(3.0);
    in_order(
        &events(&mut bench),
        &["job began: /sd/part.g", "job suspended at line 2", "job goes on at line 2", "job done"],
    );
}

#[test]
fn it_tells_as_many_as_it_is_asked_for_and_keeps_256() {
    let mut bench = Plan::new(CARTESIAN).start();
    for number in 0..150 {
        bench.run(&[if number % 2 == 0 { "M104 S40" } else { "M104 S0" }]);
        bench.hear(0.02);
        bench.run(&[if number % 2 == 0 { "M140 S40" } else { "M140 S0" }]);
        bench.hear(0.02);
    }
    assert_eq!(events(&mut bench).len(), 256);
    let lines = |answer: String| answer.lines().filter(|line| *line != "ok").count();
    assert_eq!(lines(bench.say("events 5")), 5);
    assert_eq!(lines(bench.say("events")), 40);
    assert!(bench.say("events some").contains("error:events takes a number, or all"));
    let without_debugger = bench.say("break");
    assert!(without_debugger.contains("no debugger is attached") && lines(without_debugger) == 9);
}

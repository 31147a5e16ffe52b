//! The spindle's S: it is modal, comes in order with motion, and is a speed where `max_rpm` says so; what
//! turns the other way, and what does not.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::Alpha;

/// Dialects in which lines can be read.
const DIALECTS: [&str; 5] = [
    "[general] dialect = smoothie",
    "[general] dialect = marlin",
    "[general] dialect = reprapfirmware",
    "[general] dialect = klipper",
    "[general] grbl_mode = true",
];

/// Adds a switch with these settings.
fn switch(plan: Plan, name: &str, settings: &[&str]) -> Plan {
    let all = ["enable = true"].iter().chain(settings);
    all.fold(plan, |plan, setting| plan.set(&format!("[switch] {name}.{setting}")))
}

/// A spindle on a timer, PWM1_1, that M3 turns.
fn spindle(plan: Plan) -> Plan {
    let settings = ["input_on_command = M3", "input_off_command = M5", "output_pin = PWM1_1", "output_type = hwpwm"];
    switch(plan.set("[pwm1] frequency = 5000"), "spindle", &settings)
}

/// Returns the percent of the output at a channel of the timer.
fn percent_at(bench: &mut Bench, channel: usize) -> f64 {
    bench.hear(0.02);
    (bench.world(|world| world.pwm_duty(0, channel)) * 10_000.0).round() / 100.0
}

fn percent(bench: &mut Bench) -> f64 {
    percent_at(bench, 0)
}

/// Sends lines, and returns the spindle's output after them.
#[track_caller]
fn after(bench: &mut Bench, lines: &[&str]) -> f64 {
    bench.run(lines);
    percent(bench)
}

// --- modal ---

// Grbl 1.1 `gcode.c` (`gc_state.spindle_speed`; M5 does not touch it), LinuxCNC "G-code overview, modal
// groups". Smoothieware v2's bare M3 takes `default_on_value`: that is here until an S was given.
#[test]
fn s_is_modal_in_every_dialect() {
    for dialect in DIALECTS {
        let mut bench =
            spindle(Plan::new(CARTESIAN)).set(dialect).set("[switch] spindle.default_on_value = 70").start();
        let bench = &mut bench;
        assert_eq!(after(bench, &["M3"]), 70.0, "{dialect}: no S yet");
        assert_eq!(after(bench, &["M5", "S12"]), 0.0, "{dialect}: it stands");
        assert_eq!(after(bench, &["M3"]), 12.0, "{dialect}: S before M3");
        assert_eq!(after(bench, &["S20"]), 20.0, "{dialect}: S alone");
        assert_eq!(after(bench, &["G1 X5 F6000 S60", "M400"]), 60.0, "{dialect}: S of a move");
        assert_eq!(after(bench, &["M5", "M3"]), 60.0, "{dialect}: M5 keeps S");
        assert_eq!(after(bench, &["M5", "G0 X6 S35", "M400"]), 0.0, "{dialect}");
        assert_eq!(after(bench, &["M3"]), 35.0, "{dialect}");
        assert_eq!(after(bench, &["M3 S0"]), 0.0, "{dialect}: S0 stands");
        assert_eq!(after(bench, &["S50"]), 50.0, "{dialect}: and M3 is still in force");
    }
}

#[test]
fn a_script_brings_back_the_s_that_the_job_had() {
    let plan = spindle(Plan::new(CARTESIAN))
        .set("[player] after_suspend_gcode = M5")
        .set("[player] before_resume_gcode = M3")
        .file("part.gcode", "M3 S40\nG1 X60 F600\n");
    let bench = &mut plan.start_homed();
    bench.type_in("play part.gcode\n");
    bench.hear(2.0);
    assert_eq!(percent(bench), 40.0);
    bench.type_in("M600\n");
    bench.hear(8.0);
    assert_eq!(percent(bench), 0.0);
    bench.type_in("M601\n");
    bench.hear(2.0);
    assert_eq!(percent(bench), 40.0, "as in Smoothieware#1526 it must not go on without");
}

#[test]
fn a_suspended_job_goes_on_as_the_spindle_turned() {
    let flood = ["input_on_command = M8", "input_off_command = M9", "output_pin = PI4", "output_type = digital"];
    for (meanwhile, begins) in [("M5\nM9\n", "M3 S40\nM8"), ("S10\n", "M3 S40\nM8"), ("M3 S70\nM8\n", "M5")] {
        let plan = switch(spindle(Plan::new(CARTESIAN)), "flood", &flood);
        let file = format!("{begins}\nG1 X20 F600\nM400\nG1 X60\n");
        let bench = &mut plan.set("[switch] spindle.on_delay = 2").file("part.gcode", &file).start_homed();
        bench.type_in("play part.gcode\n");
        bench.hear(2.5);
        bench.type_in("M600\n");
        bench.hear_until("enter resume", 20.0);
        bench.type_in(meanwhile);
        bench.hear(3.0);
        let stood_at = bench.carriage(Alpha);
        bench.type_in("M601\n");
        bench.hear(1.0);
        let (turns, flows) = (percent(bench), bench.say("switch flood").contains(" is 1"));
        let turned = if begins == "M5" { (0.0, false) } else { (40.0, true) };
        assert_eq!((turns, flows), turned, "{meanwhile}");
        if meanwhile.starts_with("M5") {
            assert_eq!(bench.carriage(Alpha), stood_at, "it waits until the spindle turns");
        }
        bench.hear(8.0);
        assert!(bench.carriage(Alpha) > 55.0, "{meanwhile}: it does not go on");
    }
}

// LinuxCNC and GRBL stop for it; here it comes where the move begins that names it, as M3 does.
#[test]
fn a_change_of_s_comes_in_order_and_stops_nothing() {
    for (line, from) in [("G1 X20 S80", 10.0), ("S80\nG1 X20", 10.0), ("G1 X20\nS80", 20.0)] {
        let bench = &mut spindle(Plan::new(CARTESIAN)).start_homed();
        bench.run(&["G1 X0 F3000", "M400", "M3 S40"]);
        bench.type_in(&format!("G1 X10 F600\n{line}\nG1 X30\n"));
        let (mut changed_at, mut slowest) = (None, f64::MAX);
        let mut before = bench.carriage(Alpha);
        bench.hear(0.2);
        while bench.carriage(Alpha) < 29.0 {
            bench.hear(0.01);
            let now = bench.carriage(Alpha);
            if now > 2.0 {
                slowest = slowest.min(now - before);
            }
            before = now;
            if changed_at.is_none() && bench.world(|world| world.pwm_duty(0, 0)) > 0.5 {
                changed_at = Some(now);
            }
        }
        let at = changed_at.expect("it turns faster");
        assert!((at - from).abs() < 0.2, "{line}: at {at}, not {from}");
        assert!(slowest > 0.09, "{line}: {slowest} mm in 10 ms");
    }
}

#[test]
fn on_delay_is_for_the_start_and_not_for_another_speed() {
    let bench = &mut spindle(Plan::new(CARTESIAN)).set("[switch] spindle.on_delay = 2").start();
    let mut takes = |line: &str| {
        let before = bench.now_s();
        bench.run(&[line]);
        bench.now_s() - before
    };
    assert!(takes("M3 S40") > 1.9);
    assert!(takes("S50") < 0.1 && takes("M3 S60") < 0.1);
    assert!(takes("M5") < 0.1 && takes("M3") > 1.9);
}

// --- what S is ---

#[test]
fn s_is_a_speed_where_max_rpm_says_so() {
    for dialect in DIALECTS {
        let plan = switch(spindle(Plan::new(CARTESIAN)), "spindle", &["max_rpm = 24000", "default_on_value = 10"]);
        let bench = &mut plan.set(dialect).start();
        for (line, expected) in
            [("M3", 10.0), ("S12000", 50.0), ("S24000", 100.0), ("G1 X1 F600 S6000", 25.0), ("M5", 0.0), ("M3", 25.0)]
        {
            assert_eq!(after(bench, &[line, "M400"]), expected, "{dialect}, {line}");
        }
        // A share, as Klipper's: of the greatest speed.
        if dialect.contains("klipper") {
            assert_eq!(after(bench, &["SET_PIN PIN=spindle VALUE=0.5"]), 50.0);
        }
    }
}

#[test]
fn an_s_beyond_the_scale_is_told_once_and_limited() {
    let plan = switch(spindle(Plan::new(CARTESIAN)), "spindle", &["max_rpm = 24000", "min_rpm = 6000"]);
    let file = "M3 S30000\nG1 X10 F3000\nG1 X12 S31000\nS20000\nG1 X14\nS40000\nM5\n";
    let bench = &mut plan.file("part.gcode", file).start();
    let said = bench.say("M3 S30000");
    assert_eq!(said, "WARNING: S30000 is above max_rpm = 24000 of [switch] spindle: it turns with S24000\nok\n");
    assert_eq!(percent(bench), 100.0);
    assert_eq!(bench.say("M3 S30000"), "ok\n", "it is told once");
    let said = bench.say("S2000");
    assert_eq!(said, "WARNING: S2000 is below min_rpm = 6000 of [switch] spindle: it turns with S6000\nok\n");
    assert_eq!(percent(bench), 25.0);
    assert_eq!(after(bench, &["S0"]), 0.0, "S0 is none that could be too low");
    // Each job tells it once.
    for _ in 0..2 {
        bench.type_in("play part.gcode -t\n");
        let said = bench.hear_until("Done printing file", 60.0);
        assert_eq!(said.matches("WARNING: S").count(), 1, "{said}");
    }
    let said = bench.say("check part.gcode");
    assert!(said.contains("line 1: warning: S30000 is above max_rpm = 24000 of [switch] spindle"), "{said}");
    assert_eq!(said.matches("is above max_rpm").count(), 1, "{said}");
}

#[test]
fn without_max_rpm_s_is_percent_and_a_speed_is_told() {
    let bench = &mut spindle(Plan::new(CARTESIAN)).start();
    let said = bench.say("M3 S12000");
    let told = "S12000 is above 100, which is full power: [switch] spindle has no max_rpm: it turns with S100";
    assert_eq!(said, format!("WARNING: {told}\nok\n"));
    assert_eq!(bench.say("M5"), "ok\n");
    // An S that reaches nothing that turns is nobody's.
    assert_eq!(bench.say("G1 X1 F600 S12000"), "ok\n");
    // Fans have always been limited, and are now.
    assert_eq!(bench.say("M106 S300"), "ok\n");
}

// --- S0 ---

#[test]
fn s0_is_off_on_an_output_without_speeds() {
    let digital = ["output_type = digital", "output_pin = PI4"];
    for dialect in DIALECTS {
        let plan = switch(spindle(Plan::new(CARTESIAN)), "spindle", &digital);
        let bench = &mut plan.set(dialect).set("[switch] fan.output_type = digital").start();
        let mut is_on = |name: &str, line: &str| {
            bench.run(&[line]);
            bench.say(&format!("switch {name}")).contains(" is 1")
        };
        assert!(is_on("spindle", "M3") && !is_on("spindle", "M3 S0") && is_on("spindle", "M3 S12000"), "{dialect}");
        assert!(!is_on("spindle", "S0") && is_on("spindle", "S1"), "{dialect}");
        assert!(!is_on("spindle", "M5") && !is_on("spindle", "S5") && is_on("spindle", "M3"), "{dialect}");
        // There M106 alone asks how the fan is.
        let on = if dialect.contains("reprapfirmware") { "M106 S1" } else { "M106" };
        assert!(is_on("fan", on) && !is_on("fan", "M106 S0") && is_on("fan", "M106 S1"), "{dialect}");
    }
}

// --- the other way ---

/// A spindle that PWM1_1 turns both ways, and PWM1_2 says which; described in that order, so that nothing is
/// right by chance.
fn both_ways(plan: Plan) -> Plan {
    let direction = ["input_on_command = M4", "input_off_command = M3", "output_type = hwpwm", "output_pin = PWM1_2"];
    let plan = spindle(plan).set("[switch] spindle.input_reverse_command = M4");
    switch(plan, "direction", &direction)
}

// Grbl 1.1 without a direction pin answers M4 with error 20 (`config.h`, USE_SPINDLE_DIR_AS_ENABLE_PIN).
#[test]
fn m4_is_refused_where_nothing_turns_the_other_way() {
    for dialect in DIALECTS {
        let file = "M3 S30\nG1 X10 F3000\nM4 S50\nG1 X30\n";
        let bench = &mut spindle(Plan::new(CARTESIAN)).set(dialect).file("part.gcode", file).start();
        let begun = bench.carriage(Alpha);
        assert_eq!(after(bench, &["M3 S100"]), 100.0);
        let said = bench.say("M4 S50");
        assert!(said.contains("this spindle has no M4: see input_reverse_command of [switch]"), "{dialect}: {said}");
        assert!(said.contains("error") && !said.contains("ok\n"), "{dialect}: {said}");
        assert_eq!(percent(bench), 100.0, "nothing has changed");
        assert_eq!(after(bench, &["M5", "M3"]), 100.0, "nor has S");
        bench.run(&["M5"]);
        bench.type_in("play part.gcode\n");
        bench.hear_until("this spindle has no M4", 20.0);
        bench.hear(2.0);
        assert!((bench.carriage(Alpha) - begun - 10.0).abs() < 0.1, "{dialect}: the file went on");
        let said = bench.say("check part.gcode");
        assert!(said.contains("line 3: stops: this spindle has no M4"), "{dialect}: {said}");
    }
}

#[test]
fn m4_turns_over_what_stands_and_m3_back() {
    for dialect in DIALECTS {
        let bench = &mut both_ways(Plan::new(CARTESIAN)).set(dialect).set("[switch] spindle.off_delay = 1").start();
        let mut seen = |line: &str| {
            bench.type_in(&format!("{line}\n"));
            let mut seen = Vec::new();
            for _ in 0..800 {
                bench.hear(0.002);
                let reversed = bench.world(|world| world.pwm_duty(0, 1)) > 0.0;
                let turns = bench.world(|world| (world.pwm_duty(0, 0) * 100.0).round());
                if seen.last() != Some(&(turns, reversed)) {
                    seen.push((turns, reversed));
                }
            }
            seen
        };
        assert_eq!(seen("M4 S30"), [(30.0, true)], "{dialect}");
        // The spindle never turns with the direction of the previous code.
        assert_eq!(seen("M3"), [(0.0, true), (30.0, false)], "{dialect}");
        assert_eq!(seen("M4 S50"), [(0.0, false), (50.0, true)], "{dialect}");
        assert_eq!(seen("S60"), [(60.0, true)], "{dialect}");
        assert_eq!(seen("M5"), [(0.0, true)], "{dialect}");
        assert_eq!(seen("M4"), [(60.0, true)], "{dialect}");
    }
}

#[test]
fn two_outputs_never_turn_both_ways_at_once() {
    let left = ["input_on_command = M4", "input_off_command = M5", "output_pin = PWM1_2", "output_type = hwpwm"];
    let bench = &mut switch(spindle(Plan::new(CARTESIAN)), "left", &left).start();
    for (line, turns) in [("M3 S40", [40.0, 0.0]), ("M4", [0.0, 40.0]), ("S50", [0.0, 50.0]), ("M3 S20", [20.0, 0.0])] {
        bench.run(&[line]);
        assert_eq!([percent_at(bench, 0), percent_at(bench, 1)], turns, "{line}");
    }
}

#[test]
fn off_delay_keeps_the_next_line_until_it_stands() {
    let bench = &mut spindle(Plan::new(CARTESIAN)).set("[switch] spindle.off_delay = 2").start();
    let mut takes = |line: &str| {
        let before = bench.now_s();
        bench.run(&[line]);
        bench.now_s() - before
    };
    assert!(takes("M3 S40") < 0.1 && takes("M5") > 1.9);
    assert!(takes("M5") < 0.1, "it stands already");
}

// --- what is said ---

#[test]
fn grbl_says_how_it_turns_and_keeps_s() {
    let plan = both_ways(Plan::new(CARTESIAN)).set("[general] grbl_mode = true");
    let bench = &mut plan.set("[switch] spindle.max_rpm = 24000").start();
    let mut says = |line: &str| {
        bench.run(&[line]);
        let status = bench.status();
        let (_, rest) = status.split_once("|FS:").expect("a speed");
        let speed = rest.split([',', '|', '>']).nth(1).unwrap().to_owned();
        let modes = bench.say("$G");
        let spindle = ["M3", "M4", "M5"].into_iter().find(|code| modes.contains(&format!(" {code} ")));
        let (_, s) = modes.split_once(" S").expect("an S");
        (speed, spindle.expect("how it turns"), s.split(']').next().unwrap().to_owned())
    };
    let mut expect = |line: &str, speed: &str, code: &'static str, s: &str| {
        assert_eq!(says(line), (speed.to_owned(), code, s.to_owned()), "{line}");
    };
    expect("S12000", "0", "M5", "12000");
    expect("M3", "12000", "M3", "12000");
    expect("G1 X1 F600 S8000", "8000", "M3", "8000");
    expect("M4", "8000", "M4", "8000");
    expect("M5", "0", "M5", "8000");
    expect("M3", "8000", "M3", "8000");
    for (line, letter) in [("M3", Some('S')), ("M4", Some('C')), ("M5", None)] {
        bench.run(&[line]);
        let report = (0..40).map(|_| bench.status()).find(|report| report.contains("|Ov:")).expect("a report of them");
        let letters = report.split_once("|A:").map(|(_, rest)| rest.trim_end_matches(">\n").to_owned());
        assert_eq!(letters, letter.map(String::from), "{line}: {report}");
    }
    assert!(bench.say("$$").contains("$30=24000") && bench.say("$$").contains("$31=0"));
}

#[test]
fn smoothieware_s_status_has_no_s_after_m5() {
    let bench = &mut spindle(Plan::new(CARTESIAN)).start();
    let said = |bench: &mut Bench| {
        let status = bench.status();
        status.split_once("|S:").map(|(_, rest)| rest.trim_end_matches(">\n").to_owned()).expect("an S")
    };
    bench.run(&["S30", "M3"]);
    assert!(said(bench).starts_with("30.0"));
    assert!(bench.say("$G").contains(" M3 ") && bench.say("$G").contains(" S30.0000"));
    bench.run(&["M5"]);
    assert!(said(bench).starts_with("0.0"));
    bench.run(&["M3"]);
    assert!(said(bench).starts_with("30.0"));
}

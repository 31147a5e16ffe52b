//! The executor: lines that wait for other lines, and lines that wait for nothing.

use base::sessions::SessionId;
use scenarios::{Bench, CARTESIAN, Plan};
use units::{Actuator, Direction};

const OTHER: SessionId = SessionId(1);

fn homed(plan: Plan) -> Bench {
    let mut bench = plan.start();
    assert_eq!(bench.say("G28"), "ok\n");
    bench
}

/// Returns the edges after the first `from` ones: nanoseconds since the first of them, motor and direction.
fn profile(bench: &Bench, from: usize) -> Vec<(u64, Actuator, Direction)> {
    bench.world(|world| {
        let edges = world.trace().edges().get(from..).unwrap_or_default();
        let start = edges.first().map_or(0, |edge| edge.time_ns);
        edges.iter().map(|edge| (edge.time_ns - start, edge.actuator, edge.direction)).collect()
    })
}

/// Returns a part of many short lines, with the given line in the middle of each.
fn part(between: &str) -> String {
    let lines = (0..40).map(|n| format!("G1 X{} Y{} F6000\n{between}", 10 + n, 10 + n % 2));
    format!("G90\n{}G1 X10 Y10\n", lines.collect::<String>())
}

#[test]
fn outputs_change_on_the_way_and_the_speed_profile_stays_what_it_is() {
    let run = |between: &str| {
        let mut bench = homed(Plan::new(CARTESIAN).file("part.g", &part(between)));
        let before = bench.world(|world| world.trace().total()) as usize;
        bench.say("play part.g -t");
        bench.hear_until("Done printing file", 60.0);
        profile(&bench, before)
    };
    let plain = run("");
    assert!(plain.len() > 1_000);
    for between in ["M106 S255\nM107\n", "M104 S60\n", "M140 S40\n", "M221 S100\n", "M106 S100\nM104 S50\nM140 S45\n"] {
        assert!(run(between) == plain, "{between:?} changes the motion");
    }
}

#[test]
fn an_output_changes_where_its_line_stands() {
    let mut bench = homed(Plan::new(CARTESIAN).file("part.g", "G90\nG1 X20 F600\nM106 S255\nG1 X40\nM107\nG1 X60\n"));
    bench.say("play part.g");
    let (mut turns_on, mut turns_off) = (None, None);
    for _ in 0..14_000 {
        bench.hear(0.000_5);
        let (x, on) = (bench.carriage(Actuator::Alpha), bench.world(|world| world.fan_speed(0)) > 0.0);
        if on && turns_on.is_none() {
            turns_on = Some(x);
        } else if !on && turns_on.is_some() && turns_off.is_none() {
            turns_off = Some(x);
        }
    }
    // 10 mm/s: a hundredth of a millimetre is a millisecond, as long as the fan is looked at.
    let (on, off) = (turns_on.expect("it goes on"), turns_off.expect("it goes off"));
    assert!((20.0..20.03).contains(&on) && (40.0..40.03).contains(&off), "on at {on}, off at {off}");
}

#[test]
fn questions_are_answered_while_another_session_waits_for_heat() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.type_in("M109 S60\n");
    bench.hear(0.5);
    for (question, answer) in [
        ("M105", "T:22"),
        ("M114", "ok C: X:"),
        ("M27", "Not currently playing"),
        ("progress", "Not"),
        ("get temp", "hotend"),
    ] {
        let before = bench.now_s();
        let said = bench.say_on(OTHER, question);
        assert!(said.contains(answer), "{question}: {said}");
        assert!(bench.now_s() - before < 0.01, "{question} took {} s", bench.now_s() - before);
    }
    bench.type_on(OTHER, "?");
    bench.hear(0.01);
    // A line that is no query waits for its turn.
    bench.type_on(OTHER, "G91\n");
    let heard = bench.hear_until("ok\n", 120.0);
    assert!(heard.contains("T:"), "{heard}");
}

#[test]
fn m112_stops_a_machine_that_waits() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.type_in("M109 S60\n");
    bench.hear(0.5);
    assert!(bench.duty("hotend") > 0.0);
    bench.type_on(OTHER, "M112\n");
    bench.hear(0.002);
    assert!(bench.status().starts_with("<Alarm"), "{}", bench.status());
    // The duty is a mean of the last second, so the duty before the halt must decay first.
    bench.hear(10.0);
    assert!(bench.duty("hotend") < 1e-3, "{}", bench.duty("hotend"));
}

#[test]
fn a_line_with_a_checksum_keeps_its_bytes() {
    let mut bench = homed(Plan::new(CARTESIAN));
    let sum = "N1 M117 Hi!".bytes().fold(0, |sum, byte| sum ^ byte);
    assert_eq!(bench.say("M110 N0"), "ok\n");
    assert_eq!(bench.say(&format!("N1 M117 Hi!*{sum}")), "ok\n");
    bench.run(&["G91", "G1 X5 F6000", "M400"]);
    assert!(bench.status().starts_with("<Idle"), "{}", bench.status());
}

#[test]
fn a_flood_on_one_session_leaves_the_others_their_turns() {
    let mut bench = homed(Plan::new(CARTESIAN));
    let flood: String = (0..150).map(|n| format!("G1 X{} F300\n", 1 + n % 2 * 20)).collect();
    bench.type_in("G90\n");
    assert!(bench.try_type(&flood), "it fits");
    bench.hear(1.0);
    for line in ["G90", "M220 S100", "M105", "M301"] {
        let before = bench.now_s();
        let said = bench.say_on(OTHER, line);
        assert!(said.contains("ok"), "{line}: {said}");
        assert!(bench.now_s() - before < 0.05, "{line} took {} s", bench.now_s() - before);
    }
}

#[test]
fn a_refused_line_is_answered_once() {
    let mut bench = Plan::new(CARTESIAN).start();
    for line in ["M104 S900", "G10 L7", "T7", "M221 S-5", "nonsense", "$nonsense", "M303 P9 S100"] {
        bench.type_in(&format!("{line}\n"));
        let said = bench.hear(0.2);
        assert!(said.starts_with("error:") && said.lines().count() == 1, "{line}: {said}");
    }
}

#[test]
fn m24_goes_on_with_a_suspended_job_where_it_was() {
    let file = "G90\nG1 X20 F600\nG1 X40\nG1 X60\n";
    let mut bench = homed(Plan::new(CARTESIAN).file("part.g", file));
    bench.say("play part.g");
    bench.hear(1.0);
    bench.type_in("suspend\n");
    bench.hear_until("Print Suspended", 30.0);
    assert!(bench.say("get mode").contains("suspended"));
    bench.run(&["G91", "G1 Y7 F6000", "M400"]);
    bench.type_in("M24\n");
    bench.hear_until("// Resuming print", 10.0);
    bench.hear(10.0);
    assert!(bench.carriage(Actuator::Beta).abs() < 0.01, "where it was, and in absolute coordinates");
    assert!((bench.carriage(Actuator::Alpha) - 60.0).abs() < 0.01);
}

#[test]
fn a_script_may_hold_any_code_and_an_unknown_one_is_told() {
    let plan = Plan::new(CARTESIAN)
        .set("[player] after_suspend_gcode = G91_G1_Z5_F600_G90_M9999_M220_S50")
        .set("[player] before_resume_gcode = M220_S100");
    let mut bench = homed(plan.file("part.g", "G90\nG1 X20 F600\nG1 X40\n"));
    bench.say("play part.g");
    bench.hear(1.0);
    bench.type_in("M600\n");
    let said = bench.hear_until("Print Suspended", 30.0);
    assert!(said.contains("is not known here and was passed over"), "{said}");
    bench.hear(0.2);
    assert!(bench.say("M220").contains("50.00"), "a script may hold any code");
    bench.say("M601");
    bench.hear(10.0);
    assert!(bench.say("M220").contains("100.00"));
    assert!((bench.carriage(Actuator::Alpha) - 40.0).abs() < 0.01);
}

#[test]
fn progress_says_that_the_job_heats_and_where_it_executes() {
    let lines: String = (0..30).map(|n| format!("G1 X{} F600\n", 1 + n % 2 * 5)).collect();
    let mut bench = homed(Plan::new(CARTESIAN).file("part.g", &format!("M109 S60\nG90\n{lines}")));
    bench.say("play part.g -t");
    bench.hear(1.0);
    let said = bench.say("progress");
    assert!(said.contains(", heating"), "{said}");
    while bench.say("progress").contains("heating") {
        bench.hear(1.0);
        assert!(bench.now_s() < 300.0, "it does not heat");
    }
    let mut last = 0.0;
    for _ in 0..20 {
        bench.hear(0.5);
        let said = bench.say("progress");
        let Some(percent) = said.split(", ").nth(1).and_then(|part| part.split(' ').next()?.parse::<f64>().ok()) else {
            break;
        };
        assert!(percent >= last && !said.contains("heating"), "{said} after {last}");
        last = percent;
    }
    assert!(last > 20.0, "{last}");
}

#[test]
fn check_mode_reads_and_carries_nothing_out() {
    let mut bench = homed(Plan::new(CARTESIAN));
    let x = bench.carriage(Actuator::Alpha);
    assert_eq!(bench.say("$C"), "[MSG:Enabled]\nok\n");
    bench.run(&["G90", "G1 X50 F6000", "M104 S60"]);
    assert!(bench.say("G1 X1 Q").starts_with("error") || bench.status().starts_with("<Check"), "{}", bench.status());
    bench.hear(1.0);
    assert_eq!((bench.carriage(Actuator::Alpha), bench.duty("hotend")), (x, 0.0));
    assert_eq!(bench.say("$C"), "[MSG:Disabled]\nok\n");
    bench.run(&["G91", "G1 X5 F6000", "M400"]);
    assert!((bench.carriage(Actuator::Alpha) - x - 5.0).abs() < 0.01, "it goes on from where it is");
}

#[test]
fn check_mode_deletes_nothing() {
    let mut bench = Plan::new(CARTESIAN).start();
    for line in ["M28 kept.g", "G1 X1", "M29"] {
        bench.say(line);
    }
    assert!(bench.say("$C").contains("Enabled"));
    bench.say("M30 kept.g");
    assert!(bench.say("$C").contains("Disabled"));
    assert!(bench.say("ls").to_ascii_lowercase().contains("kept.g"));
    bench.say("M30 kept.g");
    assert!(!bench.say("ls").to_ascii_lowercase().contains("kept.g"));
}

#[test]
fn check_mode_carries_out_nothing_that_takes_time() {
    let probe = ["[zprobe] enable = true", "[zprobe] probe_pin = PB10^", "[general] grbl_mode = true"];
    let mut bench = probe.into_iter().fold(Plan::new(CARTESIAN), Plan::set).start();
    bench.run(&["G28.3 X30 Y40 Z10"]);
    assert!(bench.say("$C").contains("Enabled"));
    for line in [
        "$H",
        "G28",
        "G28.2",
        "G30",
        "G29",
        "G32",
        "M48",
        "$P",
        "M303 E0 S60",
        "G38.2 Z-5 F300",
        "M104 S60",
        "M109 S60",
    ] {
        assert!(bench.say(line).contains("ok"), "{line}");
        bench.hear(0.2);
        assert_eq!(bench.world(|world| world.trace().total()), 0, "{line} moves something");
        assert!(!bench.heats(), "{line} heats");
    }
    for line in ["suspend", "resume"] {
        bench.say(line);
        assert!(bench.say("get mode").starts_with("[MSG:check]\n"), "{line}");
    }
    assert!(bench.say("$C").contains("Disabled"), "a job is not suspended");
}

#[test]
fn a_sleeping_machine_wakes_by_ctrl_x_alone() {
    let mut bench = homed(Plan::new(CARTESIAN));
    assert_eq!(bench.say("$SLP"), "ok\n");
    assert!(bench.say("get mode").contains("sleep"));
    assert_eq!(bench.say("G1 X5 F600"), "!!\n");
    bench.say("$X");
    assert!(bench.say("get mode").contains("sleep"));
    bench.type_in("\x18");
    bench.hear(0.1);
    assert!(bench.say("get mode").contains("alarm"));
    bench.say("$X");
    bench.hear(0.5);
    assert!(bench.say("get mode").contains("idle"));
}

#[test]
fn a_fan_obeys_a_halted_machine_before_it_stands() {
    let mut bench = homed(Plan::new(CARTESIAN));
    bench.run(&["G90"]);
    bench.type_in("G1 X150 F12000\n");
    bench.hear(0.4);
    bench.type_in("M112\n");
    bench.hear(0.001);
    assert_eq!(bench.say_on(OTHER, "M106 S255"), "ok\n");
    let x = bench.carriage(Actuator::Alpha);
    bench.hear(0.5);
    assert!(bench.carriage(Actuator::Alpha) > x + 0.1, "the fan waited until the carriage stood");
}

//! Small jobs: what is answered, and where the machine ends up.

use scenarios::{Bench, CARTESIAN, COREXY, Plan};
use units::Actuator::{Alpha, Beta, Delta, Gamma};

fn homed(config: &str) -> Bench {
    let mut bench = Plan::new(config).start();
    assert_eq!(bench.say("G28"), "ok\n");
    bench
}

fn assert_near(actual: f64, expected: f64, what: &str) {
    assert!((actual - expected).abs() < 0.0126, "{what}: {actual}, not {expected}");
}

#[test]
fn homing_finds_the_switches_to_the_step() {
    let bench = homed(CARTESIAN);
    for (motor, mm) in [(Alpha, 0.0), (Beta, 0.0), (Gamma, 0.0)] {
        assert_near(bench.carriage(motor), mm, motor.name());
    }
}

#[test]
fn homing_twice_ends_in_the_same_place() {
    let mut bench = homed(CARTESIAN);
    bench.run(&["G1 X31 Y17 Z3 F3000", "G28", "M400"]);
    assert_near(bench.carriage(Alpha), 0.0, "alpha");
    assert_near(bench.carriage(Gamma), 0.0, "gamma");
}

#[test]
fn corexy_homes_one_axis_at_a_time_and_ends_at_its_switches() {
    let mut bench = homed(COREXY);
    let tool = bench.world(|world| world.tool_mm());
    let status = bench.status();
    let expected = status.split("MPos:").nth(1).unwrap().split(['|', ',']).take(3);
    for (real, said) in tool.into_iter().zip(expected) {
        assert_near(real, said.parse().unwrap(), &status);
    }
    bench.run(&["G91", "G1 X10 Y5 F3000", "M400"]);
    let moved = bench.world(|world| world.tool_mm());
    assert_near(moved[0], tool[0] + 10.0, "x");
    assert_near(moved[1], tool[1] + 5.0, "y");
}

#[test]
fn lines_arcs_and_offsets_end_where_the_program_says() {
    let mut bench = homed(CARTESIAN);
    bench.run(&["G90", "G1 X50 Y40 Z2 F6000", "G3 X60 Y50 I0 J10", "G92 X0 Y0", "G1 X5 Y-5", "G10 L2 P2 X100 Y100"]);
    bench.run(&["G92.1", "G55", "G1 X-20 Y-30", "G91", "G1 X1 Y1", "G90", "G20", "G54", "G1 X2", "G21", "M400"]);
    assert_near(bench.carriage(Alpha), 50.8, "x");
    assert_near(bench.carriage(Beta), 71.0, "y");
    assert_eq!(bench.say("M114"), "ok C: X:50.8000 Y:71.0000 Z:2.0000 E:0.0000 \n");
    assert_eq!(bench.say("M114.2"), "ok MCS: X:50.8000 Y:71.0000 Z:2.0000\n");
}

#[test]
fn the_extruder_counts_absolutely_and_relatively_and_scales_with_flow() {
    let mut bench = homed(CARTESIAN);
    bench.run(&["M82", "G92 E0", "G1 E4 F300", "M83", "G1 E1", "M221 S50", "G1 E2", "G10", "G11", "M400"]);
    // 4 + 1 + half of 2; retraction and recovery cancel.
    assert!((bench.carriage(Delta) - 6.0).abs() < 0.003, "{}", bench.carriage(Delta));
    assert!(bench.say("M114").contains("E:7.0000"));
}

#[test]
fn a_file_plays_to_its_end_and_says_so() {
    let part = "G28\nG90\nM83\nG1 X20 Y20 F6000\nG1 X60 E3 F3000\nM106 S255\nG4 P50\nM107\nG1 Y60 E3\n";
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", part).start();
    assert_eq!(bench.say("M23 part.gcode"), format!("File opened:part.gcode Size:{}\nFile selected\nok\n", part.len()));
    assert_eq!(bench.say("M24"), "ok\n");
    bench.hear_until("Done printing file", 60.0);
    assert_near(bench.carriage(Alpha), 60.0, "x");
    assert_near(bench.carriage(Beta), 60.0, "y");
    assert!((bench.carriage(Delta) - 6.0).abs() < 0.003);
    assert_eq!(bench.say("M27"), "Not currently playing\nok\n");
}

#[test]
fn temperatures_are_reached_and_held() {
    let mut bench = Plan::new(CARTESIAN).start();
    let waited = bench.say("M109 S200");
    assert!(waited.lines().count() > 3 && waited.lines().next().unwrap().starts_with("T:"), "{waited}");
    assert!(waited.ends_with("ok\n"));
    bench.hear(60.0);
    assert!((bench.celsius("hotend") - 200.0).abs() < 2.0, "{}", bench.celsius("hotend"));
    let report = bench.say("M105");
    assert!(report.starts_with("ok B:") && report.contains(" T:") && report.contains("/200.0 @"), "{report}");
    bench.run(&["M104 S0"]);
    bench.hear(6.0);
    assert!(bench.duty("hotend") < 0.01);
}

#[test]
fn tuned_gains_hold_the_temperature() {
    let mut bench = Plan::new(CARTESIAN).start();
    let said = bench.say("M303 P0 S180 C3");
    assert!(said.contains("PID tuned: p_factor = ") && said.ends_with("ok\n"), "{said}");
    assert!(bench.say("M105").contains("T:") && bench.say("M105").contains("/0.0 @0"));
    bench.say("M109 S180");
    bench.hear(90.0);
    assert!((bench.celsius("hotend") - 180.0).abs() < 2.0, "{}", bench.celsius("hotend"));
}

#[test]
fn a_target_above_the_maximum_is_refused() {
    let mut bench = Plan::new(CARTESIAN).start();
    let refused = "error:hotend: 400.0 C is above its max_temp 290.0 C\n";
    for line in ["M104 S400", "M109 S400", "M303 P0 S400"] {
        assert_eq!(bench.say(line), refused, "{line}");
    }
    assert_eq!(bench.say("M303 P254 S150"), "error:bed: 150.0 C is above its max_temp 120.0 C\n");
    bench.hear(5.0);
    assert!(bench.duty("hotend") == 0.0 && bench.duty("bed") == 0.0);
}

#[test]
fn an_uploaded_file_is_kept_as_sent() {
    let mut bench = Plan::new(CARTESIAN).start();
    assert_eq!(bench.say("M28 new.g"), "Writing to file: new.g\nok\n");
    bench.run(&["G1 X1 ; a comment", "M117 hello"]);
    assert_eq!(bench.say("M29"), "Done saving file.\nok\n");
    assert_eq!(bench.read_card("new.g").as_deref(), Some("G1 X1 ; a comment\nM117 hello\n"));
    assert_eq!(bench.say("M30 new.g"), "deleted new.g\nok\n");
    assert_eq!(bench.read_card("new.g"), None);
}

#[test]
fn the_same_job_gives_the_same_edges_whatever_is_asked_meanwhile() {
    let part = "G28\nG90\nG1 X20 Y20 F6000\nG2 X40 Y20 I10 J0 F3000\nG1 Y60\nG1 X0 Y0 F9000\n";
    let edges = |asked: bool| {
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", part).start();
        bench.say("play /sd/part.gcode -t");
        for _ in 0..20_000 {
            if asked {
                bench.type_in("?");
            }
            if bench.hear(0.01).contains("Done") {
                break;
            }
        }
        bench.world(|world| (world.trace().total(), world.trace().edge_hash()))
    };
    let quiet = edges(false);
    assert!(quiet.0 > 10_000, "only {} edges", quiet.0);
    assert_eq!(quiet, edges(true));
}

/// Plays a file of moves around one line that cannot be carried out; what is said until the machine rests.
fn playing_with(line: &str) -> (Bench, String) {
    let file = format!("G28.3 X30 Y40 Z30\nG1 X40 F6000\n{line}\nG1 Y45\n");
    let mut bench = Plan::new(CARTESIAN).file("job.gcode", &file).start();
    let said = bench.ask("play /sd/job.gcode") + &bench.hear(3.0);
    let (_, said) = said.split_once("File size").expect("it plays");
    let said = said.split_once("\nok\n").map_or("", |(_, said)| said).to_owned();
    (bench, said)
}

#[test]
fn a_file_waits_at_a_line_that_cannot_be_carried_out_and_goes_on_when_told() {
    let long = "G1 X1 ".repeat(60);
    for (line, why) in [
        ("G1 Yfoo", "line 3 of /sd/job.gcode was not carried out"),
        ("G1 @", "line 3 of /sd/job.gcode was not carried out"),
        ("lift the pen", "line 3 of /sd/job.gcode was not carried out"),
        (&long, "line 3 of /sd/job.gcode is too long"),
    ] {
        let (mut bench, said) = playing_with(line);
        assert_eq!(said.matches(&format!("error:paused, {why}: M24 goes on")).count(), 1, "{line}: {said}");
        assert_near(bench.carriage(Alpha), 40.0, "what came before is done");
        assert_near(bench.carriage(Beta), 40.0, "what comes after is not");
        assert!(bench.status().contains("<Idle"), "it waits");
        bench.run(&["M24"]);
        bench.hear(2.0);
        assert_near(bench.carriage(Beta), 45.0, "it went on");
        assert_eq!(bench.say("progress"), "Not currently playing\nok\n");
    }
}

#[test]
fn an_unknown_g_code_in_a_file_pauses_it_and_an_unknown_m_code_is_counted() {
    let (bench, said) = playing_with("G12 X3");
    let why = "error:G12 is not known here, and what follows counts on it\nerror:paused, line 3 of";
    assert!(said.contains(why), "{said}");
    assert_near(bench.carriage(Beta), 40.0, "what comes after is not done");
    // Slicers write M73 and the like hundreds of times.
    assert_eq!(playing_with("M73 P5\nM73 P6\nM9999").1, "// NOTE not carried out: M73 2x, M9999 1x\n");
}

//! Soft endstops: no move starts that would leave the travel of a homed axis. The sample printer homes at X0
//! Y0 Z0, and goes to X220 Y220 Z200.

use scenarios::{Bench, CARTESIAN, DELTA, Plan};
use units::Actuator::{Alpha, Beta, Delta, Gamma};

fn homed(plan: Plan) -> Bench {
    let mut bench = plan.start();
    assert_eq!(bench.say("G28"), "ok\n");
    bench
}

fn edges(bench: &Bench) -> u64 {
    bench.world(|world| world.trace().total())
}

/// The line is refused with these words, nothing moves, and the position is what it was.
fn refused(bench: &mut Bench, line: &str, why: &str) {
    bench.run(&["M400"]);
    let (before, edges_before) = (bench.say("M114.2"), edges(bench));
    assert_eq!(bench.say(line), format!("error:{why}\n"), "{line}");
    bench.hear(0.5);
    assert_eq!(edges(bench), edges_before, "{line} moves");
    assert_eq!(bench.say("M114.2"), before, "{line}");
    assert!(bench.status().contains("<Idle|"), "{line}");
}

fn beyond(axis: char, target: f64, end: f64) -> String {
    let (small, which) = (axis.to_ascii_lowercase(), if target < end { "min" } else { "max" });
    format!("machine {axis} {target:.3} is out of travel, which ends at {end:.3} ([soft endstop] {small}_{which})")
}

#[test]
fn a_move_out_of_the_travel_is_refused_and_nothing_moves() {
    let mut bench = homed(Plan::new(CARTESIAN));
    bench.run(&["G90", "G1 X200 Y100 Z10 F9000", "M400"]);
    refused(&mut bench, "G1 X221", &beyond('X', 221.0, 220.0));
    refused(&mut bench, "G0 X10 Y-0.01", &beyond('Y', -0.01, 0.0));
    refused(&mut bench, "G53 G0 Z200.5", &beyond('Z', 200.5, 200.0));
    // The end itself can be reached, and the program goes on from where it was.
    bench.run(&["G91", "G1 X20", "M400"]);
    assert!((bench.carriage(Alpha) - 220.0).abs() < 0.02, "{}", bench.carriage(Alpha));
    refused(&mut bench, "G1 X1", &beyond('X', 221.0, 220.0));
}

#[test]
fn machine_coordinates_count_whatever_the_offsets_are() {
    let mut bench = homed(Plan::new(CARTESIAN));
    bench.run(&["G90", "G1 X100 Y100 F9000", "M400", "G92 X0", "G1 X120", "M400"]);
    refused(&mut bench, "G1 X121", &beyond('X', 221.0, 220.0));
    bench.run(&["G92.1", "G10 L2 P1 X-50", "G1 X60", "M400"]);
    assert!((bench.carriage(Alpha) - 10.0).abs() < 0.02, "{}", bench.carriage(Alpha));
    refused(&mut bench, "G1 X20", &beyond('X', -30.0, 0.0));
    bench.run(&["G20"]);
    refused(&mut bench, "G1 X11", &beyond('X', 229.4, 220.0));
}

#[test]
fn an_arc_that_bulges_out_is_refused_although_it_ends_within() {
    let mut bench = homed(Plan::new(CARTESIAN));
    bench.run(&["G90", "G1 X210 Y100 F9000", "M400"]);
    refused(&mut bench, "G3 X210 Y140 I0 J20", &beyond('X', 230.0, 220.0));
    refused(&mut bench, "G3 X210 Y140 R20", &beyond('X', 230.0, 220.0));
    // Full circles, one of two turns; a helix; one in another plane; and one whose configuration asks for
    // chords.
    refused(&mut bench, "G2 I7.5 J0", &beyond('X', 225.0, 220.0));
    refused(&mut bench, "G2 I0 J-15 P2 Z5", &beyond('X', 225.0, 220.0));
    refused(&mut bench, "G2 X210 Y140 Z201 J20", &beyond('Z', 201.0, 200.0));
    bench.run(&["G18"]);
    refused(&mut bench, "G3 X200 I-5 K0", &beyond('Z', -5.0, 0.0));
    let mut bench = homed(Plan::new(CARTESIAN).set("[motion control] mm_max_arc_error = 0.01"));
    bench.run(&["G90", "G1 X210 Y100 F9000", "M400"]);
    refused(&mut bench, "G3 X210 Y140 I0 J20", &beyond('X', 230.0, 220.0));
}

#[test]
fn curves_within_the_travel_go_though_their_circles_or_control_points_are_not() {
    let mut bench = homed(Plan::new(CARTESIAN));
    // The other half of the same circle.
    bench.run(&["G90", "G1 X210 Y100 F9000", "G2 X210 Y140 I0 J20", "M400"]);
    // The control points are at X230, the curve at most at X225 and X217.5.
    bench.run(&["G1 X210 Y100", "M400"]);
    refused(&mut bench, "G5 I20 J0 P20 Q0 X210 Y140", &beyond('X', 225.0, 220.0));
    bench.run(&["G5 I10 J0 P10 Q0 X210 Y140", "M400"]);
    assert!((bench.carriage(Beta) - 140.0).abs() < 0.02, "{}", bench.carriage(Beta));
}

#[test]
fn an_axis_that_is_not_homed_is_free() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.run(&["G1 X-30 F3000", "G28 X0"]);
    refused(&mut bench, "G1 X-30", &beyond('X', -30.0, 0.0));
    bench.run(&["G1 Y-30", "G28.5 X0", "G1 X-2", "M400"]);
}

#[test]
fn from_outside_a_move_may_come_back_in_and_not_go_further_out() {
    let mut bench = homed(Plan::new(CARTESIAN));
    bench.run(&["G90", "G1 X20 Y20 F6000", "M400", "G92.4 X-15"]);
    refused(&mut bench, "G1 X-15.5 Y30", &beyond('X', -15.5, 0.0));
    // Out to the other side of where it is: from X-15 a circle around X-10 stays right of it, one around X-20
    // does not.
    refused(&mut bench, "G2 I-5 J0", &beyond('X', -25.0, 0.0));
    bench.run(&["G2 I5 J0", "G1 Y30", "G1 X-10", "M400"]);
    refused(&mut bench, "G1 X-12", &beyond('X', -12.0, 0.0));
    bench.run(&["G1 X5"]);
}

#[test]
fn a_block_of_several_moves_is_made_whole_or_not_at_all() {
    let plan = Plan::new(CARTESIAN).set("[extruder] hotend.retract_zlift_length = 5");
    let mut bench = homed(plan);
    bench.run(&["G90", "G1 X10 Y10 Z198 F6000", "M400"]);
    let filament = bench.carriage(Delta);
    refused(&mut bench, "G10", &beyond('Z', 203.0, 200.0));
    assert_eq!(bench.carriage(Delta), filament, "it pulled all the same");
    // The refused G10 did not retract, so there is nothing to undo.
    bench.run(&["G11", "G1 Z190", "G10", "M400"]);
    assert!((bench.carriage(Gamma) - 195.0).abs() < 0.01, "{}", bench.carriage(Gamma));
    // The lift is still known after a refused Z.
    refused(&mut bench, "G1 Z201", &beyond('Z', 201.0, 200.0));
    bench.run(&["G11", "M400"]);
    assert!((bench.carriage(Gamma) - 190.0).abs() < 0.01, "{}", bench.carriage(Gamma));
    // Parking: up and away first, which is too far up.
    bench.run(&["G28.1 X0 Y0 Z0"]);
    refused(&mut bench, "G28.2 X5 Z15", &beyond('Z', 205.0, 200.0));
}

#[test]
fn a_tool_offset_is_as_before_when_its_move_is_refused() {
    let mut bench = homed(Plan::new(CARTESIAN));
    bench.run(&["G90", "G1 X200 F6000", "M400"]);
    refused(&mut bench, "G43.2 X30", &beyond('X', 230.0, 220.0));
    bench.run(&["G1 X150", "M400"]);
    assert!((bench.carriage(Alpha) - 150.0).abs() < 0.02, "{}", bench.carriage(Alpha));
}

#[test]
fn a_file_waits_at_the_line_that_would_leave_the_travel() {
    let part = "G28\nG90\nG1 X50 Y50 F6000\nG1 X300\nG1 Y60\n";
    // A look ahead would have it wait before that line.
    let mut bench = Plan::new(CARTESIAN).set("[player] preflight = time").file("part.gcode", part).start();
    bench.say("M23 part.gcode");
    bench.say("M24");
    let said = bench.hear_until("error:paused", 60.0) + &bench.hear(2.0);
    assert!(said.contains(&format!("error:{}\n", beyond('X', 300.0, 220.0))), "{said}");
    assert!(said.contains("line 4 of"), "{said}");
    assert!((bench.carriage(Alpha) - 50.0).abs() < 0.02 && (bench.carriage(Beta) - 50.0).abs() < 0.02);
    // The operator decides to continue with the next line.
    bench.run(&["M24"]);
    bench.hear_until("Done printing file", 20.0);
    assert!((bench.carriage(Beta) - 60.0).abs() < 0.02, "{}", bench.carriage(Beta));
}

#[test]
fn a_script_that_would_leave_the_travel_ends_the_line_that_started_it() {
    let plan = Plan::new(CARTESIAN).set("[player] after_suspend_gcode = G91 G0 Z300");
    let mut bench = homed(plan.file("part.gcode", "G90\nG1 X50 F6000\nM600\nG1 X60\n"));
    bench.say("M23 part.gcode");
    let said = bench.say("M24") + &bench.hear(2.0);
    assert!(said.contains(&beyond('Z', 300.0, 200.0)) && said.contains("line 3 of"), "{said}");
    assert!(bench.carriage(Gamma).abs() < 0.01, "{}", bench.carriage(Gamma));
}

#[test]
fn a_job_whose_place_is_out_of_travel_meanwhile_stays_suspended() {
    let plan = Plan::new(CARTESIAN).file("part.gcode", "G90\nG1 X30 F6000\nM600\nG1 X20\n");
    let mut bench = plan.start();
    bench.run(&["G28"]);
    bench.say("M23 part.gcode");
    assert!((bench.say("M24") + &bench.hear(1.0)).contains("// Print Suspended"));
    // Somebody moves the work, and the place of the job with it.
    bench.run(&["G10 L2 P1 X-50"]);
    let said = bench.say("resume");
    assert!(said.contains(&format!("error:{}\n", beyond('X', -20.0, 0.0))), "{said}");
    assert_eq!(bench.say("progress"), "Suspended\nok\n");
    assert!(bench.say("M114.2").contains("X:30.0000"));
    bench.run(&["G10 L2 P1 X0"]);
    let said = bench.say("resume") + &bench.hear(3.0);
    assert!(said.contains("Done printing file"), "{said}");
}

#[test]
fn the_configuration_overrides_what_follows_from_homing() {
    let plan = Plan::new(CARTESIAN).set("[soft endstop] x_min = -8").set("[soft endstop] x_max = 100");
    let mut bench = homed(plan.set("[soft endstop] z_max = 30"));
    bench.run(&["G90", "G1 X-8 F6000", "G1 X100", "G1 Y220", "G1 Z30", "M400"]);
    refused(&mut bench, "G1 X-9", &beyond('X', -9.0, -8.0));
    refused(&mut bench, "G1 X101", &beyond('X', 101.0, 100.0));
    refused(&mut bench, "G1 Y221", &beyond('Y', 221.0, 220.0));
    refused(&mut bench, "G1 Z31", &beyond('Z', 31.0, 30.0));
}

#[test]
fn without_them_moves_and_jogs_go_where_they_are_told() {
    let mut bench = homed(Plan::new(CARTESIAN).set("[soft endstop] enable = false"));
    bench.run(&["G90", "G1 X222 F9000", "$J -r X1", "M400"]);
    assert!((bench.carriage(Alpha) - 223.0).abs() < 0.02, "{}", bench.carriage(Alpha));
}

#[test]
fn m211_switches_them_and_says_where_travel_ends() {
    let ends = "Min: X0.000 Y0.000 Z0.000  Max: X220.000 Y220.000 Z200.000\nok\n";
    let mut bench = homed(Plan::new(CARTESIAN));
    assert_eq!(bench.say("M211"), format!("Soft endstops: On  {ends}"));
    assert_eq!(bench.say("M211 S0"), format!("Soft endstops: Off  {ends}"));
    bench.run(&["G90", "G1 X225 F9000", "M400"]);
    assert_eq!(bench.say("M211 S1"), format!("Soft endstops: On  {ends}"));
    refused(&mut bench, "G1 X226", &beyond('X', 226.0, 220.0));
    bench.run(&["G1 X200"]);
    let mut off = Plan::new(CARTESIAN).set("[soft endstop] enable = false").start();
    assert!(off.say("M211").starts_with("Soft endstops: Off"));
}

#[test]
fn correcting_where_an_axis_homes_moves_its_end_at_once() {
    let mut bench = homed(Plan::new(CARTESIAN));
    bench.run(&["G90", "G1 X10 F6000", "M400"]);
    refused(&mut bench, "G1 X-3", &beyond('X', -3.0, 0.0));
    bench.say("M206 X-4");
    bench.run(&["G1 X-1", "M400"]);
}

#[test]
fn a_jog_is_cut_and_one_from_the_end_is_refused_without_a_halt() {
    let mut bench = homed(Plan::new(CARTESIAN).set("[soft endstop] halt = true"));
    bench.run(&["G90", "G1 X210 F6000", "M400", "$J -r X50", "M400"]);
    assert!((bench.carriage(Alpha) - 220.0).abs() < 0.02, "{}", bench.carriage(Alpha));
    refused(&mut bench, "$J -r X50", &beyond('X', 270.0, 220.0));
}

#[test]
fn a_halt_where_it_is_asked_for() {
    let mut bench = homed(Plan::new(CARTESIAN).set("[soft endstop] halt = true"));
    bench.run(&["M104 S60", "G90", "G1 X50 F3000", "M400"]);
    let said = bench.say("G1 X300") + &bench.hear(0.5);
    assert!(said.starts_with(&format!("Error: {}\n", beyond('X', 300.0, 220.0))), "{said}");
    assert!(said.contains("Entering Alarm/Halt state"), "{said}");
    bench.assert_safe();
    bench.say("M999");
    assert!((bench.carriage(Alpha) - 50.0).abs() < 0.02, "{}", bench.carriage(Alpha));
}

#[test]
fn in_grbl_mode_it_is_an_alarm_as_in_grbl_unless_the_file_says_otherwise() {
    let grbl = || Plan::new(CARTESIAN).with("grbl_mode = false", "grbl_mode = true");
    let mut bench = grbl().start();
    assert_eq!(bench.say("$H"), "ok\n");
    let said = bench.say("G0 X300") + &bench.hear(0.5);
    let answer = format!("ALARM:2\n[MSG:{}]\nerror:33\n", beyond('X', 300.0, 220.0));
    assert!(said.ends_with(&answer), "{said}");
    assert!(bench.status().contains("<Alarm|"));
    assert!(bench.say("G0 X10").ends_with("error:9\n"));
    bench.say("$X");
    bench.hear(1.0);
    bench.run(&["G0 X10"]);
    let mut bench = grbl().set("[soft endstop] halt = false").start();
    bench.run(&["$H", "G90"]);
    assert_eq!(bench.say("G0 X300"), format!("[MSG:{}]\nerror:33\n", beyond('X', 300.0, 220.0)));
}

#[test]
fn of_a_delta_the_top_is_held_and_what_the_file_says() {
    let mut bench = homed(Plan::new(DELTA).set("[soft endstop] x_max = 40").set("[soft endstop] z_min = -0.5"));
    bench.run(&["G90", "G1 Z100 F6000", "G1 X40 Y-60", "M400"]);
    refused(&mut bench, "G1 X41", &beyond('X', 41.0, 40.0));
    refused(&mut bench, "G1 X0 Y0 Z260", &beyond('Z', 260.0, 250.0));
    bench.run(&["G1 X0 Y0 Z0"]);
    refused(&mut bench, "G1 Z-1", &beyond('Z', -1.0, -0.5));
}

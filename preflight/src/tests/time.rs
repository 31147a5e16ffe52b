//! Time of a file, against closed forms for trapezoids, and the limits that cost it.

use super::{Desk, Kind, assert_near, look, places};
use crate::{Limit, TOLD_LINES, Told};
use motion::Motion;
use units::Axis;

/// Returns the time of one standstill of the sample printer, seconds.
fn settling() -> f64 {
    Desk::new().preflight("", |_, motion| Motion::settling(motion.config().expect("a machine")))
}

#[test]
fn a_move_from_rest_to_rest_takes_its_trapezoid() {
    let (_, totals) = look("G28\nG1 X100 F6000\n");
    // At 100 mm/s and 2000 mm/s2: two ramps of 50 ms, 2.5 mm each, and the rest at even speed.
    assert_near(totals.ramp_seconds, 0.1);
    assert_near(totals.even_seconds, 0.95);
    assert_near(totals.waiting_seconds, settling());
}

#[test]
fn an_override_counts_for_the_moves_behind_it() {
    let (_, totals) = look("G28\nG1 X95 F6000\nM220 S50\nG1 X0\n");
    let even = |speed: f64| (95.0 - speed * speed / 2_000.0) / speed;
    assert_near(totals.even_seconds, even(100.0) + even(50.0));
}

#[test]
fn dwells_count_in_full() {
    let (_, totals) = look("G4 P500\nG4 S2\nG4 P250 S1\n");
    assert_near(totals.waiting_seconds, 3.75);
    assert_near(totals.seconds(), 3.75);
}

#[test]
fn a_standstill_costs_time_only_behind_moves() {
    let (_, once) = look("G28\nG1 X10 F6000\nM400\nM400\nM400\n");
    assert_near(once.waiting_seconds, settling());
    let (_, twice) = look("G28\nG1 X10 F6000\nM400\nG1 X20\n");
    assert_near(twice.waiting_seconds, 2.0 * settling());
}

#[test]
fn homing_takes_its_ways_at_the_speeds_of_the_switches() {
    // Twice 5 mm at 10 mm/s, X and Y together; twice 2 mm at 2 mm/s for Z.
    assert_near(look("G28\n").1.homing_seconds, 1.0 + 2.0);
    // From X100: 100 mm at 50 mm/s first.
    assert_near(look("G28\nG1 X100 Y50 F6000\nG28 X Y\n").1.homing_seconds, 3.0 + 2.0 + 1.0);
    assert_near(look("G28 Z\n").1.homing_seconds, 2.0);
}

#[test]
fn a_speed_above_an_axis_limit_is_that_limits_cost_and_said_once() {
    let (found, totals) = look("G28\nG1 Z30 F6000\nG1 Z0\n");
    assert_eq!(places(&found), [(2, Kind::Speed)]);
    let z = totals.limits[Limit::AxisSpeed(Axis::Z).index()];
    // Z accelerates with 200 mm/s2: 15 mm/s are reached, 100 mm/s are not.
    let given = 30.0 / 15.0 + 15.0 / 200.0;
    let asked = 2.0 * (30.0_f64 / 200.0).sqrt();
    assert_near(z, 2.0 * (given - asked));
    assert_near(totals.lost_seconds(), z);
}

#[test]
fn rapids_ask_for_no_speed_unless_the_file_names_one() {
    assert!(look("G28\nG0 Z20\n").0.is_empty());
    assert_eq!(places(&look("G28\nG0 Z20 F6000\n").0), [(2, Kind::Speed)]);
}

#[test]
fn an_acceleration_that_a_code_asks_for_is_held_against_the_motors() {
    assert!(look("G28\nM204 S3000\nG1 X50 F6000\n").0.is_empty());
    let (found, totals) = look("G28\nM204 S6000\nG1 X50 F6000\n");
    assert_eq!(places(&found), [(3, Kind::Acceleration)]);
    let alpha = totals.limits[12];
    // Ramps of 100 mm/s at 3000 mm/s2 instead of 6000 mm/s2, once each.
    assert_near(alpha, 100.0 / 3_000.0 - 100.0 / 6_000.0);
}

#[test]
fn findings_of_speed_name_what_is_limited() {
    let said =
        |text: &str| look(&format!("G28\nM104 S200\n{text}\n")).0.iter().map(|f| f.what.as_str().to_owned()).collect();
    let said: [Vec<String>; 4] = [
        said("G1 Z20 F6000"),
        said("M203 X500\nG1 X50 F24000"),
        said("M203 P20\nG1 X50 Y50 F6000"),
        said("G1 E10 F90000"),
    ];
    for (said, words) in said.iter().zip(["Z is asked", "motor alpha is asked", "the path is asked", "A is asked"]) {
        assert!(said.len() == 1 && said[0].starts_with(words), "{said:?}, not {words}");
    }
}

#[test]
fn of_two_limits_on_a_slope_the_stricter_one_costs() {
    // 60 mm along X and 80 mm along Z: the path may have 500 mm/s by X, and 18.75 mm/s by Z.
    let (found, totals) = look("G28\nG1 X60 Z80 F60000\n");
    assert_eq!(places(&found), [(2, Kind::Speed), (2, Kind::Speed)]);
    assert!(totals.limits[Limit::AxisSpeed(Axis::Z).index()] > 0.01, "{:?}", totals.limits);
    assert_eq!(totals.limits[Limit::AxisSpeed(Axis::X).index()], 0.0);
}

#[test]
fn an_axis_that_stands_limits_nothing_wherever_it_is() {
    let (found, totals) = look("G28\nG1 X100 Z50 F600\nG1 X200 F60000\n");
    assert_eq!(places(&found), [(3, Kind::Speed)]);
    assert!(totals.limits[Limit::AxisSpeed(Axis::X).index()] > 0.0, "{:?}", totals.limits);
    assert_eq!(totals.limits[Limit::AxisSpeed(Axis::Z).index()], 0.0);
}

#[test]
fn a_full_circle_meets_the_limits_of_its_axes_though_it_ends_where_it_began() {
    let (found, totals) = look("G28\nM203 X20 Y20\nG1 X60 Y60 F600\nG2 I20 F6000\n");
    assert!(places(&found).contains(&(4, Kind::Speed)), "{found:?}");
    assert!(totals.lost_seconds() > 1.0, "{:?}", totals.limits);
}

#[test]
fn a_limit_of_flow_costs_the_moves_that_feed() {
    let text = "G28\nM200 D1.75\nM203 V5\nM104 S200\nG91\nG1 X10 E20 F3000\nG1 X30 F3000\n";
    let (found, totals) = look(text);
    assert_eq!(places(&found), [(6, Kind::Speed)]);
    assert!(found[0].what.as_str().ends_with("limited to 5.0 mm3/s"), "{}", found[0].what.as_str());
    let flow = totals.limits[Limit::Flow.index()];
    assert!(flow > 1.0 && (totals.lost_seconds() - flow).abs() < 1e-3, "{:?}", totals.limits);
    // Filament alone, and filament that is drawn back, is no flow.
    assert_eq!(look("G28\nM200 D1.75\nM203 V5\nM104 S200\nG91\nG1 X10 E-9 F3000\n").1.limits[Limit::Flow.index()], 0.0);
}

fn told(text: &str) -> Vec<String> {
    let mut desk = Desk::new();
    let (_, totals) = desk.read(text);
    (0..=TOLD_LINES).map(|line| Told { config: &desk.config, totals: &totals, line }.to_string()).collect()
}

#[test]
fn totals_are_told_without_lines_that_would_say_nothing() {
    let nothing = String::new();
    let of_dwell = told("G4 S90\n");
    assert_eq!(of_dwell[0], "1 lines: 0 stop the job, 0 warnings\n");
    assert!(of_dwell[1].contains("(moving 0.0 s, 0 % of it changing speed; waiting 90.0 s; homing about 0.0 s)\n"));
    assert_eq!(of_dwell[4], "filament: 0.0 mm, path: 0.0 mm and 0.0 mm without\n");
    for line in [2, 3, 5, 6] {
        assert_eq!(of_dwell[line], nothing, "line {line}");
    }
}

#[test]
fn the_costliest_limit_is_told_first() {
    let told = told("G28\nM203 P20\nG1 X200 F6000\nM203 P500\nG1 Z30 F6000\n");
    let (path, z) = (told[3].find(": max_speed").expect(&told[3]), told[3].find(", z_axis_max_speed").expect(&told[3]));
    assert!(told[3].starts_with("limits cost ") && path < z, "{}", told[3]);
}

//! Temperatures and outputs of a file.

use super::{Desk, Kind, look, places};
use crate::{Told, Totals};

#[test]
fn a_target_above_the_maximum_stops_the_job_and_the_rest_of_its_line() {
    let (found, totals) = look("G28\nM104 S291 G1 X10 F600\n");
    assert_eq!(places(&found), [(2, Kind::TooHot)]);
    assert_eq!(totals.travelled, 0.0);
    assert!(look("G28\nM104 S290\nM140 S120\n").0.is_empty());
}

#[test]
fn a_maximum_that_the_file_lowers_counts_from_there() {
    let (found, _) = look("M104 S250\nM143 S0 P240\nM104 S250\n");
    assert_eq!(places(&found), [(3, Kind::TooHot)]);
}

#[test]
fn waits_for_heat_are_counted_with_the_highest_of_each_heater() {
    let (found, totals) = look("M109 S200\nM109 S215\nM190 S60\nM109 S190\nM104 S220\n");
    assert!(found.is_empty(), "{found:?}");
    assert_eq!(totals.heat_waits, 4);
    let desk = Desk::new();
    let of = |name: &str| {
        let (heater, _) = desk.config.heaters().find(|(_, heater)| heater.name == name).expect("a heater");
        let (times, most) = totals.heats[heater.index()];
        (times, most.0)
    };
    assert_eq!((of("hotend"), of("bed")), ((3, 215.0), (1, 60.0)));
}

#[test]
fn waits_are_told_with_the_names_of_the_heaters() {
    let mut desk = Desk::new();
    let told = |desk: &Desk, totals: &Totals| Told { config: &desk.config, totals, line: 2 }.to_string();
    let (_, totals) = desk.read("M109 S200\n");
    assert_eq!(told(&desk, &totals), "heating, whose time is not foreseen: 1 wait: hotend 1x, up to 200 C\n");
    let (_, totals) = desk.read("M109 S200\nM190 S60\nM116\n");
    let both = "heating, whose time is not foreseen: 3 waits: bed 1x, up to 60 C, hotend 1x, up to 200 C\n";
    assert_eq!(told(&desk, &totals), both);
}

#[test]
fn cold_filament_is_a_warning_said_once_and_a_stop_under_a_guard() {
    let (found, totals) = look("G28\nM83\nG1 X10 E1 F600\nG1 X20 E1\n");
    assert_eq!(places(&found), [(3, Kind::Cold)]);
    assert_eq!(totals.stops, 0);
    let guarded = &[(
        "hotend.enable = true\nhotend.tool_id = 0  ",
        "hotend.min_extrude_temp = 170\nhotend.enable = true\nhotend.tool_id = 0  ",
    )];
    let (found, totals) = Desk::with(guarded).read("G28\nM83\nG1 X10 E1 F600\n");
    assert_eq!(places(&found), [(3, Kind::TooCold)]);
    assert_eq!(totals.stops, 1);
}

#[test]
fn filament_that_is_drawn_back_needs_no_heat() {
    assert!(look("G28\nM83\nG1 E-3 F600\nG1 X10\n").0.is_empty());
}

#[test]
fn a_heater_that_is_switched_off_again_is_cold() {
    let (found, _) = look("G28\nM83\nM104 S200\nG1 E1 F600\nM104 S0\nG1 E1\n");
    assert_eq!(places(&found), [(6, Kind::Cold)]);
}

#[test]
fn unknown_m_codes_are_passed_over_five_times_in_words_and_unknown_g_codes_stop() {
    let (found, totals) = look(&"M9999\n".repeat(7));
    assert_eq!((found.len(), totals.warnings, totals.stops), (5, 7, 0));
    let (found, totals) = look("G777\n");
    assert_eq!((places(&found), totals.stops), (vec![(1, Kind::Unknown)], 1));
}

#[test]
fn a_halt_in_the_file_is_not_hidden() {
    let (found, _) = look("G28\nM112\nG1 X10 F600\n");
    assert_eq!(places(&found), [(2, Kind::Unforeseen)]);
    assert!(found[0].what.as_str().contains("M112"));
}

#[test]
fn a_result_that_only_the_job_has_is_said_once() {
    let probe = "[zprobe]\nenable = true\nprobe_pin = PB10\n\n[voltage monitor]";
    let mut desk = Desk::with(&[("[voltage monitor]", probe)]);
    let (found, _) = desk.read("G28\nG38.2 Z-1 F100\nG38.2 Z-2\n");
    assert_eq!(places(&found), [(2, Kind::Unforeseen)], "{found:?}");
}

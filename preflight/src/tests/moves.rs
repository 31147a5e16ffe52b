//! Moves: the travel, homing before them, and the path of a file.

use super::{Desk, Kind, assert_near, look, places};
use crate::Severity;
use units::Axis;

#[test]
fn a_homed_axis_ends_where_its_travel_does() {
    for (target, is_out) in [("X220", false), ("X220.1", true), ("Y-0.1", true), ("Z200", false), ("Z201", true)] {
        let (found, totals) = look(&format!("G28\nG1 {target} F600"));
        assert_eq!(found.iter().any(|finding| finding.kind == Kind::OutOfTravel), is_out, "{target}: {found:?}");
        assert_eq!(totals.stops, u32::from(is_out), "{target}");
    }
}

#[test]
fn an_axis_that_is_not_homed_has_no_ends_which_is_said_once() {
    let (found, totals) = look("G28 X\nG1 Y500 F6000\nG1 Y-900\nG1 X300");
    assert_eq!(places(&found), [(2, Kind::NotHomed), (4, Kind::OutOfTravel)]);
    assert_eq!((totals.warnings, totals.stops), (1, 1));
}

#[test]
fn moves_before_homing_are_refused_where_the_configuration_says_so() {
    let mut desk = Desk::with(&[("must_be_homed = false", "must_be_homed = true")]);
    let (found, totals) = desk.read("G1 X10 F600\nG1 E1\nG28\nG1 X10");
    let of_moves: Vec<_> = places(&found).into_iter().filter(|(_, kind)| *kind != Kind::Cold).collect();
    assert_eq!(of_moves, [(1, Kind::MustHome)], "filament alone may move");
    assert_near(totals.travelled, 10.0);
}

#[test]
fn of_many_moves_out_of_travel_five_are_said_and_all_are_counted() {
    let (found, totals) = look(&format!("G28\n{}", "G1 X500 F6000\n".repeat(8)));
    assert_eq!(found.len(), 5);
    assert_eq!(totals.stops, 8);
}

#[test]
fn a_refused_move_leaves_the_place_as_it_was() {
    let (found, totals) = look("G28\nG91\nG1 X200 F6000\nG1 X50\nG1 X15\nG1 X10");
    assert_eq!(places(&found), [(4, Kind::OutOfTravel), (6, Kind::OutOfTravel)], "X215 is within, X225 is not");
    assert_near(totals.travelled, 215.0);
}

#[test]
fn paths_with_and_without_filament_are_summed_apart() {
    let (_, totals) = look("G28\nM104 S200\nM83\nG0 X30 Y40\nG1 X60 E2 F1200\nG1 E-1\nG1 X60 Y90 E3");
    assert_near(totals.travelled, 50.0);
    assert_near(totals.printed, 80.0);
    assert_near(totals.filament, 4.0);
    let [least, most] = totals.extents.expect("a part");
    let ends = [Axis::X, Axis::Y].map(|axis| (least[axis], most[axis]));
    assert_eq!(ends, [(30.0, 60.0), (40.0, 90.0)], "the way there is no part");
}

#[test]
fn a_file_without_filament_has_no_extents() {
    assert_eq!(look("G28\nG1 X50 F6000\n").1.extents, None);
}

#[test]
fn g92_moves_the_ends_of_a_program_and_g28_takes_them_back() {
    let (found, _) = look("G28\nG1 X100 F6000\nG92 X0\nG1 X150\nG1 X-90\n");
    assert_eq!(places(&found), [(4, Kind::OutOfTravel)], "machine X250, then X10");
}

#[test]
fn an_axis_whose_homing_is_forgotten_has_no_ends() {
    let (found, _) = look("G28\nG28.5\nG1 X500 F6000\n");
    assert_eq!(places(&found), [(3, Kind::NotHomed)]);
}

#[test]
fn each_way_to_lose_a_job_stops_it() {
    let kinds = [
        Kind::OutOfTravel,
        Kind::Unreachable,
        Kind::MustHome,
        Kind::Halts,
        Kind::NotHomed,
        Kind::PassedOver,
        Kind::Cold,
        Kind::TooCold,
        Kind::Speed,
        Kind::Unforeseen,
    ];
    let spoils: Vec<Kind> = kinds.into_iter().filter(|kind| kind.spoils_the_job().is_some()).collect();
    assert_eq!(spoils, kinds[..4]);
    assert!(spoils.iter().all(|kind| kind.severity() == Severity::Stop));
    let stops: Vec<Kind> = kinds.into_iter().filter(|kind| kind.severity() == Severity::Stop).collect();
    assert_eq!(stops, [&kinds[..4], &[Kind::TooCold]].concat());
}

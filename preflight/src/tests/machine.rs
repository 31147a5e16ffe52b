//! The machine that a file is read for: as it was switched on, as it has been set up, as it is.

use base::safety::travel::Travel;
use base::taken_codes::TakenCodes;
use motion::GridShape;
use program::{Dialect, Place};
use units::{AxisSet, Celsius, MAX_HEATERS};

use super::{Desk, Found, Kind, Listener, places};
use crate::turns::run_to_end;
use crate::{AsItIs, read};

#[test]
fn saved_settings_count_and_are_no_part_of_the_file() {
    let found = Desk::new().preflight("", |preflight, motion| {
        let mut found = Found::default();
        let loads = preflight.load_settings(b"M206 X-50\nM143 S0 P230\nG1 X5 F600\n", motion, &mut found);
        assert_eq!((loads, preflight.totals().lines), (None, 0));
        assert!(found.0.iter().all(|finding| finding.kind == Kind::NotHomed));
        let mut found = Found::default();
        read(preflight, b"G28\nM104 S240\n", &|_| None, motion, &mut found).unwrap();
        assert_eq!(preflight.totals().lines, 2);
        found
    });
    assert_eq!(places(&found.0), [(2, Kind::TooHot)]);
}

#[test]
fn saved_settings_say_which_line_loads_a_mesh() {
    Desk::new().preflight("", |preflight, motion| {
        let loads = preflight.load_settings(b"M204 S900\nM375 P\"bed\"\nM375\n", motion, &mut Found::default());
        assert_eq!(loads, Some(2));
    });
}

/// Mesh of three by three points, 100 mm apart.
const MESH: GridShape = GridShape { origin: [0.0; 2], step: [100.0; 2], count: [3, 3] };

#[test]
fn a_mesh_without_a_name_needs_the_configured_grid() {
    let load = |desk: &mut Desk, shape: &GridShape, has_a_name| {
        desk.preflight("", |preflight, motion| preflight.load_mesh(shape, &[0.1; 9], has_a_name, motion))
    };
    let mut bare = Desk::new();
    assert_eq!(load(&mut bare, &MESH, true), Ok(()));
    assert!(load(&mut bare, &MESH, false).unwrap_err().as_str().contains("no grid is configured"));
    let grid = "[zprobe]\nleveling = cartesian grid\n[cartesian grid leveling strategy]\nx_size = 200\ny_size = 200\ngrid_x_size = 3\ngrid_y_size = 3\n\n";
    let mut with_grid = Desk::with(&[("[voltage monitor]", &format!("{grid}[voltage monitor]"))]);
    assert_eq!(load(&mut with_grid, &MESH, false), Ok(()));
    let shorter = GridShape { step: [90.0; 2], ..MESH };
    assert!(load(&mut with_grid, &shorter, false).unwrap_err().as_str().contains("180.000"));
    let finer = GridShape { count: [5, 5], ..MESH };
    assert!(load(&mut with_grid, &finer, false).unwrap_err().as_str().starts_with("it has 5 x 5 points"));
}

#[test]
fn a_mesh_keeps_the_coordinates_of_the_tool() {
    Desk::new().preflight("", |preflight, motion| {
        let before = motion.commanded_position();
        preflight.load_mesh(&MESH, &[0.5; 9], true, motion).unwrap();
        assert_eq!(motion.commanded_position(), before);
    });
}

/// Begins a file for the machine at work after `told`, and reads it.
fn beginning(told: &str, goes_on: bool, text: &str) -> Found {
    let mut at_work = Desk::new();
    at_work.preflight("", |preflight, motion| {
        for line in told.lines() {
            let places = (Place::default(), Place::default());
            run_to_end(preflight.line(line.as_bytes(), places, motion, &mut Found::default()));
        }
    });
    let program = at_work.program.take().unwrap();
    let mut desk = Desk::new();
    let (tuning, travel) = (base::tuning::Tuning::new(&at_work.config), Travel::default());
    let (targets, most_celsius) = ([Celsius(0.0); MAX_HEATERS], [Celsius(300.0); MAX_HEATERS]);
    let machine = AsItIs {
        program: &program,
        tuning: &tuning,
        travel: &travel,
        homed: AxisSet::PRIMARY,
        targets,
        most_celsius,
        dialect: None,
        taken: TakenCodes::None,
        goes_on,
    };
    let mut found = Found::default();
    desk.preflight("", |preflight, motion| {
        preflight.begin(&machine);
        read(preflight, text.as_bytes(), &|_| None, motion, &mut found).unwrap();
    });
    found
}

#[test]
fn a_file_begins_with_the_modes_and_homing_of_the_machine() {
    assert_eq!(places(&beginning("G91\n", false, "G1 X150 F6000\nG1 X150\n").0), [(2, Kind::OutOfTravel)]);
    assert!(beginning("G90\n", false, "G1 X150 F6000\nG1 X150\n").0.is_empty());
}

#[test]
fn open_loops_of_the_program_go_on_only_in_its_own_file() {
    let told = "O7 if [1]\n";
    assert!(beginning(told, true, "O7 endif\nG4 P1\n").0.is_empty());
    assert_eq!(places(&beginning(told, false, "O7 endif\n").0), [(1, Kind::Flow)]);
}

#[test]
fn the_configuration_may_force_a_dialect() {
    let dialect = |desk: &mut Desk, own| {
        desk.preflight("", |preflight, _| {
            preflight.read_as(own);
            preflight.dialect
        })
    };
    let mut free = Desk::new();
    assert_eq!(dialect(&mut free, Some(Dialect::Marlin)), Dialect::Marlin);
    assert_eq!(dialect(&mut free, None), Dialect::Smoothie);
    let mut forced = Desk::with(&[("[player]\n", "[player]\ndialect = klipper\n")]);
    assert_eq!(dialect(&mut forced, Some(Dialect::Marlin)), Dialect::Klipper);
}

#[test]
fn who_only_listens_is_told_of_no_homing() {
    struct Nothing;
    impl Listener for Nothing {
        fn found(&mut self, finding: &crate::Finding) {
            assert_ne!(finding.kind, Kind::NotHomed);
        }
    }
    let mut desk = Desk::new();
    desk.hear("", &mut Nothing);
    let program = desk.program.take().unwrap();
    desk.preflight("", |preflight, motion| {
        preflight.only_listens(program, Dialect::Grbl);
        read(preflight, b"G1 X10 F600\n", &|_| None, motion, &mut Nothing).unwrap();
        assert_eq!(preflight.dialect, Dialect::Grbl);
    });
}

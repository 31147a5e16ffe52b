//! Whether E is a place or a distance: which of G90, G91, M82 and M83 says so in which dialect, at consoles,
//! in files, and in the scripts of the configuration. The page is docs/dialects.md, "E: places or distances".

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Delta, Gamma};

/// Codes, and for each dialect whether E is a place (P) or a distance (D) behind them.
type Row = (&'static [&'static str], [(&'static str, char); 4]);

const TABLE: [Row; 10] = {
    const fn row(smoothie: char, marlin: char, rrf: char, klipper: char) -> [(&'static str, char); 4] {
        [("smoothie", smoothie), ("marlin", marlin), ("reprapfirmware", rrf), ("klipper", klipper)]
    }
    [
        (&["G90", "M82"], row('P', 'P', 'P', 'P')),
        (&["G90", "M83"], row('D', 'D', 'D', 'D')),
        (&["M82", "G90"], row('P', 'P', 'P', 'P')),
        (&["M83", "G90"], row('P', 'P', 'D', 'D')),
        (&["M82", "G91"], row('D', 'D', 'P', 'D')),
        (&["M83", "G91"], row('D', 'D', 'D', 'D')),
        (&["G91", "M82"], row('P', 'P', 'P', 'D')),
        (&["G91", "M83"], row('D', 'D', 'D', 'D')),
        (&["M82", "G91", "G90"], row('P', 'P', 'P', 'P')),
        (&["M83", "G91", "G90"], row('P', 'P', 'D', 'D')),
    ]
};

/// Returns P or D, by how much filament `G1 E12` feeds when E is at 10.
fn kind_now(bench: &mut Bench) -> char {
    let before = bench.carriage(Delta);
    bench.run(&["G92 E10", "G1 E12 F3000", "M400"]);
    match (bench.carriage(Delta) - before).round() as i64 {
        2 => 'P',
        12 => 'D',
        other => panic!("fed {other} mm"),
    }
}

fn check_cell(bench: &mut Bench, dialect: &str, codes: &[&str], expected: char) {
    bench.run(&["G90", "M82"]);
    bench.run(codes);
    assert_eq!(kind_now(bench), expected, "{dialect}: {codes:?}");
}

#[test]
fn each_dialect_has_its_codes_for_the_extruder() {
    let mut bench = Plan::new(CARTESIAN).start();
    for (codes, cells) in TABLE {
        for (dialect, expected) in cells {
            bench.say(&format!("dialect {dialect}"));
            check_cell(&mut bench, dialect, codes, expected);
        }
    }
    // With grbl_mode every console speaks GRBL's dialect, which has no extruder modes: Smoothieware's apply.
    let mut bench = Plan::new(CARTESIAN).set("[general] grbl_mode = true").start();
    for (codes, cells) in TABLE {
        check_cell(&mut bench, "GRBL", codes, cells[0].1);
    }
}

/// A print that is done: 40 mm fed in places, then the usual end code.
const END_CODE: &str = "G90\nM82\nG92 E0\nG1 X50 E40 F3600\nG91\nG1 E-2 F2700\nG90\nG1 X10 F3600\n";

#[test]
fn an_end_code_draws_back_what_its_firmware_would() {
    for (flavour, expected) in [
        ("", 38.0),
        ("; gcode_flavor = smoothie\n", 38.0),
        (";FLAVOR:Marlin\n", 38.0),
        ("; gcode_flavor = klipper\n", 38.0),
        ("; gcode_flavor = reprapfirmware\n", -2.0),
    ] {
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", &format!("{flavour}{END_CODE}")).start();
        bench.type_in("play part.gcode -t\n");
        bench.hear_until("Done printing file", 60.0);
        bench.hear(0.5);
        assert!((bench.carriage(Delta) - expected).abs() < 0.01, "{flavour}{}", bench.carriage(Delta));
    }
}

/// Modes that a job may have left, and what it says itself of E.
const JOB_MODES: [&str; 4] = ["M82", "M83", "G91", "G20\nM82"];

#[test]
fn scripts_around_a_suspension_mean_the_same_in_every_mode_of_the_job() {
    for flavour in ["", "; gcode_flavor = reprapfirmware\n"] {
        for modes in JOB_MODES {
            let file = format!("{flavour}G92 E0\n{modes}\nG1 E1 F100\nM400\nM118 here\nG4 P300\nM600\nG4 P10\n");
            let plan = Plan::new(CARTESIAN)
                .set("[player] after_suspend_gcode = G1_E-5_F3000_G91_G1_Z5_F600")
                .set("[player] before_resume_gcode = G1_E5_F3000");
            let mut bench = plan.file("part.gcode", &file).start();
            bench.type_in("play part.gcode\n");
            bench.hear_until("here", 60.0);
            let (fed, height) = (bench.carriage(Delta), bench.carriage(Gamma));
            bench.hear_until("Print Suspended", 60.0);
            assert!((bench.carriage(Delta) - fed + 5.0).abs() < 0.01, "{modes}: {} {fed}", bench.carriage(Delta) - fed);
            assert!((bench.carriage(Gamma) - height - 5.0).abs() < 0.01, "{modes}");
            bench.type_in("resume\n");
            bench.hear_until("Resuming print", 60.0);
            bench.hear(1.0);
            assert!((bench.carriage(Delta) - fed).abs() < 0.01, "{modes}: {}", bench.carriage(Delta) - fed);
        }
    }
}

#[test]
fn a_script_leaves_the_modes_of_the_job() {
    // `[endstops] common.home_gcode` stands for G28, and works in places and inches for itself.
    let file = "; gcode_flavor = reprapfirmware\nG91\nM83\nG1 X2 E1 F600\nG28\nG1 X2 E1\nG1 X2 E1\nM400\n";
    let plan = Plan::new(CARTESIAN).set("[endstops] common.home_gcode = G28_G20_G90_M82_G1_X1_F300_M83");
    let mut bench = plan.file("part.gcode", file).start();
    bench.type_in("play part.gcode -t\n");
    bench.hear_until("Done printing file", 120.0);
    bench.hear(0.5);
    assert!((bench.carriage(Delta) - 3.0).abs() < 0.01, "{}", bench.carriage(Delta));
    let place = bench.say("M114");
    assert!(place.contains("X:29.4"), "{place}");
}

/// M121, or its like by name, brings E's mode back with the others.
#[test]
fn modes_that_come_back_bring_the_extruders() {
    for (dialect, keep, restore) in [
        ("smoothie", "M120", "M121"),
        ("reprapfirmware", "M120", "M121"),
        ("klipper", "SAVE_GCODE_STATE NAME=a", "RESTORE_GCODE_STATE NAME=a"),
    ] {
        let mut bench = Plan::new(CARTESIAN).start();
        bench.say(&format!("dialect {dialect}"));
        for (before, meanwhile, expected) in [("M82", "M83", 'P'), ("M83", "M82", 'D')] {
            check_cell(&mut bench, dialect, &["G90", before, keep, meanwhile, restore], expected);
        }
    }
}

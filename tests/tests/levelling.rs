//! Levelling and skew of whole machines: Z follows the bed, files of grids, what positions say, saving.

use scenarios::{Bench, CARTESIAN, DELTA, Plan};
use units::Actuator;

/// The sample printer with a grid of 5 by 5 points on 100 by 80 mm.
fn printer() -> Plan {
    Plan::new(CARTESIAN)
        .set("[zprobe] leveling = cartesian grid")
        .set("[cartesian grid leveling strategy] x_size = 100")
        .set("[cartesian grid leveling strategy] y_size = 80")
        .set("[cartesian grid leveling strategy] grid_x_size = 5")
        .set("[cartesian grid leveling strategy] grid_y_size = 5")
}

/// Homed, with its bed 0.4 mm higher at X50 Y40.
fn with_a_hill(plan: Plan) -> Bench {
    let mut bench = plan.start();
    bench.run(&["G28", "M421 I2 J2 Z0.4"]);
    bench
}

fn near(value: f64, wanted: f64) {
    // A step of Z is 2.5 um.
    assert!((value - wanted).abs() < 0.002_6, "{value} is not {wanted}");
}

#[test]
fn z_follows_the_bed_and_coordinates_stay_the_programs() {
    let mut bench = with_a_hill(printer());
    for (x, y, height) in [(50, 40, 0.4), (0, 0, 0.0), (50, 0, 0.0), (100, 80, 0.0), (25, 40, 0.0), (50, 40, 0.4)] {
        bench.run(&[&format!("G1 X{x} Y{y} Z1 F6000"), "M400"]);
        near(bench.carriage(Actuator::Gamma), 1.0 + height);
    }
    let said = |bench: &mut Bench, line: &str| bench.say(line);
    assert!(said(&mut bench, "M114").starts_with("ok C: X:50.0000 Y:40.0000 Z:1.0000"));
    assert!(said(&mut bench, "M114.2").starts_with("ok MCS: X:50.0000 Y:40.0000 Z:1.0000"));
    assert!(said(&mut bench, "M114.3").starts_with("ok APOS: X:50.0000 Y:40.0000 Z:1.4000"));
    assert!(said(&mut bench, "M114.4").starts_with("ok MP: X:50.0000 Y:40.0000 Z:1.0000"));
    assert!(said(&mut bench, "M114.5").starts_with("ok CMP: X:50.0000 Y:40.0000 Z:1.4000"));
    let status = bench.status();
    assert!(
        status.contains("MPos:50.0000,40.0000,1.0000") && status.contains("WPos:50.0000,40.0000,1.0000"),
        "{status}"
    );
}

#[test]
fn a_work_offset_comes_before_levelling() {
    let mut bench = with_a_hill(printer());
    bench.run(&["G10 L2 P1 X50 Y40 Z2", "G1 X0 Y0 Z1 F6000", "M400"]);
    near(bench.carriage(Actuator::Gamma), 3.4);
    assert!(bench.say("M114").starts_with("ok C: X:0.0000 Y:0.0000 Z:1.0000"));
}

#[test]
fn when_a_levelling_comes_coordinates_stay_and_the_motors_follow() {
    let mut bench = with_a_hill(printer());
    bench.say("M370");
    bench.run(&["G1 X50 Y40 Z1 F6000", "M561 A0 B-0.01 C1 D0"]);
    near(bench.carriage(Actuator::Gamma), 1.4);
    assert!(bench.say("M114").starts_with("ok C: X:50.0000 Y:40.0000 Z:1.0000"));
}

/// On a high spot the tool would go down into the bed, and from set aside to back again ever higher.
#[test]
fn when_levelling_is_taken_off_the_tool_stays_where_it_stands() {
    for (off, on) in [("M370", ""), ("M420 S0", "M420 S1"), ("BED_MESH_CLEAR", ""), ("M561", "")] {
        for dip in [1.0, -1.0] {
            let mut bench = printer().start_homed();
            bench.run(&[&format!("M421 I2 J2 Z{}", 0.4 * dip), "G1 X50 Y40 Z1 F6000", "M400"]);
            let stands = 1.0 + 0.4 * dip;
            let edges = bench.world(|world| world.trace().total());
            bench.say(off);
            assert_eq!(bench.world(|world| world.trace().total()), edges, "{off}");
            assert!(bench.say("M114").contains(&format!("Z:{stands:.4}")), "{off}");
            if !on.is_empty() {
                bench.say(on);
                assert_eq!(bench.world(|world| world.trace().total()), edges, "{on}");
                assert!(bench.say("M114").contains("Z:1.0000"), "{on}");
                continue;
            }
            // Along the bed it stays as high, and the next Z is that of the motors.
            bench.run(&["G1 X60 F6000", "M400"]);
            near(bench.carriage(Actuator::Gamma), stands);
            bench.run(&["G1 Z2", "M400"]);
            near(bench.carriage(Actuator::Gamma), 2.0);
        }
    }
}

#[test]
fn a_machine_that_does_not_know_its_place_does_not_move_when_levelling_changes() {
    let mut bench = printer().start();
    let edges = bench.world(|world| world.trace().total());
    bench.run(&["G92.4 X50 Y40 Z1", "M421 I2 J2 Z0.4"]);
    assert!(bench.say("M852 I0.01").contains("XY 0.01000000"));
    assert_eq!(bench.world(|world| world.trace().total()), edges);
    assert!(bench.say("M114").starts_with("ok C: X:50.0000 Y:40.0000 Z:1.0000"));
}

#[test]
fn a_switch_is_at_a_place_of_the_motors() {
    let mut bench = with_a_hill(printer());
    bench.run(&["G1 X50 Y40 Z1 F6000", "G28 Z", "M400"]);
    near(bench.carriage(Actuator::Gamma), 0.0);
    assert!(bench.say("M114").starts_with("ok C: X:50.0000 Y:40.0000 Z:-0.4000"));
    bench.run(&["G28", "M400"]);
    near(bench.carriage(Actuator::Gamma), 0.0);
    assert!(bench.say("M114").starts_with("ok C: X:0.0000 Y:0.0000 Z:0.0000"), "where the bed is at its height");
}

#[test]
fn correction_fades_with_height() {
    let plan = printer()
        .set("[cartesian grid leveling strategy] dampening_start = 1")
        .set("[cartesian grid leveling strategy] height_limit = 5");
    let mut bench = with_a_hill(plan);
    for (z, raised) in [(0.5, 0.4), (1.0, 0.4), (3.0, 0.2), (5.0, 0.0), (8.0, 0.0)] {
        bench.run(&[&format!("G1 X50 Y40 Z{z} F6000"), "M400"]);
        near(bench.carriage(Actuator::Gamma), z + raised);
    }
    let steep = printer()
        .set("[cartesian grid leveling strategy] dampening_start = 1")
        .set("[cartesian grid leveling strategy] height_limit = 2")
        .start()
        .say("M421 I2 J2 Z0.4");
    assert_eq!(steep, "error:with heights as great as these, fading must take at least 1.6 mm\n");
}

/// Fade target as in Klipper's `fade_target`.
#[test]
fn what_fades_is_the_difference_from_the_target() {
    let plan = printer()
        .set("[cartesian grid leveling strategy] dampening_start = 1")
        .set("[cartesian grid leveling strategy] height_limit = 6")
        .set("[cartesian grid leveling strategy] fade_target = 0.1");
    let mut bench = with_a_hill(plan);
    let raised = |bench: &mut Bench, x: f64, z: f64| {
        bench.run(&[&format!("G1 X{x} Y40 Z{z} F6000"), "M400"]);
        assert!(bench.say("M114").contains(&format!("Z:{z:.4}")), "and it knows where it is");
        bench.carriage(Actuator::Gamma) - z
    };
    for (z, on_the_hill, beside) in [(1.0, 0.4, 0.0), (3.5, 0.25, 0.05), (6.0, 0.1, 0.1), (9.0, 0.1, 0.1)] {
        near(raised(&mut bench, 50.0, z), on_the_hill);
        near(raised(&mut bench, 0.0, z), beside);
    }
    assert_eq!(bench.say("M376 T0.2"), "the mesh fades from Z1.00 to Z6.00, where 0.200 mm are left\nok\n");
    near(raised(&mut bench, 0.0, 6.0), 0.2);
    assert_eq!(bench.say("M376 H10"), "the mesh fades from Z0.00 to Z10.00, where 0.200 mm are left\nok\n");
    near(raised(&mut bench, 0.0, 5.0), 0.1);
    let saved = bench.say("M503");
    assert!(saved.contains("M376 T0.20000") && saved.contains("M376 H10"), "{saved}");
}

#[test]
fn a_grid_is_saved_and_loaded_as_smoothieware_writes_it() {
    let mut bench = with_a_hill(printer());
    assert_eq!(bench.say("M374"), "grid saved to /sd/cartesian.grid\nok\n");
    let bytes = bench.read_card_bytes("cartesian.grid").expect("it was saved");
    let mut expected = vec![5];
    expected.extend(100.0_f32.to_le_bytes());
    expected.extend(80.0_f32.to_le_bytes());
    expected.extend((0..25).flat_map(|index| if index == 12 { 0.4_f32 } else { 0.0 }.to_le_bytes()));
    assert_eq!(bytes, expected);
    bench.say("M370");
    bench.run(&["G1 X50 Y40 Z1 F6000", "M400"]);
    assert_eq!(bench.say("M375.1"), "error:no grid levels the machine: load one with M375\n");
    assert_eq!(bench.say("M375"), "grid loaded, 5 x 5 points on 100.000 x 80.000 mm\nok\n");
    near(bench.carriage(Actuator::Gamma), 1.4);
    let shown = bench.say("M375.1");
    assert!(shown.contains(" 0.0000  0.0000  0.4000  0.0000  0.0000 \n"), "{shown}");
    assert!(shown.ends_with("Maximum delta: 0.4000\nok\n"));
    assert_eq!(bench.say("M374.1"), "/sd/cartesian.grid deleted\nok\n");
    assert_eq!(bench.say("M375"), "error:/sd/cartesian.grid: no such file\n");
    near(bench.carriage(Actuator::Gamma), 1.4);
}

#[test]
fn a_file_that_is_no_grid_of_this_machine_is_refused_with_the_reason() {
    let mut bench = with_a_hill(printer());
    bench.say("M374");
    let good = bench.read_card_bytes("cartesian.grid").expect("it was saved");
    let changed = |at: usize, bytes: &[u8]| {
        let mut file = good.clone();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    let cases: [(Vec<u8>, &str); 8] = [
        (Vec::new(), "the file is too short to be a grid"),
        (good[..60].to_vec(), "the file has 60 bytes, such a grid has 109: save it again"),
        ([&good[..], &[0]].concat(), "the file has 110 bytes, such a grid has 109: save it again"),
        (changed(0, &[7]), "the file has 7 points along X, the configuration 5"),
        (changed(1, &90.0_f32.to_le_bytes()), "x_size in the file is 90.000 mm, in the configuration 100.000"),
        (changed(5, &f32::NAN.to_le_bytes()), "y_size in the file is NaN mm, in the configuration 80.000"),
        (changed(9 + 4 * 3, &f32::NAN.to_le_bytes()), "the height of point 4 is not a number"),
        (changed(9 + 4 * 3, &20.0_f32.to_le_bytes()), "the bed rises by more than 25 % between point 4 and the one"),
    ];
    for (file, reason) in cases {
        bench.write_card("cartesian.grid", &file);
        let said = bench.say("M375");
        assert!(said.starts_with(&format!("error:/sd/cartesian.grid: {reason}")), "{said}, {reason}");
    }
    bench.run(&["G1 X50 Y40 Z1 F6000", "M400"]);
    near(bench.carriage(Actuator::Gamma), 1.4);
}

#[test]
fn a_delta_is_levelled_and_another_radius_is_told() {
    let plan = Plan::new(DELTA).set("[zprobe] leveling = delta grid").set("[delta grid leveling strategy] radius = 60");
    let mut bench = plan.start();
    bench.run(&["G28", "M421 I3 J3 Z0.4"]);
    assert_eq!(bench.say("M374"), "grid saved to /sd/delta.grid\nok\n");
    let mut bytes = bench.read_card_bytes("delta.grid").expect("it was saved");
    assert_eq!((bytes.len(), bytes[0]), (1 + 4 + 4 * 49, 7));
    bytes[1..5].copy_from_slice(&50.0_f32.to_le_bytes());
    bench.write_card("delta.grid", &bytes);
    let said = bench.say("M375");
    assert!(said.contains("// WARNING: the grid's radius is 50.000 mm, not the configured one\n"), "{said}");
    bench.run(&["G1 X0 Y0 Z20 F6000", "M400"]);
    assert!(bench.say("M114.5").contains("Z:20.4000"));
    let raised = [Actuator::Alpha, Actuator::Beta, Actuator::Gamma].map(|tower| bench.carriage(tower));
    bench.say("M370");
    bench.run(&["M400"]);
    bench.run(&["G1 Z20", "M400"]);
    for (tower, before) in [Actuator::Alpha, Actuator::Beta, Actuator::Gamma].into_iter().zip(raised) {
        assert!((before - bench.carriage(tower) - 0.4).abs() < 0.02, "each tower is lower by the hill");
    }
}

#[test]
fn skew_moves_the_motors_and_not_the_coordinates() {
    let mut bench = printer().set("[skew correction] xy = 0.02").start();
    bench.run(&["G28", "G1 X50 Y50 F6000", "M400"]);
    assert!((bench.carriage(Actuator::Alpha) - 49.0).abs() < 0.02);
    assert!(bench.say("M114.5").contains("X:49.0000 Y:50.0000"));
    assert!(bench.say("M114").contains("X:50.0000 Y:50.0000"));
    assert_eq!(bench.say("M852 I0"), "Skew factors: XY 0.00000000 XZ 0.00000000 YZ 0.00000000\nok\n");
    assert!((bench.carriage(Actuator::Alpha) - 50.0).abs() < 0.02);
    assert_eq!(bench.say("M852 J0.2"), "error:a skew factor lies between -0.1 and 0.1\n");
    // Profiles, by Klipper's name.
    bench.say("M852 I0.0123 J-0.004");
    assert_eq!(bench.say("SKEW_PROFILE SAVE=cold"), "skew saved to /sd/cold.skew\nok\n");
    assert_eq!(bench.read_card("cold.skew").as_deref(), Some("M852 I0.01230000 J-0.00400000 K0.00000000\n"));
    bench.say("M852 I0 J0");
    let loaded = "Skew factors: XY 0.01230000 XZ -0.00400000 YZ 0.00000000\nok\n";
    assert_eq!(bench.say("SKEW_PROFILE LOAD=cold"), loaded);
    assert_eq!(bench.say("GET_CURRENT_SKEW"), loaded, "it is in force");
    assert_eq!(bench.say("SKEW_PROFILE REMOVE=cold"), "/sd/cold.skew deleted\nok\n");
    assert!(bench.say("M852.3 P\"cold\"").starts_with("error:"), "and gone");
    assert!(bench.say("SKEW_PROFILE SAVE=b.c").contains("a profile needs a name"));
    assert!(bench.say("SKEW_PROFILE").contains("needs LOAD="));
    assert!(bench.say("M852.2 P\"warm\"").starts_with("skew saved to /sd/warm.skew"));
    assert_eq!(bench.say("M852.4 P\"warm\""), "/sd/warm.skew deleted\nok\n");
    bench.say("M852 I0 J0");
}

#[test]
fn what_is_saved_reads_back_to_the_last_bit() {
    let plan = printer()
        .set("[zprobe] leveling = three point")
        .set("[three point leveling strategy] save_plane = true")
        .set("[general] config-override = true");
    let mut bench = plan.start();
    // As Smoothieware saved it: the bits of single-precision numbers.
    let [a, b, c, d] = [-0.012_345_678_f32, 0.003, 0.999_9, -0.25].map(f32::to_bits);
    bench.run(&["G28"]);
    bench.say("M557 P1 X12.5 Y7");
    bench.run(&[&format!("M561 A{a} B{b} C{c} D{d}")]);
    bench.say("M852 I0.0123 K-0.004");
    bench.say("M565 X-20 Y5 Z1.5");
    let before = bench.say("M503");
    assert!(before.contains("M561 A-0.012346913 B0.003000300 C1 D-0.250025007\n"), "{before}");
    assert!(before.contains("M557 P1 X12.50000 Y7.00000\n") && before.contains("M852 I0.01230000"), "{before}");
    bench.say("M500");
    for line in ["M561", "M852 I0 J0 K0", "M565 X0 Y0 Z0", "M557 P1 X0 Y0"] {
        bench.say(line);
    }
    assert!(!bench.say("M503").contains("M561"));
    bench.say("M501");
    let line_of =
        |text: &str| text.lines().filter(|line| !line.starts_with("//")).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(line_of(&bench.say("M503")), line_of(&before));
}

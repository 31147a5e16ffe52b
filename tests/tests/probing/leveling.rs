//! Leveling: an uneven bed is probed, and the nozzle then keeps its distance from it, as the motors show.

use scenarios::{Bench, CARTESIAN, DELTA, Plan};
use sim::models::surface::{Bed, Surface};
use sim::world::Fault;
use units::Actuator::Gamma;

use super::{Z_STEP, assert_near, homed_delta, lay, lay_bed, numbers};

/// Waves of 0.3 mm on a bed that leans.
const UNEVEN: Bed = Bed::tilted(0.4, [0.002, -0.003]).wavy(0.15, 260.0);

fn plan(strategy: &str) -> Plan {
    super::plan(CARTESIAN).set(&format!("[zprobe] leveling = {strategy}"))
}

fn grid() -> Plan {
    plan("cartesian grid")
        .set("[cartesian grid leveling strategy] x_size = 150")
        .set("[cartesian grid leveling strategy] y_size = 120")
}

fn three_points() -> Plan {
    plan("three point")
        .set("[three point leveling strategy] point1 = 20,10")
        .set("[three point leveling strategy] point2 = 150,30")
        .set("[three point leveling strategy] point3 = 70,140")
}

/// The nozzle's distances from the bed at many places, all at Z1.
fn gaps(bench: &mut Bench, bed: &Bed, places: &[(i32, i32)]) -> Vec<f64> {
    let gap = |(x, y): &(i32, i32)| {
        bench.run(&[&format!("G1 X{x} Y{y} Z1 F9000"), "M400"]);
        let [x, y, z] = bench.world(|world| world.tool_mm());
        z - bed.height(x, y)
    };
    places.iter().map(gap).collect()
}

fn spread(gaps: &[f64]) -> f64 {
    gaps.iter().fold(f64::MIN, |most, gap| most.max(*gap)) - gaps.iter().fold(f64::MAX, |least, gap| least.min(*gap))
}

const PLACES: &[(i32, i32)] = &[(5, 5), (140, 8), (75, 60), (33, 110), (120, 95), (61, 17), (148, 118), (12, 77)];

#[test]
fn a_grid_levels_an_uneven_bed() {
    let mut bench = grid().start();
    lay_bed(&bench, UNEVEN);
    bench.run(&["G28"]);
    let before = spread(&gaps(&mut bench, &UNEVEN, PLACES));
    assert!(before > 0.5, "{before}");
    let answer = bench.say("G32");
    assert!(answer.ends_with("ok\n"), "{answer}");
    assert_eq!(answer.matches("DEBUG: X").count(), 49, "{answer}");
    assert!(answer.contains("Maximum delta: 0."), "{answer}");
    let after = gaps(&mut bench, &UNEVEN, PLACES);
    assert!(spread(&after) < 0.01, "{} of {before} is left: {after:?}", spread(&after));
    // Z is that of the first touch.
    assert_near(after[0], 1.0 - UNEVEN.height(0.0, 0.0), 0.01);
    // M561 turns the leveling off.
    bench.say("M561");
    assert!(spread(&gaps(&mut bench, &UNEVEN, PLACES)) > 0.5);
}

#[test]
fn a_grid_can_be_given_by_two_corners_and_by_words() {
    let tip = [20.0, -10.0, -1.5];
    let surface = Surface { bed: Some(UNEVEN), tip_mm: tip, ..Surface::default() };
    let plan = grid()
        .set("[cartesian grid leveling strategy] only_by_two_corners = true")
        .set("[cartesian grid leveling strategy] probe_offsets = 20,-10,0");
    let mut bench = plan.start();
    lay(&bench, surface);
    bench.run(&["G28"]);
    assert!(bench.say("G32").starts_with("error:two corners: X and Y are the start, A and B the size of the area"));
    let answer = bench.say("G31 X40 Y30 A100 B90 I6 J5");
    assert_eq!(answer.matches("DEBUG: X").count(), 30, "{answer}");
    assert!(answer.contains("DEBUG: X40.000, Y30.000, Z0.000\n") && answer.contains("DEBUG: X140.000, Y120.000, "));
    let inside = &[(45, 35), (100, 60), (131, 112), (60, 100)];
    let after = gaps(&mut bench, &UNEVEN, inside);
    assert!(spread(&after) < 0.02, "{after:?}");
    assert!(bench.say("M374").starts_with("error:with only_by_two_corners"));
    assert!(bench.say("G31 X1 Y1 A9 B9 I50 J50").starts_with("error:I and J are points along X and Y"));
}

#[test]
fn a_grid_begins_where_the_configuration_says_and_its_file_knows() {
    let plan = || {
        grid()
            .set("[cartesian grid leveling strategy] x_size = 100")
            .set("[cartesian grid leveling strategy] y_size = 90")
            .set("[cartesian grid leveling strategy] x_start = 40")
            .set("[cartesian grid leveling strategy] y_start = 30")
    };
    let mut bench = plan().start();
    lay(&bench, Surface { bed: Some(UNEVEN), ..Surface::default() });
    bench.run(&["G28"]);
    let answer = bench.say("BED_MESH_CALIBRATE");
    assert!(answer.contains("DEBUG: X40.000, Y30.000, Z0.000\n") && answer.contains("DEBUG: X140.000, Y120.000, "));
    let inside = &[(45, 35), (100, 60), (131, 112), (60, 100)];
    let after = gaps(&mut bench, &UNEVEN, inside);
    assert!(spread(&after) < 0.02, "{after:?}");
    assert_eq!(bench.say("M374"), "grid saved to /sd/cartesian.grid\nok\n");
    assert!(bench.say("M375").contains("grid loaded"));
    let file = bench.read_card_bytes("cartesian.grid").expect("it is on the card");
    let load_with = |starts: [&str; 2]| {
        let [x, y] = starts;
        let plan = plan().set(&format!("[cartesian grid leveling strategy] x_start = {x}"));
        let mut bench = plan.set(&format!("[cartesian grid leveling strategy] y_start = {y}")).start();
        bench.write_card("cartesian.grid", &file);
        bench.say("M375")
    };
    assert!(load_with(["40", "30"]).contains("grid loaded"));
    assert!(load_with(["41", "30"]).contains("the grid in the file begins elsewhere"));
    assert!(load_with(["0", "0"]).contains("save it again"));
}

#[test]
fn r1_begins_beside_where_the_probe_is_and_stays_in_force_until_r0() {
    let mut bench = grid().set("[cartesian grid leveling strategy] probe_offsets = -20,-10,0").start();
    lay(&bench, Surface { bed: Some(UNEVEN), tip_mm: [-20.0, -10.0, -1.5], ..Surface::default() });
    bench.run(&["G28", "G1 X60 Y40 Z10 F6000", "M400"]);
    let edges = bench.world(|world| world.trace().total());
    // The size alone would make a grid of another size somewhere else.
    let refused = "error:R1: X and Y are the way from here to the start, A and B the size of the area\n";
    assert_eq!(bench.say("G32 R1 X60 Y60 I3 J3"), refused);
    // Without R1 it would home, and touch all of the bed.
    assert!(bench.say("G32").starts_with("error:two corners: X and Y are the start, A and B the size of the area"));
    assert_eq!(bench.world(|world| world.trace().total()), edges);
    let answer = bench.say("G32 R1 X10 Y5 A60 B50 I3 J3");
    assert_eq!(answer.matches("DEBUG: X").count(), 9, "{answer}");
    assert!(answer.contains("DEBUG: X50.000, Y35.000, Z0.000\n") && answer.contains("DEBUG: X110.000, Y85.000, "));
    let answer = bench.say("G32 X70 Y60 A40 B30 I3 J3");
    assert!(answer.contains("DEBUG: X70.000, Y60.000, Z0.000\n"), "heights count from its own start: {answer}");
    assert_eq!(bench.say("G32 R0 I2 J2").matches("DEBUG: X").count(), 4);
    assert_eq!(bench.say("G32").matches("DEBUG: X").count(), 49);
}

#[test]
fn a_grid_is_saved_and_loaded() {
    let mut bench = grid().start();
    lay_bed(&bench, UNEVEN);
    bench.say("G32");
    let before = gaps(&mut bench, &UNEVEN, PLACES);
    assert!(bench.say("M374").contains("grid saved to /sd/cartesian.grid"));
    bench.say("M370");
    assert!(bench.say("M375").contains("grid loaded"));
    let after = gaps(&mut bench, &UNEVEN, PLACES);
    for (one, other) in before.iter().zip(&after) {
        assert_near(*one, *other, Z_STEP);
    }
}

#[test]
fn a_scan_changes_nothing() {
    let mut bench = grid().start();
    lay_bed(&bench, UNEVEN);
    bench.run(&["G28", "G1 X20 Y30 Z12 F6000", "M400"]);
    let answer = bench.say("G29 X80 Y60 I6 J5");
    assert_eq!(answer.matches("DEBUG: X").count(), 30, "{answer}");
    assert!(answer.contains("Maximum delta: "), "{answer}");
    assert!(spread(&gaps(&mut bench, &UNEVEN, PLACES)) > 0.5);
    assert!(bench.say("G29").starts_with("error:G29 takes the size X and Y"));
    assert!(bench.say("G29 X80 Y60 I4 J7").starts_with("error:G29 scans at least 5 x 5 points"));
}

#[test]
fn lines_are_run_before_and_after_probing() {
    let plan = grid()
        .set("[cartesian grid leveling strategy] before_probe_gcode = M106 S255")
        .set("[cartesian grid leveling strategy] after_probe_gcode = M107");
    let mut bench = plan.start();
    bench.type_in("G32 I2 J2\n");
    bench.hear_until("DEBUG: X", 60.0);
    assert!(bench.world(|world| world.fan_speed(0)) > 0.5, "before_probe_gcode");
    bench.hear_until("ok\n", 60.0);
    bench.hear(10.0);
    assert!(bench.world(|world| world.fan_speed(0)) < 0.2, "after_probe_gcode");
}

/// The scripts of G31 run for G29 too, such as a servo's: a probe that stays stowed lets the nozzle meet the
/// bed.
#[test]
fn the_lines_are_run_around_a_scan_too_which_begins_at_its_height() {
    let fan = |bench: &Bench| bench.world(|world| world.fan_speed(0));
    let plan = grid()
        .set("[cartesian grid leveling strategy] before_probe_gcode = M106 S255")
        .set("[cartesian grid leveling strategy] after_probe_gcode = M107")
        .set("[cartesian grid leveling strategy] initial_height = 17")
        .set("[zprobe] max_travel = 12");
    let mut bench = plan.start();
    lay_bed(&bench, Bed::level(9.0));
    bench.run(&["G28", "G1 X20 Y30 Z45 F6000", "M400"]);
    bench.type_in("G29 X80 Y60 I5 J5\n");
    bench.hear_until("DEBUG: X", 60.0);
    assert!(fan(&bench) > 0.5, "before_probe_gcode");
    bench.hear_until("ok\n", 300.0);
    bench.hear(10.0);
    assert!(fan(&bench) < 0.2, "after_probe_gcode");
    // A miss stows the probe too.
    bench.run(&["G1 X20 Y30 Z45 F6000", "M400"]);
    bench.world(|world| world.inject(&Fault::SwitchNeverOperates("probe".into()))).expect("a probe");
    let answer = bench.say("G29 X80 Y60 I5 J5");
    assert!(answer.contains("error:ZProbe not triggered at X20.000 Y30.000 on 12 mm of way\n"), "{answer}");
    assert_near(bench.carriage(Gamma), 17.0, Z_STEP);
    bench.hear(10.0);
    assert!(fan(&bench) < 0.2, "after_probe_gcode, after a failure");
}

#[test]
fn three_points_level_a_bed_that_leans_and_set_z() {
    let bed = Bed::tilted(0.8, [0.004, -0.003]);
    let mut bench = three_points().start();
    lay_bed(&bench, bed);
    let answer = bench.say("G32");
    assert!(answer.contains("plane: Z = 0.00") && answer.ends_with("ok\n"), "{answer}");
    let after = gaps(&mut bench, &bed, &[(5, 5), (150, 10), (60, 130), (20, 10), (140, 140)]);
    for gap in &after {
        assert_near(*gap, 1.0, 3.0 * Z_STEP);
    }
    assert!(bench.say("G31").contains("plane: Z = 0.00"));
    assert!(bench.say("G29").contains("max delta: 0.00"), "the points are at one height now");
    let saved = bench.say("M503");
    assert!(saved.contains("M557 P1 X150.00000 Y30.00000\n"), "{saved}");
}

#[test]
fn a_flat_bed_needs_no_plane_but_gets_its_z() {
    let mut bench = three_points().set("[three point leveling strategy] probe_offsets = 0,0,1.2").start();
    lay_bed(&bench, Bed::level(0.5));
    let answer = bench.say("G32");
    assert!(answer.contains("The bed is flat, nothing to level\n"), "{answer}");
    assert!(bench.say("G31").starts_with("Bed leveling plane is not set\nProbe is Not triggered\n"));
    bench.run(&["G1 Z1.2 F600", "M400"]);
    assert_near(bench.carriage(Gamma), 0.5, Z_STEP);
    let mut bench = plan("three point").start();
    assert!(bench.say("G32").starts_with("error:the three points stand in a row: set point1 to point3, or M557"));
    assert_eq!(bench.world(|world| world.trace().total()), 0);
}

#[test]
fn a_delta_levels_by_a_round_grid() {
    let bed = Bed::tilted(0.2, [0.003, 0.002]).wavy(0.1, 200.0);
    let plan = super::plan(DELTA)
        .set("[zprobe] fast_feedrate = 150")
        .set("[zprobe] leveling = delta grid")
        .set("[zprobe] calibration = delta")
        .set("[delta calibration strategy] radius = 60")
        .set("[delta grid leveling strategy] radius = 70");
    // A scan homes a machine that does not know where it is, and with do_home = false it does not begin.
    let mut bench = plan.clone().start();
    lay_bed(&bench, bed);
    assert_eq!(bench.say("G29 I5 J40").matches("DEBUG: X").count(), 13);
    assert_eq!(bench.say("G28.6"), "X:1 Y:1 Z:1 \nok\n");
    let mut bench = plan.clone().set("[delta grid leveling strategy] do_home = false").start();
    let answer = bench.say("G29.1 I5 J40");
    assert!(answer.contains("Must be homed") && bench.world(|world| world.trace().total()) == 0, "{answer}");
    // It begins at its height: a probe that finds nothing ends there.
    let low = plan.clone().set("[delta grid leveling strategy] initial_height = 33").set("[zprobe] max_travel = 12");
    let mut bench = low.start();
    bench.world(|world| world.inject(&Fault::SwitchNeverOperates("probe".into()))).expect("a probe");
    for line in ["G29 I5 J40", "G29.1 I5 J40", "G31"] {
        assert!(bench.say(line).contains("error:ZProbe not triggered"), "{line}");
        let [x, y, z] = bench.world(|world| world.tool_mm());
        assert!(z > 32.9 && z < 33.1, "{line}: X{x} Y{y} Z{z}");
    }
    let mut bench = homed_delta(plan);
    lay_bed(&bench, bed);
    let places = &[(0, 0), (60, 10), (-45, 40), (20, -60), (-30, -50), (35, 45)];
    let before = spread(&gaps(&mut bench, &bed, places));
    assert!(bench.say("G31 I4").starts_with("error:I is the number of points along a side, odd, from 3 to grid_size"));
    assert_eq!(bench.say("G31 I3").matches("DEBUG: X").count(), 5, "3 x 3 points in the circle");
    let answer = bench.say("G31");
    // Of 49 points 37 lie within the circle, four more on it; those beyond have no touch.
    let touched = answer.matches("DEBUG: X").count();
    assert!((29..49).contains(&touched), "{touched}");
    let after = gaps(&mut bench, &bed, places);
    // A carriage's step is 0.0125 mm.
    assert!(before > 0.3 && spread(&after) < 0.05, "{} of {before} is left: {after:?}", spread(&after));
    assert_eq!(bench.say("G29 I5 J40").matches("DEBUG: X").count(), 13, "a map of 5 x 5 points within 40 mm");
    let answer = bench.say("G29.1 I12 J50");
    assert_eq!(answer.matches("X:").count(), 12, "{answer}");
    assert!(bench.say("G32 P0").starts_with("error:No strategy found to handle G32"));
    assert!(bench.say("G32 I0.9").contains("Spread: "), "calibration has it");
}

#[test]
fn what_cannot_be_leveled_is_said() {
    let mut bench = plan("cartesian grid").set("[cartesian grid leveling strategy] only_by_two_corners = true").start();
    assert!(bench.say("G31 X10 Y10 A0 B50").starts_with("error:the area to probe has no size"));
    // A probe that finds nothing: no leveling, and the machine stands above the bed.
    let mut bench = grid().set("[zprobe] max_travel = 12").start();
    bench.run(&["G28"]);
    bench.world(|world| world.inject(&Fault::SwitchNeverOperates("probe".into()))).expect("a probe");
    let answer = bench.say("G32");
    assert!(answer.contains("error:ZProbe not triggered at X0.000 Y0.000 on 12 mm of way\n"), "{answer}");
    assert!(bench.status().starts_with("<Idle"));
    // A step that no bed has.
    let mut bench = grid().start();
    let block = [[100.0, 170.0], [60.0, 150.0], [-5.0, 15.0]];
    lay(&bench, Surface { bed: Some(Bed::level(0.0)), blocks: vec![block], ..Surface::default() });
    let answer = bench.say("G32");
    assert!(answer.contains("error:"), "{answer}");
}

#[test]
fn g38_goes_straight_and_says_the_programs_coordinates() {
    let mut bench = three_points().start();
    let bed = Bed::tilted(0.8, [0.004, -0.003]);
    lay_bed(&bench, bed);
    bench.say("G32");
    bench.run(&["G1 X100 Y50 Z5 F6000", "M400"]);
    let found = numbers(&bench.say("G38.2 Z-10"), "[PRB:");
    assert_near(found[2], 0.0, 2.0 * Z_STEP);
    assert!(bench.status().contains("MPos:100.0000,50.0000,"));
    let here = bench.world(|world| world.tool_mm());
    assert_near(here[2], bed.height(100.0, 50.0), 2.0 * Z_STEP);
    assert_near(
        numbers(
            &{
                bench.run(&["G1 Z3 F600"]);
                bench.say("G30")
            },
            "Z:",
        )[0],
        3.0,
        2.0 * Z_STEP,
    );
}

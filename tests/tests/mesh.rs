//! Meshes of whole machines: the part of a bed that a job needs, names, faulty regions, several touches.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::models::surface::{Bed, Surface};
use units::Actuator::Gamma;

/// Step size of Z, mm.
const Z_STEP: f64 = 1.0 / 400.0;
/// Domed by 0.3 mm over a tilt.
const DOMED: Bed = Bed::tilted(0.2, [0.001, -0.0005]).bent([80.0, 60.0], [0.3, 0.25], 0.0);

/// A grid of 7 by 7 points on 160 by 120 mm.
fn plan() -> Plan {
    Plan::new(CARTESIAN)
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[zprobe] slow_feedrate = 5")
        .set("[zprobe] leveling = cartesian grid")
        .set("[cartesian grid leveling strategy] x_size = 160")
        .set("[cartesian grid leveling strategy] y_size = 120")
}

fn lay(bench: &Bench, bed: Bed, noise_mm: f64) {
    bench.lay(Surface { bed: Some(bed), noise_mm, ..Surface::default() });
}

/// Returns the height of the nozzle over the bed with Z at 1 here, mm.
fn gap(bench: &mut Bench, bed: &Bed, [x, y]: [f64; 2]) -> f64 {
    bench.run(&[&format!("G1 X{x} Y{y} Z1 F9000"), "M400"]);
    let [x, y, z] = bench.world(|world| world.tool_mm());
    z - bed.height(x, y)
}

fn spread(bench: &mut Bench, bed: &Bed, places: &[[f64; 2]]) -> f64 {
    let gaps: Vec<f64> = places.iter().map(|place| gap(bench, bed, *place)).collect();
    gaps.iter().fold(f64::MIN, |a, b| a.max(*b)) - gaps.iter().fold(f64::MAX, |a, b| a.min(*b))
}

fn near(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance, "{found} is not {wanted}");
}

fn touched(answer: &str) -> usize {
    answer.matches("DEBUG: X").count()
}

const OBJECTS: &[&str] = &[
    "EXCLUDE_OBJECT_DEFINE NAME=cube CENTER=50,40 POLYGON=[[40,30],[60,30],[60,50],[40,50]]",
    "EXCLUDE_OBJECT_DEFINE NAME=ball CENTER=90,60 POLYGON=[[80,50],[100,55],[95,70]]",
];

#[test]
fn a_mesh_is_measured_for_the_objects_of_a_job_alone() {
    let mut bench = plan().start_homed();
    lay(&bench, DOMED, 0.0);
    bench.run(OBJECTS);
    let answer = bench.say("BED_MESH_CALIBRATE ADAPTIVE=1");
    assert!(answer.contains("mesh for the objects: X35.0 to 105.0, Y25.0 to 75.0, 4 x 4 points\n"), "{answer}");
    assert_eq!(touched(&answer), 16, "{answer}");
    let inside = [[40.0, 30.0], [60.0, 50.0], [100.0, 70.0], [36.0, 74.0], [70.0, 45.0]];
    let left = spread(&mut bench, &DOMED, &inside);
    assert!(left < 0.015, "{left}");
    // Zero is where the whole grid has it.
    near(gap(&mut bench, &DOMED, [50.0, 40.0]), 1.0 - DOMED.height(0.0, 0.0), 0.015);
    // Outside the height of the edge goes on.
    let edge = bench.carriage(Gamma);
    bench.run(&["G1 X105 Y50 Z1 F9000", "M400"]);
    let at_edge = bench.carriage(Gamma);
    assert!((at_edge - edge).abs() > 0.01, "the bed is not flat: {at_edge} {edge}");
    for x in [130, 160] {
        bench.run(&[&format!("G1 X{x} Y50 Z1 F9000"), "M400"]);
        near(bench.carriage(Gamma), at_edge, Z_STEP);
    }
    // An object that is left out needs none.
    bench.say("EXCLUDE_OBJECT NAME=ball");
    let answer = bench.say("BED_MESH_CALIBRATE ADAPTIVE=1 ADAPTIVE_MARGIN=0");
    assert!(answer.contains("X40.0 to 60.0, Y30.0 to 50.0, 3 x 3 points\n"), "{answer}");
}

#[test]
fn without_outlines_all_of_the_bed_is_measured_and_that_is_said() {
    let mut bench = plan().set("[cartesian grid leveling strategy] grid_x_size = 3").start_homed();
    lay(&bench, DOMED, 0.0);
    bench.run(&["EXCLUDE_OBJECT_DEFINE NAME=cube"]);
    let answer = bench.say("G31 D10");
    assert!(answer.contains("no object of the job has an outline: all of the bed is measured"), "{answer}");
    assert_eq!(touched(&answer), 21);
    bench.run(&["EXCLUDE_OBJECT_DEFINE NAME=cube POLYGON=[[300,10],[310,10],[310,20]]"]);
    assert_eq!(bench.say("G31 D10"), "error:the objects of the job lie beside the grid that is configured\n");
    assert_eq!(bench.say("G31 D-1"), "error:D is how far the mesh goes around the objects, 0 mm or more\n");
}

#[test]
fn an_outline_longer_than_a_line_counts_whole() {
    let mut bench = plan().start_homed();
    lay(&bench, DOMED, 0.0);
    let points: Vec<String> = (0..60)
        .map(|n| {
            let angle = std::f64::consts::TAU * f64::from(n) / 60.0;
            format!("[{:.3},{:.3}]", 80.0 + 30.0 * angle.cos(), 60.0 + 20.0 * angle.sin())
        })
        .collect();
    let file = format!(
        "G21\nEXCLUDE_OBJECT_DEFINE NAME=Disc_id_0_copy_0 CENTER=80,60 POLYGON=[{}]\nG1 X5 F6000\nBED_MESH_CALIBRATE ADAPTIVE=1 PROFILE=disc\n",
        points.join(",")
    );
    assert!(file.lines().any(|line| line.len() > 1_000));
    bench.write_card("disc.gcode", file.as_bytes());
    bench.say("play /sd/disc.gcode");
    bench.run(&["M400"]);
    let saved = (0..400).find_map(|_| {
        bench.run(&["G4 P1000"]);
        bench.read_card_bytes("disc.mesh")
    });
    let saved = String::from_utf8(saved.expect("the mesh was saved")).expect("text");
    assert!(saved.contains("points 4 4\norigin 45 35\n"), "{saved}");
}

#[test]
fn meshes_have_names() {
    let mut bench = plan().start_homed();
    lay(&bench, DOMED, 0.0);
    assert_eq!(bench.say("M374 P\"pei\""), "error:no mesh to save: measure the bed with G32\n");
    bench.say("G32");
    let here = [33.0, 47.0];
    let before = gap(&mut bench, &DOMED, here);
    assert_eq!(bench.say("BED_MESH_PROFILE SAVE=pei"), "mesh saved to /sd/pei.mesh\nok\n");
    assert!(bench.say("M374.2").starts_with("pei (in force)\n1 meshes on the card\n"));
    let text = String::from_utf8(bench.read_card_bytes("pei.mesh").expect("it was saved")).expect("text");
    assert!(text.starts_with("; Velvet bed mesh") && text.contains("\npoints 7 7\norigin 0 0\n"), "{text}");
    bench.say("BED_MESH_CLEAR");
    assert!((gap(&mut bench, &DOMED, here) - before).abs() > 0.05);
    let answer = bench.say("BED_MESH_PROFILE LOAD=pei");
    assert_eq!(answer, "mesh pei loaded, 7 x 7 points from X0.0 Y0.0 to X160.0 Y120.0\nok\n");
    near(gap(&mut bench, &DOMED, here), before, 1e-6);
    bench.say("M421 I3 J3 Q0.1");
    bench.say("M374 P\"other\"");
    let answer = bench.say("BED_MESH_PROFILE");
    assert!(
        answer.contains("pei\n") && answer.contains("other (in force)\n") && answer.contains("\n2 meshes"),
        "{answer}"
    );
    assert_eq!(bench.say("M374.1 P\"pei\""), "/sd/pei.mesh deleted\nok\n");
    assert_eq!(bench.say("M375 P\"pei\""), "error:/sd/pei.mesh: no such file\n");
    assert_eq!(bench.say("M375 P\"a b\""), "error:the name of a mesh is made of letters, digits, - and _\n");
    bench.write_card("wrong.mesh", b"mesh 1\npoints 2 2\nG28\n");
    let answer = bench.say("M375 P\"wrong\"");
    assert!(answer.starts_with("error:/sd/wrong.mesh: line 3: this is no mesh: "), "{answer}");
    bench.write_card("steep.mesh", b"mesh 1\npoints 2 2\norigin 0 0\nstep 10 10\nheights 0 5 0 0\n");
    let answer = bench.say("M375 P\"steep\"");
    assert!(answer.starts_with("error:/sd/steep.mesh: the bed rises by more than 25 %"), "{answer}");
    near(bench.say("M375.1").matches('\n').count() as f64, 9.0, 0.0);
}

#[test]
fn a_mesh_can_be_set_aside_faded_and_looked_up_elsewhere() {
    let mut bench = plan().start_homed();
    bench.run(&["M421 I3 J3 Z0.4"]);
    let raised = |bench: &mut Bench, x: f64, z: f64| {
        bench.run(&[&format!("G1 X{x} Y60 Z{z} F6000"), "M400"]);
        bench.carriage(Gamma) - z
    };
    near(raised(&mut bench, 80.0, 5.0), 0.4, Z_STEP);
    bench.say("M420 S0");
    near(raised(&mut bench, 80.0, 5.0), 0.0, Z_STEP);
    bench.say("M420 S1");
    near(raised(&mut bench, 80.0, 5.0), 0.4, Z_STEP);
    assert_eq!(bench.say("M420 Z10"), "the mesh fades from Z0.00 to Z10.00\nok\n");
    near(raised(&mut bench, 80.0, 5.0), 0.2, Z_STEP);
    near(raised(&mut bench, 80.0, 10.0), 0.0, Z_STEP);
    assert!(bench.say("M376 H0.5").starts_with("error:with heights as great as these, fading must take at least"));
    assert_eq!(bench.say("M376"), "the mesh fades from Z0.00 to Z10.00\nok\n");
    assert_eq!(bench.say("M376 H0"), "the mesh does not fade\nok\n");
    near(raised(&mut bench, 80.0, 10.0), 0.4, Z_STEP);
    // The other tool stands 30 mm to the right of the one that the bed was measured with.
    assert_eq!(bench.say("BED_MESH_OFFSET X=30"), "Mesh offset: X:30.0000 Y:0.0000\nok\n");
    near(raised(&mut bench, 50.0, 2.0), 0.4, Z_STEP);
    assert_eq!(bench.say("M374"), "grid saved to /sd/cartesian.grid\nok\n");
    assert_eq!(bench.say("M420.1 X0"), "Mesh offset: X:0.0000 Y:0.0000\nok\n");
    near(raised(&mut bench, 80.0, 2.0), 0.4, Z_STEP);
    bench.say("M375");
    near(raised(&mut bench, 80.0, 2.0), 0.4, Z_STEP);
}

#[test]
fn a_mesh_that_was_set_aside_is_looked_up_where_it_was_asked_for_meanwhile() {
    let mut bench = plan().start_homed();
    bench.run(&["M421 I3 J3 Z0.4", "M420 S0"]);
    bench.say("BED_MESH_OFFSET X=30");
    bench.run(&["M420 S1"]);
    for (x, z) in [(50, 2.4), (80, 2.0)] {
        bench.run(&[&format!("G1 X{x} Y60 Z2 F6000"), "M400"]);
        near(bench.carriage(Gamma), z, 0.06);
    }
}

#[test]
fn a_halt_while_the_tool_follows_does_not_lose_where_a_mesh_lies() {
    let mut bench = plan().start_homed();
    bench.run(&["M421 I3 J3 Z2", "G1 X80 Y60 Z5 F6000", "M400"]);
    // Z comes down by 2 mm, at 5 mm/s.
    bench.type_in("M420.1 X30\n");
    bench.hear(0.2);
    bench.type_in("\x18");
    bench.hear_until("ALARM", 1.0);
    bench.say("M999");
    bench.say("M420.1 X0");
    bench.run(&["G28", "G1 X80 Y60 Z5 F6000", "M400"]);
    near(bench.carriage(Gamma), 7.0, Z_STEP);
}

#[test]
fn measuring_takes_a_mesh_off_without_going_down() {
    for (code, config) in
        [("G31", "[cartesian grid leveling strategy] do_home = false"), ("G35", "[zprobe] enable = true")]
    {
        let mut bench = plan().set(config).set("[bed screws] screws = 20,20 140,20 80,100").start_homed();
        let bed = Bed::level(0.0).bent([80.0, 60.0], [-0.3, -0.3], 0.0);
        lay(&bench, bed, 0.0);
        bench.run(&["M421 I6 J6 Z0.4", "G1 X160 Y120 Z0.05 F6000", "M400"]);
        near(bench.carriage(Gamma), 0.45, Z_STEP);
        bench.type_in(&format!("{code}\n"));
        let mut lowest: f64 = 9.0;
        while bench.carriage(Gamma) < 5.0 {
            bench.hear(0.01);
            lowest = lowest.min(bench.carriage(Gamma));
        }
        assert!(lowest > 0.44, "{code}: the tool went down to {lowest}");
    }
}

#[test]
fn points_out_of_the_travel_are_refused_before_anything_moves() {
    let mut bench = plan().set("[zprobe] probe_offsets = 30,0,0").start_homed();
    bench.run(&["G1 X50 Y50 Z20 F6000", "M400"]);
    let before = bench.carriage(Gamma);
    let said = bench.say("G31 X10 Y10 A100 B50");
    assert!(said.contains("error:") && said.contains("machine X -30.000 is out of travel"), "{said}");
    near(bench.carriage(Gamma), before, Z_STEP);
}

#[test]
fn nothing_touches_a_faulty_region_and_its_points_are_worked_out() {
    let region = [[50.0, 50.0], [110.0, 75.0]];
    let mut bench = plan().set("[bed mesh] faulty_regions = 50,50 110,75").start_homed();
    let flat_tilt = Bed::tilted(0.2, [0.002, -0.001]);
    // An obstacle in the region would be felt by a touch.
    let at_ns = (bench.now_s() * 1e9) as u64;
    let block = [[region[0][0] + 0.01, region[1][0] - 0.01], [region[0][1] + 0.01, region[1][1] - 0.01], [0.0, 3.0]];
    bench.world(|world| {
        world.lay(at_ns, Surface { bed: Some(flat_tilt), blocks: vec![block], ..Surface::default() });
    });
    let answer = bench.say("G32");
    assert!(answer.ends_with("ok\n"), "{answer}");
    // Columns at 53.3, 80 and 106.7, a row at 60.
    assert_eq!(answer.matches("// beside a faulty region").count(), 12, "{answer}");
    assert_eq!(touched(&answer), 49, "{answer}");
    let places: Vec<[f64; 2]> = (0..9).map(|n| [10.0 + 17.0 * f64::from(n), 62.0]).collect();
    let left = spread(&mut bench, &flat_tilt, &places);
    assert!(left < 0.01, "{left}");
    let everywhere = plan().set("[bed mesh] faulty_regions = -5,-5 200,200").start().say("$H");
    assert!(everywhere.ends_with("ok\n"));
    let mut bench = plan().set("[bed mesh] faulty_regions = -5,-5 200,200").start_homed();
    assert!(bench.say("G32").starts_with("error:the first point lies in one of faulty_regions"), "nothing moves");
}

#[test]
fn zero_is_where_it_is_wanted() {
    let mut bench = plan().set("[bed mesh] zero_reference = 80,60").start_homed();
    lay(&bench, DOMED, 0.0);
    bench.say("G32");
    bench.run(&["G1 X80 Y60 Z1 F9000", "M400"]);
    near(bench.carriage(Gamma), 1.0, 2.0 * Z_STEP);
}

#[test]
fn several_touches_are_held_against_each_other() {
    let touching = |more: &str, noise: f64| {
        let mut bench = plan()
            .set("[zprobe] samples = 5")
            .set("[cartesian grid leveling strategy] grid_x_size = 3")
            .set("[cartesian grid leveling strategy] grid_y_size = 3")
            .set(more)
            .start_homed();
        lay(&bench, Bed::level(0.1), noise);
        bench.say("G32")
    };
    let answer = touching("[zprobe] samples_result = median", 0.02);
    assert!(answer.contains("Touches: 50 at 10 places, 0 places again; standard deviation 0.0"), "{answer}");
    let deviation: f64 = answer
        .split("standard deviation ")
        .nth(1)
        .and_then(|text| text.split(' ').next())
        .expect("it is said")
        .parse()
        .expect("a number");
    assert!((0.013..0.028).contains(&deviation), "{deviation}");
    let answer = touching("[zprobe] samples_tolerance = 0.05", 0.02);
    assert!(answer.contains(" mm apart: again\n") && answer.contains("Touches: 50 at 10 places"), "{answer}");
    let answer = touching("[zprobe] samples_tolerance = 0.004", 0.02);
    assert!(answer.contains("samples_tolerance is 0.004: is the probe firm and clean?\n"), "{answer}");
}

#[test]
fn the_bed_is_shown_as_a_map_with_what_to_do() {
    let mut bench = plan().set("[bed screws] screws = 20,20 140,20 140,100 20,100").start_homed();
    assert!(bench.say("M375.2").starts_with("error:no grid levels the machine"));
    lay(&bench, DOMED, 0.0);
    bench.say("G32");
    let map = bench.say("BED_MESH_OUTPUT");
    println!("{map}");
    assert!(map.lines().filter(|line| line.ends_with('|')).count() == 24, "{map}");
    assert!(map.lines().take(26).all(|line| line.len() <= 80), "{map}");
    assert!(map.contains("Bend: the bed is domed by 0.28"), "{map}");
    lay(&bench, Bed::tilted(0.0, [0.003, 0.0]), 0.0);
    let answer = bench.say("G32");
    assert!(answer.contains("Tilt: the right side is 0.479") && answer.contains("To do: G35 says"), "{answer}");
}

#[test]
fn other_firmwares_words_mean_the_same() {
    let mut bench = plan().start_homed();
    lay(&bench, DOMED, 0.0);
    bench.say("dialect marlin");
    let answer = bench.say("G29 P1 X30 Y20 W70 H40 C");
    // 70 mm of 160 are three of six cells, 40 of 120 two.
    assert!(answer.contains("DEBUG: X30.000, Y20.000,") && answer.contains("DEBUG: X100.000, Y60.000,"), "{answer}");
    assert_eq!(touched(&answer), 12, "{answer}");
    let answer = bench.say("G29 L40 R120 F30 B90");
    assert!(answer.contains("DEBUG: X40.000, Y30.000,") && answer.contains("DEBUG: X120.000, Y90.000,"), "{answer}");
    let answer = bench.say("G29 L300 R320 F30 B90");
    assert!(answer.ends_with("error:the area to probe lies beside the grid that is configured\n"), "{answer}");
    bench.say("dialect rrf");
    assert_eq!(bench.say("G29 S3 P\"0:/sys/part.csv\""), "mesh saved to /sd/part.mesh\nok\n");
    bench.say("G29 S2");
    assert!(
        bench.say("G29 S1 P\"part\"").starts_with("mesh part loaded, 4 x 4 points from X40.0 Y30.0 to X120.0 Y90.0")
    );
    bench.say("dialect marlin");
    bench.say("M374 P\"2\"");
    bench.say("M420 S0");
    assert!(bench.say("M420 L2 V").contains("mesh 2 loaded"));
    bench.say("dialect klipper");
    let answer = bench.say("BED_MESH_CALIBRATE MESH_MIN=40,30 MESH_MAX=100,90 PROBE_COUNT=4,3 PROFILE=corner");
    assert_eq!(touched(&answer), 12, "{answer}");
    assert!(answer.contains("mesh saved to /sd/corner.mesh\n"), "{answer}");
}

#[test]
fn a_named_mesh_is_loaded_again_by_what_m500_saves() {
    let plan = plan().set("[cartesian grid leveling strategy] save = true").set("[general] config-override = true");
    let mut bench = plan.start_homed();
    bench.run(&["M421 I3 J3 Z0.4"]);
    bench.say("M376 H12");
    bench.say("M374 P\"pei\"");
    let saved = bench.say("M503");
    assert!(saved.contains("M376 H12.00000\n") && saved.contains("M375 P\"pei\"\n"), "{saved}");
    bench.say("M500");
    bench.say("M370");
    bench.say("M376 H0");
    bench.say("M501");
    bench.run(&["G1 X80 Y60 Z6 F6000", "M400"]);
    near(bench.carriage(Gamma), 6.2, Z_STEP);
}

#[test]
fn a_delta_has_its_mesh_by_name_too() {
    let mut bench = Plan::new(scenarios::DELTA)
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[zprobe] leveling = delta grid")
        .set("[delta grid leveling strategy] radius = 60")
        .set("[delta grid leveling strategy] size = 5")
        .set("[bed mesh] interpolation = lagrange")
        .start();
    bench.run(&["G28", "G1 Z30 F6000", "M400"]);
    lay(&bench, Bed::tilted(0.2, [0.002, -0.001]), 0.0);
    assert!(bench.say("G31 D").starts_with("error:D measures a part of a cartesian grid"));
    let answer = bench.say("G31");
    assert!(answer.contains("Tilt: the right side is 0.2") && answer.contains("the front is 0.1"), "{answer}");
    assert_eq!(bench.say("M374 P\"round\""), "mesh saved to /sd/round.mesh\nok\n");
    bench.say("M370");
    assert!(bench.say("M375 P\"round\"").starts_with("mesh round loaded, 5 x 5 points from X-60.0 Y-60.0"));
}

/// A scan says what the bed is, whatever mesh makes up for it.
#[test]
fn a_scan_measures_the_bed_and_not_what_a_mesh_leaves_of_it() {
    let mut bench = plan().start_homed();
    lay(&bench, DOMED, 0.0);
    let delta = |bench: &mut Bench| {
        bench.run(&["G1 X10 Y10 Z10 F6000", "M400"]);
        let answer = bench.say("G29 X120 Y90 I5 J5");
        let (_, rest) = answer.split_once("Maximum delta: ").expect("a scan");
        rest.lines().next().and_then(|text| text.parse::<f64>().ok()).expect("a number")
    };
    let before = delta(&mut bench);
    bench.say("G32");
    near(delta(&mut bench), before, 0.01);
    near(gap(&mut bench, &DOMED, [80.0, 60.0]), gap(&mut bench, &DOMED, [20.0, 100.0]), 0.02);
}

#[test]
fn a_deleted_mesh_stays_in_force_without_its_name() {
    let mut bench = plan().set("[cartesian grid leveling strategy] save = true").start_homed();
    bench.run(&["M421 I3 J3 Z0.4"]);
    bench.say("M374 P\"pei\"");
    assert!(bench.say("M503").contains("pei"));
    let said = bench.say("M374.1 P\"pei\"");
    assert!(said.contains("// NOTE it is in force: M374 with a name keeps it") && said.contains("deleted"), "{said}");
    assert!(!bench.say("M503").contains("pei"));
    bench.run(&["G1 X80 Y60 Z5 F6000", "M400"]);
    near(bench.carriage(Gamma), 5.4, Z_STEP);
}

/// A probe that fails in the middle of a grid is not pressed into the bed.
#[test]
fn a_probe_that_fails_in_a_grid_stops_a_little_below_its_neighbours() {
    let mut bench = plan().start_homed();
    lay(&bench, DOMED, 0.0);
    bench.type_in("G32\n");
    bench.hear_until("DEBUG: X26.667", 60.0);
    lay(&bench, Bed::level(-50.0), 0.0);
    let said = bench.hear_until("error:", 60.0) + &bench.hear(1.0);
    assert!(said.contains("ZProbe not triggered") && said.contains("far below the point before"), "{said}");
    let [lowest, _] = bench.world(|world| world.reached_mm(Gamma)).expect("a motor");
    assert!(lowest > -3.0, "down to {lowest}");
}

/// A probe error that grows along Y, from a twisted rail, is compensated.
#[test]
fn a_twist_along_y_is_taken_off_what_the_probe_reads() {
    let mut bench = plan().start_homed();
    // The probe sees a bed that rises to the rear.
    lay(&bench, Bed::tilted(0.2, [0.0, 0.003]), 0.0);
    let range = |bench: &mut Bench| {
        let answer = bench.say("G32");
        let (_, rest) = answer.split_once("Maximum delta: ").expect("a mesh");
        rest.lines().next().and_then(|text| text.parse::<f64>().ok()).expect("a number")
    };
    near(range(&mut bench), 0.36, 0.01);
    bench.say("M851.6 R Y0 Z0");
    assert!(bench.say("M851.6 Y120 Z0.36").contains("Y120.00: the probe reads +0.3600 mm"));
    near(range(&mut bench), 0.0, 0.01);
    assert_eq!(bench.say("M503").matches("M851.6 Y").count(), 2);
    bench.say("M851.6 R");
    near(range(&mut bench), 0.36, 0.01);
}

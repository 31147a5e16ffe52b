//! Ways of homing: above what stands on the bed, in several approaches by a script.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{self, Alpha, Beta, Gamma};

fn at(bench: &Bench) -> [f64; 3] {
    [Alpha, Beta, Gamma].map(|motor| bench.carriage(motor))
}

/// Moves a carriage by hand, as a motor that loses steps would.
fn slip(bench: &mut Bench, motor: Actuator, mm: f64) {
    let (at_ns, place) = ((bench.now_s() * 1e9) as u64, bench.carriage(motor));
    bench.world(|world| world.place_carriage(at_ns, motor, place + mm));
}

#[test]
fn z_rises_before_x_and_y_home_and_homes_at_its_own_place() {
    let plan = Plan::new(CARTESIAN).set("[endstops] common.home_lift = 7");
    let mut bench = plan.set("[endstops] common.safe_z_x = 60").set("[endstops] common.safe_z_y = 45").start();
    let start = at(&bench);
    bench.type_in("G28\n");
    let mut highest: f64 = 0.0;
    let mut z_homes_at = None;
    while !bench.hear(0.01).contains("ok") {
        let now = at(&bench);
        highest = highest.max(now[2]);
        if (now[0] - start[0]).abs() > 0.5 || (now[1] - start[1]).abs() > 0.5 {
            assert!(highest > start[2] + 6.9, "X or Y move before Z is up: {now:?}");
        }
        if now[2] < 1.0 {
            z_homes_at = Some([now[0], now[1]]);
        }
    }
    let [x, y] = z_homes_at.expect("Z was homed");
    assert!((x - 60.0).abs() < 0.05 && (y - 45.0).abs() < 0.05, "Z homes at {x} {y}");
    assert!(bench.say("G28.6").contains("X:1 Y:1 Z:1"));
    // Again, from a place that is known: not beyond the travel.
    bench.run(&["G1 Z198 F3000", "M400", "G28 X"]);
    assert!((at(&bench)[2] - 200.0).abs() < 0.05, "{:?}", at(&bench));
}

#[test]
fn z_alone_wants_x_and_y_homed() {
    let plan = Plan::new(CARTESIAN).set("[endstops] common.safe_z_x = 60");
    let mut bench = plan.start();
    let said = bench.say("G28 Z");
    assert!(said.contains("Z homes at safe_z_x and safe_z_y: home X and Y first"), "{said}");
    bench.run(&["G28 X Y", "G28 Z"]);
    assert!((at(&bench)[0] - 60.0).abs() < 0.05);
}

#[test]
fn z_alone_rises_too_before_it_goes_to_its_own_place() {
    let plan = Plan::new(CARTESIAN).set("[endstops] common.home_lift = 7");
    let plan = plan.set("[endstops] common.safe_z_x = 60").set("[endstops] common.safe_z_y = 45");
    let mut bench = plan.start_homed();
    bench.run(&["G1 X150 Y150 Z0.2 F6000", "M400"]);
    bench.type_in("G28 Z\n");
    while at(&bench)[0] > 149.0 {
        bench.hear(0.01);
    }
    assert!(at(&bench)[2] > 7.0, "the tool is dragged over the bed: {:?}", at(&bench));
}

#[test]
fn a_place_of_its_own_for_z_that_cannot_be_reached_is_found_in_the_configuration() {
    for order in ["[endstops] common.homing_order = ZXY", "[endstops] common.home_z_first = true"] {
        let bench = Plan::new(CARTESIAN).set("[endstops] common.safe_z_x = 60").set(order).start();
        assert!(bench.greeting().contains("Z homes before X and Y, and cannot go there"), "{}", bench.greeting());
    }
}

/// A clamp may stand in the way of an axis that nobody has named.
#[test]
fn homing_one_axis_moves_no_other_one_to_the_origin() {
    let mut bench = Plan::new(CARTESIAN).set("[endstops] common.move_to_origin_after_home = true").start_homed();
    bench.run(&["G1 X150 Y120 F6000", "M400", "G28 X", "M400"]);
    assert!((at(&bench)[1] - 120.0).abs() < 0.05, "Y has moved: {:?}", at(&bench));
    bench.run(&["G1 X150 F6000", "G28 X Y", "M400"]);
    assert!(at(&bench)[0].abs() < 0.05 && at(&bench)[1].abs() < 0.05, "{:?}", at(&bench));
}

#[test]
fn several_approaches_agree_or_homing_fails() {
    let plan = || {
        Plan::new(CARTESIAN)
            .set("[endstops] common.homing_samples = 4")
            .set("[endstops] common.homing_tolerance = 0.02")
            .set("[endstops] common.homing_retries = 1")
    };
    let mut bench = plan().start();
    let said = bench.say("G28 X");
    assert!(said.contains("// X: 4 approaches within 0.0"), "{said}");
    assert!(at(&bench)[0].abs() < 0.013);

    // A switch that is loose: between two approaches it moves.
    let mut bench = plan().start();
    bench.type_in("G28 X\n");
    let mut said = String::new();
    for _ in 0..2_000 {
        said += &bench.hear(0.05);
        if said.contains("ALARM") || said.contains("ERROR") || said.contains("ok") {
            break;
        }
        slip(&mut bench, Alpha, 0.004);
    }
    assert!(said.contains("mm apart, homing_tolerance is 0.02"), "{said}");
    bench.assert_safe();
    bench.say("M999");
    let homed = bench.say("G28.6");
    assert!(homed.contains("X:0"), "it is not homed: {homed}");
}

#[test]
fn a_script_stands_for_homing() {
    let script = "[endstops] common.home_gcode = G91_G1_Z3_F600_G90_G28_G1_X30_F6000";
    let mut bench = Plan::new(CARTESIAN).set(script).start();
    bench.say("G28");
    bench.run(&["M400"]);
    assert!((at(&bench)[0] - 30.0).abs() < 0.05, "{:?}", at(&bench));
    assert!(bench.say("G28.6").contains("X:1 Y:1 Z:1"));
    bench.run(&["G28 X", "M400"]);
    assert!(at(&bench)[0].abs() < 0.05, "one axis homes as ever");
    bench.say("$H");
    bench.run(&["M400"]);
    assert!((at(&bench)[0] - 30.0).abs() < 0.05);
}

/// Z homes by the script over the middle of the bed: beside it there is none.
#[test]
fn a_grid_is_not_measured_by_homing_past_the_script() {
    let mut bench = Plan::new(CARTESIAN)
        .set("[endstops] common.home_gcode = G28_X_Y_G1_X100_Y100_F6000_G28_Z")
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[zprobe] leveling = cartesian grid")
        .set("[cartesian grid leveling strategy] x_size = 100")
        .set("[cartesian grid leveling strategy] y_size = 100")
        .set("[cartesian grid leveling strategy] grid_x_size = 2")
        .set("[cartesian grid leveling strategy] grid_y_size = 2")
        .start();
    bench.lay(sim::models::surface::Surface::default());
    let before = at(&bench);
    assert!(bench.say("G32").starts_with("error:home the machine with G28 first: home_gcode"));
    assert_eq!(at(&bench), before, "nothing moved");
    bench.run(&["G28", "G1 X90 Y90 Z20 F6000", "M400"]);
    bench.type_in("G32\n");
    let mut nearest: f64 = 90.0;
    while bench.carriage(Gamma) > 10.0 {
        bench.hear(0.01);
        nearest = nearest.min(at(&bench)[0]);
    }
    assert!(nearest > 89.0, "it homes again, and not by the script: {nearest}");
}

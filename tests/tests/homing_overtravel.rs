//! Overtravel of a carriage beyond its switch in homing: never further than common switches give way,
//! whatever is configured.

use scenarios::{Bench, CARTESIAN, DELTA, Plan};
use sim::world::Fault;
use units::Actuator::{self, Alpha, Beta, Delta, Gamma};

/// Overtravel that a switch permits, mm.
const OVERTRAVEL: f64 = 0.3;
const ACCELERATIONS: [f64; 8] = [50.0, 100.0, 200.0, 500.0, 1_000.0, 3_000.0, 5_000.0, 10_000.0];
/// Fast rates, mm/s, up to the motors' max_rate, each with a slow rate.
const RATES: [(f64, f64); 6] = [(10.0, 2.0), (30.0, 5.0), (60.0, 10.0), (120.0, 10.0), (200.0, 20.0), (300.0, 50.0)];

fn machine(acceleration: f64, (fast, slow): (f64, f64)) -> Plan {
    let axes = ["x", "y", "z"].into_iter().zip(["alpha", "beta", "gamma"]);
    axes.fold(Plan::new(CARTESIAN), |plan, (axis, motor)| {
        plan.set(&format!("[endstops] min{axis}.fast_rate = {fast}"))
            .set(&format!("[endstops] min{axis}.slow_rate = {slow}"))
            .set(&format!("[actuator] {motor}.acceleration = {acceleration}"))
            .set(&format!("[actuator] {motor}.max_rate = 18000"))
            .set(&format!("[motion control] {axis}_axis_max_speed = 18000"))
            // The same switches and frame for every machine.
            .set(&format!("[endstops] min{axis}.max_travel = 220"))
    })
}

/// Returns how far below its switch, at zero, a carriage has been.
fn past(bench: &Bench, motor: Actuator) -> f64 {
    let [lowest, _] = bench.world(|world| world.reached_mm(motor)).expect("a motor");
    -lowest
}

#[track_caller]
fn assert_homed(bench: &Bench, motors: &[Actuator]) {
    for motor in motors {
        let at = bench.carriage(*motor);
        assert!(at.abs() < 0.013, "{} rests {at} mm from its switch", motor.name());
        assert_eq!(bench.world(|world| world.lost_mm(*motor)), 0.0, "{} was pushed against the frame", motor.name());
    }
}

/// `cargo test -p scenarios homing_overtravel:: -- --nocapture` prints the table.
#[test]
fn at_any_acceleration_and_speed() {
    println!("furthest past a switch, mm, of X, Y and Z");
    let head: Vec<String> = RATES.iter().map(|(fast, slow)| format!("{fast:.0}/{slow:.0} mm/s")).collect();
    println!("| mm/s2 | {} |", head.join(" | "));
    for acceleration in ACCELERATIONS {
        let row: Vec<String> = RATES
            .iter()
            .map(|rates| {
                let mut bench = machine(acceleration, *rates).start();
                bench.run(&["G28"]);
                assert_homed(&bench, &[Alpha, Beta, Gamma]);
                let most = [Alpha, Beta, Gamma].map(|motor| past(&bench, motor)).into_iter().fold(0.0, f64::max);
                assert!(most <= OVERTRAVEL, "{most} mm at {rates:?} mm/s and {acceleration} mm/s2");
                format!("{most:.3}")
            })
            .collect();
        println!("| {acceleration:.0} | {} |", row.join(" | "));
    }
}

#[test]
fn with_jerk_limits() {
    for jerk in [500.0, 5_000.0, 500_000.0] {
        let mut bench = machine(1_000.0, (60.0, 10.0)).set(&format!("[planner] jerk = {jerk}")).start();
        bench.run(&["G28"]);
        assert_homed(&bench, &[Alpha, Beta, Gamma]);
        for motor in [Alpha, Beta, Gamma] {
            assert!(past(&bench, motor) <= OVERTRAVEL, "{} with {jerk} mm/s3", past(&bench, motor));
        }
    }
}

#[test]
fn with_switches_that_bounce() {
    for acceleration in [50.0, 500.0, 10_000.0] {
        for rates in [(30.0, 5.0), (300.0, 20.0)] {
            for debounce in ["0", "5"] {
                let plan = machine(acceleration, rates).set(&format!("[endstops] common.debounce_ms = {debounce}"));
                let mut bench = plan.start();
                for name in ["minx", "miny", "minz"] {
                    bench.world(|world| world.inject(&Fault::SwitchBounces(name.into()))).expect("a switch");
                }
                bench.run(&["G28"]);
                assert_homed(&bench, &[Alpha, Beta, Gamma]);
                for motor in [Alpha, Beta, Gamma] {
                    let past = past(&bench, motor);
                    assert!(past <= OVERTRAVEL, "{past} mm at {rates:?}, {acceleration} mm/s2, debounce {debounce} ms");
                }
            }
        }
    }
}

/// Y by two motors, each with a switch.
fn gantry() -> Plan {
    [
        "[extruder] hotend.enable = false",
        "[actuator] delta.slaved_to = beta",
        "[actuator] delta.steps_per_mm = 80",
        "[actuator] delta.max_rate = 18000",
        "[actuator] delta.acceleration",
        "[current control] delta.current",
        "[endstops] mina.enable = true",
        "[endstops] mina.pin = PJ9^",
        "[endstops] mina.axis = A",
    ]
    .into_iter()
    .fold(machine(100.0, (60.0, 5.0)), Plan::set)
}

/// Moves the slave's carriage by hand: the gantry is racked.
fn rack(bench: &Bench, by_mm: f64) {
    let at_ns = (bench.now_s() * 1e9) as u64;
    let at = bench.carriage(Beta) + by_mm;
    bench.world(|world| world.place_carriage(at_ns, Delta, at));
}

#[test]
fn of_a_gantry_whose_two_motors_have_a_switch_each() {
    for racked in [0.0, 0.1, -0.1, -0.2] {
        let mut bench = gantry().start();
        rack(&bench, racked);
        bench.run(&["G28"]);
        assert!(bench.carriage(Beta).abs() < 0.013, "{racked}: {}", bench.carriage(Beta));
        assert!((bench.carriage(Delta) - racked).abs() < 0.013);
        for motor in [Beta, Delta] {
            let past = past(&bench, motor);
            assert!(past <= OVERTRAVEL, "racked by {racked} mm {} goes {past} mm past", motor.name());
        }
        assert_eq!(bench.say("G28.6"), "X:1 Y:1 Z:1 \nok\n");
    }
}

#[test]
fn a_slave_is_put_where_its_own_switch_says() {
    let mut bench = gantry().start();
    assert_eq!(bench.say("G28.7"), "error:G28.7 requires one axis argument (XYZ)\n");
    assert_eq!(bench.say("G28.7 Y0"), "error:The primary axis Y has not been homed: G28 Y0\n");
    assert!(bench.say("G28.7 X0").starts_with("error:axis X does not have a slaved axis"));
    // Aligned by hand: 1.5 mm from its switch where the master stands on its own.
    rack(&bench, 1.5);
    bench.run(&["G28"]);
    let aligned = bench.carriage(Delta);
    let said = bench.say("G28.7 Y0");
    let way: f64 = said.split(" moved ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap().parse().unwrap();
    assert!((way - 1.5).abs() < 0.013, "{said}");
    assert!((bench.carriage(Delta) - aligned).abs() < 0.013, "back where it was");
    assert_eq!(bench.say(&format!("M666 Y{way:.1}")), "X: 0.0000 Y: 1.5000 Z: 0.0000\nok\n");
    assert!(bench.say("M503").contains("M666 X0.00000 Y1.50000 Z0.00000"), "{}", bench.say("M503"));
    // Without current it slips; homing alone does not see that.
    rack(&bench, 2.4);
    bench.run(&["G28"]);
    let before = bench.carriage(Beta);
    assert!(bench.say("G28.7 Y1").contains("adjusted to 1.5"));
    assert!((bench.carriage(Delta) - aligned).abs() < 0.013, "{} is not {aligned}", bench.carriage(Delta));
    assert!((bench.carriage(Beta) - before).abs() < 1e-9, "the master stands");
    // Both motors move together again.
    bench.run(&["G1 Y30 F3000", "M400"]);
    assert!((bench.carriage(Delta) - bench.carriage(Beta) - aligned + before).abs() < 0.013);
}

#[test]
fn a_slave_does_not_go_far_and_a_halt_leaves_it_a_slave() {
    let mut bench = gantry().start();
    rack(&bench, 25.0);
    bench.run(&["G28"]);
    let [stood, before] = [bench.carriage(Delta), bench.carriage(Beta)];
    assert!(bench.say("G28.7 Y1").contains("was not triggered, please make sure it is within 20 mm"));
    assert!((bench.carriage(Delta) - stood).abs() < 0.013);
    bench.type_in("G28.7 Y1\n");
    bench.hear(1.0);
    bench.type_in("M112\n");
    bench.hear_until("Emergency stop", 3.0);
    assert!(stood - bench.carriage(Delta) > 1.0, "it was on its way");
    bench.say("M999");
    bench.run(&["G28", "G1 Y30 F3000", "M400"]);
    let apart = bench.carriage(Delta) - bench.carriage(Beta);
    bench.run(&["G1 Y60 F3000", "M400"]);
    assert!((bench.carriage(Delta) - bench.carriage(Beta) - apart).abs() < 0.013 && before.abs() < 0.013);
    // Limits guard by stopping the machine: they cannot be searched for.
    let mut bench = gantry().set("[endstops] mina.limit_enable = true").start();
    rack(&bench, 1.5);
    bench.run(&["G28"]);
    assert!(bench.say("G28.7 Y0").contains("limit must not be enabled for the endstop mina"));
}

// Smoothieware v2 makes some 4 billion steps then.
#[test]
fn a_slave_has_no_place_beyond_its_switch() {
    let mut bench = gantry().start();
    rack(&bench, 1.5);
    bench.run(&["G28"]);
    assert!(bench.say("M666 Y-1.5").ends_with("ok\n"));
    let edges = bench.world(|world| world.trace().total());
    assert_eq!(bench.say("G28.7 Y1"), "error:M666 Y is how far from its switch the slave stands: 0 to 20 mm\n");
    assert_eq!(bench.world(|world| world.trace().total()), edges);
}

#[test]
fn a_gantry_that_is_racked_too_far_is_not_driven_into_its_stop() {
    let mut bench = gantry().start();
    rack(&bench, -1.0);
    let said = bench.ask("G28") + &bench.hear(5.0);
    let told = "Y miny: the switch of its slave closed first, more than 0.25 mm before: the axis is racked";
    assert!(said.contains(told), "{said}");
    assert!(past(&bench, Delta) <= OVERTRAVEL, "{}", past(&bench, Delta));
    bench.assert_safe();
}

#[test]
fn of_the_towers_of_a_delta() {
    for acceleration in [50.0, 500.0] {
        let mut bench = ["alpha", "beta", "gamma"]
            .into_iter()
            .fold(Plan::new(DELTA), |plan, motor| {
                plan.set(&format!("[actuator] {motor}.acceleration = {acceleration}"))
            })
            .start();
        bench.run(&["G28"]);
        for (motor, name) in [(Alpha, "maxx"), (Beta, "maxy"), (Gamma, "maxz")] {
            let (past, lost) = bench.world(|world| {
                let at = world.config().switches.iter().find(|switch| switch.name == name).and_then(|s| s.operator);
                let (_, at, _) = at.expect("a tower's switch");
                (world.reached_mm(motor).expect("a motor")[1] - at, world.lost_mm(motor))
            });
            assert!(past <= OVERTRAVEL && lost == 0.0, "{name}: {past} mm past at {acceleration} mm/s2");
        }
    }
}

#[test]
fn limits_that_are_homed_to_are_left_again() {
    let limits = |plan: Plan, names: &[&str]| {
        names.iter().fold(plan, |plan, name| plan.set(&format!("[endstops] {name}.limit_enable = true")))
    };
    // Soft endstops would refuse the way back to a switch.
    let cartesian = Plan::new(CARTESIAN).set("[soft endstop] enable = false");
    let mut bench = limits(cartesian, &["minx", "miny", "minz"]).start();
    bench.run(&["G28"]);
    assert!(bench.say("M119").starts_with("X_min:0 Y_min:0 Z_min:0 "), "{}", bench.say("M119"));
    assert!(bench.say("M114").starts_with("ok C: X:5.0000 Y:5.0000 Z:2.0000"), "{}", bench.say("M114"));
    for (motor, retract) in [(Alpha, 5.0), (Beta, 5.0), (Gamma, 2.0)] {
        assert!((bench.carriage(motor) - retract).abs() < 0.013);
    }
    // The switches guard at once: 50 ms after they opened, and more time has passed.
    bench.hear(0.1);
    bench.run(&["G92 X50"]);
    bench.type_in("G1 X40 F1200\n");
    bench.hear_until("ALARM: Hard limit -X was hit (minx)", 3.0);
    // Only those that are limits are left.
    let mut bench = limits(Plan::new(CARTESIAN), &["miny"]).start();
    bench.run(&["G28"]);
    assert!(bench.say("M114").starts_with("ok C: X:0.0000 Y:5.0000 Z:0.0000"));
    // An axis that was not asked for does not move.
    bench.run(&["G28 X0"]);
    assert!(bench.say("M114").starts_with("ok C: X:0.0000 Y:5.0000 Z:0.0000"));
    let mut bench = limits(Plan::new(DELTA), &["maxx", "maxy", "maxz"]).start();
    bench.run(&["G28"]);
    assert!(bench.say("M119").contains("X_max:0 Y_max:0 Z_max:0 "), "{}", bench.say("M119"));
}

/// The stop at once may lose steps, and the slow approach measures: between them nobody knows.
#[test]
fn a_halt_between_the_stop_and_the_slow_approach_leaves_the_axis_unknown() {
    let mut bench = machine(500.0, (100.0, 10.0)).start();
    bench.run(&["G28", "G1 X20 F6000", "M400"]);
    bench.type_in("G28 X\n");
    while past(&bench, Alpha) < 0.0 {
        bench.hear(0.002);
    }
    bench.hear(0.05);
    bench.type_in("\x18");
    bench.hear(1.0);
    bench.say("M999");
    assert!(bench.say("G28.6").starts_with("X:0 Y:1 Z:1"), "X is not homed");
}

#[test]
fn a_hold_stops_the_search_for_a_slaves_switch_which_goes_on() {
    let mut held = gantry().start();
    rack(&held, 12.0);
    held.run(&["G28"]);
    let before = held.carriage(Delta) - held.carriage(Beta);
    held.type_in("G28.7 Y1\n");
    held.hear(0.25);
    held.type_in("!");
    held.hear(1.0);
    let edges = held.world(|world| world.trace().total());
    held.hear(2.0);
    assert_eq!(held.world(|world| world.trace().total()), edges);
    held.type_in("~");
    assert!((held.carriage(Delta) - held.carriage(Beta) - before).abs() > 0.5, "it was on its way");
    let said = held.hear_until("to its endstop", 20.0);
    assert!(!said.contains("rror"), "{said}");
    assert!(said.contains("moved 12.0000 mm to its endstop"), "exactly, all the same: {said}");
}

//! The phase of a motor at its switch: what it makes of a noisy switch, and what it sees that a switch does
//! not. Motors of the sample: 80 steps/mm of 16 microsteps, so a cycle of 0.8 mm, a full step of 0.2 mm.

use scenarios::{Bench, CARTESIAN, COREXY, DELTA, Plan};
use sim::world::Fault;
use units::Actuator::{self, Alpha, Beta, Gamma};

const CHECKED: &str = "[endstops] minx.phase_check = true";
const STEP: f64 = 1.0 / 80.0;
const FULL_STEP: f64 = 0.2;

fn checked() -> Plan {
    Plan::new(CARTESIAN).set(CHECKED)
}

/// Homes X some times from elsewhere; returns the resting place of each homing, mm, and all text said.
fn home_x(bench: &mut Bench, times: u32) -> (Vec<f64>, String) {
    let mut said = String::new();
    let places = (0..times)
        .map(|n| {
            bench.run(&[&format!("G1 X{} F6000", 20.0 + 3.7 * f64::from(n % 5)), "M400"]);
            said += &bench.say("G28 X");
            bench.carriage(Alpha)
        })
        .collect();
    (places, said)
}

fn spread(places: &[f64]) -> f64 {
    let [least, most] = places.iter().fold([f64::MAX, f64::MIN], |[a, b], place| [a.min(*place), b.max(*place)]);
    most - least
}

fn noisy(bench: &Bench, deviation_mm: f64) {
    bench.world(|world| world.make_switch_noisy("minx", deviation_mm)).expect("a switch");
}

/// Pulls a carriage along without its motor.
fn slip(bench: &Bench, motor: Actuator, mm: f64) {
    let (at_ns, place) = ((bench.now_s() * 1e9) as u64, bench.carriage(motor));
    bench.world(|world| world.place_carriage(at_ns, motor, place + mm));
}

#[test]
fn a_noisy_switch_homes_to_the_same_step() {
    for (plan, best) in [(Plan::new(CARTESIAN), None), (checked(), Some(STEP / 100.0))] {
        let mut bench = plan.start_homed();
        noisy(&bench, 0.02);
        let (places, said) = home_x(&mut bench, 25);
        println!("spread of 25 homings with 20 um of noise, phase check {}: {:.4} mm", best.is_some(), spread(&places));
        assert!(!said.contains("WARNING"), "{said}");
        match best {
            None => assert!(spread(&places) > 2.0 * STEP, "the switch is not noisy: {places:?}"),
            Some(best) => assert!(spread(&places) < best, "{places:?}"),
        }
    }
}

#[test]
fn with_several_approaches_and_aligned_zero_it_does_so_too() {
    for more in ["[endstops] common.homing_samples = 3", "[endstops] minx.phase_align_zero = true"] {
        let mut bench = checked().set("[endstops] common.homing_tolerance = 1").set(more).start();
        bench.say("M206 X0.07");
        bench.say("G28");
        noisy(&bench, 0.02);
        let (places, said) = home_x(&mut bench, 8);
        assert!(!said.contains("WARNING") && spread(&places) < STEP / 100.0, "{more}: {places:?} {said}");
        if more.contains("align") {
            bench.run(&["G1 X4 F600", "G1 X0", "M400"]);
            let counter = bench.world(|world| world.driver(0).microstep_counter());
            assert_eq!(counter % 256, 0, "zero is at a full step");
            let moved = places[0].abs();
            assert!(moved <= FULL_STEP / 2.0 + 3.0 * 0.02, "the switch is {moved} mm from its place");
        }
    }
}

#[test]
fn motors_that_turn_the_other_way_or_step_coarser_do_so_too() {
    for more in [
        "[actuator] alpha.reversed = true",
        "[actuator] alpha.microsteps = 32",
        "[actuator] alpha.microsteps = 8",
        "[tmc2590] alpha.step_interpolation = true",
    ] {
        let mut bench = checked().set(more).start_homed();
        noisy(&bench, 0.02);
        let (places, said) = home_x(&mut bench, 8);
        assert!(!said.contains("WARNING"), "{more}: {said}");
        assert!(spread(&places) < STEP / 100.0, "{more}: {places:?}");
    }
}

#[test]
fn a_pulley_that_slips_by_a_full_step_is_seen() {
    let mut bench = checked().set("[endstops] minx.phase_tolerance = 0.15").start_homed();
    assert!(!home_x(&mut bench, 2).1.contains("WARNING"));
    slip(&bench, Alpha, FULL_STEP);
    let said = bench.say("G28 X");
    assert!(said.contains("WARNING: X: the switch closed ") && said.contains("0.2000 mm from its phase"), "{said}");
    assert!(bench.carriage(Alpha).abs() < 2.0 * STEP, "it is homed to the switch: {}", bench.carriage(Alpha));
    assert!(bench.say("M875").contains("4 homings"));
}

#[test]
fn whole_cycles_that_a_motor_lost_are_counted() {
    // Once with a fast approach that brakes, once with one that stops at once.
    for rate in ["10", "50"] {
        let mut bench = checked().set(&format!("[endstops] minx.fast_rate = {rate}")).start_homed();
        assert!(!home_x(&mut bench, 2).1.contains("WARNING"));
        bench.run(&["G1 X30 F6000", "M400"]);
        slip(&bench, Alpha, -2.0 * 4.0 * FULL_STEP);
        let said = bench.say("G28 X");
        assert!(said.contains("WARNING: X: 8 full steps (1.600 mm) were lost since it was homed"), "{said}");
        assert!(!home_x(&mut bench, 2).1.contains("WARNING"));
        // A position declared by G28.3 or M206 is no lost step.
        bench.run(&["G28.3 X120"]);
        bench.say("M206 X3");
        assert!(!bench.say("G28 X").contains("lost"));
    }
}

#[test]
fn a_phase_far_off_halts_where_that_is_asked_for() {
    let mut bench = checked().set("[endstops] minx.phase_fault = halt").start_homed();
    slip(&bench, Alpha, 1.5 * FULL_STEP);
    let said = bench.say("G28 X");
    assert!(said.contains("mm from its phase") && said.contains("ERROR: Homing cycle failed"), "{said}");
    assert!(bench.status().starts_with("<Alarm"), "{}", bench.status());
    bench.say("M999");
    assert!(bench.say("G28.6").contains("X:0"));
}

#[test]
fn a_driver_that_says_nothing_is_told_of() {
    for (reaction, words) in [("warn", "homed to the switch alone"), ("halt", "Homing cycle failed")] {
        let plan = checked().set(&format!("[endstops] minx.phase_fault = {reaction}"));
        let mut bench = plan.set("[actuator] common.check_driver_errors = false").start_homed();
        bench.run(&["G1 X20 F6000", "M400"]);
        bench.world(|world| world.inject(&Fault::DriverSilent(Alpha))).expect("a driver");
        let said = bench.say("G28 X");
        assert!(said.contains("driver alpha does not say its phase") && said.contains(words), "{reaction}: {said}");
        assert_eq!(bench.say("G28.6").contains("X:1"), reaction == "warn");
    }
}

/// Ten homings with a noisy switch, the calibrated phase of them, and homings after the next power up.
#[test]
fn a_calibrated_phase_is_true_after_power_was_off() {
    let mut bench = checked().set("[general] config-override = true").start_homed();
    noisy(&bench, 0.02);
    assert!(bench.say("ENDSTOP_PHASE_CALIBRATE AXIS=Y").contains("write phase_check = true"));
    bench.run(&["M875.3"]);
    assert!(bench.say("ENDSTOP_PHASE_CALIBRATE AXIS=X").contains("home it first"));
    home_x(&mut bench, 3);
    assert!(bench.say("ENDSTOP_PHASE_CALIBRATE STEPPER=stepper_x").contains("home it some times more"));
    let (_, _) = home_x(&mut bench, 9);
    let report = bench.say("ENDSTOP_PHASE_CALIBRATE");
    assert!(report.contains("X: 12 homings") && report.contains("of a cycle of 0.8000"), "{report}");
    let said = bench.say("ENDSTOP_PHASE_CALIBRATE AXIS=X");
    assert!(said.contains("by 12 homings, sure to 0.0") && said.contains("M500 saves it"), "{said}");
    bench.say("M500");
    let saved = bench.read_card("config-override").expect("saved settings");
    assert!(saved.contains("M875.2 X"), "{saved}");
    let (before, _) = home_x(&mut bench, 1);
    for _ in 0..3 {
        // An arbitrary place, from which the rotor snaps when the power is cycled.
        bench.run(&["G1 X33.31 F6000", "M400"]);
        bench.cycle_power_and_snap();
        noisy(&bench, 0.02);
        assert!(bench.say("M875").contains("calibrated phase"), "{}{}", bench.greeting().to_owned(), bench.say("M875"));
        bench.run(&["G28"]);
        let (places, said) = home_x(&mut bench, 6);
        assert!(!said.contains("WARNING"), "{said}");
        let off = places.iter().map(|place| (place - before[0]).abs()).fold(0.0, f64::max);
        assert!(off < STEP / 100.0, "{off} mm from where it was homed before power was off: {places:?}");
    }
}

#[test]
fn a_wrong_calibration_is_told_in_the_first_homing() {
    let mut bench = checked().start_homed();
    let report = bench.say("M875");
    let phase: f64 = report.split("phase ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap().parse().unwrap();
    let wrong = (phase + 400.0) % 1_024.0;
    let mut bench = checked().set(&format!("[endstops] minx.phase = {wrong}")).start();
    let said = bench.say("G28 X");
    assert!(said.contains("-0.3125 mm from its phase, allowed are 0.2000"), "{said}");
    // Noise of half a cycle makes the phase meaningless.
    noisy(&bench, 0.5);
    home_x(&mut bench, 20);
    assert!(bench.say("M875.1 X").contains("its switch is too noisy"));
    bench.run(&["M875.2 X-1", "M875.3"]);
    assert!(bench.say("M875").contains("not calibrated"));
}

#[test]
fn both_motors_of_a_corexy_make_the_phase_of_an_axis() {
    let plan = Plan::new(COREXY).set(CHECKED).set("[endstops] miny.phase_check = true");
    let mut bench = plan.start_homed();
    bench.world(|world| world.make_switch_noisy("miny", 0.02)).expect("a switch");
    noisy(&bench, 0.02);
    let tool: Vec<[f64; 3]> = (0..8)
        .map(|n| {
            bench.run(&[&format!("G1 X{} Y{} F6000", 30.0 + 3.7 * f64::from(n), 60.0 - 7.1 * f64::from(n)), "M400"]);
            assert!(!bench.say("G28 X Y").contains("WARNING"));
            bench.world(|world| world.tool_mm())
        })
        .collect();
    for axis in 0..2 {
        let places: Vec<f64> = tool.iter().map(|place| place[axis]).collect();
        assert!(spread(&places) < STEP / 100.0, "axis {axis}: {places:?}");
    }
    assert!(bench.say("M875 X").contains("of a cycle of 0.4000"), "{}", bench.say("M875 X"));
}

#[test]
fn towers_of_a_delta_have_each_their_own() {
    let towers = ["maxx", "maxy", "maxz"];
    let plan =
        towers.iter().fold(Plan::new(DELTA), |plan, name| plan.set(&format!("[endstops] {name}.phase_check = true")));
    let mut bench = plan.start_homed();
    for name in towers {
        bench.world(|world| world.make_switch_noisy(name, 0.02)).expect("a switch");
    }
    let tool: Vec<[f64; 3]> = (0..6)
        .map(|n| {
            bench.run(&[&format!("G1 X{} Z100 F6000", 3.0 + f64::from(n)), "M400"]);
            assert!(!bench.say("G28").contains("WARNING"));
            bench.world(|world| world.tool_mm())
        })
        .collect();
    for axis in 0..3 {
        let places: Vec<f64> = tool.iter().map(|place| place[axis]).collect();
        assert!(spread(&places) < STEP, "axis {axis}: {places:?}");
    }
    let report = bench.say("M875");
    assert!(["X: 7 homings", "Y: 7 homings", "Z: 7 homings"].iter().all(|words| report.contains(words)), "{report}");
}

/// Nobody can read an external driver: its phases are true from the first homing to the next power up.
#[test]
fn an_external_driver_is_compared_with_its_first_homing() {
    let plan = checked().set("[actuator] alpha.driver = external").set("[actuator] alpha.en_pin = PE4");
    let mut bench = plan.set("[actuator] alpha.step_pin = PE11").set("[actuator] alpha.dir_pin = PE9").start();
    assert!(!bench.greeting().to_lowercase().contains("error"), "{}", bench.greeting());
    bench.run(&["G28"]);
    noisy(&bench, 0.02);
    let (places, said) = home_x(&mut bench, 8);
    assert!(!said.contains("WARNING") && spread(&places) < STEP / 100.0, "{places:?} {said}");
    assert!(bench.say("M875").contains("counts until power goes"));
    assert!(bench.say("M875.1 X").contains("external driver") && bench.say("M875.2 X7").contains("external driver"));
    slip(&bench, Alpha, 1.5 * FULL_STEP);
    assert!(bench.say("G28 X").contains("mm from its phase"));
}

/// Phase data of an on-board driver survives, as the chip itself reports its phase.
#[test]
fn without_motor_supply_an_external_driver_begins_anew() {
    for (driver, kept) in [("tmc2590", "X: 1 homings"), ("external", "X: no homing yet")] {
        let pins = ["alpha.step_pin = PE11", "alpha.dir_pin = PE9", "alpha.en_pin = PE4", "alpha.driver = external"];
        let pins = if driver == "external" { &pins[..] } else { &[] };
        let plan = pins.iter().fold(checked(), |plan, line| plan.set(&format!("[actuator] {line}")));
        let mut bench = plan.start();
        bench.run(&["G28 X"]);
        bench.world(|world| world.inject(&Fault::MotorSupply(0.0))).expect("a supply");
        assert!(bench.hear(3.0).contains("motor supply is off"));
        assert!(bench.say("M875").contains(kept), "{driver}: {}", bench.say("M875"));
    }
}

#[test]
fn a_tolerance_that_codes_made_too_wide_is_told() {
    let mut bench = checked().set("[endstops] minx.phase_tolerance = 0.15").start_homed();
    assert!(!bench.say("M875").contains("finds nothing"));
    bench.say("M92 X320");
    bench.run(&["G28 X"]);
    assert!(bench.say("M875").contains("write less than 0.1000"), "{}", bench.say("M875"));
}

#[test]
fn motors_without_the_check_are_not_asked() {
    let mut bench = Plan::new(CARTESIAN).start_homed();
    let frames = |bench: &Bench| {
        [Alpha, Beta, Gamma].map(|motor| bench.world(|world| world.driver(motor as usize).words().len()))
    };
    let before = frames(&bench);
    bench.run(&["G1 X20 F6000", "G28"]);
    assert_eq!(frames(&bench), before);
    assert!(bench.say("M875").contains("no homing endstop has phase_check"));
}

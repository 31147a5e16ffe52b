//! Homing without a switch, by the load that the driver measures. Motors of the sample: a full step of
//! 0.2 mm.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::world::Fault;
use units::Actuator::{Alpha, Beta};

const FULL_STEP: f64 = 0.2;
const FREE: [f64; 2] = [0.0, 205.0];

/// An axis without a switch: 50 mm/s, 250 full steps a second, at two thirds of the current.
fn without_switch(plan: Plan, stop: &str) -> Plan {
    plan.set(&format!("[endstops] {stop}.pin"))
        .set(&format!("[endstops] {stop}.slow_rate"))
        .set(&format!("[endstops] {stop}.stall_homing = true"))
        .set(&format!("[endstops] {stop}.stall_current = 0.8"))
}

fn machine() -> Plan {
    without_switch(Plan::new(CARTESIAN), "minx")
}

/// Returns the registers for current and load in the chip of X.
fn registers(bench: &Bench) -> [u32; 4] {
    let [drvctrl, _, smarten, sgcsconf, drvconf] = bench.world(|world| world.driver(0).registers());
    [drvctrl, smarten, sgcsconf, drvconf]
}

/// `cargo test -p scenarios stall_homing:: -- --nocapture` prints the figures.
#[test]
fn twenty_five_homings_end_within_two_full_steps() {
    for give in [0.0, 0.02, 0.1] {
        let mut bench = machine().start();
        let mut places = Vec::new();
        for n in 0..25_u32 {
            // The end gives way by some hundredths of a millimetre; the readings are noisy anyhow.
            let end = (f64::from(n * 7 % 5) / 2.0 - 1.0) * give;
            bench.world(|world| world.obstruct(Alpha, [end, 205.0]));
            let said = bench.say("G28 X");
            assert_eq!(said, "ok\n");
            places.push(bench.carriage(Alpha));
            bench.run(&[&format!("G1 X{} F6000", 20.0 + 3.7 * f64::from(n % 5)), "M400"]);
        }
        let [least, most] = places.iter().fold([f64::MAX, f64::MIN], |[a, b], place| [a.min(*place), b.max(*place)]);
        println!("25 homings without a switch, an end that gives way by {give} mm: within {:.3} mm", most - least);
        assert!(most - least <= 2.0 * FULL_STEP, "{places:?}");
        // The carriage rests `retract` from the end.
        assert!((least - 5.0).abs() < 2.0 * FULL_STEP && (most - 5.0).abs() < 2.0 * FULL_STEP, "{places:?}");
    }
}

#[test]
fn it_homes_from_its_end_and_from_a_step_beside_it() {
    for start in [0.0, 0.1, 0.4, 1.0, 3.0] {
        let mut bench = machine().start();
        bench.world(|world| world.place_carriage(0, Alpha, start));
        assert_eq!(bench.say("G28 X"), "ok\n");
        assert!((bench.carriage(Alpha) - 5.0).abs() < 2.0 * FULL_STEP, "from {start}: {}", bench.carriage(Alpha));
    }
}

#[test]
fn an_override_does_not_make_it_too_slow() {
    let mut bench = machine().start();
    bench.run(&["M220 S20"]);
    assert_eq!(bench.say("G28 X"), "ok\n");
    assert!((bench.carriage(Alpha) - 5.0).abs() < 2.0 * FULL_STEP, "{}", bench.carriage(Alpha));
    assert!(bench.say("M220").contains("20.00 %"), "and it is as it was");
}

#[test]
fn two_axes_without_switches_home_one_after_the_other() {
    let mut bench = without_switch(machine(), "miny").start();
    assert_eq!(bench.say("G28"), "ok\n");
    for motor in [Alpha, Beta] {
        assert!((bench.carriage(motor) - 5.0).abs() < 2.0 * FULL_STEP, "{}", bench.carriage(motor));
    }
    let said = bench.say("M114");
    assert!(said.contains("X:5.0000 Y:5.0000"), "{said}");
}

#[test]
fn the_chip_has_the_search_s_settings_meanwhile_and_its_own_again_whatever_happens() {
    let mut bench =
        machine().set("[endstops] minx.stall_threshold = 2").set("[tmc2590] alpha.coolstep_lower = 64").start();
    bench.run(&["G1 X1 F600", "M400"]);
    let before = registers(&bench);
    assert_ne!(before[1], 0, "coolStep is on");
    let searching = |bench: &mut Bench| {
        bench.type_in("G28 X\n");
        bench.hear(0.3);
        let now = registers(bench);
        assert_eq!((now[1], now[2] >> 8 & 0x7F, now[2] >> 16), (0, 2, 0), "coolStep off, the search's threshold");
        let amps = bench.world(|world| world.driver(0).peak_current_amps(0.05));
        assert!((amps - 0.8).abs() < 0.1, "{amps}");
    };
    // The homing is halted on its way.
    searching(&mut bench);
    bench.type_in("M112\n");
    bench.hear(1.0);
    assert_eq!(registers(&bench), before, "after a halt");
    bench.say("M999");
    // The end of the axis is missing.
    bench.world(|world| world.obstruct(Alpha, [-1_000.0, 1_000.0]));
    searching(&mut bench);
    bench.hear_until("did not stall within its travel", 20.0);
    bench.hear(0.5);
    assert_eq!(registers(&bench), before, "after failing");
    bench.say("M999");
    // The driver falls silent, and comes back.
    searching(&mut bench);
    bench.world(|world| world.inject(&Fault::DriverSilent(Alpha))).expect("a driver");
    bench.hear(10.0);
    bench.world(|world| world.inject(&Fault::Repaired)).expect("a machine");
    bench.say("M999");
    bench.world(|world| world.obstruct(Alpha, FREE));
    bench.run(&["G1 X2 F600", "M400"]);
    assert_eq!(registers(&bench), before, "after silence");
    assert_eq!(bench.say("G28 X"), "ok\n");
    assert_eq!(registers(&bench), before, "after success");
}

#[test]
fn a_threshold_that_is_too_high_or_too_low_is_told() {
    let mut bench = machine().set("[endstops] minx.stall_threshold = 40").start();
    let said = bench.say("G28 X");
    assert!(said.contains("did not stall within its travel: stall_threshold may be too high"), "{said}");
    let mut bench = machine().set("[endstops] minx.stall_threshold = -30").start();
    let said = bench.say("G28 X");
    assert!(said.contains("stalls before its end, or nearly: raise stall_threshold"), "{said}");
    bench.say("M999");
    assert!(bench.say("G28.6").contains("X:0"), "and nothing is homed");
}

/// With any threshold, the end is found or the fault is reported: no other place counts as the end.
#[test]
fn with_any_threshold_it_homes_to_its_end_or_fails() {
    for rate in ["40", "50", "100"] {
        let mut good = Vec::new();
        for threshold in (-40..=40).step_by(4) {
            let mut bench = machine()
                .set(&format!("[endstops] minx.fast_rate = {rate}"))
                .set("[endstops] minx.retract = 8")
                .set(&format!("[endstops] minx.stall_threshold = {threshold}"))
                .start();
            let said = bench.say("G28 X");
            if said == "ok\n" {
                assert!(
                    (bench.carriage(Alpha) - 8.0).abs() < 2.0 * FULL_STEP,
                    "{threshold}: {}",
                    bench.carriage(Alpha)
                );
                good.push(threshold);
            } else {
                assert!(said.contains("Error: X minx: the motor "), "{threshold}: {said}");
            }
        }
        println!("at {rate} mm/s these thresholds home: {good:?}");
        assert!(good.contains(&0), "{good:?}");
    }
}

#[test]
fn something_in_the_way_that_gives_way_is_no_end() {
    let mut bench = machine().start();
    bench.world(|world| world.obstruct(Alpha, [15.0, 205.0]));
    bench.type_in("G28 X\n");
    while bench.carriage(Alpha) > 15.01 {
        bench.hear(0.01);
    }
    bench.hear(0.03);
    bench.world(|world| world.obstruct(Alpha, FREE));
    bench.hear_until("does not stall where it did at first: something gave way", 5.0);
}

#[test]
fn a_speed_at_which_no_driver_sees_a_stall_is_refused_or_warned_of() {
    for (rate, word) in [("5", "too slow for a driver to see its motor stall"), ("30", "unstable below 200")] {
        let plan = machine().set(&format!("[endstops] minx.slow_rate = {rate}"));
        let bench = plan.start();
        assert!(bench.greeting().contains(word), "{}", bench.greeting());
    }
    let bench = machine().set("[endstops] minx.retract = 1").start();
    assert!(bench.greeting().contains("to be at 50 mm/s and look for the stall"), "{}", bench.greeting());
    for (more, word) in [
        ("[motion control] arm_solution = corexy", "moves more than one axis"),
        ("[endstops] minx.limit_enable = true", "and not where it is"),
        ("[endstops] minx.phase_check = true", "has no phase to be compared"),
        ("[endstops] minx.stall_current = 4", "above the driver's max_current"),
    ] {
        let bench = machine().set(more).start();
        assert!(bench.greeting().contains(word), "{more}: {}", bench.greeting());
    }
}

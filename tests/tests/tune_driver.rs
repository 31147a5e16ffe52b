//! Runs `tune_driver` on motors of several kinds, those of the sample: a full step of 0.2 mm.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::models::rotor::Plant;
use sim::world::Fault;
use units::Actuator::Alpha;

const FULL_STEP: f64 = 0.2;
const FREE: [f64; 2] = [0.0, 205.0];

/// Motors and loads, as they are sold and built: peak current, and what moves.
const MOTORS: [(&str, f64, Plant); 8] = [
    ("NEMA 17, 1.2 A, a carriage on a belt", 1.2, Plant::PRINTER),
    ("the same on stiff rails", 1.2, Plant { friction: 0.35, friction_noise: 0.04, ..Plant::PRINTER }),
    ("the same, a bed of 2 kg", 1.2, Plant { inertia: 9e-6, friction: 0.2, ..Plant::PRINTER }),
    (
        "NEMA 17, 1.7 A, low resistance",
        1.7,
        Plant { rated_amps: 1.7, ohms: 1.5, volts_per_full_step: 5.5e-3, ..Plant::PRINTER },
    ),
    (
        "pancake, 0.8 A, high resistance",
        0.8,
        Plant { rated_amps: 0.8, ohms: 4.5, volts_per_full_step: 8.0e-3, friction: 0.25, ..Plant::PRINTER },
    ),
    (
        "NEMA 23, 2.8 A",
        2.8,
        Plant {
            rated_amps: 2.8,
            ohms: 0.9,
            volts_per_full_step: 9.0e-3,
            inertia: 3e-6,
            friction: 0.1,
            ..Plant::PRINTER
        },
    ),
    ("a noisy one", 1.2, Plant { reading_noise: 28.0, friction_noise: 0.05, ..Plant::PRINTER }),
    ("a light gantry", 1.2, Plant { friction: 0.05, inertia: 0.8e-6, reading_noise: 8.0, ..Plant::PRINTER }),
];

/// X homes without a switch, and is watched.
fn machine(amps: f64) -> Plan {
    Plan::new(CARTESIAN)
        .set("[endstops] minx.pin")
        .set("[endstops] minx.slow_rate")
        .set("[endstops] minx.stall_homing = true")
        .set(&format!("[endstops] minx.stall_current = {:.2}", amps * 2.0 / 3.0))
        .set("[tmc2590] alpha.stall_watch = true")
        .set("[tmc2590] alpha.stall_filter = false")
        .set("[tmc2590] alpha.stall_threshold = 30")
        .set("[endstops] minx.fast_rate = 60")
        .set("[endstops] minx.retract = 8")
        .set(&format!("[current control] alpha.current = {amps}"))
}

/// Starts a machine that stands at its end and is said to be homed, though nothing is tuned: Z and Y home, X
/// is set.
fn start(plan: Plan, plant: Plant) -> Bench {
    let mut bench = plan.start();
    bench.world(|world| {
        world.fit_rotor(Alpha, plant);
        world.obstruct(Alpha, FREE);
    });
    bench.run(&["G28.3 X0"]);
    let place = bench.carriage(Alpha);
    bench.run(&[&format!("G28.3 X{place:.3}")]);
    bench
}

fn registers(bench: &Bench) -> [u32; 4] {
    let [drvctrl, _, smarten, sgcsconf, drvconf] = bench.world(|world| world.driver(0).registers());
    [drvctrl, smarten, sgcsconf, drvconf]
}

/// `cargo test -p scenarios tune_driver:: -- --nocapture` prints what is said.
#[test]
fn motors_of_many_kinds_then_home_without_a_switch_and_never_stall_by_themselves() {
    for (name, amps, plant) in MOTORS {
        let mut bench = start(machine(amps), plant);
        let begun = bench.now_s();
        let said = bench.say("tune_driver X");
        println!("{name}, in {:.0} s:\n{said}", bench.now_s() - begun);
        assert!(said.ends_with("ok\n") && said.contains("stall_threshold = "), "{name}: {said}");
        assert!(said.lines().all(|line| line.len() <= 111), "{name}: {said}");
        // Homing works with the tuned threshold.
        for _ in 0..3 {
            let homed = bench.say("G28 X");
            assert_eq!(homed, "ok\n", "{name}");
            assert!((bench.carriage(Alpha) - 8.0).abs() < 2.0 * FULL_STEP, "{name}: {}", bench.carriage(Alpha));
            bench.run(&["G1 X63 F6000", "M400"]);
        }
        // A free run at the speeds of jobs.
        let mut heard = String::new();
        for rate in [60, 90, 120, 150] {
            for x in [190, 20, 150, 60, 180, 30] {
                heard += &bench.say(&format!("G1 X{x} F{}", rate * 60));
            }
            heard += &bench.say("M400");
        }
        assert!(!heard.contains("stalls"), "{name}: {heard}");
        assert!(!bench.status().contains("Alarm"), "{name}");
        // And a crash is seen.
        bench.world(|world| world.obstruct(Alpha, [0.0, 120.0]));
        bench.type_in("G1 X190 F4800\n");
        bench.hear_until("motor X stalls", 10.0);
    }
}

#[test]
fn m500_saves_it_and_the_next_boot_has_it() {
    let plan = machine(1.2).set("[general] config-override = true");
    let mut bench = start(plan, Plant::PRINTER);
    assert!(bench.say("tune_driver X").ends_with("ok\n"));
    let (tuned, saved) = (registers(&bench), bench.say("M503"));
    assert!(saved.contains("M911.3 P0 S7 O") && saved.contains("M911.3 P0 S9 O"), "{saved}");
    bench.say("M500");
    bench.cycle_power();
    bench.world(|world| world.obstruct(Alpha, FREE));
    assert_eq!(registers(&bench)[2] >> 8, tuned[2] >> 8, "{}", bench.greeting());
    assert_eq!(bench.say("G28 X"), "ok\n");
    assert!((bench.carriage(Alpha) - 8.0).abs() < 2.0 * FULL_STEP);
    // Saved again, it is still there.
    assert!(bench.say("M503").contains("M911.3 P0 S9 O"));
}

#[test]
fn a_tuning_that_is_halted_stopped_or_fails_puts_back_what_was_there() {
    let mut bench = start(machine(1.2).set("[tmc2590] alpha.coolstep_lower = 64"), Plant::PRINTER);
    bench.run(&["G1 X5 F600", "M400"]);
    let before = registers(&bench);
    for (ends, seconds) in [("M112\n", 3.0), ("\x18", 12.0), ("\x19", 20.0)] {
        bench.type_in("tune_driver X\n");
        bench.hear(seconds);
        assert_ne!(registers(&bench), before, "{seconds}");
        bench.type_in(ends);
        bench.hear(6.0);
        assert_eq!(registers(&bench), before, "{seconds}");
        bench.say("M999");
        let place = bench.carriage(Alpha);
        bench.run(&[&format!("G28.3 X{place:.3}")]);
    }
    // The driver falls silent.
    bench.type_in("tune_driver X\n");
    bench.hear(3.0);
    bench.world(|world| world.inject(&Fault::DriverSilent(Alpha))).expect("a driver");
    let said = bench.hear_until("does not answer", 20.0);
    bench.hear(5.0);
    bench.world(|world| world.inject(&Fault::Repaired)).expect("a machine");
    bench.say("M999");
    bench.run(&["M400", "G91", "G1 X1 F600", "M400"]);
    assert_eq!(registers(&bench), before, "{said}");
    assert!(!bench.say("M503").contains("M911.3"), "nothing was changed");
}

#[test]
fn where_no_threshold_fits_it_says_so_and_changes_nothing() {
    // The motor has hardly torque to spare.
    let weak = Plant { friction: 0.93, friction_noise: 0.0, ..Plant::PRINTER };
    let mut bench = start(machine(1.2), weak);
    let before = registers(&bench);
    let said = bench.say("tune_driver X");
    assert!(said.contains("no threshold tells a stall from running free"), "{said}");
    assert_eq!(registers(&bench), before);
}

#[test]
fn what_cannot_be_measured_is_refused_and_nothing_moves() {
    let mut bench = machine(1.2).start();
    for (line, word) in [
        ("tune_driver", "tune_driver takes"),
        ("tune_driver X fast", "home X first"),
        ("tune_driver X", "home X first"),
        ("tune_driver C", "has no motor"),
    ] {
        assert!(bench.say(line).contains(word), "{line}");
    }
    bench.run(&["G28.3 X10"]);
    for (line, word) in [
        ("tune_driver X fast", "tune_driver takes"),
        ("tune_driver X 10", "give speeds from stall_least_speed"),
        ("tune_driver X 600", "give speeds from stall_least_speed"),
    ] {
        let said = bench.say(line);
        assert!(said.contains(word), "{line}: {said}");
    }
    let mut bench = Plan::new(scenarios::COREXY).start();
    assert!(bench.say("tune_driver X").contains("does not move this axis alone"));
}

/// TMC2590, 15 MHz: 150 clocks of 10 us, (150 - 24) / 32 = 3.9; 24 V * 3.6 us / 2.6 mH = 33 mA; 1.65 Ohm *
/// 1.19 A * 2 * 10.1 us / 2.6 mH = 15 mA; CS 10: 0.5 + 48.5 mA * 496 * 11 / 32 / 1.19 A - 8 = -0.5.
#[test]
fn a_chopper_is_computed_from_the_motor_s_data_sheet_and_kept_by_m500() {
    let plan = Plan::new(CARTESIAN).set("[actuator] alpha.coil_resistance = 1.65");
    let mut bench = plan.clone().start();
    let said = bench.say("tune_driver X chopper");
    assert!(said.contains("write [actuator] alpha.coil_resistance and alpha.coil_inductance"), "{said}");
    let mut bench = plan.clone().set("[actuator] alpha.coil_inductance = 2.6").start();
    let said = bench.say("tune_driver X chopper");
    for words in [
        "24.0 V, 1.19 A, 1.65 Ohm, 2.60 mH",
        "off_time 4: 10.1 us, twice in a cycle, for 25 kHz; the current falls by 15 mA",
        "blanking 54 clocks: 3.6 us, as it was; the current rises by 33 mA",
        "hysteresis start 1, end -1: 0, where -0.5 cover both",
        "Computed, not measured",
    ] {
        assert!(said.contains(words), "{words} is not in {said}");
    }
    let chopconf = |bench: &Bench| bench.world(|world| world.driver(0).registers()[1]);
    // TOFF is 0 while the motor is off; HEND -1 + 3, HSTRT 1 - 1, TBL 54 clocks.
    assert_eq!(chopconf(&bench), 2 << 7 | 3 << 15);
    bench.run(&["G91", "G1 X1 F600", "M400"]);
    assert_eq!(chopconf(&bench), 2 << 7 | 3 << 15 | 4);
    let saved = bench.say("M503");
    assert!(saved.contains("M911.3 P0 S1 U4 V54 W1 X-1 Y0"), "{saved}");
    // Loaded again it is the same; set by hand it is not the computed one any more.
    let mut again = Plan::new(CARTESIAN).start();
    again.run(&["M911.3 P0 S1 U4 V54 W1 X-1 Y0"]);
    assert_eq!(chopconf(&again), 2 << 7 | 3 << 15);
    bench.run(&["M911.3 P0 S1 U5 V54 W5 X0 Y0"]);
    assert!(!bench.say("M503").contains("S1 U4"));
    let mut bench =
        plan.set("[actuator] alpha.coil_inductance = 2.6").set("[actuator] alpha.coil_resistance = 30").start();
    assert!(bench.say("tune_driver X chopper").contains("24.0 V do not drive 1.19 A through 30.00 Ohm"));
}

/// More than the chip has is told, with what helps.
#[test]
fn a_motor_of_little_inductance_gets_what_there_is() {
    let plan = Plan::new(CARTESIAN).set("[actuator] alpha.coil_resistance = 0.5");
    let mut bench = plan.set("[actuator] alpha.coil_inductance = 0.4").start();
    let said = bench.say("tune_driver X chopper");
    assert!(said.contains("hysteresis start 8, end 7: 15") && said.contains("that is the most there is"), "{said}");
}

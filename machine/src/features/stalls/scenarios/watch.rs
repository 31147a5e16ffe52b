//! Stalls of motors while they move. Motors of the sample: a full step of 0.2 mm.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::Alpha;

const FULL_STEP: f64 = 0.2;
/// A part of two minutes: rapids, perimeters, infill, arcs of short moves.
const PART: &str = include_str!("../../../../../demo/part.gcode");

fn watched() -> Plan {
    ["alpha", "beta"].into_iter().fold(Plan::new(CARTESIAN), |plan, motor| {
        plan.set(&format!("[tmc2590] {motor}.stall_watch = true"))
            .set(&format!("[tmc2590] {motor}.stall_threshold = 2"))
            .set(&format!("[tmc2590] {motor}.stall_filter = false"))
    })
}

/// Runs X to 180 at this speed, mm/s, into an obstacle at 100; returns the full steps from there until the
/// report, and the text.
fn crash(bench: &mut Bench, mm_per_s: f64) -> (f64, String) {
    bench.run(&["G1 X20 F6000", "M400"]);
    bench.world(|world| world.obstruct(Alpha, [-3.0, 100.0]));
    bench.type_in(&format!("G1 X180 F{}\n", mm_per_s * 60.0));
    while bench.carriage(Alpha) < 99.99 {
        bench.hear(0.000_5);
    }
    let (met, mut said) = (bench.now_s(), String::new());
    while !said.contains("motor X stalls") {
        assert!(bench.now_s() < met + 2.0, "nothing is said of it: {said}");
        said += &bench.hear(0.000_5);
    }
    ((bench.now_s() - met) * mm_per_s / FULL_STEP, said)
}

/// `cargo test -p machine stalls::watch:: -- --nocapture` prints the figures.
#[test]
fn a_crash_is_seen_within_ten_full_steps_and_halts() {
    for mm_per_s in [50.0, 100.0, 200.0] {
        let mut bench = watched().start_homed();
        let (full_steps, said) = crash(&mut bench, mm_per_s);
        println!("a crash at {mm_per_s} mm/s is told after {full_steps:.1} full steps");
        assert!(said.contains("ERROR: motor X stalls: it hit something"), "{said}");
        assert!(full_steps <= 10.0, "{full_steps}");
        assert!(bench.status().contains("<Alarm"));
        bench.hear(1.5);
        bench.say("M999");
        assert_eq!(bench.say("G28.6"), "X:0 Y:0 Z:0 \nok\n");
    }
}

#[test]
fn where_it_does_not_halt_it_is_told_and_no_more_homed() {
    let mut bench = watched().set("[actuator] common.halt_on_stall = false").start_homed();
    let (_, said) = crash(&mut bench, 100.0);
    assert!(said.contains("WARNING: motor X stalls: it hit something"), "{said}");
    bench.say("M400");
    assert_eq!(bench.say("G28.6"), "X:0 Y:0 Z:0 \nok\n");
    assert!(!bench.status().contains("Alarm"));
}

#[test]
fn an_axis_that_homes_without_a_switch_is_watched_by_the_same_output() {
    let plan = watched().set("[endstops] minx.pin").set("[endstops] minx.slow_rate");
    let mut bench = plan.set("[endstops] minx.stall_homing = true").start_homed();
    assert!((bench.carriage(Alpha) - 5.0).abs() < 2.0 * FULL_STEP, "homing is no crash");
    assert!(crash(&mut bench, 100.0).1.contains("ERROR: motor X stalls"));
}

#[test]
fn a_sound_job_never_stalls() {
    let mut bench = watched().file("part.gcode", PART).start_homed();
    assert!(bench.say("M23 part.gcode").ends_with("ok\n"));
    assert_eq!(bench.say("M24"), "ok\n");
    let mut said = String::new();
    while !said.contains("Done printing file") {
        assert!(bench.now_s() < 2_000.0 && !said.contains("stalls"), "{said}");
        said += &bench.hear(1.0);
    }
}

/// X with a driver outside, its output DIAG on an input, and the chopper whose load the chip measures.
fn outside(kind: &str, own: &[&str]) -> Plan {
    let plan = Plan::new(CARTESIAN).with_x_outside(kind).set(&format!("[{kind}] alpha.stall_watch = true"));
    own.iter().fold(plan, |plan, line| plan.set(&format!("[{kind}] alpha.{line}")))
}

const OF_2209: &[&str] =
    &["sense_resistor = 110", "stall_pin = PG0", "stealthchop_threshold = 300", "stall_threshold = 10"];
const OF_5160: &[&str] = &["sense_resistor = 75", "spi_cs_pin = PJ9", "stall_pin = PG0!", "stall_threshold = 2"];
const OF_2130: &[&str] = &["sense_resistor = 110", "spi_cs_pin = PJ9", "stall_pin = PG0!", "stall_threshold = 2"];
const OF_2240: &[&str] = &["reference_resistor = 12000", "spi_cs_pin = PJ9", "stall_pin = PG0!", "stall_threshold = 2"];

/// stallGuard4 of a TMC2209, stallGuard2 of the chips on SPI.
#[test]
fn a_crash_of_a_motor_with_a_driver_outside_is_seen_as_soon() {
    for (kind, own) in
        [("tmc2209", OF_2209), ("tmc2226", OF_2209), ("tmc5160", OF_5160), ("tmc2130", OF_2130), ("tmc2240", OF_2240)]
    {
        for mm_per_s in [50.0, 200.0] {
            let mut bench = outside(kind, own).start_homed();
            assert!(
                !bench.greeting().contains("ERROR") && !bench.greeting().contains("WARNING"),
                "{}",
                bench.greeting()
            );
            let (full_steps, said) = crash(&mut bench, mm_per_s);
            println!("{kind}: a crash at {mm_per_s} mm/s is told after {full_steps:.1} full steps");
            assert!(said.contains("ERROR: motor X stalls: it hit something"), "{kind}: {said}");
            assert!(full_steps <= 10.0, "{kind}: {full_steps}");
        }
    }
}

#[test]
fn a_sound_job_with_a_driver_outside_never_stalls() {
    for (kind, own) in [("tmc2209", OF_2209), ("tmc5160", OF_5160)] {
        let mut bench = outside(kind, own).file("part.gcode", PART).start_homed();
        bench.say("M23 part.gcode");
        assert_eq!(bench.say("M24"), "ok\n");
        let mut said = String::new();
        while !said.contains("Done printing file") {
            assert!(bench.now_s() < 2_000.0 && !said.contains("stalls"), "{kind}: {said}");
            said += &bench.hear(1.0);
        }
    }
}

/// By the input by which the axis homes, where no other is named.
#[test]
fn an_axis_that_homes_by_its_driver_outside_is_watched_by_the_same_input() {
    let own: Vec<&str> = OF_2209.iter().copied().filter(|line| !line.starts_with("stall_pin")).collect();
    let plan = outside("tmc2209", &own).set("[endstops] minx.pin = PG0").set("[endstops] minx.slow_rate");
    let plan = plan.set("[endstops] minx.stall_threshold = 30").set("[endstops] minx.stall_current = 0.8");
    let mut bench = plan.set("[endstops] minx.stall_homing = true").start_homed();
    assert!((bench.carriage(Alpha) - 5.0).abs() < 2.0 * FULL_STEP, "homing is no crash: {}", bench.greeting());
    assert!(crash(&mut bench, 100.0).1.contains("ERROR: motor X stalls"));
}

#[test]
fn a_watch_that_could_see_nothing_is_told() {
    let without = |own: &[&'static str], key: &str| -> Vec<&'static str> {
        own.iter().copied().filter(|line| !line.starts_with(key)).collect()
    };
    for (kind, own, words) in [
        ("tmc2209", without(OF_2209, "stall_pin"), "its output DIAG leads nowhere"),
        ("tmc2209", without(OF_2209, "stealthchop"), "a tmc2209 measures load while stealthChop drives"),
        ("tmc5160", [OF_5160, &["stealthchop_threshold = 100"]].concat(), "measures no load while stealthChop drives"),
    ] {
        let bench = outside(kind, &own).start();
        assert!(bench.greeting().contains(words), "{kind}: {}", bench.greeting());
    }
    let bench = outside("tmc2209", OF_2209).set("[tmc2209] alpha.stall_watch = false").start();
    assert!(bench.greeting().contains("nobody looks at it while the motor moves"), "{}", bench.greeting());
}

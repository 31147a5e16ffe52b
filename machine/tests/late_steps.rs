//! Late steps: the report of them, and the end of the job when a step might have been lost.

use base::ports::StepTimes;
use scenarios::{Bench, CARTESIAN, Plan};
use units::{Actuator, Ticks};

const DELAYED: &str = "ERROR: steps came up to 12.5 us late and had to be delayed for their driver";
const NOT_READY: &str = "ERROR: steps were not ready in time and the motion stood still for a moment";

/// Returns a machine on its way from its initial place, 30 mm, to 130.
fn moving() -> Bench {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.run(&["G28.3 X30 Y30 Z30", "G1 X130 F6000"]);
    bench.hear(0.3);
    bench
}

/// Asserts that the machine is halted on the way and knows its position.
fn stands_where_it_says(bench: &mut Bench) {
    bench.assert_safe();
    let real = bench.carriage(Actuator::Alpha);
    assert!(real > 40.0 && real < 125.0, "{real} mm");
    let said = bench.say("M114.2");
    let told: f64 =
        said.split("X:").nth(1).and_then(|rest| rest.split(' ').next()).map_or(f64::NAN, |x| x.parse().unwrap());
    assert!((real - told).abs() < 0.01, "at {real} mm, told: {said}");
}

#[test]
fn a_step_delayed_for_its_driver_halts_and_positions_are_kept() {
    let mut bench = moving();
    bench.pretend_step_times(StepTimes { late: 2, delayed: 1, worst: Ticks(2_500) });
    let said = bench.hear(1.5);
    assert_eq!(said.matches(DELAYED).count(), 1, "{said}");
    stands_where_it_says(&mut bench);
}

#[test]
fn steps_that_were_not_ready_halt_and_positions_are_kept() {
    let mut bench = moving();
    bench.block_feed(8);
    let said = bench.hear(1.5);
    assert_eq!(said.matches(NOT_READY).count(), 1, "{said}");
    stands_where_it_says(&mut bench);
}

#[test]
fn a_feed_that_misses_a_run_or_two_goes_unnoticed() {
    let mut bench = moving();
    bench.block_feed(1);
    assert_eq!(bench.hear(2.0), "");
    assert!((bench.carriage(Actuator::Alpha) - 130.0).abs() < 1e-6);
}

#[test]
fn steps_merely_late_are_told_once_a_second() {
    let mut bench = moving();
    let mut said = String::new();
    for late in 1..=30 {
        bench.pretend_step_times(StepTimes { late, delayed: 0, worst: Ticks(60) });
        said.push_str(&bench.hear(0.1));
    }
    let told: Vec<_> = said.lines().collect();
    assert!(told.len() >= 3 && told.len() <= 4, "{said}");
    assert_eq!(told[0], "WARNING: 1 steps came late, by up to 0.3 us");
    assert_eq!(told[1], "WARNING: 10 steps came late, by up to 0.3 us");
    assert!((bench.carriage(Actuator::Alpha) - 130.0).abs() < 1e-6, "it does no harm");
    let asked = bench.say("get steps");
    assert!(asked.starts_with("steps late: 30 (worst 0.30 us), delayed: 0\n"), "{asked}");
}

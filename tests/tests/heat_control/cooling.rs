//! Cooling on purpose: nothing halts, and what waits for it waits as long as it takes.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::world::Fault;

const TOLD: &str = "TURN POWER OFF";

fn warm(plan: Plan, heater: &str, celsius: f64) -> Bench {
    let mut bench = plan.start();
    bench.world(|world| {
        let heater = world.heater_index(heater).expect("a heater");
        world.soak(heater, celsius);
    });
    bench.hear(1.0);
    bench
}

#[test]
fn a_bed_and_a_hot_end_cool_for_longer_than_any_time_of_heating_up() {
    // A minute is not enough for either; nor for a job to be asked to cool.
    for (heater, from, line, to, more) in [
        ("bed", 90.0, "M190 R40", 40.0, "runaway_heating_timeout"),
        ("hotend", 230.0, "M109 R45", 45.0, "runaway_heating_timeout"),
        // Off, that one made a lower target a runaway.
        ("hotend", 230.0, "M109 R45", 45.0, "runaway_cooling_timeout"),
    ] {
        let seconds = if more == "runaway_cooling_timeout" { 0 } else { 60 };
        let plan = Plan::new(CARTESIAN)
            .set(&format!("[temperature control] {heater}.{more} = {seconds}"))
            .set(&format!("[temperature control] {heater}.wait_timeout = 50"))
            .set(&format!("[temperature control] {heater}.hold_timeout = 50"));
        let mut bench = warm(plan, heater, from);
        bench.type_in(&format!("{line}\n"));
        let began = bench.now_s();
        let said = bench.hear_until("ok\n", 10_000.0);
        assert!(!said.contains("ERROR") && !said.contains("error"), "{line}: {said}");
        assert!(bench.now_s() - began > 60.0, "{line} took {} s", bench.now_s() - began);
        assert!((to - 1.0..=to + 1.2).contains(&bench.celsius(heater)), "{line}: {}", bench.celsius(heater));
    }
}

#[test]
fn a_lower_target_in_the_middle_of_a_job_is_no_fault() {
    let mut bench = warm(Plan::new(CARTESIAN), "bed", 100.0);
    assert_eq!(bench.say("M140 S35"), "ok\n");
    let said = bench.hear(3_000.0);
    assert!(!said.contains("ERROR") && bench.celsius("bed") < 40.0, "{said} {}", bench.celsius("bed"));
}

#[test]
fn colder_than_the_room_is_said_and_not_waited_for() {
    for line in ["M109 R5", "M116 P0 B5"] {
        let mut bench = warm(Plan::new(CARTESIAN), "hotend", 60.0);
        bench.type_in(&format!("{line}\n"));
        let said = bench.hear_until("ok\n", 10_000.0);
        assert!(
            said.contains("// NOTE hotend is at 2") && said.contains("and cools no more: not waiting for "),
            "{said}"
        );
        let said = bench.hear(2_000.0);
        assert!(!said.contains("ERROR"), "{said}");
    }
}

#[test]
fn klipper_waits_downward_with_s_as_well() {
    let mut bench = warm(Plan::new(CARTESIAN), "hotend", 120.0);
    bench.say("dialect klipper");
    assert!(bench.say("M109 S100").ends_with("ok\n"));
    assert!((99.0..101.2).contains(&bench.celsius("hotend")), "{}", bench.celsius("hotend"));
    // Off is not waited for.
    let before = bench.now_s();
    assert!(bench.say("M109 S0").ends_with("ok\n") && bench.now_s() - before < 1.0);
}

#[test]
fn a_heater_that_is_stuck_on_is_told_while_something_waits_for_it_to_cool() {
    for (heater, from, line) in [("hotend", 200.0, "M109 R50"), ("bed", 70.0, "M190 R40")] {
        let mut bench = warm(Plan::new(CARTESIAN), heater, from);
        bench.type_in(&format!("{line}\n"));
        bench.hear(20.0);
        bench.world(|world| world.inject(&Fault::HeaterStuckOn(heater.into()))).expect("a heater");
        let said = bench.hear_until(TOLD, 300.0);
        assert!(said.contains("ERROR"), "{said}");
    }
}

//! Probing where a switch of the axis that probes is a limit as well.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::models::surface::Bed;
use sim::world::Fault;
use units::Actuator::Gamma;

use super::{Z_STEP, assert_near, lay_bed, numbers, plan};

const HIT: &str = "ALARM: Hard limit -Z was hit (minz)";

/// Homed, and 20 mm above Z's switch, which is at zero and a limit.
fn above(plan: Plan) -> Bench {
    // Soft endstops would refuse the way to the switch.
    let mut bench = plan.set("[endstops] minz.limit_enable = true").set("[soft endstop] enable = false").start();
    bench.run(&["G28", "G1 X50 Y60 Z20 F6000", "M400"]);
    // Long enough open to guard.
    bench.hear(0.1);
    bench
}

#[test]
fn the_probe_closes_where_the_limit_does() {
    // Below, at and above the switch; and a search that gives the poll time between the two.
    for (height, feed) in [(0.0, 300), (0.1, 300), (-0.1, 300), (-0.2, 300), (-0.2, 30), (0.2, 1200)] {
        let mut bench = above(plan(CARTESIAN));
        lay_bed(&bench, Bed::level(height));
        let answer = bench.say(&format!("G30 F{feed}"));
        assert!(!answer.contains(HIT), "height {height} at F{feed}: {answer}");
        assert_near(numbers(&answer, "Z:")[0], 20.0 - height, Z_STEP);
        assert_near(bench.carriage(Gamma), 20.0, 1e-9);
        assert!(bench.status().starts_with("<Idle"), "height {height}: {}", bench.status());
        // And the limit guards again.
        bench.hear(0.1);
        bench.run(&["G92 Z50"]);
        bench.type_in("G1 Z25 F600\n");
        bench.hear_until(HIT, 3.0);
    }
}

#[test]
fn g38_and_m48_beside_the_limit_complete() {
    let mut bench = above(plan(CARTESIAN));
    assert_near(numbers(&bench.say("G38.2 Z-30 F300"), "[PRB:")[2], 0.0, Z_STEP);
    bench.run(&["G1 Z5 F600", "M400"]);
    assert!(bench.say("M48 P3").contains("Delta: 0.0000"));
}

/// A bed that is too low for the probe: the limit still keeps the nozzle from it.
#[test]
fn a_search_that_goes_on_past_the_limit_halts() {
    for (line, height) in [("G30", -2.0), ("G38.2 Z-25 F300", -2.0), ("G38.3 Z-25 F300", -1.0)] {
        let mut bench = above(plan(CARTESIAN));
        lay_bed(&bench, Bed::level(height));
        let said = bench.ask(line) + &bench.hear(10.0);
        assert_eq!(said.matches(HIT).count(), 1, "{line}: {said}");
        bench.assert_safe();
        let at = bench.carriage(Gamma);
        assert!((-0.8..=0.0).contains(&at), "{line}: it went on to {at}");
    }
}

/// A limit that opens while a search is under way must not take the search's input from it.
#[test]
fn a_search_that_begins_on_a_limit_finds_its_contact() {
    let mut bench = above(plan(CARTESIAN).set("[endstops] minx.limit_enable = true"));
    bench.world(|world| world.inject(&Fault::SwitchAlwaysOperated("minx".into()))).expect("a switch");
    bench.hear(0.1);
    lay_bed(&bench, Bed::level(5.0));
    bench.type_in("G38.2 Z-20 F300\n");
    bench.hear(1.0);
    bench.world(|world| world.inject(&Fault::Repaired)).expect("nothing");
    let said = bench.hear_until("[PRB:", 5.0);
    assert_near(numbers(&said, "[PRB:")[2], 5.0, Z_STEP);
}

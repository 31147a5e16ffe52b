//! Faults of a probe, and interruptions of probing: halts, holds, files.

use scenarios::{Bench, CARTESIAN};
use sim::models::surface::Bed;
use sim::world::Fault;
use units::Actuator::{Alpha, Gamma};

use super::{Z_STEP, assert_near, homed, lay_bed, numbers, plan};

/// A job's file with these lines, played to its end.
fn play(bench: &mut Bench) -> String {
    bench.say("M23 part.g");
    bench.type_in("M24\n");
    bench.hear(20.0)
}

#[test]
fn a_bed_out_of_reach_is_a_miss_that_ends_where_it_began() {
    let mut bench = homed(plan(CARTESIAN).set("[zprobe] max_travel = 10"));
    assert_eq!(bench.say("G30"), "ZProbe not triggered\nok\n");
    assert_near(bench.carriage(Gamma), 20.0, 1e-9);
    assert!(bench.status().starts_with("<Idle"));
}

#[test]
fn a_probe_before_homing_is_refused_where_moves_are() {
    let mut bench = plan(CARTESIAN).set("[motion control] must_be_homed = true").start();
    assert!(bench.say("G30").starts_with("Error: Must be homed before moving\n"));
}

#[test]
fn a_probe_that_is_stuck_closed_is_noticed_before_anything_moves() {
    let mut bench = homed(plan(CARTESIAN));
    bench.world(|world| world.inject(&Fault::SwitchAlwaysOperated("probe".into()))).expect("a probe");
    bench.hear(0.1);
    let edges = bench.world(|world| world.trace().total());
    for line in ["G30", "G38.2 Z-5", "G38.3 X5", "M48"] {
        assert_eq!(bench.say(line), "error:ZProbe triggered before move, aborting command.\n", "{line}");
    }
    assert_eq!(bench.world(|world| world.trace().total()), edges);
    assert!(bench.say("M119").contains("(Probe)PB10^:1 "));
}

#[test]
fn a_probe_that_is_stuck_open_ends_at_its_travel() {
    let plan = plan(CARTESIAN).set("[zprobe] max_travel = 21").fault("switch-never:probe");
    let mut bench = homed(plan);
    assert_eq!(bench.say("G30"), "ZProbe not triggered\nok\n");
    assert!(bench.say("G38.2 Z-21").contains("ALARM: Probe fail\n"));
    bench.assert_safe();
    assert_eq!(bench.world(|world| world.lost_mm(Gamma)), 0.0);
}

#[test]
fn a_bouncing_contact_counts_from_its_first_edge() {
    for debounce in ["0", "10"] {
        let plan = plan(CARTESIAN).set(&format!("[zprobe] debounce_ms = {debounce}")).fault("switch-bounces:probe");
        let mut bench = homed(plan);
        lay_bed(&bench, Bed::level(1.0));
        assert_near(numbers(&bench.say("G38.2 Z-30 F600"), "[PRB:")[2], 1.0, Z_STEP);
    }
}

/// A spark on the probe's wire while it searches.
fn spark(bench: &mut Bench) {
    for pressed in [true, false] {
        let at_ns = (bench.now_s() * 1e9) as u64;
        bench.world(|world| world.press(at_ns, "probe", pressed)).expect("a probe");
        bench.hear(0.001);
    }
}

#[test]
fn with_debounce_a_spark_does_not_count_and_the_search_goes_on() {
    let mut bench = homed(plan(CARTESIAN).set("[zprobe] debounce_ms = 5"));
    lay_bed(&bench, Bed::level(1.0));
    bench.type_in("G38.2 Z-30 F300\n");
    for _ in 0..2 {
        bench.hear(0.5);
        spark(&mut bench);
    }
    let answer = bench.hear_until("ok\n", 20.0);
    assert_near(numbers(&answer, "[PRB:")[2], 1.0, Z_STEP);
    // Without, the first edge stops the search, as for a probe that gives only a pulse.
    let mut bench = homed(plan(CARTESIAN));
    bench.type_in("G38.2 Z-30 F300\n");
    bench.hear(0.5);
    spark(&mut bench);
    let answer = bench.hear_until("ok\n", 20.0);
    assert!(numbers(&answer, "[PRB:")[2] > 15.0, "{answer}");
}

#[test]
fn a_contact_that_never_stays_is_the_wirings_fault() {
    let mut bench = homed(plan(CARTESIAN).set("[zprobe] debounce_ms = 5"));
    bench.type_in("G38.2 Z-30 F60\n");
    let mut heard = String::new();
    for _ in 0..20 {
        heard += &bench.hear(0.3);
        spark(&mut bench);
    }
    assert!(heard.contains("Error: the probe fires but does not stay triggered: check its wiring\n"), "{heard}");
    bench.assert_safe();
}

#[test]
fn a_halt_ends_a_search_and_the_next_one_works() {
    for stop in ["\x18", "kill"] {
        let plan = plan(CARTESIAN).set("[kill button] enable = true").set("[kill button] pin = PB7^");
        let mut bench = homed(plan);
        bench.type_in("G38.2 Z-30 F300\n");
        bench.hear(0.5);
        let mut said = String::new();
        if stop == "kill" {
            let at_ns = (bench.now_s() * 1e9) as u64;
            bench.world(|world| world.press(at_ns, "kill", true)).expect("a button");
            said += &bench.hear(0.1);
            bench.world(|world| world.press(at_ns, "kill", false)).expect("a button");
        } else {
            bench.type_in(stop);
        }
        said += &bench.hear(0.5);
        assert!(said.contains("ALARM: ") && !said.contains("PRB"), "{said}");
        bench.assert_safe();
        bench.say("M999");
        // The machine knows its position, to the step, for it has braked.
        let place = numbers(&bench.status(), "<Idle|MPos:")[2];
        assert_near(bench.carriage(Gamma), place, 0.5001 * Z_STEP);
        assert_near(numbers(&bench.say("G38.2 Z-30"), "[PRB:")[2], 0.0, Z_STEP);
    }
}

#[test]
fn a_search_can_be_held_and_goes_on() {
    let mut bench = homed(plan(CARTESIAN));
    lay_bed(&bench, Bed::level(1.0));
    bench.type_in("G38.2 Z-30 F300\n");
    bench.hear(0.5);
    bench.type_in("!");
    bench.hear(0.2);
    let held = bench.carriage(Gamma);
    assert!(bench.status().starts_with("<Hold"));
    bench.hear(1.0);
    assert_eq!(bench.carriage(Gamma), held);
    bench.type_in("~");
    let answer = bench.hear_until("ok\n", 20.0);
    assert_near(numbers(&answer, "[PRB:")[2], 1.0, Z_STEP);
    assert!(bench.status().starts_with("<Idle"));
}

#[test]
fn a_contact_during_a_hold_counts_and_nothing_moves_before_the_operator_says_so() {
    let mut bench = homed(plan(CARTESIAN));
    bench.type_in("G38.2 Z-30 F300\n");
    bench.hear(0.5);
    bench.type_in("!");
    bench.hear(0.2);
    let held = bench.carriage(Gamma);
    let at_ns = (bench.now_s() * 1e9) as u64;
    bench.world(|world| world.press(at_ns, "probe", true)).expect("a probe");
    let said = bench.hear(1.0);
    assert!(!said.contains("PRB") && bench.status().starts_with("<Hold"), "{said}");
    assert_eq!(bench.carriage(Gamma), held);
    bench.type_in("~");
    let answer = bench.hear_until("ok\n", 2.0);
    assert_near(numbers(&answer, "[PRB:")[2], held, Z_STEP);
    assert!(bench.status().starts_with("<Idle"));
}

#[test]
fn a_file_does_not_go_on_with_a_height_it_does_not_know() {
    for (fault, line, reason) in [
        ("switch-always:probe@30", "G30 Z0", "error:ZProbe triggered before move, aborting command.\n"),
        ("switch-never:probe", "G30 Z0", "error:ZProbe not triggered\n"),
        ("switch-never:probe", "G38.2 Z-5", "ALARM: Probe fail\n"),
    ] {
        let job = format!("{line}\nG1 X100 F6000\n");
        let mut bench = homed(plan(CARTESIAN).set("[zprobe] max_travel = 5").file("part.g", &job).fault(fault));
        while bench.now_s() < 30.1 {
            bench.hear(1.0);
        }
        let said = play(&mut bench);
        assert!(said.contains(reason), "{said}");
        assert_near(bench.carriage(Alpha), 50.0, 1e-9);
        if reason.starts_with("ALARM") {
            bench.assert_safe();
        } else {
            assert!(said.contains("error:paused, line 1 of "), "{said}");
        }
    }
}

#[test]
fn a_file_probes_and_prints_on_the_height_it_found() {
    let mut bench = homed(plan(CARTESIAN).file("part.g", "G30 Z0\nG1 Z5 F600\nG1 X100 F6000\n"));
    lay_bed(&bench, Bed::level(0.7));
    let said = play(&mut bench);
    assert!(said.contains("Done printing file"), "{said}");
    assert_near(bench.carriage(Gamma), 5.7, Z_STEP);
    assert_near(bench.carriage(Alpha), 100.0, 1e-9);
}

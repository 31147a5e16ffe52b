//! Tests of an axis, and figures to be drawn: what they say, and what they leave.

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
fn an_axis_says_how_well_it_homes() {
    let mut bench = Plan::new(CARTESIAN).start();
    let said = bench.say("test endstop x 5");
    assert!(said.contains("// X: 5 approaches within 0.0") && said.contains("standard deviation 0.0"), "{said}");
    assert!(bench.say("test endstop q").contains("axis must be"));
    assert!(bench.say("test endstop").contains("usage: test endstop axis [approaches]"));
}

#[test]
fn lost_steps_are_found_and_counted() {
    let mut bench = Plan::new(CARTESIAN).start();
    let said = bench.say("test speed x 100 100 3");
    assert!(said.contains("X is where it was, within 0.0") && said.contains("no step was lost"), "{said}");
    bench.type_in("test speed x 100 100 3\n");
    // The carriage is on its way back and forth by then. 80 steps a mm in 16 microsteps: four full steps are
    // 0.8 mm.
    bench.hear(1.0);
    while bench.carriage(Alpha) < 50.0 {
        bench.hear(0.01);
    }
    slip(&mut bench, Alpha, 1.6);
    let said = bench.hear_until("lost", 60.0);
    assert!(said.contains("8 full steps were"), "{said}");
}

/// At 20 to 40 Hz, half a second each: so many turns back, and nothing is left of it.
#[test]
fn a_sweep_shakes_an_axis_and_leaves_it_where_it_was() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.run(&["G28", "G1 X50 Y50 F6000", "M400"]);
    let before = at(&bench);
    bench.world(|world| world.trace_mut().take());
    let began = bench.now_s();
    let said = bench.say("test sweep x 20 40 0.5");
    let took = bench.now_s() - began;
    assert!(["20 Hz", "25 Hz", "40 Hz"].iter().all(|word| said.contains(word)), "{said}");
    let edges = bench.world(|world| world.trace_mut().take());
    let turns = edges.windows(2).filter(|pair| pair[0].direction != pair[1].direction).count();
    // Two turns a period, but for the last.
    let expected: f64 = (20..=40).map(|hertz| 2.0 * (f64::from(hertz) * 0.5).ceil()).sum();
    assert!((turns as f64 + 1.0 - expected).abs() < 1.5, "{turns} turns of {expected}");
    assert!((9.5..12.5).contains(&took), "21 half seconds took {took} s");
    assert!(at(&bench).iter().zip(before).all(|(now, before)| (now - before).abs() < 0.013));
    let limits = bench.say("M503");
    assert!(limits.contains("M204 S"), "{limits}");
    assert!(bench.say("test sweep x 0 40").contains("frequencies are from 1 to 200 Hz"));
}

#[test]
fn an_acceleration_is_as_it_was_behind_a_sweep() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.run(&["G28", "G1 X50 F6000", "M204 S777"]);
    bench.say("test sweep x 20 22 0.2");
    let settings = bench.ask("M503");
    let settings = settings + &bench.hear(1.0);
    assert!(settings.contains("M204 S777"), "{settings}");
    bench.run(&["M204 X900"]);
    let said = bench.say("test sweep x 20 40 0.2");
    assert!(said.contains("this needs 3000 mm/s2, and motor X may take 900: M204 X changes it"), "{said}");
}

#[test]
fn backlash_is_measured_with_the_probe() {
    for backlash in [0.0, 0.12] {
        let plan = Plan::new(CARTESIAN).set("[zprobe] enable = true").set("[zprobe] probe_pin = PB10^");
        let mut bench = plan.set("[zprobe] slow_feedrate = 2").start();
        bench.run(&["G28 X Y", "G28.3 Z10"]);
        bench.world(|world| world.loosen(Gamma, backlash));
        let said = bench.say("test backlash z -30");
        let measured: f64 =
            said.trim_start_matches("Z: ").split(' ').next().and_then(|mm| mm.parse().ok()).expect(&said);
        assert!((measured - backlash).abs() < 0.01, "{backlash} mm: {said}");
    }
}

fn homed() -> Bench {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.run(&["G28", "G1 X50 Y50 Z5 F6000", "M400"]);
    bench
}

// --- figures ---

#[test]
fn figures_are_drawn_and_nothing_of_them_stays() {
    let mut bench = homed();
    bench.run(&["G91", "G1 F1500"]);
    let state = bench.say("$G");
    for (line, seconds) in [("test jog x 10 2", 0.8), ("test square 10 2 3000", 1.6), ("test circle 10 1 3000", 1.6)] {
        let (began, least) = (bench.now_s(), seconds);
        assert_eq!(bench.say(line), "ok\n", "{line}");
        assert!(bench.now_s() - began > least, "{line}: {} s", bench.now_s() - began);
        assert!((bench.carriage(Alpha) - 50.0).abs() < 0.02 && (bench.carriage(Beta) - 50.0).abs() < 0.02, "{line}");
        let now = bench.say("$G");
        assert_eq!(now.split(' ').skip(1).collect::<Vec<_>>(), state.split(' ').skip(1).collect::<Vec<_>>(), "{line}");
    }
    assert_eq!(bench.say("test jog y 5 1"), "ok\n");
    assert!((bench.carriage(Beta) - 55.0).abs() < 0.02, "an odd number of moves ends at the other end");
    bench.run(&["G20"]);
    assert_eq!(bench.say("test jog y 1 1 200"), "ok\n");
    assert!((bench.carriage(Beta) - 80.4).abs() < 0.02, "inches: {}", bench.carriage(Beta));
}

#[test]
fn a_figure_that_leaves_the_travel_does_not_begin() {
    let mut bench = homed();
    for line in ["test jog x 9999 2", "test square 9999 1", "test circle 60 1", "test acc x -60 10"] {
        let said = bench.say(line);
        assert!(said.contains("out of travel"), "{line}: {said}");
        bench.say("$X");
    }
    assert!((bench.carriage(Alpha) - 50.0).abs() < 0.02, "{}", bench.carriage(Alpha));
}

#[test]
fn a_figure_ends_by_ctrl_y_and_by_a_halt() {
    let mut bench = homed();
    bench.type_in("test jog x 10 1000 3000\n");
    assert_eq!(bench.hear(1.0), "");
    bench.send(b"\x19");
    assert_eq!(bench.hear(1.0), "ok\n");
    assert!(!bench.moves());
    let state = bench.say("$G");
    bench.type_in("test square 10 1000 3000\n");
    bench.hear(1.0);
    bench.type_in("M112\n");
    bench.hear(1.0);
    assert!(!bench.moves());
    assert_eq!(bench.say("test jog x 1 1"), "!!\n");
    assert!(bench.say("M999").ends_with("ok\n"));
    assert_eq!(bench.say("$G").contains(" G90 "), state.contains(" G90 "));
}

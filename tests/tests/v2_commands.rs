//! Commands of Smoothieware v2 for whoever builds a machine, `test raw` and `gpio`; and its M23 and M26.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::Alpha;

fn start() -> Bench {
    Plan::new(CARTESIAN).start()
}

fn homed() -> Bench {
    let mut bench = start();
    bench.run(&["G28", "G1 X50 Y50 Z5 F6000", "M400"]);
    bench
}

// --- test raw ---

#[test]
fn one_motor_makes_so_many_steps() {
    let mut bench = homed();
    let steps = |bench: &mut Bench| -> i64 {
        let said = bench.say("get pos");
        let raw = said.lines().find(|line| line.starts_with("RAW:")).expect("steps");
        raw.split_whitespace().nth(1).expect("X").parse().expect("steps")
    };
    let before = steps(&mut bench);
    assert_eq!(bench.say("test raw x 123 1000"), "issuing 123 steps at a rate of 1000 steps/sec on the X axis\nok\n");
    assert_eq!(steps(&mut bench) - before, 123);
    assert_eq!(bench.say("test raw x -123 1000"), "issuing 123 steps at a rate of 1000 steps/sec on the X axis\nok\n");
    assert_eq!(steps(&mut bench), before);
    assert!(bench.say("test acc x 2 20").contains("on the X axis\nok\n"));
    assert!((bench.carriage(Alpha) - 52.0).abs() < 0.02);
    assert!(bench.say("test raw c 10 10").starts_with("error:axis is out of range"));
    assert!(bench.say("test").starts_with("error:usage: test jog|square"));
    assert!(bench.say("test -h").starts_with("test "));
}

// --- gpio ---

#[test]
fn a_pin_that_nothing_uses_is_looked_at_and_driven() {
    let mut bench = start();
    assert_eq!(bench.say("gpio PJ1"), "PJ1^:1\nok\n");
    assert_eq!(bench.say("gpio pj_1v in"), "PJ1v:0\nok\n");
    assert_eq!(bench.say("gpio PJ1!v"), "PJ1!v:1\nok\n");
    let began = bench.now_s();
    assert_eq!(bench.say("gpio PJ1 out on 500"), "PJ1:1: was set to on\nok\n");
    assert!(bench.now_s() - began > 0.5);
    bench.type_in("gpio PJ1 out off\n");
    assert_eq!(bench.hear(0.2), "PJ1:0: was set to off\n", "it is driven for two seconds");
    bench.send(b"\x19");
    assert_eq!(bench.hear(0.2), "ok\n");
}

#[test]
fn a_pin_that_something_uses_is_refused() {
    let mut bench = start();
    for (line, why) in [
        ("gpio PD3", "PD3 is used by actuator.alpha"),
        ("gpio PE0 out on", "temperature control.hotend"),
        ("gpio PC8", "belongs to the SD card"),
        ("gpio PD5", "belongs to the debug UART"),
        ("gpio PJ14 out on", "the boot button drives it"),
        ("gpio XX", "Illegal pin name: XX"),
        ("gpio PJ1 sideways", "incorrect usage"),
    ] {
        let said = bench.say(line);
        assert!(said.starts_with("error:") && said.contains(why), "{line}: {said}");
    }
    assert_eq!(bench.say("gpio PJ14"), "PJ14^:1\nok\n", "to look at it is allowed");
}

// --- files ---

// Smoothieware v2: M26 ends the job, and M23 answers with the size of the file that plays.
#[test]
fn a_file_that_plays_is_begun_anew_by_m26_and_keeps_its_place_from_m23() {
    let job = "G91\nG1 X10 F6000\nG4 S2\nG1 X-10\n".repeat(2);
    let mut bench = Plan::new(CARTESIAN).file("a.g", &job).file("b.g", "G28\n").start();
    bench.say("M23 a.g");
    bench.say("M24");
    bench.hear(1.0);
    let begun = bench.carriage(Alpha);
    assert!(bench.say("M23 b.g").starts_with("error:"));
    assert_eq!(bench.say("M26"), "ok\n");
    bench.hear(1.5);
    assert!((bench.carriage(Alpha) - begun - 10.0).abs() < 0.02, "its first line again");
}

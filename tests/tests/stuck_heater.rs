//! A heater whose MOSFET conducts whatever it is told: in every state the supply that the board can cut is
//! cut and a person is told.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::world::Fault;
use units::Actuator::Alpha;

const TOLD_HOT_END: &str = "ERROR: T is switched off and has warmed by ";
const TOLD_BED: &str = "ERROR: B is switched off and has warmed by ";

fn fail(bench: &Bench, fault: Fault) {
    bench.world(|world| world.inject(&fault)).expect("a part of this machine");
}

/// Sticks the heater on now. Seconds until one of these words is said, and how hot the heater has become by
/// then.
fn time_to_tell(bench: &mut Bench, heater: &str, words: &[&str], patience_s: f64) -> (f64, f64) {
    let began = bench.now_s();
    fail(bench, Fault::HeaterStuckOn(heater.into()));
    let mut heard = String::new();
    while !words.iter().any(|word| heard.contains(word)) {
        assert!(bench.now_s() - began < patience_s, "none of {words:?} within {patience_s} s: {heard}");
        heard.push_str(&bench.hear(0.05));
    }
    assert!(heard.contains("TURN POWER OFF IMMEDIATELY"), "{heard}");
    (bench.now_s() - began, bench.celsius(heater))
}

fn assert_cut_off(bench: &mut Bench) {
    assert_eq!(bench.world(|world| world.vfet_v()), 0.0, "the supply of hot ends and fans is on");
    assert!(bench.status().contains("<Alarm"), "it must be halted");
}

/// Prints the measurement, for the closing lines of `cargo test -p scenarios stuck_heater:: -- --nocapture`.
fn show(state: &str, heater: &str, (seconds, celsius): (f64, f64)) {
    println!("| {heater} | {state} | {seconds:.1} s | {celsius:.0} C |");
}

#[test]
fn idle_and_cold() {
    for (heater, told, limit_s) in [("hotend", TOLD_HOT_END, 20.0), ("bed", TOLD_BED, 75.0)] {
        let mut bench = Plan::new(CARTESIAN).start();
        let found = time_to_tell(&mut bench, heater, &[told], limit_s);
        show("idle, never used", heater, found);
        assert_cut_off(&mut bench);
        if heater == "bed" {
            // The bed's connector lies before the supply's switch: the bed goes on heating, the operator is
            // told again, and turns the power off.
            bench.hear_until(told, limit_s);
            fail(&bench, Fault::FetSupply(0.0));
        }
        // The heater cools, and stays off until a person says otherwise.
        let hottest = bench.celsius(heater);
        bench.hear(30.0);
        assert!(bench.celsius(heater) < hottest);
    }
}

#[test]
fn idle_after_use() {
    for (heater, heat, off, told, limit_s) in
        [("hotend", "M109 S200", "M104 S0", TOLD_HOT_END, 40.0), ("bed", "M190 S60", "M140 S0", TOLD_BED, 90.0)]
    {
        let mut bench = Plan::new(CARTESIAN).start();
        bench.say(heat);
        bench.hear(60.0);
        bench.say(off);
        let found = time_to_tell(&mut bench, heater, &[told], limit_s);
        show("just switched off", heater, found);
        assert_cut_off(&mut bench);
    }
}

#[test]
fn printing() {
    let part = "G28.3 X0 Y0 Z10\nM104 S200\nM140 S60\n".to_owned() + &"G1 X100 F6000\nG1 X10\n".repeat(2_000);
    for (heater, limit_s) in [("hotend", 40.0), ("bed", 120.0)] {
        let mut bench = Plan::new(CARTESIAN).file("part.g", &part).start();
        bench.ask("play /sd/part.g");
        bench.hear(300.0);
        let words = [TOLD_HOT_END, TOLD_BED, "ERROR: Temperature runaway on"];
        let found = time_to_tell(&mut bench, heater, &words, limit_s);
        show("printing", heater, found);
        assert_cut_off(&mut bench);
        bench.hear(2.0);
        assert!(!bench.is_energised(Alpha));
        let limit_c = if heater == "bed" { 120.0 } else { 290.0 };
        assert!(bench.celsius(heater) < limit_c, "{heater} became {} C hot", bench.celsius(heater));
    }
}

/// Sticks a heater while another one is on.
#[test]
fn beside_another_heater() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.say("M104 S200");
    bench.hear(120.0);
    let found = time_to_tell(&mut bench, "bed", &[TOLD_BED], 90.0);
    show("off, hot end on", "bed", found);
    assert_cut_off(&mut bench);
}

/// Halted, the supply is off: it takes a second fault to heat, and all that is left is to say so, again and
/// again.
#[test]
fn halted_with_a_supply_switch_that_conducts() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.type_in("\x18");
    bench.hear(1.0);
    fail(&bench, Fault::HeaterStuckOn("hotend".into()));
    bench.hear(60.0);
    assert!(bench.celsius("hotend") < 25.0, "a halt cuts the supply");
    fail(&bench, Fault::FetSwitchStuckOn);
    let found = time_to_tell(&mut bench, "hotend", &[TOLD_HOT_END], 20.0);
    show("halted, supply switch shorted too", "hotend", found);
    assert!(bench.hear(30.0).contains(TOLD_HOT_END), "it goes on warming, and must be told again");
}

/// After a halt is cleared the heater sticks still.
#[test]
fn clearing_the_halt_does_not_silence_it() {
    let mut bench = Plan::new(CARTESIAN).start();
    time_to_tell(&mut bench, "hotend", &[TOLD_HOT_END], 20.0);
    bench.say("M999");
    bench.hear(0.1);
    assert!(bench.world(|world| world.vfet_v()) > 0.0, "a person armed it again");
    bench.hear_until(TOLD_HOT_END, 60.0);
    assert_cut_off(&mut bench);
}

#[test]
fn sound_machines_are_never_accused() {
    let mut bench = Plan::new(CARTESIAN).start();
    for line in ["M109 S250", "M104 S100", "M109 S180", "M104 S0", "M190 S110", "M140 S40", "M140 S0", "M109 S200"] {
        bench.say(line);
        let said = bench.hear(90.0);
        assert!(!said.contains("ERROR"), "after {line}: {said}");
    }
}

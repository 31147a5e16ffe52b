//! Codes and commands that Smoothieware v2 has, on a whole machine; and what makes v2 itself hang or lose
//! something, which ours does not.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Gamma};

fn start() -> Bench {
    Plan::new(CARTESIAN).start()
}

#[test]
fn microsteps_and_registers_change_until_the_next_reset() {
    let mut bench = start();
    let before: f64 = steps(&bench.say("M92"));
    assert_eq!(bench.say("M909 X64"), "microsteps for X temporarily changed to: 1/64\nok\n");
    assert_eq!(steps(&bench.say("M92")), before);
    let said = bench.say("M909.1 X32");
    assert!(said.contains("microsteps for X temporarily changed to: 1/32\nsteps/mm for X temporarily changed to: "));
    assert_eq!(steps(&bench.say("M92")), before / 2.0);
    assert!(bench.say("M909 X5").contains("cannot be set so"));
    assert_eq!(bench.say("M911.1 P0"), "X,0,5,54,5,0,0\nok\n");
    assert_eq!(bench.say("M911.3 P0 S1 U4 V36 W6 X2 Y1"), "ok\n");
    assert_eq!(bench.say("M911.1 P0"), "X,0,4,36,6,2,1\nok\n");
    assert_eq!(bench.say("M911.3 P0 S4 Z1"), "ok\n");
    assert!(bench.say("M911 P0").contains("Step interpolation is on"));
    assert!(bench.say("M911.3 P0 S3 Z0").starts_with("error:"), "double edges are what the step engine counts on");
    assert_eq!(bench.say("M911.2 P0 R1 V4"), "ok\n");
    assert!(bench.say("M911 P0").contains("driver control register: 00104("), "and stay, whatever is written");
    assert!(bench.say("M911.2").contains("R255"));
    assert_eq!(bench.say("setregs X 00003,901B4,A0000,D0A0D,EF072"), "registers temporarily set for motor 0\nok\n");
    assert!(bench.say("M911 P0").contains("config-set tmc2590 alpha.reg = 00103,901B4,A0000,D0A0D,EF072"));
}

fn steps(said: &str) -> f64 {
    said.split([' ', ':']).nth(1).and_then(|word| word.parse().ok()).expect("steps")
}

#[test]
fn the_clock_is_set_and_goes_on() {
    let mut bench = start();
    assert!(bench.say("date").starts_with("2000-01-01 00:00:0"), "nobody has set it");
    bench.run(&["date 260102030405"]);
    bench.hear(3.0);
    assert_eq!(bench.say("date"), "2026-01-02 03:04:08\nok\n");
}

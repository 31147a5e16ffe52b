//! Z by the frame's temperature: here the bed's sensor is taken for one on the frame.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::Gamma;

/// A frame that lifts the tool by 4 um for each degree.
fn plan() -> Plan {
    Plan::new(CARTESIAN).set("[z thermal adjust] sensor = bed").set("[z thermal adjust] coefficient = 0.004")
}

fn start(plan: Plan) -> Bench {
    let mut bench = plan.start_homed();
    bench.run(&["G1 X20 Y20 Z5 F6000", "M400"]);
    bench
}

#[test]
fn z_comes_down_as_the_frame_grows() {
    let mut bench = start(plan());
    assert!((bench.carriage(Gamma) - 5.0).abs() < 0.003);
    let cold = bench.celsius("bed");
    bench.say("M190 S62");
    // Nothing moves by itself, and moves that do not name Z leave it.
    assert!((bench.carriage(Gamma) - 5.0).abs() < 0.003);
    bench.run(&["G1 X60 F3000", "M400"]);
    assert!((bench.carriage(Gamma) - 5.0).abs() < 0.003);
    bench.run(&["G1 Z5.2 F600", "M400"]);
    let grown = 0.004 * (bench.celsius("bed") - cold);
    assert!(grown > 0.14 && (bench.carriage(Gamma) - (5.2 - grown)).abs() < 0.008, "{} {grown}", bench.carriage(Gamma));
    let said = bench.say("M290.1");
    assert!(said.starts_with("Z by temperature: on, 0.004000 mm for a degree, 0.5 mm at most\n"), "{said}");
    assert!(said.contains("C as Z was homed: Z is shifted by -0.15") || said.contains("by -0.16"), "{said}");
    // A shift of the operator's is beside it, and stays when the temperature is not made up for any more.
    bench.run(&["M290 R0 Z0.05 Q0"]);
    bench.say("M290.1 S0");
    bench.run(&["G4 P200", "G1 Z5.4 F600", "M400"]);
    assert!((bench.carriage(Gamma) - 5.45).abs() < 0.003, "{}", bench.carriage(Gamma));
    assert!(bench.say("M503").contains("M290.1 S0 K0.00400000\n"));
    // Homed while warm, the machine has nothing to compensate.
    bench.run(&["M290 R0 Z0 Q0"]);
    bench.say("M290.1 S1");
    bench.run(&["G28", "G4 P200", "G1 Z5 F600", "M400"]);
    assert!((bench.carriage(Gamma) - 5.0).abs() < 0.01, "{}", bench.carriage(Gamma));
}

#[test]
fn no_more_than_max_adjust_whatever_the_sensor_says() {
    let mut bench = start(plan().set("[z thermal adjust] max_adjust = 0.05"));
    bench.say("M190 S62");
    bench.run(&["G1 Z6 F600", "M400"]);
    assert!((bench.carriage(Gamma) - 5.95).abs() < 0.003, "{}", bench.carriage(Gamma));
    // A sensor that comes off halts the machine; what it says then changes nothing.
    assert!(Plan::new(CARTESIAN).start().say("M290.1").starts_with("error:M290.1 needs to know which sensor"));
    let bench = plan().set("[z thermal adjust] sensor = chamber").start();
    assert!(bench.greeting().contains("there is no [temperature control] chamber"), "{}", bench.greeting());
}

#[test]
fn a_job_that_is_suspended_and_goes_on_is_shifted_once() {
    let mut bench = start(plan());
    bench.run(&["M120"]);
    bench.say("M190 S62");
    bench.run(&["G1 Z5 F600", "M400"]);
    let shifted = bench.carriage(Gamma);
    bench.run(&["M121", "G1 Z5.1 F600", "G1 Z5 F600", "M400"]);
    assert!((bench.carriage(Gamma) - shifted).abs() < 0.01, "{shifted} {}", bench.carriage(Gamma));
    // A move that is refused is taken back, and the shift with it stays what it is.
    let refused = bench.say("G1 Z5 F0");
    assert!(refused.starts_with("error") || refused == "ok\n");
    bench.run(&["G1 Z5.1 F600", "G1 Z5 F600", "M400"]);
    assert!((bench.carriage(Gamma) - shifted).abs() < 0.01);
}

#[test]
fn z_is_right_at_the_temperature_of_the_last_homing_of_z_and_of_no_other() {
    let mut bench = start(plan());
    let cold = bench.celsius("bed");
    bench.say("M190 S62");
    bench.run(&["G1 Z5.2 F600", "M400"]);
    // Z is where it was: homing X says nothing of it.
    bench.run(&["G28 X", "G4 P200", "G1 Z5 F600", "M400"]);
    let grown = 0.004 * (bench.celsius("bed") - cold);
    assert!(grown > 0.14 && (bench.carriage(Gamma) - (5.0 - grown)).abs() < 0.008, "{}", bench.carriage(Gamma));
    // The first move behind homing is right already.
    bench.run(&["G28", "G1 Z5 F6000", "M400"]);
    assert!((bench.carriage(Gamma) - 5.0).abs() < 0.003, "{}", bench.carriage(Gamma));
}

#[test]
fn whatever_homes_z_tells_the_temperature_too() {
    let probe = plan()
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[zprobe] leveling = cartesian grid")
        .set("[cartesian grid leveling strategy] x_size = 100")
        .set("[cartesian grid leveling strategy] y_size = 100")
        .set("[cartesian grid leveling strategy] grid_x_size = 2")
        .set("[cartesian grid leveling strategy] grid_y_size = 2");
    let mut bench = start(probe);
    bench.lay(sim::models::surface::Surface::default());
    bench.say("M190 S62");
    bench.run(&["G1 Z6 F600", "M400"]);
    assert!(bench.carriage(Gamma) < 5.9, "{}", bench.carriage(Gamma));
    let answer = bench.say("G32");
    assert!(answer.ends_with("ok\n"), "{answer}");
    bench.run(&["G4 P200", "G1 X20 Y20 Z1 F6000", "M400"]);
    assert!((bench.carriage(Gamma) - 1.0).abs() < 0.01, "{}", bench.carriage(Gamma));
}

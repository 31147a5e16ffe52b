//! The shift of Z goes into the offset that Z homes by.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::models::surface::{Bed, Surface};
use units::Actuator::Gamma;

/// Goes to Z 5 of the program, and returns how high the tool is.
fn at_five(bench: &mut Bench) -> f64 {
    bench.run(&["G90", "G1 Z5 F600", "M400"]);
    bench.carriage(Gamma)
}

#[test]
fn it_goes_into_the_switch_s_place() {
    let mut bench = Plan::new(CARTESIAN).file("a.g", "G4 S20\n").start_homed();
    assert!(bench.say("Z_OFFSET_APPLY_ENDSTOP").contains("nothing is to be done"));
    let plain = at_five(&mut bench);
    bench.run(&["M290 Z0.3"]);
    let high = at_five(&mut bench);
    assert!((high - plain - 0.3).abs() < 0.005);
    let said = bench.say("Z_OFFSET_APPLY_ENDSTOP");
    assert!(said.contains("M500 saves it"), "{said}");
    assert!((at_five(&mut bench) - high).abs() < 0.005, "nothing moves");
    bench.run(&["G28 Z"]);
    assert!((at_five(&mut bench) - high).abs() < 0.005, "nor once Z has homed");
    assert!(bench.say("M503").contains("Z-0.3"));
    assert!(bench.say("Z_OFFSET_APPLY_PROBE").contains("nothing is to be done"), "the shift has ended");
    bench.run(&["M290 Z0.1"]);
    assert!(bench.say("Z_OFFSET_APPLY_PROBE").starts_with("error:no probe is configured"));
    bench.type_in("M32 a.g\n");
    bench.hear(0.5);
    assert!(bench.say("Z_OFFSET_APPLY_ENDSTOP").starts_with("error:a job goes by the shift"));
}

#[test]
fn it_goes_into_the_probe_by_which_z_homes() {
    let mut bench = Plan::new(CARTESIAN)
        .set("[endstops] minz.enable = false")
        .set("[endstops] common.home_z_gcode = G91_G0_Z20_F600_G90_G30_L_G28.3_P1_G0_Z10")
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[zprobe] slow_feedrate = 5")
        .set("[zprobe] max_travel = 60")
        .set("[zprobe] probe_offsets = 0,0,1.5")
        .start();
    bench.lay(Surface { bed: Some(Bed::level(0.0)), ..Surface::default() });
    bench.run(&["G28"]);
    let plain = at_five(&mut bench);
    bench.run(&["M290 Z-0.2"]);
    let low = at_five(&mut bench);
    assert!((low - plain + 0.2).abs() < 0.005);
    assert!(bench.say("Z_OFFSET_APPLY_ENDSTOP").starts_with("error:Z has no switch to home with"));
    assert!(bench.say("Z_OFFSET_APPLY_PROBE").contains("Z:1.7000"));
    assert!((at_five(&mut bench) - low).abs() < 0.005, "nothing moves");
    bench.run(&["G28"]);
    assert!((at_five(&mut bench) - low).abs() < 0.01, "nor once Z has homed");
}

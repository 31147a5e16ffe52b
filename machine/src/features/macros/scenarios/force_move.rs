//! FORCE_MOVE and STEPPER_BUZZ: motors moved as the printer.cfg allows.

use scenarios::{CARTESIAN, Plan};
use units::Actuator::{Alpha, Gamma};

use super::{place, with};

#[test]
fn a_motor_is_moved_where_the_file_allows_it() {
    let mut bench = with("[force_move]\nenable_force_move: True\n").start();
    let said = bench.say("FORCE_MOVE STEPPER=stepper_y DISTANCE=-3.5 VELOCITY=10");
    assert!(said.contains("on the Y axis") && said.ends_with("ok\n"), "{said}");
    assert_eq!(place(&bench), [0, -350]);
    let before = bench.now_s();
    bench.say("FORCE_MOVE STEPPER=stepper_y DISTANCE=3.5 VELOCITY=100 ACCEL=14");
    // Half the way at 14 mm/s2 takes half a second, and so does the rest.
    assert!((bench.now_s() - before - 1.0).abs() < 0.05, "{}", bench.now_s() - before);
    assert_eq!(place(&bench), [0, 0]);
    let before = bench.now_s();
    bench.say("FORCE_MOVE STEPPER=stepper_y DISTANCE=3.5 VELOCITY=100");
    assert!(bench.now_s() - before < 0.5, "the machine's own acceleration again");
    for (words, why) in [
        ("STEPPER=stepper_q DISTANCE=1 VELOCITY=1", "names no motor"),
        ("DISTANCE=1 VELOCITY=1", "FORCE_MOVE needs STEPPER="),
        ("STEPPER=stepper_x VELOCITY=1", "needs DISTANCE="),
        ("STEPPER=stepper_x DISTANCE=1 VELOCITY=0", "above zero"),
        ("STEPPER=stepper_x DISTANCE=1 VELOCITY=1 ACCEL=much", "ACCEL is a number"),
    ] {
        let said = bench.say(&format!("FORCE_MOVE {words}"));
        assert!(said.starts_with("error:") && said.contains(why), "{words}: {said}");
    }
}

#[test]
fn without_the_option_no_motor_is_moved() {
    for text in ["[printer]\n", "[force_move]\n", "[force_move]\nenable_force_move: False\n"] {
        let mut bench = with(text).start();
        let said = bench.say("FORCE_MOVE STEPPER=stepper_x DISTANCE=3 VELOCITY=10");
        assert!(said.starts_with("error:FORCE_MOVE needs [force_move] enable_force_move"), "{said}");
        assert_eq!(place(&bench), [0, 0]);
    }
}

#[test]
fn a_motor_that_moves_no_axis_alone_is_refused_but_z_of_a_corexy_is_not() {
    let mut bench =
        with("[force_move]\nenable_force_move: yes\n").set("[motion control] arm_solution = corexy").start();
    let said = bench.say("FORCE_MOVE STEPPER=stepper_x DISTANCE=3 VELOCITY=10");
    assert!(said.contains("no motor moves one axis alone"), "{said}");
    let before = bench.carriage(Gamma);
    bench.say("FORCE_MOVE STEPPER=stepper_z DISTANCE=3 VELOCITY=5");
    assert!((bench.carriage(Gamma) - before - 3.0).abs() < 0.01);
}

#[test]
fn a_motor_is_shaken_and_ends_where_it_was() {
    let mut bench = Plan::new(CARTESIAN).start();
    let before = bench.carriage(Alpha);
    bench.say("STEPPER_BUZZ STEPPER=stepper_x");
    let [least, most] = bench.world(|world| world.reached_mm(Alpha)).expect("a motor");
    assert!((most - least - 1.0).abs() < 0.05, "{least} to {most}");
    assert!((bench.carriage(Alpha) - before).abs() < 0.01);
    assert!(bench.say("STEPPER_BUZZ STEPPER=fan").contains("names no motor"));
}

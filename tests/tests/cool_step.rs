//! Current saved by coolStep, on the modelled motor.

use scenarios::{CARTESIAN, Plan};
use sim::models::rotor::Plant;
use units::Actuator::Alpha;

/// Returns the heat in the coils of X as a share of that without coolStep, while X goes to and fro at 50
/// mm/s.
fn heat(friction: f64, least: &str) -> f64 {
    let plan = [
        "stall_filter = true".to_owned(),
        "stall_threshold = 5".to_owned(),
        // The setting gives the motor a model of its rotor; no stall is expected.
        "stall_watch = true".to_owned(),
        "coolstep_lower = 64".to_owned(),
        "coolstep_upper = 128".to_owned(),
        "coolstep_down = 2".to_owned(),
        "coolstep_up = 4".to_owned(),
        format!("coolstep_least = {least}"),
    ];
    let plan = plan.iter().fold(Plan::new(CARTESIAN), |plan, line| plan.set(&format!("[tmc2590] alpha.{line}")));
    let mut bench = plan.set("[actuator] common.halt_on_stall = false").start_homed();
    bench.world(|world| world.fit_rotor(Alpha, Plant { friction, ..Plant::PRINTER }));
    for _ in 0..4 {
        bench.type_in("G1 X180 F3000\nG1 X10\n");
    }
    // The measurement leaves out the time in which the current falls.
    bench.hear(2.0);
    let (mut sum, mut count) = (0.0, 0.0);
    for _ in 0..800 {
        bench.hear(0.01);
        let [now, set] = bench.world(|world| {
            let chip = world.driver(Alpha as usize);
            [chip.scale_in_force(), chip.current_scale()].map(|scale| f64::from(scale + 1))
        });
        sum += (now / set).powi(2);
        count += 1.0;
    }
    sum / count
}

/// The coils' heat goes with the square of the current. `cargo test -p scenarios cool_step:: -- --nocapture`
/// prints the figures of `docs/drivers.md`.
#[test]
fn coolstep_saves_the_heat_of_a_motor_with_little_to_do_and_none_of_one_with_much() {
    let mut shares = Vec::new();
    for (friction, least) in [(0.15, "half"), (0.05, "quarter"), (0.6, "half")] {
        let share = heat(friction, least);
        println!("friction {friction} of the torque, down to a {least}: {:.0} % less heat", (1.0 - share) * 100.0);
        shares.push(share);
    }
    assert!(shares[0] < 0.5 && shares[1] < shares[0] && shares[2] > 0.9, "{shares:?}");
}

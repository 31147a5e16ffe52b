//! Homing by the real image: overtravel of the carriages past their switches, where the end switch's
//! interrupt stops the step queue.

use crate::common::velvet::{Plan, SECOND, Velvet};
use sim::world::Fault;
use units::Actuator::{self, Alpha, Beta, Gamma};

/// Overtravel that a switch allows, mm.
const OVERTRAVEL: f64 = 0.3;

/// Plans the sample with these rates for every axis.
fn machine(acceleration: u32, fast: u32, slow: u32) -> Plan {
    let axes = ["x", "y", "z"].into_iter().zip(["alpha", "beta", "gamma"]);
    axes.fold(Plan::new(), |plan, (axis, motor)| {
        plan.set(&format!("[endstops] min{axis}.fast_rate = {fast}"))
            .set(&format!("[endstops] min{axis}.slow_rate = {slow}"))
            .set(&format!("[actuator] {motor}.acceleration = {acceleration}"))
            .set(&format!("[actuator] {motor}.max_rate = 18000"))
            .set(&format!("[motion control] {axis}_axis_max_speed = 18000"))
            .set(&format!("[endstops] min{axis}.retract = 1"))
    })
}

#[track_caller]
fn assert_home(velvet: &mut Velvet) {
    for motor in [Alpha, Beta, Gamma] {
        let name = Actuator::name(motor);
        let (at, reached, lost) =
            velvet.world(|world| (world.carriage_mm(motor), world.reached_mm(motor), world.lost_mm(motor)));
        assert!(at.is_some_and(|at| at.abs() < 0.013), "{name} rests at {at:?}");
        let past = -reached.expect("a motor")[0];
        println!("{name}: {past:.3} mm past its switch");
        assert!(past <= OVERTRAVEL && lost == 0.0, "{name} went {past} mm past its switch");
    }
}

#[test]
fn lazy_axes_stop_at_their_switches() {
    // A brake at 100 mm/s2 from 30 mm/s would take 4.5 mm. X and Z share an edge detector of the chip.
    let mut velvet = machine(100, 30, 2).start();
    velvet.ask("G28", 20 * SECOND);
    assert_home(&mut velvet);
}

#[test]
fn fast_axes_stop_at_switches_that_bounce() {
    let mut velvet = machine(3_000, 200, 10).start();
    for name in ["minx", "miny", "minz"] {
        velvet.inject(&Fault::SwitchBounces(name.into()));
    }
    velvet.ask("G28", 20 * SECOND);
    assert_home(&mut velvet);
}

/// The driver's microstep counter is read over SPI while the motor stands, and corrected by the steps made
/// since the switch closed: a switch that is 20 um worse each time homes to the same step.
#[test]
fn the_phase_read_from_the_driver_homes_a_noisy_switch_to_the_same_step() {
    let mut velvet = Plan::new().set("[endstops] minx.phase_check = true").start();
    velvet.ask("G28 X", 20 * SECOND);
    velvet.world(|world| world.make_switch_noisy("minx", 0.02)).expect("a switch");
    let mut rests = || {
        velvet.ask("G1 X7 F6000", 5 * SECOND);
        velvet.ask("G28 X", 20 * SECOND);
        velvet.world(|world| (world.carriage_mm(Alpha).expect("a motor"), world.driver(0).microstep_counter()))
    };
    let homed = [rests(), rests(), rests()];
    println!("{homed:?}");
    assert!(homed.iter().all(|(place, _)| (place - homed[0].0).abs() < 1e-4), "{homed:?}");
    let said = velvet.ask("M875", SECOND);
    // The sample's X counts up with DIR low, as the driver's counter does.
    let phase = format!("phase {}.00 of 1024", homed[0].1);
    assert!(
        said.contains(&phase) && said.contains("4 homings") && !velvet.said().contains("WARNING"),
        "{phase}: {said}"
    );
}

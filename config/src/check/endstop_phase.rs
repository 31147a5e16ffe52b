//! The phase of a motor at its switch: whether it says anything of the axis, and what it can tell apart.

use super::findings::Checks;
use crate::machine::{ActuatorConfig, ArmSolution, EndstopConfig, HomingDirection, MachineConfig};
use units::{Actuator, Axis};

const ENDSTOPS: &str = "endstops";
/// The electrical cycle of a stepper is four full steps long.
const FULL_STEPS: f64 = 4.0;

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    for (place, stop) in config.endstops.iter().enumerate() {
        if stop.enable && stop.phase.check {
            switch(checks, place, stop);
        }
    }
}

fn switch(checks: &mut Checks<'_, '_>, place: usize, stop: &EndstopConfig) {
    let config = checks.config;
    let Some(axis) = stop.axis else { return };
    let letter = axis.letter();
    if stop.homing_direction == HomingDirection::None {
        let reason = format_args!("no axis homes to this switch, and only homing looks at the phase");
        return checks.error((ENDSTOPS, place, "phase_check"), reason, format_args!("delete it"));
    }
    let motors = match motors_of(config, axis) {
        Motors::One(motor) => [Some(motor), None],
        Motors::Two(one, other) => [Some(one), Some(other)],
        Motors::Other => return,
        Motors::Uneven => {
            let reason = format_args!("{letter} does not follow its motors evenly, so their phases say nothing of it");
            return checks.error((ENDSTOPS, place, "phase_check"), reason, format_args!("delete it"));
        }
    };
    let motors = motors.map(|motor| motor.map(|motor| &config.actuators[motor]));
    let [Some(motor), other] = motors else { return };
    if !motor.present || motor.steps_per_mm <= 0.0 {
        return;
    }
    if other.is_some_and(|other| (other.steps_per_mm, other.microsteps) != (motor.steps_per_mm, motor.microsteps)) {
        let reason = format_args!("the two motors of {letter} have unlike steps, so their phases say nothing of it");
        return checks.error((ENDSTOPS, place, "phase_check"), reason, format_args!("delete it"));
    }
    if stop.phase.align_zero && Axis::PRIMARY.contains(&axis) && homes_by_motor(config) {
        let reason = format_args!("the zero of a tower or an arm is no place of the tool");
        checks.error((ENDSTOPS, place, "phase_align_zero"), reason, format_args!("delete it"));
    }
    let is_external = |motor: &ActuatorConfig| !motor.driver.is_spoken_with();
    if stop.phase.calibrated.is_some() && [Some(motor), other].into_iter().flatten().any(is_external) {
        let reason = format_args!("nobody can read where an external driver is in its cycle after power up");
        let fix = format_args!("delete it: the first homing then sets the phase, until the next power up");
        checks.error((ENDSTOPS, place, "phase"), reason, fix);
    }
    let Some(tolerance) = stop.phase.tolerance else { return };
    let half = cycle(config, axis, motor) / 2.0;
    if tolerance.0 >= half {
        let reason = format_args!(
            "phases repeat every {:.4} mm, so {} mm either way cannot be told apart",
            2.0 * half,
            tolerance.0
        );
        checks.error((ENDSTOPS, place, "phase_tolerance"), reason, format_args!("write less than {half:.4}"));
    }
}

/// Motors that an axis follows at its switch.
enum Motors {
    One(Actuator),
    /// The sum or difference of two motors.
    Two(Actuator, Actuator),
    /// A combination that is worked out when it homes.
    Other,
    /// None that is everywhere the same.
    Uneven,
}

fn motors_of(config: &MachineConfig, axis: Axis) -> Motors {
    use Actuator::{Alpha, Beta, Gamma};
    use ArmSolution as Arm;
    match (config.motion.arm_solution, axis) {
        (Arm::Winch, _) => Motors::Uneven,
        (_, Axis::A | Axis::B | Axis::C) => own(axis),
        _ if homes_by_motor(config) => own(axis),
        (Arm::CoreXy, Axis::X | Axis::Y) | (Arm::CoreXz, Axis::X | Axis::Z) | (Arm::HybridCoreXy, Axis::X) => {
            Motors::Two(Alpha, Beta)
        }
        (Arm::HybridCoreXz, Axis::X) => Motors::Two(Alpha, Gamma),
        (Arm::CoreXz, Axis::Y) => Motors::One(Gamma),
        (Arm::Lathe, Axis::Z) => Motors::One(Beta),
        (Arm::Generic, _) => Motors::Other,
        (Arm::Polar | Arm::Deltesian | Arm::LinearDelta | Arm::RotaryDelta | Arm::Morgan, _) => Motors::Uneven,
        _ => own(axis),
    }
}

/// Towers and arms home one by one.
const fn homes_by_motor(config: &MachineConfig) -> bool {
    config.homing.delta || config.homing.rotary_delta || config.homing.scara
}

fn own(axis: Axis) -> Motors {
    Actuator::from_index(axis as usize).map_or(Motors::Other, Motors::One)
}

/// After how many mm of the axis the phase is the same again.
fn cycle(config: &MachineConfig, axis: Axis, motor: &ActuatorConfig) -> f64 {
    let [x, z] = config.motion.arms.corexz;
    let geared = match (config.motion.arm_solution, axis) {
        (ArmSolution::CoreXy, Axis::X | Axis::Y) => 0.5,
        (ArmSolution::CoreXz, Axis::X) => 0.5 / x,
        (ArmSolution::CoreXz, Axis::Z) => 0.5 / z,
        _ => 1.0,
    };
    geared * FULL_STEPS * f64::from(motor.microsteps) / motor.steps_per_mm
}

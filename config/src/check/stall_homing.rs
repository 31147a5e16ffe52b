//! Checks of sensorless homing: whether the stall of the axis' motor can be detected, and only at the end.

use super::findings::Checks;
use crate::machine::GOOD_FULL_STEPS_PER_S;
use crate::machine::{ActuatorConfig, ArmSolution, DriverKind, EndstopConfig, EndstopStallConfig, HomingDirection};
use crate::suggest::at_least;
use units::Actuator;

const ENDSTOPS: &str = "endstops";
/// At a fifth of that speed the voltage a motor induces drowns in that across its coils: 0.25 V of 2.4 V.
const LEAST_FULL_STEPS_PER_S: f64 = 40.0;

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    for (place, stop) in config.endstops.iter().enumerate() {
        if stop.enable && stop.stall.homing {
            axis(checks, place, stop);
        }
    }
}

fn axis(checks: &mut Checks<'_, '_>, place: usize, stop: &EndstopConfig) {
    let config = checks.config;
    let setting = |key| (ENDSTOPS, place, key);
    let Some(motor) = stop.axis.and_then(|axis| Actuator::from_index(axis as usize)) else { return };
    if stop.homing_direction == HomingDirection::None {
        let reason = format_args!("no axis homes to this end");
        return checks.error(setting("stall_homing"), reason, format_args!("write homing_direction, or delete it"));
    }
    let has_motor_of_its_own =
        config.motion.arm_solution == ArmSolution::Cartesian || motor as usize >= Actuator::Delta as usize;
    if !has_motor_of_its_own {
        let reason = format_args!("a motor of this machine moves more than one axis, so its stall is that of none");
        return checks.error(setting("stall_homing"), reason, format_args!("use a switch"));
    }
    if stop.limit_enable {
        let reason = format_args!("the driver's output says that the motor stalls, and not where it is");
        checks.error(setting("limit_enable"), reason, format_args!("delete it"));
    }
    if stop.phase.check {
        let reason = format_args!("a motor that is stalled has no phase to be compared");
        checks.error(setting("phase_check"), reason, format_args!("delete it"));
    }
    threshold(checks, place, stop, motor);
    let (most, wanted) = (config.max_current(motor), stop.stall.current);
    if let (Some(most), Some(wanted)) = (most, wanted)
        && wanted > most
    {
        let reason = format_args!("{} A is above the driver's max_current", wanted.0);
        checks.error(setting("stall_current"), reason, format_args!("write {} or less", most.0));
    }
    let motor = &config.actuators[motor];
    for (key, rate) in [("fast_rate", stop.fast_rate), ("slow_rate", stop.slow_rate)] {
        speed(checks, (place, key), rate.get(), motor);
    }
    run_up(checks, place, stop, motor);
}

fn threshold(checks: &mut Checks<'_, '_>, place: usize, stop: &EndstopConfig, motor: Actuator) {
    let driver = checks.config.actuators[motor].driver;
    let Some([least, most]) = checks.config.stall_thresholds(motor) else {
        if driver != DriverKind::External {
            let reason = format_args!("a {} measures no load", driver.name());
            checks.error((ENDSTOPS, place, "stall_homing"), reason, format_args!("use a switch"));
        }
        return;
    };
    let threshold = stop.stall.threshold;
    if !(least..=most).contains(&threshold) {
        let reason = format_args!("{threshold} is none of a {}", driver.name());
        checks.error((ENDSTOPS, place, "stall_threshold"), reason, format_args!("write {least} to {most}"));
    }
}

fn full_steps_per_mm(motor: &ActuatorConfig) -> f64 {
    motor.steps_per_mm / f64::from(motor.microsteps.max(1))
}

fn speed(checks: &mut Checks<'_, '_>, (place, key): (usize, &str), rate: f64, motor: &ActuatorConfig) {
    let (full_steps, per_mm) = (rate * full_steps_per_mm(motor), full_steps_per_mm(motor));
    let fix = format_args!("write {} mm/s or more", at_least(GOOD_FULL_STEPS_PER_S / per_mm));
    if full_steps < LEAST_FULL_STEPS_PER_S {
        let reason = format_args!("{full_steps:.0} full steps/s are too slow for a driver to see its motor stall");
        checks.error((ENDSTOPS, place, key), reason, fix);
    } else if full_steps < GOOD_FULL_STEPS_PER_S {
        let reason =
            format_args!("{full_steps:.0} full steps/s are slow for stallGuard, which gets unstable below 200");
        checks.warn((ENDSTOPS, place, key), reason, fix);
    }
}

/// Backing off must leave the way that the second approach needs to be at its speed, where alone a stall can
/// be seen, and then some to be measured.
fn run_up(checks: &mut Checks<'_, '_>, place: usize, stop: &EndstopConfig, motor: &ActuatorConfig) {
    let acceleration = motor.acceleration.unwrap_or(checks.config.motion.default_acceleration).get();
    let own = stop.axis.and_then(|axis| checks.config.planner.axis_jerk.get(axis as usize).copied().flatten());
    let jerk = own.or(checks.config.planner.jerk).map(|jerk| jerk.0);
    let rate = stop.slow_rate.get();
    let needed = EndstopStallConfig::run_up(rate, acceleration, jerk, full_steps_per_mm(motor));
    if stop.retract.get() < needed {
        let reason =
            format_args!("the second approach needs {needed:.1} mm to be at {rate} mm/s and look for the stall");
        checks.error((ENDSTOPS, place, "retract"), reason, format_args!("write {:.1} or more", needed + 0.05));
    }
}

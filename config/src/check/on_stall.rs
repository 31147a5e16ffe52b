//! Checks of the response to stalls: whether it is possible, and whether stalls are monitored at all.

use super::findings::Checks;
use crate::machine::OnStall;
use units::{Actuator, Axis};

const ACTUATOR: &str = "actuator";

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    for (motor, settings) in config.actuators() {
        let Some(wanted) = settings.on_stall else { continue };
        let setting = (ACTUATOR, motor as usize, "on_stall");
        if !config.watched_for_stalls().any(|(watched, _)| watched == motor) {
            let reason = format_args!("nobody looks for stalls of this motor");
            checks.warn(setting, reason, format_args!("write stall_watch = true for its driver"));
        } else if wanted == OnStall::Recover {
            recovers(checks, motor);
        }
    }
}

/// Whether what this motor moves can be homed in the middle of a job.
fn recovers(checks: &mut Checks<'_, '_>, motor: Actuator) {
    let (config, setting) = (checks.config, (ACTUATOR, motor as usize, "on_stall"));
    let fix = format_args!("write pause");
    let Some(axes) = config.motion.arm_solution.axes_of(motor) else {
        let reason = format_args!("the axes of this machine home together, Z among them");
        return checks.error(setting, reason, fix);
    };
    if axes.has(Axis::Z) {
        return checks.error(setting, format_args!("Z is not homed onto a part"), fix);
    }
    if let Some(axis) = axes.axes().find(|axis| config.homing_endstop(*axis).is_none()) {
        let reason = format_args!("{} has nothing to home with", axis.letter());
        checks.error(setting, reason, fix);
    }
}

//! Axes whose phase is checked, and those of them whose drivers cannot be read.

use config::{HomingDirection, MachineConfig};
use motion::{Kinematics, MotionConfig};
use units::{Axis, AxisSet};

use super::cycle::Gearing;

/// Returns the axes whose phase is checked when they home.
pub fn checked(config: &MachineConfig) -> AxisSet {
    let stops = config.endstops.iter().filter(|stop| stop.phase.check);
    AxisSet::collect(stops.filter(|stop| stop.homing_direction != HomingDirection::None).filter_map(|stop| stop.axis))
}

/// Returns whether a driver that cannot be asked moves the axis, alone or beside others: its phase cannot be
/// read.
pub(super) fn is_external(config: &MachineConfig, motion: &MotionConfig, axis: Axis) -> bool {
    let homing = &config.homing;
    let by_motor = homing.delta || homing.rotary_delta || homing.scara;
    let kinematics = if by_motor { Kinematics::Cartesian } else { motion.kinematics };
    let external = |motor| !config.actuators[motor].driver.is_spoken_with();
    Gearing::of(&kinematics, axis).is_some_and(|gearing| gearing.motors().any(|(motor, _)| external(motor)))
}

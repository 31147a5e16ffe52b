//! `[endstops]`: the settings of the phase that a motor has at its switch.

use super::build::{NOT_NEGATIVE, bool, number, word};
use super::{Setting, Words};
use crate::machine::{EndstopPhaseConfig, MachineConfig};
use units::Mm;

const REACTIONS: &Words = &Words(&["warn", "halt"]);

/// `|phase, value| ...` on the phase of the endstop at the instance's place.
macro_rules! phase {
    (|$phase:ident, $value:ident| $body:expr) => {
        |c, i, $value| {
            if let Some($phase) = of(c, i) {
                $body;
            }
        }
    };
}

fn of(config: &mut MachineConfig, place: usize) -> Option<&mut EndstopPhaseConfig> {
    config.endstops.get_mut(place).map(|stop| &mut stop.phase)
}

pub(super) const CHECK: Setting = bool(
    "phase_check",
    "false",
    phase!(|p, v| p.check = v),
    "Each homing compares where the motor is in its cycle of four full steps when the switch closes with where it was \
     calibrated, and puts the axis at the nearest place that has the calibrated phase.",
)
.klipper("[endstop_phase stepper_<axis>]")
.velvet();

pub(super) const PHASE: Setting = number(
    "phase",
    "0",
    &(0.0, 1_023.999),
    phase!(|p, v| p.calibrated = Some(v)),
    "The calibrated phase, which ENDSTOP_PHASE_CALIBRATE finds and M500 saves. 0 to 1024 is one cycle; it rises as the motor \
     counts up. Klipper's trigger_phase a/b is 1024 a/b. Not for external drivers, whose phase nobody can read.",
)
.derived("that of the first homing since power up")
.klipper("[endstop_phase stepper_<axis>] trigger_phase")
.unit("1/256 full step")
.velvet();

pub(super) const TOLERANCE: Setting = number(
    "phase_tolerance",
    "0",
    NOT_NEGATIVE,
    phase!(|p, v| p.tolerance = Some(Mm(v))),
    "How far from the calibrated phase the switch may close, either way: less than half a cycle. Half of Klipper's \
     endstop_accuracy.",
)
.derived("one full step")
.klipper("[endstop_phase stepper_<axis>] endstop_accuracy")
.unit("mm")
.velvet();

pub(super) const ALIGN_ZERO: Setting = bool(
    "phase_align_zero",
    "false",
    phase!(|p, v| p.align_zero = v),
    "Move the homing position by half a full step at most, so that coordinate 0 is at a full step: layers of whole full \
     steps are then held at full steps.",
)
.klipper("[endstop_phase stepper_<axis>] endstop_align_zero")
.velvet();

pub(super) const REACTION: Setting = word(
    "phase_fault",
    "warn",
    REACTIONS,
    phase!(|p, v| p.halts = v == 1),
    "What follows when the switch closes further off than phase_tolerance, or the phase cannot be read: a warning, and the \
     axis is homed to its switch alone; or an alarm, and the axis is not homed. Klipper does the latter.",
)
.velvet();

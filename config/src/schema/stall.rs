//! Rows of `[actuator]` for the response to a stall in a job.

use super::build::{NOT_NEGATIVE, integer, number, word};
use super::{Setting, Words};
use crate::machine::OnStall;
use units::{Micros, Mm};

pub(super) const ON_STALL: Setting = word(
    "on_stall",
    "halt",
    &Words(OnStall::WORDS),
    |c, i, v| {
        if let Some(motor) = c.actuators.0.get_mut(i) {
            motor.on_stall = OnStall::ALL.get(v).copied();
        }
    },
    "What follows when the motor stalls while it moves; its driver needs stall_watch. tell: a message, and its axis is not \
     homed any more. halt: the machine halts. pause: the job stops there and is suspended; resume homes the axis and goes on. \
     recover: the job stops there, Z rises, the axis homes, and the job goes on by itself. Without a job under way pause and \
     recover halt.",
)
.derived("halt, or tell where halt_on_stall is false")
.velvet();

pub(super) const RECOVERIES: Setting = integer(
    "stall_recoveries",
    "3",
    &(1, 16),
    |c, _, v| c.motors.stall.most = v as u8,
    "How often a job gets over stalls by itself (on_stall = recover) within stall_recovery_time. At one more it pauses.",
)
.common()
.velvet();

pub(super) const RECOVERY_TIME: Setting = number(
    "stall_recovery_time",
    "600",
    NOT_NEGATIVE,
    |c, _, v| c.motors.stall.time = Micros((v * 1e6) as u64),
    "Time within which such recoveries are counted.",
)
.common()
.unit("s")
.velvet();

pub(super) const LIFT: Setting = number(
    "stall_lift",
    "5",
    NOT_NEGATIVE,
    |c, _, v| c.motors.stall.lift = Mm(v),
    "How far Z rises where a motor has stalled in a job, and above all that was printed while the axis homes.",
)
.common()
.unit("mm")
.velvet();

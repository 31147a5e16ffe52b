//! `[endstops]`: the settings of an axis that homes without a switch.

use super::Setting;
use super::build::{bool, integer, number};
use crate::machine::{EndstopStallConfig, MachineConfig};
use units::Amps;

/// `|stall, value| ...` on the stall detection of the endstop at the instance's place.
macro_rules! stall {
    (|$stall:ident, $value:ident| $body:expr) => {
        |c, i, $value| {
            if let Some($stall) = of(c, i) {
                $body;
            }
        }
    };
}

fn of(config: &mut MachineConfig, place: usize) -> Option<&mut EndstopStallConfig> {
    config.endstops.get_mut(place).map(|stop| &mut stop.stall)
}

pub(super) const HOMING: Setting = bool(
    "stall_homing",
    "false",
    stall!(|s, v| s.homing = v),
    "Home without a switch: the axis runs against its end, and the stallGuard output of its driver says so. `pin` is that \
     output, which on-board drivers have wired; both approaches then go at fast_rate unless slow_rate is written, and homing \
     ends `retract` away from the end.",
)
.velvet();

pub(super) const CURRENT: Setting = number(
    "stall_current",
    "0",
    &(0.001, 20.0),
    stall!(|s, v| s.current = Some(Amps(v as f32))),
    "Peak coil current while it homes so: less pushes less hard against the end, and stalls sooner.",
)
.derived("that of the motor")
.unit("A")
.typical(&(0.05, 10.0))
.velvet();

pub(super) const THRESHOLD: Setting = integer(
    "stall_threshold",
    "0",
    &(-64, 255),
    stall!(|s, v| s.threshold = v as i16),
    "How little load counts as a stall (SGT, -64 to 63): lower is more sensitive. Too low stalls on the way, too high never \
     stalls. With a TMC2209 or TMC2226 (SGTHRS, 0 to 255) it is the other way round.",
)
.klipper("[tmc2660 <stepper>] driver_SGT")
.velvet();

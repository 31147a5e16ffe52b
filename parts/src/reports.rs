//! Reports of the machine about itself. All of them answer at once, from their arguments.

mod device;
mod get;
mod parts;
mod position;
mod program;
mod status;

pub use device::{Came, failure, firmware, memory, version};
pub use get::get;
pub use parts::{modules, thermistor_coefficients, thermistors};
pub use position::{end_switches, position};
pub use program::{filament_diameter, flow_factor, modal, offsets};
pub use status::{Status, is_live, status};

use ::program::Tools;
use config::MachineConfig;
use units::{Actuator, Axis};

/// Line of a report: a status report with positions, rates and eight heaters is the longest one.
pub type Line = heapless::String<512>;

/// Formats onto a line; text that does not fit is cut at its end.
#[macro_export]
macro_rules! add {
    ($line:expr, $($format:tt)*) => {{
        // A cut line is still a line: see the macro's comment.
        let _ = core::fmt::Write::write_fmt(&mut $line, format_args!($($format)*));
    }};
}
pub use add;

/// Returns whether an axis beside X, Y and Z has a motor of its own.
fn has_axis(config: &MachineConfig, axis: Axis) -> bool {
    let motor = Actuator::from_index(axis as usize).map(|motor| &config.actuators[motor]);
    motor.is_some_and(|motor| motor.present && motor.slaved_to.is_none())
}

/// Returns those of A, B and C that the machine has.
fn auxiliary_axes(config: &MachineConfig) -> impl Iterator<Item = Axis> + '_ {
    [Axis::A, Axis::B, Axis::C].into_iter().filter(|axis| has_axis(config, *axis))
}

/// Returns the same axes, without those that extruders turn.
pub fn free_axes<'a>(config: &'a MachineConfig, tools: &'a Tools) -> impl Iterator<Item = Axis> + 'a {
    auxiliary_axes(config).filter(|axis| !tools.uses(*axis))
}

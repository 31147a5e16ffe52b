//! G28 and `$H`: homing, or the script of the configuration that stands for it.

use units::AxisSet;

use super::frames::Then;
use super::{Machine, MachineHands, suspend};
use crate::failure::{Answer, Outcome};
use crate::ports::Ports;
use crate::sessions::Recipient;

/// Homes these axes, or all where none is named.
pub(super) fn home<P: Ports>(machine: &mut Machine<'_, P>, named: AxisSet, to: Recipient) -> Outcome {
    let script = machine.config.homing.gcode.as_str();
    // Within the script G28 is homing itself.
    if named.is_empty() && !script.is_empty() && !machine.frames.run_script(script) {
        return suspend::start_script(machine, script, Then::Ended(Ok(())));
    }
    let homed = crate::homing::home(&mut MachineHands::new(machine, to), named);
    machine.resynchronise_if_still();
    homed.map(|()| Answer::Ok)
}

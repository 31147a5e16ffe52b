//! G28 and `$H`: homing, or the script of the configuration that stands for it.

use base::Ports;
use base::failure::{Answer, Outcome};
use base::sessions::Recipient;
use units::AxisSet;

use crate::machine::frames::Then;
use crate::machine::hands::MachineHands;
use crate::machine::{Machine, suspend};

/// Homes these axes, or all where none is named.
pub(crate) fn home<P: Ports>(machine: &mut Machine<'_, P>, named: AxisSet, to: Recipient) -> Outcome {
    let script = machine.world.config.homing.gcode.as_str();
    // Within the script G28 is homing itself.
    if named.is_empty() && !script.is_empty() && !machine.frames.run_script(script) {
        return suspend::start_script(&mut machine.frames, script, Then::Ended(Ok(())));
    }
    let homed = procedures::homing::home(&mut MachineHands::new(machine, to), named);
    machine.resynchronise_if_still();
    homed.map(|()| Answer::Ok)
}

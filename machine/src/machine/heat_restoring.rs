//! Heaters and outputs, restored for a job that goes on in the middle of its file.

use base::Ports;
use base::failure::Failure;
use base::hands::Hands as _;
use base::sessions::Recipient;
use parts::heat_codes;
use units::{Celsius, HeaterId, SwitchId};

use crate::machine::Machine;
use crate::machine::hands::MachineHands;

/// States asked of switches last: on or off, and S.
pub(crate) type Switches = [Option<(bool, Option<f32>)>];

/// Heats all heaters with a target, and waits: bed and chamber first, so that the part holds before the
/// nozzle oozes.
///
/// # Errors
/// As waiting for a temperature. Heaters stay on then: a caller that gives up calls [`cool`].
pub(crate) fn heat<P: Ports>(machine: &mut Machine<'_, P>, targets: &[Celsius], to: Recipient) -> Result<(), Failure> {
    for tools in [false, true] {
        for (id, target) in HeaterId::all().zip(targets) {
            let Some(heater) = machine.world.config.temperatures.get(id.index()) else { continue };
            if *target <= thermal::OFF_BELOW || heater.designator.starts_with('T') != tools {
                continue;
            }
            let hands = &mut MachineHands::new(machine, to);
            hands.announce(format_args!("// {} heats to {:.0} C\n", heater.name, target.0));
            heat_codes::heat_and_wait(hands, id, *target, false)?;
        }
    }
    Ok(())
}

/// Switches every heater off.
pub(crate) fn cool<P: Ports>(machine: &mut Machine<'_, P>) {
    for id in HeaterId::all() {
        // Switching off is never refused.
        let _ = machine.world.ports.heat(|heat| heat.set_target(id, Celsius(0.0)));
    }
}

/// Sets fans and other outputs as the file has set them.
pub(crate) fn switch<P: Ports>(machine: &mut Machine<'_, P>, switches: &Switches) {
    for (index, told) in switches.iter().enumerate() {
        let Some((on, value)) = *told else { continue };
        if let Some(output) = machine.outputs.turn(machine.world.config, SwitchId(index as u8), on, value) {
            // A switch takes any value.
            let _ = machine.world.ports.heat(|heat| heat.apply(output));
        }
    }
}

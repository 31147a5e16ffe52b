//! Heaters and outputs, restored for a job that goes on in the middle of its file.

use base::failure::Failure;
use base::hands::Hands;
use base::ports::HeatPort;
use config::MachineConfig;
use parts::heat_codes;
use parts::outputs::Outputs;
use units::{Celsius, HeaterId, SwitchId};

/// States asked of switches last: on or off, and S.
pub(crate) type Switches = [Option<(bool, Option<f32>)>];

/// Heats all heaters with a target, and waits: bed and chamber first, so that the part holds before the
/// nozzle oozes.
///
/// # Errors
/// As waiting for a temperature. Heaters stay on then: a caller that gives up calls [`cool`].
pub(crate) fn heat<'c>(hands: &mut impl Hands<'c>, targets: &[Celsius]) -> Result<(), Failure> {
    for tools in [false, true] {
        for (id, target) in HeaterId::all().zip(targets) {
            let Some(heater) = hands.config().temperatures.get(id.index()) else { continue };
            if *target <= thermal::OFF_BELOW || heater.designator.starts_with('T') != tools {
                continue;
            }
            hands.announce(format_args!("// {} heats to {:.0} C\n", heater.name, target.0));
            heat_codes::heat_and_wait(hands, id, *target, false)?;
        }
    }
    Ok(())
}

/// Switches every heater off.
pub(crate) fn cool(ports: &mut impl HeatPort) {
    for id in HeaterId::all() {
        // Switching off is never refused.
        let _ = ports.heat(|heat| heat.set_target(id, Celsius(0.0)));
    }
}

/// Sets fans and other outputs as the file has set them.
pub(crate) fn switch(outputs: &mut Outputs, config: &MachineConfig, ports: &mut impl HeatPort, switches: &Switches) {
    for (index, told) in switches.iter().enumerate() {
        let Some((on, value)) = *told else { continue };
        if let Some(output) = outputs.turn(config, SwitchId(index as u8), on, value) {
            // A switch takes any value.
            let _ = ports.heat(|heat| heat.apply(output));
        }
    }
}

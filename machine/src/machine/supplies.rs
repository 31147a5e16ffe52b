//! Loss of the supplies of motors and heaters. The text is that of the halt that follows; without a halt the
//! loss has been announced.

use base::axes::Axes;
use base::safety::Safety;
use base::{Ports, World};
use procedures::endstop_phase::EndstopPhases;
use program::State;

/// Handles the loss of the motor supply: without it motors hold nothing, and positions are no longer known.
pub(crate) fn motor_supply_lost<P: Ports>(
    world: &mut World<'_, P>,
    axes: &mut Axes,
    phases: &mut EndstopPhases,
    safety: &Safety,
) -> Option<&'static str> {
    axes.lose_supply();
    phases.lose_supply();
    if !matches!(safety.state(), State::Idle | State::Suspended | State::Check) && !safety.is_halted() {
        return Some("ERROR: motor supply lost while moving\n");
    }
    world.announce(format_args!("WARNING: motor supply is off (vmotor below 6 V), axes are no longer homed\n"));
    None
}

/// Handles the loss of the heater supply, which a heater's guard would only notice minutes later.
pub(crate) fn fet_supply_lost<P: Ports>(world: &mut World<'_, P>) -> Option<&'static str> {
    if world.ports.heat(|heat| heat.any_on()) {
        return Some("ERROR: heater supply lost while heating (vfet below 6 V)\n");
    }
    world.announce(format_args!("WARNING: heater supply is off (vfet below 6 V), heaters and fans do nothing\n"));
    None
}

//! Loss of the supplies of motors and heaters.

use base::Ports;
use base::reason::Alarm;
use program::State;

use super::Machine;

/// Handles the loss of the motor supply: without it motors hold nothing, and positions are no longer known.
pub(crate) fn motor_supply_lost<P: Ports>(machine: &mut Machine<'_, P>) {
    machine.axes.lose_supply();
    machine.phases.lose_supply();
    let state = machine.safety.state();
    if matches!(state, State::Idle | State::Suspended | State::Check) || machine.safety.is_halted() {
        machine.announce(format_args!("WARNING: motor supply is off (vmotor below 6 V), axes are no longer homed\n"));
    } else {
        machine.halt(Alarm::Abort, format_args!("ERROR: motor supply lost while moving\n"));
    }
}

/// Handles the loss of the heater supply, which a heater's guard would only notice minutes later.
pub(crate) fn fet_supply_lost<P: Ports>(machine: &mut Machine<'_, P>) {
    if machine.world.ports.heat(|heat| heat.any_on()) {
        machine.halt(Alarm::Abort, format_args!("ERROR: heater supply lost while heating (vfet below 6 V)\n"));
    } else {
        machine.announce(format_args!("WARNING: heater supply is off (vfet below 6 V), heaters and fans do nothing\n"));
    }
}

//! The safety door: while it is open nothing moves, turns, burns or sprays.

use base::Ports;
use base::ports::Input;
use base::safety::Event;
use parts::outputs::Changes;
use program::State;

use crate::machine::Machine;

/// Interrupts everything that may be interrupted while the door is open.
pub(crate) fn watch<P: Ports>(machine: &mut Machine<'_, P>) {
    if is_open(machine) && machine.safety.state() != State::Door {
        machine.feed_hold(Event::DoorOpens);
    }
}

/// Whether there is a door contact that says open.
pub(crate) fn is_open<P: Ports>(machine: &Machine<'_, P>) -> bool {
    machine.config.safety_door.enable && machine.ports.inputs().is_active(Input::Door)
}

/// Stops outputs behind an open door: nothing turns or burns while somebody reaches in; also nothing that the
/// path, until it stood, had turned on since the door opened.
pub(crate) fn stop_what_is_behind<P: Ports>(machine: &mut Machine<'_, P>) {
    let outputs = machine.outputs.door_opens(machine.config);
    give(machine, outputs);
}

/// Lets the machine go on, once the door is closed and somebody has said so.
pub(crate) fn let_go_on<P: Ports>(machine: &mut Machine<'_, P>) {
    let outputs = machine.outputs.door_closes(machine.config);
    give(machine, outputs);
}

fn give<P: Ports>(machine: &mut Machine<'_, P>, outputs: Changes) {
    machine.ports.heat(|heat| {
        for output in outputs {
            // A switch takes any value.
            let _ = heat.apply(output);
        }
    });
}

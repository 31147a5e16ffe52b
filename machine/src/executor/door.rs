//! The safety door: while it is open nothing moves, turns, burns or sprays.

use program::State;

use super::Machine;
use crate::outputs::Changes;
use crate::ports::{Input, Ports};
use crate::safety::Event;

/// An open one interrupts whatever may be interrupted.
pub(super) fn watch<P: Ports>(machine: &mut Machine<'_, P>) {
    if is_open(machine) && machine.safety.state() != State::Door {
        machine.feed_hold(Event::DoorOpens);
    }
}

/// Whether there is such a contact, and it says so.
pub(super) fn is_open<P: Ports>(machine: &Machine<'_, P>) -> bool {
    machine.config.safety_door.enable && machine.ports.inputs().is_active(Input::Door)
}

/// Nothing turns or burns while somebody reaches in; also nothing that the path, until it stood, had turned
/// on since the door opened.
pub(super) fn stop_what_is_behind<P: Ports>(machine: &mut Machine<'_, P>) {
    let outputs = machine.outputs.door_opens(machine.config);
    give(machine, outputs);
}

/// The door is closed and somebody has said so.
pub(super) fn let_go_on<P: Ports>(machine: &mut Machine<'_, P>) {
    let outputs = machine.outputs.door_closes(machine.config);
    give(machine, outputs);
}

fn give<P: Ports>(machine: &mut Machine<'_, P>, outputs: Changes) {
    machine.ports.heat(|heat| {
        for output in outputs {
            // A switch takes anything.
            let _ = heat.apply(output);
        }
    });
}

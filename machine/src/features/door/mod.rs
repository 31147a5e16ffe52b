//! The safety door: while it is open nothing moves, turns, burns or sprays.

use base::Ports;
use base::ports::Input;
use base::safety::Event;
use base::sessions::SessionId;
use gcode::realtime::Realtime;
use parts::outputs::Changes;
use program::State;
use units::Micros;

use crate::machine::Machine;
use crate::machine::moments::Moments;

/// The door at the machine's moments.
pub(crate) struct Feature;

impl<P: Ports> Moments<P> for Feature {
    fn each_250_us(machine: &mut Machine<'_, P>, _now: Micros) {
        if is_open(machine) && machine.safety.state() != State::Door {
            opens(machine);
        }
    }

    fn each_10_ms(machine: &mut Machine<'_, P>, _now: Micros) {
        if machine.safety.state() == State::Door {
            stop_what_is_behind(machine);
        }
    }

    fn take_request(machine: &mut Machine<'_, P>, request: Realtime, _id: SessionId) -> bool {
        if request == Realtime::Door {
            opens(machine);
        }
        request == Realtime::Door
    }

    fn may_go_on(machine: &mut Machine<'_, P>) -> bool {
        let is_blocked = machine.safety.state() == State::Door && is_open(machine);
        if is_blocked {
            machine.announce(format_args!("// NOTE the door is still open: close it, then ~ goes on\n"));
        }
        !is_blocked
    }

    fn goes_on(machine: &mut Machine<'_, P>, from: State) {
        if from == State::Door {
            let_go_on(machine);
        }
    }
}

/// Interrupts everything that may be interrupted while the door is open.
fn opens<P: Ports>(machine: &mut Machine<'_, P>) {
    if machine.feed_hold(Event::DoorOpens) {
        stop_what_is_behind(machine);
        machine.announce(format_args!("// NOTE the door is open: close it, then ~ goes on\n"));
    }
}

/// Whether there is a door contact that says open.
pub(crate) fn is_open<P: Ports>(machine: &Machine<'_, P>) -> bool {
    machine.world.config.safety_door.enable && machine.world.ports.inputs().is_active(Input::Door)
}

/// Stops outputs behind an open door: nothing turns or burns while somebody reaches in; also nothing that the
/// path, until it stood, had turned on since the door opened.
pub(crate) fn stop_what_is_behind<P: Ports>(machine: &mut Machine<'_, P>) {
    let outputs = machine.outputs.door_opens(machine.world.config);
    give(machine, outputs);
}

/// Lets the machine go on, once the door is closed and somebody has said so.
pub(crate) fn let_go_on<P: Ports>(machine: &mut Machine<'_, P>) {
    let outputs = machine.outputs.door_closes(machine.world.config);
    give(machine, outputs);
}

fn give<P: Ports>(machine: &mut Machine<'_, P>, outputs: Changes) {
    machine.world.ports.heat(|heat| {
        for output in outputs {
            // A switch takes any value.
            let _ = heat.apply(output);
        }
    });
}

//! The safety door: while it is open nothing moves, turns, burns or sprays.

use base::ports::Input;
use base::safety::Event;
use base::sessions::SessionId;
use base::{Ports, World};
use gcode::realtime::Realtime;
use parts::outputs::{Changes, Outputs};
use program::State;
use units::Micros;

use crate::machine::moments::Moments;
use crate::machine::{Machine, feed_hold};

/// The door at the machine's moments.
pub(crate) struct Feature;

impl<'c, P: Ports> Moments<Machine<'c, P>> for Feature {
    fn each_250_us(machine: &mut Machine<'_, P>, _now: Micros) {
        if is_open(&machine.world) && machine.safety.state() != State::Door {
            opens(machine);
        }
    }

    fn each_10_ms(machine: &mut Machine<'_, P>, _now: Micros) {
        if machine.safety.state() == State::Door {
            stop_what_is_behind(&mut machine.world, &machine.outputs);
        }
    }

    fn take_request(machine: &mut Machine<'_, P>, request: Realtime, _id: SessionId) -> bool {
        if request == Realtime::Door {
            opens(machine);
        }
        request == Realtime::Door
    }

    fn may_go_on(machine: &mut Machine<'_, P>) -> bool {
        let is_blocked = machine.safety.state() == State::Door && is_open(&machine.world);
        if is_blocked {
            machine.announce(format_args!("// NOTE the door is still open: close it, then ~ goes on\n"));
        }
        !is_blocked
    }

    /// Lets what is behind the door go on, once it is closed and somebody has said so.
    fn goes_on(machine: &mut Machine<'_, P>, from: State) {
        if from == State::Door {
            give(&mut machine.world.ports, machine.outputs.door_closes(machine.world.config));
        }
    }
}

/// Interrupts everything that may be interrupted while the door is open.
fn opens<P: Ports>(machine: &mut Machine<'_, P>) {
    if feed_hold::hold(machine, Event::DoorOpens) {
        stop_what_is_behind(&mut machine.world, &machine.outputs);
        machine.announce(format_args!("// NOTE the door is open: close it, then ~ goes on\n"));
    }
}

/// Whether there is a door contact that says open.
fn is_open<P: Ports>(world: &World<'_, P>) -> bool {
    world.config.safety_door.enable && world.ports.inputs().is_active(Input::Door)
}

/// Stops outputs behind an open door: nothing turns or burns while somebody reaches in; also nothing that the
/// path, until it stood, had turned on since the door opened.
fn stop_what_is_behind<P: Ports>(world: &mut World<'_, P>, outputs: &Outputs) {
    give(&mut world.ports, outputs.door_opens(world.config));
}

fn give<P: Ports>(ports: &mut P, outputs: Changes) {
    ports.heat(|heat| {
        for output in outputs {
            // A switch takes any value.
            let _ = heat.apply(output);
        }
    });
}

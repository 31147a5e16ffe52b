//! The safety door: while it is open nothing moves, turns, burns or sprays.

use base::ports::Input;
use base::safety::Event;
use base::sessions::SessionId;
use base::{Ports, World};
use gcode::realtime::Realtime;
use parts::outputs::{Changes, Outputs};
use program::State;
use units::Micros;

use crate::machine::feed_hold::FeedHoldHands;
use crate::machine::moments::Moments;
use crate::machine::{Machine, feed_hold};

/// The machine for its safety door.
pub(crate) trait DoorHands<'c>: FeedHoldHands<'c> {
    /// Returns the outputs behind the door, and the world.
    fn behind(&mut self) -> (&Outputs, &mut World<'c, Self::Ports>);
}

impl<'c, P: Ports> DoorHands<'c> for Machine<'c, P> {
    fn behind(&mut self) -> (&Outputs, &mut World<'c, P>) {
        (&self.outputs, &mut self.world)
    }
}

/// The door at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: DoorHands<'c>> Moments<M> for Feature {
    fn each_250_us(hands: &mut M, _now: Micros) {
        if is_open(hands.world()) && hands.state() != State::Door {
            opens(hands);
        }
    }

    fn each_10_ms(hands: &mut M, _now: Micros) {
        if hands.state() == State::Door {
            let (outputs, world) = hands.behind();
            stop_what_is_behind(world, outputs);
        }
    }

    fn take_request(hands: &mut M, request: Realtime, _id: SessionId) -> bool {
        if request == Realtime::Door {
            opens(hands);
        }
        request == Realtime::Door
    }

    fn may_go_on(hands: &mut M) -> bool {
        let is_blocked = hands.state() == State::Door && is_open(hands.world());
        if is_blocked {
            hands.announce(format_args!("// NOTE the door is still open: close it, then ~ goes on\n"));
        }
        !is_blocked
    }

    /// Lets what is behind the door go on, once it is closed and somebody has said so.
    fn goes_on(hands: &mut M, from: State) {
        if from == State::Door {
            let (outputs, world) = hands.behind();
            give(&mut world.ports, outputs.door_closes(world.config));
        }
    }
}

/// Interrupts everything that may be interrupted while the door is open.
fn opens<'c>(hands: &mut impl DoorHands<'c>) {
    if feed_hold::hold(hands, Event::DoorOpens) {
        let (outputs, world) = hands.behind();
        stop_what_is_behind(world, outputs);
        hands.announce(format_args!("// NOTE the door is open: close it, then ~ goes on\n"));
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

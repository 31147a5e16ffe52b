//! Feed holds: motion brakes along its path, and goes on when somebody says so.

use base::Ports;
use base::safety::Event;
use base::sessions::{Recipient, Sessions};
use jobs::player::Jobs;
use program::State;

use super::moments::{Features, Moments as _};
use super::{Machine, program_io};

/// Holds, or interrupts because the door opens. False: there is nothing to hold, or the hold waits.
pub(crate) fn hold<P: Ports>(machine: &mut Machine<'_, P>, event: Event) -> bool {
    if event == Event::Hold && !machine.hold.ask() {
        machine.announce(format_args!("// NOTE: the hold waits until the tap is out of the hole\n"));
        return false;
    }
    machine.follow_motion();
    let was_held = machine.safety.state() == State::Hold;
    if !machine.safety.apply(event) {
        return false;
    }
    if !was_held {
        machine.world.ports.motion(motion::Motion::hold);
    }
    true
}

/// Goes on from a hold, or ends a wait for the operator.
pub(crate) fn resume<P: Ports>(machine: &mut Machine<'_, P>) {
    if machine.hold.take_back() {
        return;
    }
    let from = machine.safety.state();
    if !matches!(from, State::Hold | State::Door) && operator_is_done(&mut machine.jobs, machine.world.sessions) {
        return;
    }
    if !Features::<P>::may_go_on(machine) || !machine.safety.apply(Event::Resume) {
        return;
    }
    machine.outputs.stop_spindle(false);
    program_io::say_spindle(&mut machine.world, &mut machine.outputs);
    Features::<P>::goes_on(machine, from);
    machine.world.ports.motion(motion::Motion::resume);
}

/// Ends the job's wait for the operator. False when it did not wait.
pub(crate) fn operator_is_done(jobs: &mut Jobs, sessions: &mut Sessions) -> bool {
    let waited = jobs.operator_is_done();
    if waited {
        sessions.tell_hosts("resumed", Recipient::Nobody);
    }
    waited
}

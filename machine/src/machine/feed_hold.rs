//! Feed holds: motion brakes along its path, and goes on when somebody says so.

use base::Ports;
use base::safety::Event;
use base::sessions::Recipient;
use program::State;

use super::Machine;
use super::moments::{Features, Moments as _};
use super::program_io;

impl<P: Ports> Machine<'_, P> {
    /// Holds, or interrupts because the door opens. False: there is nothing to hold, or the hold waits.
    pub(crate) fn feed_hold(&mut self, event: Event) -> bool {
        if event == Event::Hold && !self.hold.ask() {
            self.announce(format_args!("// NOTE: the hold waits until the tap is out of the hole\n"));
            return false;
        }
        self.follow_motion();
        let was_held = self.safety.state() == State::Hold;
        if !self.safety.apply(event) {
            return false;
        }
        if !was_held {
            self.world.ports.motion(motion::Motion::hold);
        }
        true
    }

    /// Goes on from a hold, or ends a wait for the operator.
    pub(crate) fn feed_resume(&mut self) {
        if self.hold.take_back() {
            return;
        }
        let from = self.safety.state();
        if !matches!(from, State::Hold | State::Door) && self.operator_is_done() {
            return;
        }
        if !Features::<P>::may_go_on(self) || !self.safety.apply(Event::Resume) {
            return;
        }
        self.outputs.stop_spindle(false);
        program_io::say_spindle(&mut self.world, &mut self.outputs);
        Features::<P>::goes_on(self, from);
        self.world.ports.motion(motion::Motion::resume);
    }

    /// Ends the job's wait for the operator. False when it did not wait.
    pub(crate) fn operator_is_done(&mut self) -> bool {
        let waited = self.jobs.operator_is_done();
        if waited {
            self.world.sessions.tell_hosts("resumed", Recipient::Nobody);
        }
        waited
    }
}

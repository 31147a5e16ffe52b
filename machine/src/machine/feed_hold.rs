//! Feed holds: motion brakes along its path, and goes on when somebody says so.

use base::Ports;
use base::ports::MotionPort as _;
use base::safety::Event;
use base::sessions::{Recipient, Sessions};
use jobs::player::Jobs;
use program::State;

use crate::machine::hold::Hold;
use crate::machine::moments::{Features, Moments as _};
use crate::machine::work_hands::HaltHands;
use crate::machine::{Machine, program_io};

/// The machine for holds, and for going on from them.
pub(crate) trait FeedHoldHands<'c>: HaltHands<'c> {
    /// Returns the delay of feed holds.
    fn delay(&mut self) -> &mut Hold;

    /// Follows the planner's state where nothing else says the machine's.
    fn follow_motion(&mut self);

    /// Ends the job's wait for the operator. False when it did not wait.
    fn operator_is_done(&mut self) -> bool;

    /// Whether no feature refuses to go on; else the reason was said.
    fn may_go_on(&mut self) -> bool;

    /// Has the spindle turn again, and features go on.
    fn goes_on(&mut self, from: State);
}

impl<'c, P: Ports> FeedHoldHands<'c> for Machine<'c, P> {
    fn delay(&mut self) -> &mut Hold {
        &mut self.hold
    }

    fn follow_motion(&mut self) {
        self.follow_motion();
    }

    fn operator_is_done(&mut self) -> bool {
        operator_is_done(&mut self.jobs, self.world.sessions)
    }

    fn may_go_on(&mut self) -> bool {
        Features::<P>::may_go_on(self)
    }

    fn goes_on(&mut self, from: State) {
        self.outputs.stop_spindle(false);
        program_io::say_spindle(&mut self.world, &mut self.outputs);
        Features::<P>::goes_on(self, from);
    }
}

/// Holds, or interrupts because the door opens. False: there is nothing to hold, or the hold waits.
pub(crate) fn hold<'c>(hands: &mut impl FeedHoldHands<'c>, event: Event) -> bool {
    if event == Event::Hold && !hands.delay().ask() {
        hands.announce(format_args!("// NOTE: the hold waits until the tap is out of the hole\n"));
        return false;
    }
    hands.follow_motion();
    let was_held = hands.state() == State::Hold;
    if !hands.apply(event) {
        return false;
    }
    if !was_held {
        hands.world().ports.motion(motion::Motion::hold);
    }
    true
}

/// Goes on from a hold, or ends a wait for the operator.
pub(crate) fn resume<'c>(hands: &mut impl FeedHoldHands<'c>) {
    if hands.delay().take_back() {
        return;
    }
    let from = hands.state();
    if !matches!(from, State::Hold | State::Door) && hands.operator_is_done() {
        return;
    }
    if !hands.may_go_on() || !hands.apply(Event::Resume) {
        return;
    }
    hands.goes_on(from);
    hands.world().ports.motion(motion::Motion::resume);
}

/// Ends the job's wait for the operator. False when it did not wait.
pub(crate) fn operator_is_done(jobs: &mut Jobs, sessions: &mut Sessions) -> bool {
    let waited = jobs.operator_is_done();
    if waited {
        sessions.tell_hosts("resumed", Recipient::Nobody);
    }
    waited
}

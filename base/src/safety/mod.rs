//! Safety: the machine's state, halting and coming back, limits, the kill button, and the watch over step
//! times.
//!
//! Safety is the single owner of all facts that decide whether the machine may move: it changes the state and
//! orders the actions, which crate `machine` performs.

mod kill_button;
mod limits;
pub mod state;
mod step_times;
pub mod travel;

use program::State;
use units::Micros;

pub use kill_button::{KillButton, Press};
pub use limits::{Hit, Limits};
pub use state::{Event, Mode};
pub use step_times::{Lateness, StepTimesWatch, microseconds};
use travel::Travel;

/// Time for which a reset from a hold keeps the machine halted: every waiting part hears of the halt by then.
const RESET_TIME: Micros = Micros::from_millis(10);
/// Time in which motion must come to rest; else it is cut.
const STOP_TIMEOUT: Micros = Micros::from_seconds(1);

/// The machine's state and the watches over it.
#[derive(Debug, Default)]
pub struct Safety {
    mode: Mode,
    /// Time since which motion is being brought to rest.
    stopping_since: Option<Micros>,
    /// Whether the motors keep their current in this halt.
    holds_motors: bool,
    /// Whether to release as soon as everything stands still.
    release_wanted: bool,
    /// Time since which a reset halts a machine that stands; such a halt is no alarm and ends by itself.
    resetting_since: Option<Micros>,
    /// Hard limits of the axes.
    pub limits: Limits,
    /// Soft endstops: positions to which axes may be commanded.
    pub travel: Travel,
    /// State of the kill button.
    pub kill_button: KillButton,
    /// Watch over the times of steps.
    pub step_times: StepTimesWatch,
}

/// Action that a halt still needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stopping {
    /// None: no halt is under way, or motion comes to rest by itself.
    Wait,
    /// The motion does not come to rest: cut it, and lose the positions.
    Cut,
    /// Everything stands still, or will not: switch the motors off.
    Over,
}

impl Safety {
    /// Returns the machine's state.
    #[must_use]
    pub const fn state(&self) -> State {
        self.mode.state()
    }

    /// Returns the state, with the state that it interrupted.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.mode
    }

    /// Returns the state for reports, in which a reset is over at once.
    #[must_use]
    pub fn told_mode(&self) -> Mode {
        if self.is_resetting() { Mode::default() } else { self.mode }
    }

    /// Returns whether nothing may move.
    #[must_use]
    pub const fn is_halted(&self) -> bool {
        matches!(self.state(), State::Alarm | State::Sleep | State::Invalid)
    }

    /// Applies an event to the table; an event without meaning changes nothing. Returns true when it was
    /// accepted.
    pub const fn apply(&mut self, event: Event) -> bool {
        match self.mode.next(event) {
            Some(next) => {
                self.mode = next;
                true
            }
            None => false,
        }
    }

    /// Enters the alarm. Returns false when the machine is halted already; a reset is no halt here, and gives
    /// way.
    pub const fn halt(&mut self, now: Micros) -> bool {
        if self.is_halted() && !self.is_resetting() {
            return false;
        }
        self.resetting_since = None;
        self.apply(Event::Halt);
        self.stopping_since = Some(now);
        self.release_wanted = false;
        true
    }

    /// Decides whether the motors keep their current in the present or the next halt; an action that takes
    /// the current from them is then completed.
    pub const fn hold_motors(&mut self, holds: bool) {
        self.holds_motors = holds;
    }

    /// Returns whether the motors keep their current in this halt.
    #[must_use]
    pub const fn holds_motors(&self) -> bool {
        self.holds_motors
    }

    /// Returns whether the machine is halted, at rest, and the motors have their current.
    #[must_use]
    pub const fn rests_held(&self) -> bool {
        self.is_halted() && self.holds_motors && self.stopping_since.is_none()
    }

    /// Halts a machine that stands in a hold, for a moment, so that all waiting parts end. Returns false when
    /// it is halted already.
    pub const fn begin_reset(&mut self, now: Micros) -> bool {
        if self.is_halted() {
            return false;
        }
        self.apply(Event::Halt);
        self.resetting_since = Some(now);
        true
    }

    /// Returns whether the machine is halted for a reset alone.
    #[must_use]
    pub const fn is_resetting(&self) -> bool {
        self.resetting_since.is_some()
    }

    /// Ends a reset, when every waiting part has heard of it. Returns true when it ended now.
    pub fn finish_reset(&mut self, now: Micros) -> bool {
        let is_due = self.resetting_since.is_some_and(|since| now.since(since) >= RESET_TIME);
        if is_due {
            self.resetting_since = None;
            self.apply(Event::Release);
        }
        is_due
    }

    /// Enters the sleep, with everything off; the motors may still come to rest.
    pub const fn sleep(&mut self, now: Micros) -> bool {
        if !self.apply(Event::Sleep) {
            return false;
        }
        if self.stopping_since.is_none() {
            self.stopping_since = Some(now);
        }
        self.release_wanted = false;
        true
    }

    /// Notes that the operator wants the alarm to end, as soon as the motors stand still.
    pub const fn want_release(&mut self) {
        self.release_wanted = self.state() as u8 == State::Alarm as u8;
    }

    /// Returns whether a release waits for the motors to stand still.
    #[must_use]
    pub const fn release_is_pending(&self) -> bool {
        self.release_wanted
    }

    /// Watches a halt under way, and returns the action that it needs.
    pub fn watch_stop(&mut self, now: Micros, motion_is_idle: bool) -> Stopping {
        let Some(since) = self.stopping_since else { return Stopping::Wait };
        if !motion_is_idle {
            let elapsed = now.since(since);
            if elapsed <= STOP_TIMEOUT {
                return Stopping::Wait;
            }
            // Repeating the cut is harmless; the feed answers within its period, if it lives.
            if elapsed <= STOP_TIMEOUT.plus(STOP_TIMEOUT) {
                return Stopping::Cut;
            }
        }
        self.stopping_since = None;
        Stopping::Over
    }

    /// Ends the alarm if a release is wanted and the motors stand still. Returns true when it ended now.
    pub const fn finish_release(&mut self) -> bool {
        if self.stopping_since.is_some() || !self.release_wanted {
            return false;
        }
        self.release_wanted = false;
        self.apply(Event::Release)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(millis: u64) -> Micros {
        Micros::from_millis(millis)
    }

    #[test]
    fn a_reset_ends_by_itself_unless_something_halts_meanwhile() {
        let mut safety = Safety::default();
        assert!(safety.begin_reset(ms(5)) && safety.is_halted() && !safety.finish_reset(ms(14)));
        assert!(safety.finish_reset(ms(15)) && safety.state() == State::Idle);
        assert!(safety.begin_reset(ms(20)) && safety.halt(ms(21)) && !safety.begin_reset(ms(22)));
        assert!(!safety.finish_reset(ms(99)) && safety.state() == State::Alarm);
    }

    #[test]
    fn a_release_waits_until_the_motors_stand() {
        let mut safety = Safety::default();
        assert!(safety.halt(ms(0)) && !safety.halt(ms(1)));
        safety.want_release();
        assert_eq!(safety.watch_stop(ms(10), false), Stopping::Wait);
        assert!(!safety.finish_release() && safety.state() == State::Alarm);
        assert_eq!(safety.watch_stop(ms(20), true), Stopping::Over);
        assert!(safety.finish_release() && safety.state() == State::Idle);
        assert_eq!(safety.watch_stop(ms(30), true), Stopping::Wait);
    }

    #[test]
    fn motion_that_does_not_come_to_rest_is_cut_and_then_given_up() {
        let mut safety = Safety::default();
        safety.halt(ms(0));
        let course = [(500, Stopping::Wait), (1_500, Stopping::Cut), (1_900, Stopping::Cut), (2_100, Stopping::Over)];
        for (at, expected) in course {
            assert_eq!(safety.watch_stop(ms(at), false), expected, "after {at} ms");
        }
    }

    #[test]
    fn a_sleeping_machine_wakes_in_alarm_and_cannot_be_released_before() {
        let mut safety = Safety::default();
        assert!(safety.sleep(ms(0)));
        safety.want_release();
        assert_eq!(safety.watch_stop(ms(1), true), Stopping::Over);
        assert!(!safety.finish_release() && !safety.halt(ms(2)));
        assert!(safety.apply(Event::Wake) && safety.state() == State::Alarm);
    }
}

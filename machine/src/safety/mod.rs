//! Safety: the state of the machine, halting and coming back, limits, the kill button, whether steps came in
//! time.
//!
//! One owner of all that decides whether the machine may move. It changes the state and says what is to be
//! done; the executor does it.

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

/// How long a reset from a hold keeps the machine halted: whatever waits has heard of it by then.
const RESET_TIME: Micros = Micros::from_millis(10);
/// Motion must have come to rest by then, else it is cut.
const STOP_TIMEOUT: Micros = Micros::from_seconds(1);

/// The machine's state and what watches over it.
#[derive(Debug, Default)]
pub struct Safety {
    mode: Mode,
    /// Motion is being brought to rest since then.
    stopping_since: Option<Micros>,
    /// The motors keep their current in this halt.
    holds_motors: bool,
    /// Release as soon as everything stands still.
    release_wanted: bool,
    /// Halted since then by a reset of a machine that stands, which is no alarm and ends by itself.
    resetting_since: Option<Micros>,
    /// The limits.
    pub limits: Limits,
    /// How far axes may be commanded.
    pub travel: Travel,
    /// The kill button.
    pub kill_button: KillButton,
    /// Whether steps came in time.
    pub step_times: StepTimesWatch,
}

/// What a halt still needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stopping {
    /// Nothing: no halt is under way, or motion comes to rest by itself.
    Wait,
    /// The motion does not come to rest: it is to be cut, and positions are lost.
    Cut,
    /// Everything stands still, or will not: motors off.
    Over,
}

impl Safety {
    /// What the machine is doing.
    #[must_use]
    pub const fn state(&self) -> State {
        self.mode.state()
    }

    /// The state, with what it interrupted.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.mode
    }

    /// The state as others are told: a reset is over at once.
    #[must_use]
    pub fn told_mode(&self) -> Mode {
        if self.is_resetting() { Mode::default() } else { self.mode }
    }

    /// Nothing may move.
    #[must_use]
    pub const fn is_halted(&self) -> bool {
        matches!(self.state(), State::Alarm | State::Sleep | State::Invalid)
    }

    /// Applies an event to the table; one that means nothing changes nothing. True when it was accepted.
    pub const fn apply(&mut self, event: Event) -> bool {
        match self.mode.next(event) {
            Some(next) => {
                self.mode = next;
                true
            }
            None => false,
        }
    }

    /// Enters the alarm. False when the machine is halted already; a reset is none, and gives way.
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

    /// Whether the motors keep their current in the halt that follows, or that is: what takes it from them
    /// comes to its end then.
    pub const fn hold_motors(&mut self, holds: bool) {
        self.holds_motors = holds;
    }

    /// The motors keep their current in this halt.
    #[must_use]
    pub const fn holds_motors(&self) -> bool {
        self.holds_motors
    }

    /// Halted, at rest, and the motors have their current.
    #[must_use]
    pub const fn rests_held(&self) -> bool {
        self.is_halted() && self.holds_motors && self.stopping_since.is_none()
    }

    /// Halts a machine that stands in a hold, for a moment: what waits to go on is to end. False when it is
    /// halted already.
    pub const fn begin_reset(&mut self, now: Micros) -> bool {
        if self.is_halted() {
            return false;
        }
        self.apply(Event::Halt);
        self.resetting_since = Some(now);
        true
    }

    /// Halted for a reset alone.
    #[must_use]
    pub const fn is_resetting(&self) -> bool {
        self.resetting_since.is_some()
    }

    /// Ends a reset, when whatever waited has heard of it. True when it ended now.
    pub fn finish_reset(&mut self, now: Micros) -> bool {
        let is_due = self.resetting_since.is_some_and(|since| now.since(since) >= RESET_TIME);
        if is_due {
            self.resetting_since = None;
            self.apply(Event::Release);
        }
        is_due
    }

    /// Everything is off since now; the motors may still come to rest.
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

    /// The operator wants the alarm to end, as soon as the motors stand still.
    pub const fn want_release(&mut self) {
        self.release_wanted = self.state() as u8 == State::Alarm as u8;
    }

    /// A release waits for the motors to stand still.
    #[must_use]
    pub const fn release_is_pending(&self) -> bool {
        self.release_wanted
    }

    /// Looks at a halt under way.
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

    /// Ends the alarm if that is wanted and the motors stand still. True when it ended now.
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

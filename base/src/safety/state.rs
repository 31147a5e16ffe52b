//! States of the machine, and the table of their transitions.
//!
//! | state | accepts | leaves it |
//! |---|---|---|
//! | `Idle` | everything | whatever begins |
//! | `Run` | everything, between the moves | the last move's end; a hold; the door |
//! | `Hold` | lines, which wait in the queue | resume, to what was held |
//! | `Homing`, `Probing`, `Jog` | questions, hold, stops | their ends |
//! | `Suspended` | everything; it is `Idle` with a job to come back to | resume of the job; homing |
//! | `Check` | everything, and carries nothing out | `$C` |
//! | `Door` | questions, stops | resume, to what was interrupted |
//! | `Alarm` | questions and ends (see the table of codes) | release: M999, `$X`, Ctrl-Y, the kill button |
//! | `Sleep` | nothing but a reset | Ctrl-X, to `Alarm` |
//! | `Invalid` | questions, files | a reset with another configuration |
//!
//! In these states heaters keep their targets but in `Alarm`, `Sleep` and `Invalid`, where they are off; a
//! spindle or laser on a hardware timer is off in `Alarm`, `Sleep`, `Invalid` and while the `Door` is open;
//! motors lose their current in `Alarm` once they stand, and in `Sleep`; a job is read in `Idle`, `Run` and
//! `Check` alone, and ends with an alarm.

use program::State;

/// Events that change the machine's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The machine began a move.
    Started,
    /// The last queued move ended.
    Drained,
    /// A homing sequence begins.
    HomingBegins,
    /// The homing sequence ended, well or not.
    HomingEnds,
    /// A search with the probe begins.
    ProbingBegins,
    /// The search ended, well or not.
    ProbingEnds,
    /// The operator moves the machine by hand.
    JogBegins,
    /// The operator asks for a feed hold.
    Hold,
    /// The operator asks to go on.
    Resume,
    /// The job is suspended.
    Suspend,
    /// The job is resumed, or given up.
    Unsuspend,
    /// Programs are read from now on, and nothing moves, heats or is deleted.
    CheckBegins,
    /// Programs are carried out again.
    CheckEnds,
    /// The safety door is open.
    DoorOpens,
    /// A fault or an emergency stop happened.
    Halt,
    /// The operator clears a halt.
    Release,
    /// The operator switches everything off.
    Sleep,
    /// The operator resets a sleeping machine.
    Wake,
    /// The configuration cannot be used.
    ConfigurationFails,
}

impl Event {
    /// List of every event.
    pub const ALL: [Self; 19] = [
        Self::Started,
        Self::Drained,
        Self::HomingBegins,
        Self::HomingEnds,
        Self::ProbingBegins,
        Self::ProbingEnds,
        Self::JogBegins,
        Self::Hold,
        Self::Resume,
        Self::Suspend,
        Self::Unsuspend,
        Self::CheckBegins,
        Self::CheckEnds,
        Self::DoorOpens,
        Self::Halt,
        Self::Release,
        Self::Sleep,
        Self::Wake,
        Self::ConfigurationFails,
    ];
}

/// The state, with the memory needed to come back from it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mode {
    state: State,
    /// State that a hold or the door interrupted.
    interrupted: State,
    /// Whether a job is suspended: then the machine at rest is `Suspended`, not `Idle`.
    suspended: bool,
}

impl Mode {
    /// Returns the present state.
    #[must_use]
    pub const fn state(self) -> State {
        self.state
    }

    /// Returns the state that goes on when a hold ends or the door closes.
    #[must_use]
    pub const fn interrupted(self) -> State {
        self.interrupted
    }

    /// Returns whether the machine is in this state, or has interrupted it for a hold or the door.
    #[must_use]
    pub fn is_in(self, state: State) -> bool {
        self.state == state || matches!(self.state, State::Hold | State::Door) && self.interrupted == state
    }

    /// Returns whether a job is suspended.
    #[must_use]
    pub const fn is_suspended(self) -> bool {
        self.suspended
    }

    const fn rest(self) -> State {
        if self.suspended { State::Suspended } else { State::Idle }
    }

    const fn to(self, state: State) -> Self {
        Self { state, ..self }
    }

    const fn interrupted_by(self, state: State) -> Self {
        Self { state, interrupted: self.state, ..self }
    }

    /// Returns the next state by the whole transition table. `None`: the event means nothing in this state
    /// and changes nothing.
    #[must_use]
    pub const fn next(self, event: Event) -> Option<Self> {
        use State::{Alarm, Check, Door, Hold, Homing, Idle, Invalid, Jog, Probing, Run, Sleep, Suspended};
        Some(match (self.state, event) {
            (Invalid, _) | (Sleep, Event::Halt) => return None,
            (_, Event::ConfigurationFails) => Self { state: Invalid, interrupted: Idle, suspended: false },
            (_, Event::Halt) => Self { state: Alarm, interrupted: Idle, suspended: false },
            (Alarm, Event::Release) => self.to(Idle),
            (Alarm | Idle | Suspended, Event::Sleep) => Self { state: Sleep, interrupted: Idle, suspended: false },
            (Sleep, Event::Wake) => self.to(Alarm),
            (Idle | Suspended, Event::Started) => self.to(Run),
            (Idle | Suspended | Run, Event::HomingBegins) => self.to(Homing),
            (Idle | Suspended | Run, Event::ProbingBegins) => self.to(Probing),
            (Idle | Suspended, Event::JogBegins) => self.to(Jog),
            (Run | Jog, Event::Drained) | (Homing, Event::HomingEnds) | (Probing, Event::ProbingEnds) => {
                self.to(self.rest())
            }
            (Run | Homing | Probing | Jog, Event::Hold) => self.interrupted_by(Hold),
            (Hold | Door, Event::Resume) => Self { state: self.interrupted, interrupted: Idle, ..self },
            (Idle | Suspended | Run | Homing | Probing | Jog, Event::DoorOpens) => self.interrupted_by(Door),
            // The state that the hold interrupted goes on when the door is closed.
            (Hold, Event::DoorOpens) => self.to(Door),
            (Idle, Event::Suspend) => Self { state: Suspended, suspended: true, ..self },
            (Run, Event::Suspend) => Self { suspended: true, ..self },
            (Suspended, Event::Unsuspend) => Self { state: Idle, suspended: false, ..self },
            (_, Event::Unsuspend) if self.suspended => Self { suspended: false, ..self },
            (Idle, Event::CheckBegins) => self.to(Check),
            (Check, Event::CheckEnds) => self.to(Idle),
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn walk(events: &[Event]) -> Mode {
        events.iter().fold(Mode::default(), |mode, event| mode.next(*event).unwrap_or(mode))
    }

    #[test]
    fn what_a_hold_interrupts_goes_on() {
        for (begins, state) in [
            (Event::Started, State::Run),
            (Event::HomingBegins, State::Homing),
            (Event::ProbingBegins, State::Probing),
            (Event::JogBegins, State::Jog),
        ] {
            let held = walk(&[begins, Event::Hold]);
            assert_eq!((held.state(), held.is_in(state)), (State::Hold, true));
            assert_eq!(walk(&[begins, Event::Hold, Event::Resume]).state(), state);
            assert_eq!(walk(&[begins, Event::Hold, Event::DoorOpens]).state(), State::Door);
            assert_eq!(walk(&[begins, Event::DoorOpens]).state(), State::Door);
            assert_eq!(walk(&[begins, Event::Hold, Event::DoorOpens, Event::Resume]).state(), state);
        }
    }

    #[test]
    fn a_suspended_machine_rests_suspended_until_it_is_resumed() {
        let suspended = [Event::Started, Event::Suspend, Event::Drained];
        assert_eq!(walk(&suspended).state(), State::Suspended);
        let moved = walk(&[&suspended[..], &[Event::Started, Event::Drained]].concat());
        assert_eq!(moved.state(), State::Suspended);
        assert_eq!(moved.next(Event::Unsuspend).unwrap().state(), State::Idle);
        let homed = walk(&[&suspended[..], &[Event::HomingBegins, Event::HomingEnds]].concat());
        assert_eq!(homed.state(), State::Suspended);
    }

    proptest! {
        /// In every state a halt stops the machine, and only a release or a sleep leads out of an alarm.
        #[test]
        fn a_halt_ends_everything_and_only_a_release_ends_a_halt(
            events in proptest::collection::vec(0..Event::ALL.len(), 0..12), after in 0..Event::ALL.len(),
        ) {
            let events: Vec<Event> = events.into_iter().map(|index| Event::ALL[index]).collect();
            let mode = walk(&events);
            let halted = mode.next(Event::Halt).unwrap_or(mode);
            prop_assert!(matches!(halted.state(), State::Alarm | State::Sleep | State::Invalid));
            prop_assert!(!halted.is_suspended());
            let after = Event::ALL[after];
            if halted.state() == State::Alarm
                && let Some(next) = halted.next(after)
            {
                prop_assert!(
                    matches!(after, Event::Halt | Event::Release | Event::Sleep | Event::ConfigurationFails),
                    "{after:?} leads to {next:?}"
                );
            }
        }

        /// No state is a dead end, except those that need a reset.
        #[test]
        fn every_state_can_be_left(events in proptest::collection::vec(0..Event::ALL.len(), 0..12)) {
            let events: Vec<Event> = events.into_iter().map(|index| Event::ALL[index]).collect();
            let mode = walk(&events);
            let leads_out = Event::ALL.into_iter().filter_map(|event| mode.next(event)).any(|next| next.state() != mode.state());
            prop_assert!(leads_out || mode.state() == State::Invalid, "{mode:?}");
        }
    }
}

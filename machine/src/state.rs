//! What the machine is doing, as one table.

/// The state of the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum State {
    /// Nothing moves and nothing is queued.
    #[default]
    Idle,
    /// Moves are being executed.
    Run,
    /// A homing sequence is under way.
    Home,
    /// Held by the operator; goes on with [`Event::Resume`].
    Hold {
        /// The hold interrupted a homing sequence.
        homing: bool,
    },
    /// Halted: nothing moves, nothing heats, until released.
    Halt,
}

/// What can happen to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// A move began.
    Started,
    /// The last queued move ended.
    Drained,
    /// A homing sequence begins.
    HomingBegins,
    /// The homing sequence ended, well or not.
    HomingEnds,
    /// The operator asks for a feed hold.
    Hold,
    /// The operator asks to go on.
    Resume,
    /// A fault or an emergency stop.
    Halt,
    /// The operator clears a halt.
    Release,
}

impl State {
    /// The whole transition table. `None`: the event means nothing in this state and is refused.
    #[must_use]
    pub const fn next(self, event: Event) -> Option<Self> {
        Some(match (self, event) {
            (_, Event::Halt) => Self::Halt,
            (Self::Halt, Event::Release) | (Self::Run, Event::Drained) | (Self::Home, Event::HomingEnds) => Self::Idle,
            (Self::Idle, Event::Started) | (Self::Hold { homing: false }, Event::Resume) => Self::Run,
            (Self::Idle | Self::Run, Event::HomingBegins) | (Self::Hold { homing: true }, Event::Resume) => Self::Home,
            (Self::Run, Event::Hold) => Self::Hold { homing: false },
            (Self::Home, Event::Hold) => Self::Hold { homing: true },
            _ => return None,
        })
    }

    /// The name in status reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "Idle",
            Self::Run => "Run",
            Self::Home => "Home",
            Self::Hold { .. } => "Hold",
            Self::Halt => "Alarm",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Event::{Drained, Halt, Hold, HomingBegins, HomingEnds, Release, Resume, Started};

    const EVENTS: [Event; 8] = [Started, Drained, HomingBegins, HomingEnds, Hold, Resume, Halt, Release];
    const HELD: State = State::Hold { homing: false };
    const HELD_HOMING: State = State::Hold { homing: true };

    /// The table as a person would write it: a row for each state, a column for each event.
    #[test]
    fn the_table_is_walked_state_by_state_and_event_by_event() {
        let rows: [(State, [Option<State>; 8]); 6] = [
            (State::Idle, [Some(State::Run), None, Some(State::Home), None, None, None, Some(State::Halt), None]),
            (State::Run, [None, Some(State::Idle), Some(State::Home), None, Some(HELD), None, Some(State::Halt), None]),
            (State::Home, [None, None, None, Some(State::Idle), Some(HELD_HOMING), None, Some(State::Halt), None]),
            (HELD, [None, None, None, None, None, Some(State::Run), Some(State::Halt), None]),
            (HELD_HOMING, [None, None, None, None, None, Some(State::Home), Some(State::Halt), None]),
            (State::Halt, [None, None, None, None, None, None, Some(State::Halt), Some(State::Idle)]),
        ];
        for (state, row) in rows {
            for (event, expected) in EVENTS.into_iter().zip(row) {
                assert_eq!(state.next(event), expected, "{state:?} on {event:?}");
            }
        }
    }

    #[test]
    fn every_state_can_be_halted_and_only_release_leaves_a_halt() {
        for state in [State::Idle, State::Run, State::Home, HELD, HELD_HOMING, State::Halt] {
            assert_eq!(state.next(Halt), Some(State::Halt));
        }
        for event in EVENTS {
            let leaves = State::Halt.next(event).is_some_and(|next| next != State::Halt);
            assert_eq!(leaves, event == Release, "{event:?}");
        }
    }
}

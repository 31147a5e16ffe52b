//! States of a machine, and sets of states.

/// State of the machine, which decides the commands that are permitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum State {
    /// Nothing moves and nothing is queued.
    #[default]
    Idle,
    /// Moves are being executed.
    Run,
    /// The operator has stopped the motion by feed hold, and can resume.
    Hold,
    /// Axes are being homed.
    Homing,
    /// The machine is probing for a contact.
    Probing,
    /// The operator moves the machine by hand.
    Jog,
    /// A job is suspended: the operator may move the machine, and resumes the job.
    Suspended,
    /// Programs are read and nothing is carried out.
    Check,
    /// The safety door is open.
    Door,
    /// Halted: nothing moves, nothing heats, until released.
    Alarm,
    /// Everything is off until a reset.
    Sleep,
    /// The configuration cannot be used: nothing may move or heat.
    Invalid,
}

impl State {
    /// All states, in the order of the bits of [`States`].
    pub const ALL: [Self; 12] = [
        Self::Idle,
        Self::Run,
        Self::Hold,
        Self::Homing,
        Self::Probing,
        Self::Jog,
        Self::Suspended,
        Self::Check,
        Self::Door,
        Self::Alarm,
        Self::Sleep,
        Self::Invalid,
    ];

    /// Returns the name in status reports, GRBL's if GRBL has the state.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle | Self::Suspended => "Idle",
            Self::Run | Self::Probing => "Run",
            Self::Hold => "Hold",
            Self::Homing => "Home",
            Self::Jog => "Jog",
            Self::Check => "Check",
            Self::Door => "Door",
            Self::Alarm | Self::Invalid => "Alarm",
            Self::Sleep => "Sleep",
        }
    }
}

/// Set of states, one bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct States(u16);

impl States {
    /// Set of all states.
    pub const ALL: Self = Self(0x0FFF);
    /// States of a working machine: all but alarm, sleep and an invalid configuration.
    pub const WORKING: Self = Self::ALL.without(State::Alarm).without(State::Sleep).without(State::Invalid);
    /// States of a working machine, and alarm.
    pub const WORKING_OR_ALARM: Self = Self::WORKING.with(State::Alarm);
    /// States for commands that need neither motion nor heat: a working machine, or an invalid configuration.
    pub const WORKING_OR_INVALID: Self = Self::WORKING.with(State::Invalid);

    /// Returns the set of a single state.
    #[must_use]
    pub const fn of(state: State) -> Self {
        Self(1 << state as u16)
    }

    /// Returns this set with a state added.
    #[must_use]
    pub const fn with(self, state: State) -> Self {
        Self(self.0 | 1 << state as u16)
    }

    /// Returns this set with a state removed.
    #[must_use]
    pub const fn without(self, state: State) -> Self {
        Self(self.0 & !(1 << state as u16))
    }

    /// Whether the set contains a state.
    #[must_use]
    pub const fn has(self, state: State) -> bool {
        self.0 & 1 << state as u16 != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_has_every_state_and_only_those() {
        assert_eq!(State::ALL.into_iter().fold(States(0), States::with), States::ALL);
        assert!(!States::WORKING.has(State::Alarm) && States::WORKING_OR_ALARM.has(State::Alarm));
        assert!(!States::WORKING_OR_INVALID.has(State::Sleep) && States::of(State::Sleep).has(State::Sleep));
    }
}

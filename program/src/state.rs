//! The states a machine can be in, and sets of them.

/// What the machine is doing, as far as it decides what may be asked of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum State {
    /// Nothing moves and nothing is queued.
    #[default]
    Idle,
    /// Moves are being executed.
    Run,
    /// The operator has stopped the motion, which goes on when he says so.
    Hold,
    /// Switches are being searched for.
    Homing,
    /// A contact is being searched for.
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
    /// Every state, in this order.
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

    /// The name in status reports, in GRBL's words where it has one.
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

/// A set of states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct States(u16);

impl States {
    /// Every state.
    pub const ALL: Self = Self(0x0FFF);
    /// A machine that works: all but alarm, sleep and an invalid configuration.
    pub const WORKING: Self = Self::ALL.without(State::Alarm).without(State::Sleep).without(State::Invalid);
    /// The same, and alarm.
    pub const WORKING_OR_ALARM: Self = Self::WORKING.with(State::Alarm);
    /// What needs neither motion nor heat: a machine that works, or whose configuration cannot be used.
    pub const WORKING_OR_INVALID: Self = Self::WORKING.with(State::Invalid);

    /// One state.
    #[must_use]
    pub const fn of(state: State) -> Self {
        Self(1 << state as u16)
    }

    /// This set and a state.
    #[must_use]
    pub const fn with(self, state: State) -> Self {
        Self(self.0 | 1 << state as u16)
    }

    /// This set but for a state.
    #[must_use]
    pub const fn without(self, state: State) -> Self {
        Self(self.0 & !(1 << state as u16))
    }

    /// Whether a state is in it.
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

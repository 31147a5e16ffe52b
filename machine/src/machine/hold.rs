//! Delay of feed holds: a tap that stands while the spindle turns breaks.

/// State of feed holds during taps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Hold {
    /// A feed hold acts at once.
    #[default]
    Acts,
    /// Behind the hole that is being tapped.
    Waits,
    /// Behind that hole, and a hold has been asked for.
    Asked,
}

impl Hold {
    /// Asks for a hold; returns whether it acts now.
    pub fn ask(&mut self) -> bool {
        if *self == Self::Waits {
            *self = Self::Asked;
        }
        *self == Self::Acts
    }

    /// Whether a hold would act now.
    pub fn acts(self) -> bool {
        self == Self::Acts
    }

    /// Takes back a hold that waits. False when none does.
    pub fn take_back(&mut self) -> bool {
        let waited = *self == Self::Asked;
        if waited {
            *self = Self::Waits;
        }
        waited
    }

    /// Has holds act at once, or wait from now on. Returns whether a hold has waited, and acts now.
    pub fn let_act(&mut self, acts: bool) -> bool {
        let before = *self;
        *self = match (acts, before) {
            (true, _) => Self::Acts,
            (false, Self::Asked) => Self::Asked,
            (false, _) => Self::Waits,
        };
        acts && before == Self::Asked
    }
}

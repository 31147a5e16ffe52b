//! What a turn of a wait comes back with.

use crate::failure::Failure;

/// How the machine stands after a turn of a wait. Whoever waits looks whether that is still worth it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use = "most waits end when the machine halts"]
pub enum Waited {
    /// Nothing is in the way.
    Free,
    /// The operator holds the machine, or the door is open.
    Held,
    /// The machine is halted.
    Halted,
}

impl Waited {
    /// For what ends with the machine's halt.
    ///
    /// # Errors
    /// [`Failure::HALTED`].
    pub const fn unless_halted(self) -> Result<(), Failure> {
        match self {
            Self::Halted => Err(Failure::HALTED),
            Self::Free | Self::Held => Ok(()),
        }
    }

    /// For what goes on whatever happens: files are to be whole on the card, halt or not.
    pub const fn whatever_happens(self) {}
}

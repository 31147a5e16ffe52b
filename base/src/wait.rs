//! Result of one turn of a wait.

use crate::failure::Failure;

/// State of the machine after a turn of a wait. The waiting code decides whether to go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use = "most waits end when the machine halts"]
pub enum Waited {
    /// The machine may go on.
    Free,
    /// The operator holds the machine, or the door is open.
    Held,
    /// The machine is halted.
    Halted,
}

impl Waited {
    /// Fails when the machine is halted, for waits that end with a halt.
    ///
    /// # Errors
    /// [`Failure::HALTED`].
    pub const fn unless_halted(self) -> Result<(), Failure> {
        match self {
            Self::Halted => Err(Failure::HALTED),
            Self::Free | Self::Held => Ok(()),
        }
    }

    /// Ignores halts, for waits that go on whatever happens: files are to be whole on the card, halt or not.
    pub const fn whatever_happens(self) {}
}

//! The USB socket.

use config::SystemConfig;

use super::StorageError;

/// How the card stands with the computer at the USB socket.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Disk {
    /// The machine has it.
    #[default]
    Kept,
    /// The computer has it, as a disk.
    Lent,
    /// It has ended that: the card is to be [taken back](Usb::take_card_back).
    GivenBack,
    /// It has gone without a word, with the card.
    Gone,
}

/// Why a computer cannot have the card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotLent {
    /// There is none, or it sleeps.
    NoComputer,
    /// The card's own reason: there is none, or files are open.
    Storage(StorageError),
}

/// What the machine has to do with the computer at its USB socket, beside the sessions that it has there. A
/// board without a socket leaves all of it out.
pub trait Usb {
    /// Shows the board to a computer, as what its settings allow. Once, when the configuration has been read,
    /// whatever has become of it.
    ///
    /// # Errors
    /// The socket does not work: what is wrong, and what to do.
    fn connect(&mut self, _system: &SystemConfig) -> Result<(), &'static str> {
        Ok(())
    }

    /// Gives the card to the computer, which sees it from now on as a disk; the machine has no files then.
    /// False while something waits to be written: ask again.
    ///
    /// # Errors
    /// [`NotLent`].
    fn lend_card(&mut self) -> Result<bool, NotLent> {
        Err(NotLent::NoComputer)
    }

    /// Who has the card.
    fn disk(&mut self) -> Disk {
        Disk::Kept
    }

    /// The computer's disk is empty from now on. [`Self::disk`] says so when nothing is under way any more.
    fn revoke_card(&mut self) {}

    /// The card is the machine's again, and not mounted.
    fn take_card_back(&mut self) {}

    /// The lamp that says who has the card.
    fn set_disk_lamp(&mut self, _on: bool) {}
}

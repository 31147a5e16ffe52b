//! Access to the USB socket.

use config::SystemConfig;

use super::StorageError;

/// Ownership of the card between the machine and the computer at the USB socket.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Disk {
    /// The machine has the card.
    #[default]
    Kept,
    /// The computer has the card, as a disk.
    Lent,
    /// The computer has ended its use: the card is to be [taken back](Usb::take_card_back).
    GivenBack,
    /// The computer has gone without a word, with the card.
    Gone,
}

/// Reason why a computer cannot have the card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotLent {
    /// There is no computer, or it sleeps.
    NoComputer,
    /// The card's own reason: there is none, or files are open.
    Storage(StorageError),
}

/// Access to the computer at the USB socket, beside its sessions. A board without a socket leaves all of it
/// out.
pub trait Usb {
    /// Shows the board to a computer, as its settings allow. Called once, when the configuration has been
    /// read, valid or not.
    ///
    /// # Errors
    /// When the socket does not work: what is wrong, and what to do.
    fn connect(&mut self, _system: &SystemConfig) -> Result<(), &'static str> {
        Ok(())
    }

    /// Gives the card to the computer, which sees it from now on as a disk; the machine has no files then.
    /// False while something waits to be written: ask again.
    ///
    /// # Errors
    /// [`NotLent`] with the reason.
    fn lend_card(&mut self) -> Result<bool, NotLent> {
        Err(NotLent::NoComputer)
    }

    /// Returns the ownership of the card.
    fn disk(&mut self) -> Disk {
        Disk::Kept
    }

    /// Makes the computer's disk empty from now on. [`Self::disk`] shows it when nothing is under way any
    /// more.
    fn revoke_card(&mut self) {}

    /// Takes the card back; it is not mounted.
    fn take_card_back(&mut self) {}

    /// Switches the lamp that shows the card's ownership.
    fn set_disk_lamp(&mut self, _on: bool) {}
}

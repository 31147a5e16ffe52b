//! Errors of a card, with messages for the user.

use core::fmt;

use super::host::Fault;

/// Kinds of cards that cannot be used here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unsupported {
    /// The card is a MultiMediaCard.
    Mmc,
    /// The card does not work at 3.3 V.
    Voltage,
    /// More than 2 TB (SDUC).
    TooLarge,
    /// The card is locked with a password.
    Locked,
}

/// Error of the card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SdError {
    /// No card answers to identification.
    NoCard,
    /// The card is not one that can be used.
    Unsupported(Unsupported),
    /// The card stopped answering; carries the command.
    NotResponding(u8),
    /// The card was busy for longer than any card may be; carries the command.
    StaysBusy(u8),
    /// Answers or blocks arrive damaged, however often they are repeated; carries the command.
    Damaged(u8),
    /// The card refused a command; carries the command and the error bits of its status.
    Refused(u8, u32),
    /// The card cannot read a block any more: its own error correction has failed.
    Unreadable,
    /// The card takes no writes.
    Protected,
    /// A block written reads back differently.
    NotKept,
    /// The host could not keep up with the card.
    Host,
    /// A block beyond the card's end.
    OutOfRange,
    /// Another user has the card.
    Lent,
    /// An earlier write has failed, and nothing is written until that is forgiven by
    /// [`Service::forgive`](super::Service::forgive).
    WriteFailed,
}

impl SdError {
    /// Converts a fault on the bus.
    pub(super) const fn of(fault: Fault, command: u8) -> Self {
        match fault {
            Fault::NoAnswer => Self::NotResponding(command),
            Fault::AnswerDamaged | Fault::DataDamaged => Self::Damaged(command),
            Fault::TooLate => Self::StaysBusy(command),
            Fault::Host => Self::Host,
        }
    }
}

impl fmt::Display for SdError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoCard => f.write_str("no SD card answers"),
            Self::Unsupported(Unsupported::Mmc) => f.write_str("this is a MultiMediaCard: use an SD card"),
            Self::Unsupported(Unsupported::Voltage) => f.write_str("the SD card does not work at 3.3 V"),
            Self::Unsupported(Unsupported::TooLarge) => f.write_str("the SD card is larger than 2 TB"),
            Self::Unsupported(Unsupported::Locked) => f.write_str("the SD card is locked with a password"),
            Self::NotResponding(command) => write!(f, "the SD card did not answer command {command}"),
            Self::StaysBusy(command) => write!(f, "the SD card did not end command {command}"),
            Self::Damaged(command) => write!(f, "SD command {command}, or its data, arrived damaged"),
            Self::Refused(command, bits) => write!(f, "the SD card refused command {command} with status {bits:#010x}"),
            Self::Unreadable => f.write_str("the SD card cannot read one of its blocks"),
            Self::Protected => f.write_str("the SD card is write-protected"),
            Self::NotKept => f.write_str("the SD card does not keep what is written"),
            Self::Host => f.write_str("the SD controller lost data"),
            Self::OutOfRange => f.write_str("a block beyond the end of the SD card was asked for"),
            Self::Lent => f.write_str("the SD card is in use over USB"),
            Self::WriteFailed => f.write_str("an earlier write to the SD card has failed"),
        }
    }
}

impl core::error::Error for SdError {}

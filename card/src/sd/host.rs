//! Interface to a host controller: send a command, move blocks by DMA, report the progress.

use super::BLOCK_BYTES;

/// Contents of a block.
pub type Block = [u8; BLOCK_BYTES];

/// State of the interface's power supply (PL 6.00 section 6.4.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Power {
    /// All lines low, so that the card is not fed through them; the controller as after a reset.
    Cycle,
    /// All lines high, no clock.
    Off,
    /// The card is clocked.
    On,
}

/// Kind of answer to a command (PL 6.00 section 4.9).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The card does not answer.
    None,
    /// 48 bits with a checksum (R1, R6, R7).
    Short,
    /// 48 bits without a checksum (R3).
    ShortUnchecked,
    /// 136 bits with a checksum (R2).
    Long,
}

/// Command to the card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Command {
    /// Number of the command, 0 to 63. 12 ends whatever transfer is under way, in the host too.
    pub index: u8,
    /// Argument of the command.
    pub argument: u32,
    /// Kind of the answer.
    pub answer: Answer,
}

impl Command {
    /// Creates a command with a short answer.
    #[must_use]
    pub const fn new(index: u8, argument: u32) -> Self {
        Self { index, argument, answer: Answer::Short }
    }

    /// Changes the kind of answer.
    #[must_use]
    pub const fn answered(self, answer: Answer) -> Self {
        Self { answer, ..self }
    }
}

/// Direction of a data transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From the card to the host.
    FromCard,
    /// From the host to the card.
    ToCard,
}

/// Place of data in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// From this slot of the service's own memory on.
    Slot(usize),
    /// From this address on, within reach of the host's DMA.
    Address(u32),
}

/// Data that follow a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transfer {
    /// Direction of the transfer.
    pub direction: Direction,
    /// Number of blocks to transfer.
    pub blocks: u32,
    /// Bytes of each block: 512, or 8 or 64 for a register.
    pub block_bytes: u16,
    /// Source or destination in memory.
    pub place: Place,
}

/// Fault on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// No answer to the command.
    NoAnswer,
    /// The answer arrived damaged.
    AnswerDamaged,
    /// A block arrived damaged at the host or the card.
    DataDamaged,
    /// No data came, or the card stayed busy, for longer than any card may.
    TooLate,
    /// The host could not keep up with the card, or did not reach the memory.
    Host,
}

/// Progress of the host with its command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// The command has not ended yet.
    Busy,
    /// All of it is done: answered, and data moved.
    Done,
    /// The command has failed, and ends with that.
    Failed(Fault),
}

/// Host controller of the card slot.
///
/// The host calls the code that advances the [`Service`](super::Service) when [`progress`](Self::progress) or
/// [`is_held_busy`](Self::is_held_busy) changes; a clock that ticks makes up for calls that are missed.
pub trait Host {
    /// Sets the power of the interface.
    fn power(&mut self, state: Power);

    /// Sets the bus: the highest clock that is not above `hz`, with one data line or four.
    fn set_bus(&mut self, hz: u32, is_wide: bool);

    /// Sends a command, with data or without.
    fn begin(&mut self, command: Command, data: Option<Transfer>);

    /// Returns the progress of the command.
    fn progress(&mut self) -> Progress;

    /// The last answer: the first word of a short one, or all four, most significant first.
    fn answer(&self) -> [u32; 4];

    /// Whether the card holds D0 low: it is busy.
    fn is_held_busy(&mut self) -> bool;

    /// Reads a slot of the memory.
    fn load(&self, slot: usize, block: &mut Block);

    /// Writes a slot of the memory.
    fn store(&mut self, slot: usize, block: &Block);
}

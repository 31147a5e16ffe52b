//! What a host controller has to do: send a command, move blocks by DMA, say how far it is.

use super::BLOCK_BYTES;

/// A block.
pub type Block = [u8; BLOCK_BYTES];

/// How the interface to the card is powered (PL 6.00 section 6.4.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Power {
    /// All lines low, so that the card is not fed through them; the controller as after a reset.
    Cycle,
    /// All lines high, no clock.
    Off,
    /// The card is clocked.
    On,
}

/// What a command is answered with (PL 6.00 section 4.9).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Nothing.
    None,
    /// 48 bits with a checksum (R1, R6, R7).
    Short,
    /// 48 bits without (R3).
    ShortUnchecked,
    /// 136 bits (R2).
    Long,
}

/// A command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Command {
    /// Its number, 0 to 63. 12 ends whatever transfer is under way, in the host too.
    pub index: u8,
    /// Its argument.
    pub argument: u32,
    /// What is answered.
    pub answer: Answer,
}

impl Command {
    /// With a short answer.
    #[must_use]
    pub const fn new(index: u8, argument: u32) -> Self {
        Self { index, argument, answer: Answer::Short }
    }

    /// With another answer.
    #[must_use]
    pub const fn answered(self, answer: Answer) -> Self {
        Self { answer, ..self }
    }
}

/// Which way data go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// The card sends.
    FromCard,
    /// The card receives.
    ToCard,
}

/// Where data are in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// From this slot of the service's own memory on.
    Slot(usize),
    /// From this address on, which the host's DMA must reach.
    Address(u32),
}

/// Data that follow a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transfer {
    /// Which way.
    pub direction: Direction,
    /// How many blocks.
    pub blocks: u32,
    /// Bytes of each: 512, or 8 or 64 for a register.
    pub block_bytes: u16,
    /// Where from, or where to.
    pub place: Place,
}

/// What went wrong on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// No answer to the command.
    NoAnswer,
    /// Its answer arrived damaged.
    AnswerDamaged,
    /// A block arrived damaged, here or there.
    DataDamaged,
    /// No data came, or the card stayed busy, for longer than any card may.
    TooLate,
    /// The host could not keep up with the card, or did not reach the memory.
    Host,
}

/// How far the host is with what it was told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Not yet at its end.
    Busy,
    /// All of it is done: answered, and data moved.
    Done,
    /// It has failed, and no more will come of it.
    Failed(Fault),
}

/// A host controller.
///
/// It calls whoever moves the [`Service`](super::Service) on when [`progress`](Self::progress) or
/// [`is_held_busy`](Self::is_held_busy) has something new to say; a clock that ticks makes up for calls that
/// are missed.
pub trait Host {
    /// Powers the interface.
    fn power(&mut self, state: Power);

    /// Sets the bus: the highest clock that is not above `hz`, with one data line or four.
    fn set_bus(&mut self, hz: u32, is_wide: bool);

    /// Sends a command, with data or without.
    fn begin(&mut self, command: Command, data: Option<Transfer>);

    /// How far it is.
    fn progress(&mut self) -> Progress;

    /// The last answer: the first word of a short one, or all four, most significant first.
    fn answer(&self) -> [u32; 4];

    /// Whether the card holds D0 low: it is busy.
    fn is_held_busy(&mut self) -> bool;

    /// Reads a slot.
    fn load(&self, slot: usize, block: &mut Block);

    /// Writes a slot.
    fn store(&mut self, slot: usize, block: &Block);
}

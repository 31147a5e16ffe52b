//! The medium behind the disk.

/// Bytes of a block.
pub const BLOCK_BYTES: usize = 512;

/// One of the two buffers that a medium brings: one is filled while the other is emptied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// The one used first.
    First,
    /// The other.
    Second,
}

impl Half {
    /// The other one.
    #[must_use]
    pub const fn other(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
        }
    }
}

/// Whether there is a medium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// None, or none that the host may see.
    Absent,
    /// There is one.
    Ready {
        /// How many blocks it has.
        blocks: u32,
        /// It may only be read.
        is_read_only: bool,
        /// Another number than the last time there was one: it may be another one, or have changed. The host
        /// forgets what it remembers of the one before.
        visit: u32,
    },
}

/// What became of reading or writing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The medium is gone.
    Gone,
    /// It may not be written.
    ReadOnly,
    /// Its blocks cannot be read.
    Unreadable,
    /// Its blocks could not be written.
    NotWritten,
    /// It does not answer.
    Silent,
}

/// How far an operation is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Under way.
    Busy,
    /// At its end.
    Done,
    /// It failed.
    Failed(Fault),
}

/// A medium with two buffers. One operation at a time: it is begun, and looked at until it is not busy any
/// more. None of this waits. Whoever implements it calls [`crate::Composite::run`] when an operation ends.
pub trait Medium {
    /// How many blocks a buffer holds.
    const BUFFER_BLOCKS: u32;

    /// Whether there is a medium.
    fn state(&self) -> State;

    /// Begins to read blocks into a buffer: one at least, as many as it holds at most, none behind the end.
    fn begin_read(&mut self, block: u32, count: u32, buffer: Half);

    /// Begins to write blocks from a buffer, as many.
    fn begin_write(&mut self, block: u32, count: u32, buffer: Half);

    /// How the operation that was begun last stands.
    fn progress(&mut self) -> Progress;

    /// Copies bytes of a buffer.
    fn fetch(&self, buffer: Half, at: usize, into: &mut [u8]);

    /// Copies bytes into a buffer.
    fn store(&mut self, buffer: Half, at: usize, bytes: &[u8]);

    /// The host is done with the medium and gives it back. It is absent from now on.
    fn eject(&mut self);
}

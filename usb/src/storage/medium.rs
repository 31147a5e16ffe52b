//! The medium behind the disk: the trait, and its types.

/// Size of a block in bytes.
pub const BLOCK_BYTES: usize = 512;

/// Selects one of a medium's two buffers: one is filled while the other is emptied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// Buffer that is used first.
    First,
    /// Buffer that is used second.
    Second,
}

impl Half {
    /// Returns the other buffer of the two.
    #[must_use]
    pub const fn other(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
        }
    }
}

/// Presence of a medium, and its properties.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// No medium, or none that the host may see.
    Absent,
    /// Medium that the host may use.
    Ready {
        /// Number of blocks of the medium.
        blocks: u32,
        /// Whether the medium is write-protected.
        is_read_only: bool,
        /// Number that changes whenever the medium may have been exchanged or changed, so that the host drops
        /// its cache.
        visit: u32,
    },
}

/// Failure of reading or writing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The medium has been removed.
    Gone,
    /// The medium is write-protected.
    ReadOnly,
    /// Blocks cannot be read.
    Unreadable,
    /// Blocks could not be written.
    NotWritten,
    /// The medium does not answer.
    Silent,
}

/// Progress of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Operation still in progress.
    Busy,
    /// Operation completed without error.
    Done,
    /// Operation ended with an error.
    Failed(Fault),
}

/// A medium with two buffers. Operations run one at a time: begin one, and poll `progress` until it is no
/// longer busy. No method waits. Implementers call [`crate::Composite::run`] when an operation ends.
pub trait Medium {
    /// Number of blocks in a buffer.
    const BUFFER_BLOCKS: u32;

    /// Returns the presence and properties of the medium.
    fn state(&self) -> State;

    /// Begins to read blocks into a buffer: at least one, at most a buffer full, none behind the end.
    fn begin_read(&mut self, block: u32, count: u32, buffer: Half);

    /// Begins to write blocks from a buffer, with the same limits.
    fn begin_write(&mut self, block: u32, count: u32, buffer: Half);

    /// Returns the progress of the last operation.
    fn progress(&mut self) -> Progress;

    /// Copies bytes out of a buffer.
    fn fetch(&self, buffer: Half, at: usize, into: &mut [u8]);

    /// Copies bytes into a buffer.
    fn store(&mut self, buffer: Half, at: usize, bytes: &[u8]);

    /// Ends the host's use of the medium, which is absent from now on.
    fn eject(&mut self);
}

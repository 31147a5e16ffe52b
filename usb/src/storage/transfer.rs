//! Transfer of blocks between bus and medium: while the bus uses one buffer, the medium uses the other.

use super::medium::{BLOCK_BYTES, Fault, Half, Medium, Progress};
use super::scsi::Blocks;

/// Direction of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// From the medium to the host.
    ToHost,
    /// From the host to the medium.
    FromHost,
    /// From the medium only, to check that blocks can be read.
    Nowhere,
}

/// Transfer of a command's blocks.
#[derive(Clone, Copy, Debug)]
pub struct Transfer {
    way: Way,
    /// Blocks that the medium has not been asked for yet.
    rest: Blocks,
    /// Bytes that have not crossed the bus yet.
    bytes: u32,
    /// Bytes that each buffer holds for the other side.
    held: [usize; 2],
    /// Buffer used by the bus, and the offset in it.
    at_bus: (Half, usize),
    /// Buffer for the medium's next operation.
    at_medium: Half,
    /// Size of the medium's operation in progress, bytes.
    operation: Option<usize>,
}

impl Transfer {
    /// Creates a transfer of these blocks.
    pub const fn new(way: Way, blocks: Blocks) -> Self {
        let bytes = if matches!(way, Way::Nowhere) { 0 } else { blocks.bytes() };
        let (at_bus, at_medium) = ((Half::First, 0), Half::First);
        Self { way, rest: blocks, bytes, held: [0; 2], at_bus, at_medium, operation: None }
    }

    /// Returns the direction of the transfer.
    pub const fn way(&self) -> Way {
        self.way
    }

    /// Whether all blocks have been moved to their destination.
    pub const fn is_over(&self) -> bool {
        self.bytes == 0 && self.rest.count == 0 && self.operation.is_none() && self.held[0] == 0 && self.held[1] == 0
    }

    /// Whether the medium carries out an operation.
    pub const fn is_at_medium(&self) -> bool {
        self.operation.is_some()
    }

    const fn held(&mut self, half: Half) -> &mut usize {
        match half {
            Half::First => &mut self.held[0],
            Half::Second => &mut self.held[1],
        }
    }

    /// Handles the end of the medium's operation, and begins the next if possible.
    ///
    /// # Errors
    /// When the medium reports a fault.
    pub fn advance<M: Medium>(&mut self, medium: &mut M) -> Result<(), Fault> {
        if let Some(bytes) = self.operation {
            match medium.progress() {
                Progress::Busy => return Ok(()),
                Progress::Failed(fault) => {
                    self.operation = None;
                    return Err(fault);
                }
                Progress::Done => self.operation_ends(bytes),
            }
        }
        self.begin(medium);
        Ok(())
    }

    fn operation_ends(&mut self, bytes: usize) {
        self.operation = None;
        match self.way {
            Way::ToHost => *self.held(self.at_medium) = bytes,
            Way::FromHost => *self.held(self.at_medium) = 0,
            Way::Nowhere => return,
        }
        self.at_medium = self.at_medium.other();
    }

    fn begin<M: Medium>(&mut self, medium: &mut M) {
        let held = *self.held(self.at_medium);
        let blocks = match self.way {
            // The bus still needs the bytes of a full buffer, so do not fill it again.
            Way::ToHost if held > 0 => return,
            Way::ToHost | Way::Nowhere => self.rest.count.min(M::BUFFER_BLOCKS),
            Way::FromHost => (held / BLOCK_BYTES) as u32,
        };
        if blocks == 0 {
            return;
        }
        match self.way {
            Way::FromHost => medium.begin_write(self.rest.first, blocks, self.at_medium),
            _ => medium.begin_read(self.rest.first, blocks, self.at_medium),
        }
        self.operation = Some(blocks as usize * BLOCK_BYTES);
        self.rest = Blocks { first: self.rest.first + blocks, count: self.rest.count - blocks };
    }

    /// Returns the next bytes for the host; `None` while the medium has not read them.
    pub fn fetch<'p, M: Medium>(&self, medium: &M, packet: &'p mut [u8]) -> Option<&'p [u8]> {
        let (half, at) = self.at_bus;
        let held = self.held[half as usize];
        let packet = packet.get_mut(..(held - at).min(packet.len()))?;
        if packet.is_empty() {
            return None;
        }
        medium.fetch(half, at, packet);
        Some(packet)
    }

    /// Notes that the bus has taken this number of bytes.
    pub fn taken(&mut self, count: usize) {
        let (half, at) = self.at_bus;
        self.bytes -= count as u32;
        self.at_bus.1 = at + count;
        if self.at_bus.1 >= *self.held(half) {
            *self.held(half) = 0;
            self.at_bus = (half.other(), 0);
        }
    }

    /// Returns the number of bytes that the host may send: up to the end of a buffer, none while the medium
    /// has not written the buffer.
    pub fn room<M: Medium>(&self) -> usize {
        let (half, at) = self.at_bus;
        if self.held[half as usize] > 0 { 0 } else { self.capacity::<M>() - at }
    }

    /// Returns the number of bytes after which the buffer at the bus goes to the medium.
    fn capacity<M: Medium>(&self) -> usize {
        let (_, at) = self.at_bus;
        (M::BUFFER_BLOCKS as usize * BLOCK_BYTES).min(at + self.bytes as usize)
    }

    /// Stores bytes of the host, no more than there is room for.
    pub fn store<M: Medium>(&mut self, medium: &mut M, bytes: &[u8]) {
        let (half, at) = self.at_bus;
        let capacity = self.capacity::<M>();
        medium.store(half, at, bytes);
        self.bytes -= bytes.len() as u32;
        self.at_bus.1 = at + bytes.len();
        if self.at_bus.1 >= capacity {
            *self.held(half) = capacity;
            self.at_bus = (half.other(), 0);
        }
    }
}

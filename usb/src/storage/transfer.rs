//! Blocks on their way between bus and medium: while one buffer is at the bus the other is at the medium.

use super::medium::{BLOCK_BYTES, Fault, Half, Medium, Progress};
use super::scsi::Blocks;

/// Which way the blocks go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// From the medium to the host.
    ToHost,
    /// From the host to the medium.
    FromHost,
    /// From the medium to nowhere: only whether they can be read matters.
    Nowhere,
}

/// A command's blocks.
#[derive(Clone, Copy, Debug)]
pub struct Transfer {
    way: Way,
    /// Blocks that the medium has not been asked for yet.
    rest: Blocks,
    /// Bytes that have not crossed the bus yet.
    bytes: u32,
    /// Bytes that each buffer holds for the other side.
    held: [usize; 2],
    /// The buffer that the bus is at, and the place in it.
    at_bus: (Half, usize),
    /// The buffer for the medium's next operation.
    at_medium: Half,
    /// Bytes of the medium's operation under way.
    operation: Option<usize>,
}

impl Transfer {
    /// These blocks, that way.
    pub const fn new(way: Way, blocks: Blocks) -> Self {
        let bytes = if matches!(way, Way::Nowhere) { 0 } else { blocks.bytes() };
        let (at_bus, at_medium) = ((Half::First, 0), Half::First);
        Self { way, rest: blocks, bytes, held: [0; 2], at_bus, at_medium, operation: None }
    }

    /// Which way.
    pub const fn way(&self) -> Way {
        self.way
    }

    /// Every block has crossed the bus, and is where it belongs.
    pub const fn is_over(&self) -> bool {
        self.bytes == 0 && self.rest.count == 0 && self.operation.is_none() && self.held[0] == 0 && self.held[1] == 0
    }

    /// Whether the medium has an operation under way.
    pub const fn is_at_medium(&self) -> bool {
        self.operation.is_some()
    }

    const fn held(&mut self, half: Half) -> &mut usize {
        match half {
            Half::First => &mut self.held[0],
            Half::Second => &mut self.held[1],
        }
    }

    /// Takes what the medium has done, and gives it what it can do next.
    ///
    /// # Errors
    /// The medium's.
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
            // A buffer whose bytes the bus has not taken is not filled anew.
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

    /// The next bytes for the host; none while the medium has not read them.
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

    /// The bus has taken so many bytes.
    pub fn taken(&mut self, count: usize) {
        let (half, at) = self.at_bus;
        self.bytes -= count as u32;
        self.at_bus.1 = at + count;
        if self.at_bus.1 >= *self.held(half) {
            *self.held(half) = 0;
            self.at_bus = (half.other(), 0);
        }
    }

    /// How many bytes of the host have a place: up to the end of a buffer, none while the medium has not
    /// written what is in it.
    pub fn room<M: Medium>(&self) -> usize {
        let (half, at) = self.at_bus;
        if self.held[half as usize] > 0 { 0 } else { self.capacity::<M>() - at }
    }

    /// Bytes that the buffer at the bus takes before the medium gets it.
    fn capacity<M: Medium>(&self) -> usize {
        let (_, at) = self.at_bus;
        (M::BUFFER_BLOCKS as usize * BLOCK_BYTES).min(at + self.bytes as usize)
    }

    /// Bytes of the host, no more than there is room for.
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

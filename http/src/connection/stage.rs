//! Few bytes on their way out, for rooms that are too small for what has to be made in one piece.

use crate::limits::BODY_ROOM;

/// Framing around a small piece of a body: three digits and two ends of lines.
const FRAME: usize = 16;

/// Bytes on their way out.
#[derive(Clone, Debug)]
pub struct Stage {
    bytes: [u8; BODY_ROOM + FRAME],
    from: u8,
    to: u8,
}

impl Stage {
    /// Makes an empty stage.
    pub const fn new() -> Self {
        Self { bytes: [0; BODY_ROOM + FRAME], from: 0, to: 0 }
    }

    /// Returns whether all is on its way.
    pub const fn is_empty(&self) -> bool {
        self.from >= self.to
    }

    /// Has an empty stage filled. `fill` says how many bytes are to go out.
    pub fn fill(&mut self, fill: impl FnOnce(&mut [u8]) -> usize) {
        self.from = 0;
        self.to = fill(&mut self.bytes).min(self.bytes.len()) as u8;
    }

    /// Adds bytes, as far as there is room.
    pub fn add(&mut self, bytes: &[u8]) {
        if self.is_empty() {
            (self.from, self.to) = (0, 0);
        }
        for byte in bytes {
            let Some(place) = self.bytes.get_mut(usize::from(self.to)) else { return };
            *place = *byte;
            self.to += 1;
        }
    }

    /// Moves bytes out into a room.
    pub fn drain(&mut self, room: &mut [u8]) -> usize {
        let waiting = self.bytes.get(usize::from(self.from)..usize::from(self.to)).unwrap_or_default();
        let count = waiting.len().min(room.len());
        for (place, byte) in room.iter_mut().zip(waiting) {
            *place = *byte;
        }
        self.from += count as u8;
        count
    }
}

//! Answers on their way to the host.

use crate::table::Response;
use crate::wire::{BLOCK_BYTES, FRAME_BYTES, write_block, write_integer};

/// Bytes that wait for the line at most: those of 10 ms at USB's rate.
const OUTBOX_BYTES: usize = 2048;

/// Blocks for the host. What finds no room is dropped whole, as Klipper's firmware does it: the host asks
/// again.
#[derive(Debug)]
pub struct Outbox {
    bytes: heapless::Deque<u8, OUTBOX_BYTES>,
    /// Sequence number that the next block of the host must have.
    pub expected: u8,
}

impl Outbox {
    /// Creates an outbox that expects block 0.
    pub const fn new() -> Self {
        Self { bytes: heapless::Deque::new(), expected: 0 }
    }

    fn put(&mut self, content: &[u8]) {
        let mut block = [0; BLOCK_BYTES];
        let length = write_block(content, self.expected, &mut block);
        if self.bytes.capacity() - self.bytes.len() < length {
            return;
        }
        for byte in block.iter().take(length) {
            // There is room for all.
            let _fits = self.bytes.push_back(*byte);
        }
    }

    /// Acknowledges what has come, or says what is expected instead.
    pub fn acknowledge(&mut self) {
        self.put(&[]);
    }

    /// Sends a message of integers.
    pub fn send(&mut self, response: Response, integers: &[u32]) {
        self.send_bytes(response, integers, None);
    }

    /// Sends a message of integers, and a buffer behind them.
    pub fn send_bytes(&mut self, response: Response, integers: &[u32], buffer: Option<&[u8]>) {
        let mut content = heapless::Vec::<u8, { BLOCK_BYTES - FRAME_BYTES }>::new();
        let number = response.number() as u32;
        for value in core::iter::once(&number).chain(integers) {
            let (bytes, length) = write_integer(*value);
            // Six integers are the most that a message has, 30 bytes.
            let _fits = content.extend_from_slice(&bytes[..length]);
        }
        if let Some(buffer) = buffer {
            let room = content.capacity() - content.len();
            let part = &buffer[..buffer.len().min(room.saturating_sub(1))];
            let _fits = content.push(part.len() as u8);
            let _fits = content.extend_from_slice(part);
        }
        self.put(&content);
    }

    /// Whether no bytes wait for the line.
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Takes bytes for the line. Returns how many.
    pub fn fetch(&mut self, into: &mut [u8]) -> usize {
        let mut count = 0;
        for place in into {
            let Some(byte) = self.bytes.pop_front() else { break };
            *place = byte;
            count += 1;
        }
        count
    }
}

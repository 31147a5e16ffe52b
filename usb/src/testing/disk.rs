//! Storage driver of a host: commands, and recovery from unexpected results.

use super::{Board, Failure, Request};
use crate::storage::BLOCK_BYTES;

const TO_HOST: u8 = 5;
const FROM_HOST: u8 = 3;
/// Interface of the disk among all functions.
const INTERFACE: u16 = 4;

/// Result of a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ended {
    pub data: Vec<u8>,
    /// Whether the data stage ended with a halt.
    pub was_halted: bool,
    pub status: u8,
    pub residue: u32,
}

/// Direction in which the host expects data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expects<'d> {
    Nothing,
    In(u32),
    Out(&'d [u8]),
}

pub fn command(tag: u32, expects: Expects<'_>, command: &[u8]) -> Vec<u8> {
    let (length, flags) = match expects {
        Expects::Nothing => (0, 0),
        Expects::In(length) => (length, 0x80),
        Expects::Out(data) => (data.len() as u32, 0),
    };
    let mut wrapper = b"USBC".to_vec();
    wrapper.extend(tag.to_le_bytes());
    wrapper.extend(length.to_le_bytes());
    wrapper.extend([flags, 0, command.len() as u8]);
    wrapper.extend(command);
    wrapper.resize(31, 0);
    wrapper
}

impl Board {
    /// Runs a command as Linux' driver does: ends a halt in the data stage, then reads the status.
    pub fn disk(&mut self, expects: Expects<'_>, bytes: &[u8]) -> Ended {
        let tag = 0x1234_5678;
        self.host.bulk_out(FROM_HOST, &command(tag, expects, bytes)).unwrap();
        let (mut data, mut was_halted) = (Vec::new(), false);
        match expects {
            Expects::Nothing => {}
            Expects::In(length) => match self.host.bulk_in(TO_HOST, length as usize) {
                Ok(bytes) => data = bytes,
                Err((bytes, failure)) => {
                    assert_eq!(failure, Failure::Stall);
                    (data, was_halted) = (bytes, true);
                    self.host.clear_halt(0x80 | TO_HOST);
                }
            },
            Expects::Out(bytes) => {
                if let Err((_, failure)) = self.host.bulk_out(FROM_HOST, bytes) {
                    assert_eq!(failure, Failure::Stall);
                    was_halted = true;
                    self.host.clear_halt(FROM_HOST);
                }
            }
        }
        // A halt behind a short packet appears here (BOT figure 2).
        let status = match self.host.bulk_in(TO_HOST, 13) {
            Ok(status) => status,
            Err((nothing, failure)) => {
                assert!(nothing.is_empty() && failure == Failure::Stall && !was_halted, "{failure:?}");
                was_halted = true;
                self.host.clear_halt(0x80 | TO_HOST);
                self.host.bulk_in(TO_HOST, 13).unwrap()
            }
        };
        if matches!(expects, Expects::Out(_)) && self.host.is_halted(FROM_HOST) {
            was_halted = true;
            self.host.clear_halt(FROM_HOST);
        }
        assert_eq!(status[..8], [b'U', b'S', b'B', b'S', 0x78, 0x56, 0x34, 0x12], "signature and tag");
        let residue = u32::from_le_bytes([status[8], status[9], status[10], status[11]]);
        Ended { data, was_halted, status: status[12], residue }
    }

    /// Resets the transport, by which a host recovers (BOT section 5.3.4).
    pub fn recover_disk(&mut self) {
        self.host.out(Request::new(0x21, 0xFF, 0, INTERFACE, 0), &[]).unwrap();
        self.host.clear_halt(0x80 | TO_HOST);
        self.host.clear_halt(FROM_HOST);
    }

    /// Creates a board, and takes the unit attention for the new medium, as every host does first.
    pub fn with_disk() -> Self {
        let mut board = Self::enumerated();
        assert_eq!(board.disk(Expects::Nothing, &[0; 6]).status, 1, "unit attention: a medium has come");
        assert_eq!(board.sense(), [6, 0x28, 0]);
        assert_eq!(board.disk(Expects::Nothing, &[0; 6]).status, 0, "ready");
        board
    }

    /// Returns key, code and qualifier of the last command's failure.
    pub fn sense(&mut self) -> [u8; 3] {
        let ended = self.disk(Expects::In(18), &[0x03, 0, 0, 0, 18, 0]);
        assert_eq!((ended.data.len(), ended.status), (18, 0));
        [ended.data[2], ended.data[12], ended.data[13]]
    }

    pub fn read_blocks(&mut self, first: u32, count: u16) -> Ended {
        self.disk(Expects::In(u32::from(count) * BLOCK_BYTES as u32), &ten(0x28, first, count))
    }

    pub fn write_blocks(&mut self, first: u32, data: &[u8]) -> Ended {
        self.disk(Expects::Out(data), &ten(0x2A, first, (data.len() / BLOCK_BYTES) as u16))
    }
}

/// Builds a ten-byte command that names blocks.
pub fn ten(operation: u8, first: u32, count: u16) -> [u8; 10] {
    let [a, b, c, d] = first.to_be_bytes();
    let [h, l] = count.to_be_bytes();
    [operation, 0, a, b, c, d, 0, h, l, 0]
}

//! RTT as a debug probe sees it: rings in the image's memory, which are read and written while it runs.
//!
//! Layout of the control block (SEGGER UM08001, "RTT control block"): 16 bytes of name, the counts of up and
//! down channels, then 24 bytes for each channel, those up first.

use std::path::Path;

use rigless::emulator::Host;
use rigless::soc::Width;

use crate::image::Symbols;

const ID: [u8; 16] = *b"SEGGER RTT\0\0\0\0\0\0";
const UP_COUNT: u64 = 16;
const DOWN_COUNT: u64 = 20;
const CHANNELS: u64 = 24;
const CHANNEL_BYTES: u64 = 24;
/// Offsets of a channel's fields.
const BUFFER: u64 = 4;
const SIZE: u64 = 8;
const WRITE: u64 = 12;
const READ: u64 = 16;
const MODE: u64 = 20;
/// Mode in which an image waits while a ring is full.
pub const BLOCK_IF_FULL: u64 = 2;

/// A debug probe's access to the control block of an image.
#[derive(Clone, Copy, Debug)]
pub struct Probe {
    block: u64,
}

impl Probe {
    /// Finds the control block of an image; `None` when it has none.
    ///
    /// # Errors
    /// When the image cannot be read.
    pub fn of(elf: &Path) -> Result<Option<Self>, String> {
        Ok(Self::in_image(&Symbols::read(elf)?))
    }

    /// Finds the control block in the symbols of an image.
    #[must_use]
    pub fn in_image(symbols: &Symbols) -> Option<Self> {
        symbols.object("_SEGGER_RTT").map(|block| Self { block: block.address })
    }

    /// Address of the word that changes when the image writes to an up channel.
    #[must_use]
    pub const fn write_word(self, up: u64) -> u64 {
        self.block + CHANNELS + CHANNEL_BYTES * up + WRITE
    }

    /// Returns the numbers of up and down channels; `None` while the image has not made the block.
    pub fn channels(self, host: &mut dyn Host) -> Option<(u64, u64)> {
        let id: Vec<u8> = (0..16).map(|byte| host.read(self.block + byte, Width::W8).unwrap_or(0) as u8).collect();
        (id == ID).then(|| (word(host, self.block + UP_COUNT), word(host, self.block + DOWN_COUNT)))
    }

    fn up(self, channel: u64) -> u64 {
        self.block + CHANNELS + CHANNEL_BYTES * channel
    }

    fn down(self, host: &mut dyn Host, channel: u64) -> u64 {
        self.up(word(host, self.block + UP_COUNT) + channel)
    }

    /// Sets the mode of an up channel, as probes do when they attach.
    pub fn set_mode(self, host: &mut dyn Host, up: u64, mode: u64) {
        // A failed write leaves the old mode.
        let _ = host.write(self.up(up) + MODE, Width::W32, mode);
    }

    /// Takes everything that the image has written to an up channel.
    pub fn read(self, host: &mut dyn Host, up: u64) -> Vec<u8> {
        let channel = self.up(up);
        let (buffer, size) = (word(host, channel + BUFFER), word(host, channel + SIZE));
        let (write, mut read) = (word(host, channel + WRITE), word(host, channel + READ));
        if size == 0 || write >= size || read >= size {
            return Vec::new();
        }
        let mut bytes = Vec::new();
        while read != write {
            bytes.push(host.read(buffer + read, Width::W8).unwrap_or(0) as u8);
            read = (read + 1) % size;
        }
        // After a failed write the bytes stay in the buffer, and are read again.
        let _ = host.write(channel + READ, Width::W32, read);
        bytes
    }

    /// Writes to a down channel as much as there is room for. Returns the number of bytes written.
    pub fn write(self, host: &mut dyn Host, down: u64, bytes: &[u8]) -> usize {
        let channel = self.down(host, down);
        let (buffer, size) = (word(host, channel + BUFFER), word(host, channel + SIZE));
        let (mut write, read) = (word(host, channel + WRITE), word(host, channel + READ));
        let mut count = 0;
        for byte in bytes {
            let next = (write + 1) % size.max(1);
            if size == 0 || next == read || host.write(buffer + write, Width::W8, u64::from(*byte)).is_err() {
                break;
            }
            (write, count) = (next, count + 1);
        }
        // After a failed write the bytes count as not sent.
        let _ = host.write(channel + WRITE, Width::W32, write);
        count
    }
}

fn word(host: &mut dyn Host, address: u64) -> u64 {
    host.read(address, Width::W32).unwrap_or(0)
}

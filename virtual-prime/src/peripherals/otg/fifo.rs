//! The FIFOs, RM0399 sections 60.11 ("FIFO architecture") and 60.14 (OTG_GRXFSIZ, OTG_DIEPTXFx,
//! OTG_DTXFSTSx): a receive FIFO for everything, a transmit FIFO for each IN endpoint, in 4 KB of RAM that
//! firmware parts among them.

use std::collections::VecDeque;

use super::registers::rxsts;

/// Size of the FIFOs' RAM, 32-bit words.
pub const RAM_WORDS: u32 = 1_024;
/// Locations for SETUP packets of the one control endpoint: 5 n + 8 (section 60.11.3, "Receive FIFO RAM
/// allocation").
const SETUP_WORDS: u32 = 5 + 8;
/// Locations for each OUT endpoint's end of transfer, from the same list.
const STATUS_WORDS: u32 = 2;
/// Location for the global OUT NAK.
const NAK_WORDS: u32 = 1;

/// Returns the number of words that so many bytes take.
pub const fn words(bytes: usize) -> u32 {
    bytes.div_ceil(4) as u32
}

/// An entry of the receive FIFO.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Packet status, PKTSTS of OTG_GRXSTSR.
    pub status: u32,
    pub endpoint: u8,
    /// Data PID, DPID of OTG_GRXSTSR.
    pub pid: u32,
    /// Frame number, FRMNUM of OTG_GRXSTSR.
    pub frame: u16,
    pub data: Vec<u8>,
}

/// The receive FIFO: entries of a status word and the packet's data.
#[derive(Clone, Debug, Default)]
pub struct ReceiveFifo {
    entries: VecDeque<Entry>,
    /// Data of the entry that was popped last.
    data: VecDeque<u32>,
}

impl ReceiveFifo {
    /// Adds an entry.
    pub fn push(&mut self, entry: Entry) {
        self.entries.push_back(entry);
    }

    /// Returns the next entry, which stays.
    pub fn front(&self) -> Option<&Entry> {
        self.entries.front()
    }

    /// Takes the next entry; its data are read word by word from then on. Also returns whether data of the
    /// entry before were still there, which are lost.
    pub fn pop(&mut self) -> Option<(Entry, bool)> {
        let entry = self.entries.pop_front()?;
        let left = !self.data.is_empty();
        self.data = entry.data.chunks(4).map(little_endian).collect();
        Some((entry, left))
    }

    /// Takes the next word of the popped packet.
    pub fn word(&mut self) -> Option<u32> {
        self.data.pop_front()
    }

    /// Returns whether no entry waits.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Drops all entries, and the data of the popped one.
    pub fn flush(&mut self) {
        *self = Self::default();
    }

    /// Whether a data packet of this size still fits: the locations for SETUP packets, ends of transfers and
    /// the global OUT NAK are never used for data.
    pub fn has_room(&self, bytes: usize, size: u32, out_endpoints: u32) -> bool {
        let held: u32 = self.entries.iter().filter(|entry| entry.status == rxsts::OUT_DATA).map(taken).sum();
        // The status word of a popped packet has left, its data have not.
        let held = held + self.data.len() as u32;
        held + 1 + words(bytes) + Self::reserved(out_endpoints) <= size
    }

    /// Returns the number of locations that no data packet takes.
    pub const fn reserved(out_endpoints: u32) -> u32 {
        SETUP_WORDS + STATUS_WORDS * out_endpoints + NAK_WORDS
    }
}

fn taken(entry: &Entry) -> u32 {
    1 + words(entry.data.len())
}

fn little_endian(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte))
}

/// The transmit FIFO of an IN endpoint: whole packets, and the packet that firmware is writing.
#[derive(Clone, Debug, Default)]
pub struct TransmitFifo {
    packets: VecDeque<Vec<u8>>,
    /// The packet being written, with its length.
    writing: Option<(Vec<u8>, usize)>,
}

impl TransmitFifo {
    /// Whether a packet is half written.
    pub const fn is_midway(&self) -> bool {
        self.writing.is_some()
    }

    /// Takes a word of a packet, whose length counts as given with its first word. Returns the bytes of the
    /// packet, once it is complete.
    pub fn write(&mut self, word: u32, length: usize) -> Option<usize> {
        let (mut packet, length) = self.writing.take().unwrap_or((Vec::with_capacity(length), length));
        let left = length - packet.len();
        packet.extend_from_slice(&word.to_le_bytes()[..left.min(4)]);
        if packet.len() < length {
            self.writing = Some((packet, length));
            return None;
        }
        self.packets.push_back(packet);
        Some(length)
    }

    /// Returns the next packet, which stays.
    pub fn front(&self) -> Option<&Vec<u8>> {
        self.packets.front()
    }

    /// Drops the next packet.
    pub fn pop(&mut self) {
        self.packets.pop_front();
    }

    /// Drops all packets, and the one that is being written.
    pub fn flush(&mut self) {
        *self = Self::default();
    }

    /// Words held in the FIFO.
    pub fn held(&self) -> u32 {
        let writing = self.writing.as_ref().map_or(0, |(packet, _)| words(packet.len()));
        self.packets.iter().map(|packet| words(packet.len())).sum::<u32>() + writing
    }
}

/// A part of the RAM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    pub start: u32,
    pub depth: u32,
}

impl Span {
    /// Decodes OTG_DIEPTXFx: the start in the low half, the depth in the high half.
    pub const fn of(register: u32) -> Self {
        Self { start: register & 0xFFFF, depth: register >> 16 }
    }

    /// Returns whether the part ends within the RAM.
    pub const fn fits(self) -> bool {
        self.start + self.depth <= RAM_WORDS
    }

    /// Returns whether the two parts share a word.
    pub const fn overlaps(self, other: Self) -> bool {
        self.start < other.start + other.depth && other.start < self.start + self.depth
    }
}

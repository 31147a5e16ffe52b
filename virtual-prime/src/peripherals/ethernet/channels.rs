//! State of the DMA's two channels and of the queues between DMA and MAC.

use std::collections::VecDeque;

use super::descriptor::Descriptor;

/// Bytes of status that go with a packet through the queue.
const STATUS_BYTES: usize = 4;
/// State of the transmit channel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum TransmitState {
    #[default]
    Stopped,
    /// Ready for the next descriptor, once the queue has room.
    Ready,
    Fetching(Descriptor),
    /// Reads the buffers of a descriptor.
    Loading(Descriptor),
    Suspended,
    /// Stopped by a bus error.
    Failed,
}

/// A frame in the transmit queue.
#[derive(Clone, Debug)]
pub(super) struct Queued {
    pub(super) bytes: Vec<u8>,
    /// Whether a partner would take it: a right check sequence.
    pub(super) is_sound: bool,
    pub(super) last: Descriptor,
    /// Bits of the status to be written back.
    pub(super) status: u32,
}

/// The transmit channel.
#[derive(Debug, Default)]
pub(super) struct Transmitter {
    pub(super) state: TransmitState,
    /// Address of the current descriptor.
    pub(super) current: u32,
    /// Whether the list's address was written since the channel last began.
    pub(super) list_is_new: bool,
    /// Bytes of the frame that is being read, and DES3 of its first descriptor.
    pub(super) frame: Vec<u8>,
    pub(super) first: Option<u32>,
    /// Bytes of the reads under way.
    pub(super) reads: VecDeque<u32>,
    pub(super) queue: VecDeque<Queued>,
    /// Instant of the last bit of the frame on the line, the first of the queue.
    pub(super) ends_ns: Option<u64>,
    /// Instant from which the line is free.
    pub(super) free_ns: u64,
}

impl Transmitter {
    /// Returns the number of frames in the queue.
    pub(super) fn queued(&self) -> usize {
        self.queue.len()
    }

    /// Drops the frames that are not on the line yet: MTLTXQOMR.FTQ.
    pub(super) fn flush(&mut self) {
        self.queue.truncate(usize::from(self.ends_ns.is_some()));
    }
}

/// State of the receive channel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum ReceiveState {
    #[default]
    Stopped,
    Fetching(Descriptor),
    /// Has a descriptor, and waits for a packet.
    Ready(Descriptor),
    Suspended,
    /// Stopped by a bus error.
    Failed,
}

/// A packet in the receive queue, with the words of its last descriptor.
#[derive(Clone, Debug, Default)]
pub(super) struct Packet {
    pub(super) bytes: Vec<u8>,
    pub(super) des1: u32,
    pub(super) des2: u32,
    /// Bits of DES3 but those of the descriptor and the length.
    pub(super) des3: u32,
}

impl Packet {
    pub(super) fn room(&self) -> usize {
        (self.bytes.len() + STATUS_BYTES).next_multiple_of(4)
    }
}

/// The receive channel.
#[derive(Debug, Default)]
pub(super) struct Receiver {
    pub(super) state: ReceiveState,
    /// Address of the current descriptor.
    pub(super) current: u32,
    /// Whether the list's address was written since the channel last began.
    pub(super) list_is_new: bool,
    pub(super) queue: VecDeque<Packet>,
    /// Bytes of the first packet that are in memory already.
    pub(super) stored: usize,
    /// Instant at which a packet first found the channel suspended with a descriptor given back.
    pub(super) forgotten_ns: Option<u64>,
    /// Instant at which the watchdog of a packet without an interrupt sets RI.
    pub(super) watchdog_ns: Option<u64>,
}

impl Receiver {
    pub(super) fn used(&self) -> usize {
        self.queue.iter().map(Packet::room).sum()
    }

    /// Whether the queue holds a packet.
    pub(super) fn holds_packets(&self) -> bool {
        !self.queue.is_empty()
    }
}

//! Where a console's bytes wait between the interrupt that receives them and the dispatcher.
//!
//! One writer (the receive task) and one reader (the dispatcher), atomics only. Realtime characters are taken out of
//! the stream on the writing side, so a feed hold or an abort is seen even when the line queue is full.
//! Depth: [`INBOX_BYTES`] hold 44 ms of a 115200 baud line, longer than any one wait of the dispatcher between looks.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use gcode::realtime::{self, Realtime};

/// Bytes an inbox holds. A power of two.
pub const INBOX_BYTES: usize = 512;
/// How many `?` may wait; more are dropped, as Smoothieware v2 does.
const MAX_QUERIES: u32 = 8;

/// The bit of a request that is not counted.
const fn bit(request: Realtime) -> u32 {
    match request {
        Realtime::Status => 0,
        Realtime::Abort => 1,
        Realtime::Hold => 2,
        Realtime::Resume => 4,
        Realtime::Stop => 8,
    }
}

/// A console's receive queue.
#[derive(Debug)]
pub struct Inbox {
    bytes: [AtomicU8; INBOX_BYTES],
    /// Count of bytes ever received, wrapping. Written by the receive task only.
    received: AtomicU32,
    /// Count of bytes ever taken, wrapping. Written by the dispatcher only.
    taken: AtomicU32,
    /// Pending realtime requests but `?`, one bit each.
    requests: AtomicU32,
    /// Pending `?`.
    queries: AtomicU32,
    /// Bytes dropped because the queue was full.
    lost: AtomicU32,
}

impl Default for Inbox {
    fn default() -> Self {
        Self::new()
    }
}

impl Inbox {
    /// An empty inbox.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            bytes: [const { AtomicU8::new(0) }; INBOX_BYTES],
            received: AtomicU32::new(0),
            taken: AtomicU32::new(0),
            requests: AtomicU32::new(0),
            queries: AtomicU32::new(0),
            lost: AtomicU32::new(0),
        }
    }

    /// How many more bytes fit. A transport that can hold its sender back (USB, TCP) asks before it receives.
    #[must_use]
    pub fn room(&self) -> usize {
        let used = self.received.load(Ordering::Relaxed).wrapping_sub(self.taken.load(Ordering::Acquire));
        INBOX_BYTES.saturating_sub(used as usize)
    }

    /// Receives one byte: acts on it if it is a realtime character, else queues it. False when it had to be dropped.
    pub fn receive(&self, byte: u8) -> bool {
        if let Some(request) = realtime::classify(byte) {
            self.request(request);
            return true;
        }
        let received = self.received.load(Ordering::Relaxed);
        if self.room() == 0 {
            self.lost.fetch_add(1, Ordering::Relaxed);
            return false;
        }
        if let Some(slot) = self.bytes.get(received as usize % INBOX_BYTES) {
            slot.store(byte, Ordering::Relaxed);
        }
        self.received.store(received.wrapping_add(1), Ordering::Release);
        true
    }

    /// Leaves a realtime request, as its character would.
    pub fn request(&self, request: Realtime) {
        if request == Realtime::Status {
            if self.queries.load(Ordering::Relaxed) < MAX_QUERIES {
                self.queries.fetch_add(1, Ordering::Relaxed);
            }
        } else {
            self.requests.fetch_or(bit(request), Ordering::AcqRel);
        }
    }

    /// Takes the next byte.
    pub fn take_byte(&self) -> Option<u8> {
        let taken = self.taken.load(Ordering::Relaxed);
        if taken == self.received.load(Ordering::Acquire) {
            return None;
        }
        let byte = self.bytes.get(taken as usize % INBOX_BYTES)?.load(Ordering::Relaxed);
        self.taken.store(taken.wrapping_add(1), Ordering::Release);
        Some(byte)
    }

    /// Takes the most urgent pending request: abort, then hold, resume, stop, then queries.
    pub fn take_request(&self) -> Option<Realtime> {
        for request in [Realtime::Abort, Realtime::Hold, Realtime::Resume, Realtime::Stop] {
            if self.requests.fetch_and(!bit(request), Ordering::AcqRel) & bit(request) != 0 {
                return Some(request);
            }
        }
        if self.queries.load(Ordering::Relaxed) > 0 {
            self.queries.fetch_sub(1, Ordering::Relaxed);
            return Some(Realtime::Status);
        }
        None
    }

    /// Bytes dropped since the last call.
    pub fn take_lost(&self) -> u32 {
        self.lost.swap(0, Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn realtime_characters_leave_the_stream_even_when_it_is_full() {
        let inbox = Inbox::new();
        for _ in 0..INBOX_BYTES {
            assert!(inbox.receive(b'a'));
        }
        assert!(!inbox.receive(b'b'), "a full inbox must refuse");
        assert_eq!(inbox.take_lost(), 1);
        assert!(inbox.receive(b'?') && inbox.receive(b'!') && inbox.receive(0x18));
        assert_eq!(inbox.take_request(), Some(Realtime::Abort));
        assert_eq!(inbox.take_request(), Some(Realtime::Hold));
        assert_eq!(inbox.take_request(), Some(Realtime::Status));
        assert_eq!(inbox.take_request(), None);
        for _ in 0..INBOX_BYTES {
            assert_eq!(inbox.take_byte(), Some(b'a'));
        }
        assert_eq!(inbox.take_byte(), None);
    }

    #[test]
    fn at_most_eight_queries_wait() {
        let inbox = Inbox::new();
        for _ in 0..20 {
            inbox.request(Realtime::Status);
        }
        let answered = core::iter::from_fn(|| inbox.take_request()).count();
        assert_eq!(answered, 8);
    }
}

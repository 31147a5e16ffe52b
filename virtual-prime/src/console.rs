//! A serial line with two ends: the board's UART at one, a queue of bytes for us at the other.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rigless::chip::Timeline;
use rigless::chip::uart::Peer;
use rigless::snapshot::Store;
use rigless::time::VirtualNanos;

#[derive(Debug, Default)]
struct Bytes {
    to_board: VecDeque<u8>,
    /// Instant at which the frame of the last byte to the board began.
    last_began_ns: Option<u64>,
    from_board: VecDeque<Arrived>,
}

/// A byte from the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arrived {
    /// End of the byte's stop bit, nanoseconds since power-on.
    pub at_ns: u64,
    /// Byte that has arrived.
    pub byte: u8,
}

/// Our end of the line. Bytes take their time on the wire: the UART accepts the next byte once the frame of
/// the last is through.
#[derive(Clone, Debug, Default)]
pub struct Line(Arc<Mutex<Bytes>>);

impl Line {
    fn lock(&self) -> MutexGuard<'_, Bytes> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts bytes on the wire to the board.
    pub fn send(&self, bytes: &[u8]) {
        self.lock().to_board.extend(bytes);
    }

    /// Returns the number of bytes still on our side of the wire.
    #[must_use]
    pub fn unsent(&self) -> usize {
        self.lock().to_board.len()
    }

    /// Takes the bytes still on our side off the wire again.
    #[cfg(test)]
    pub(crate) fn take_unsent(&self) -> Vec<u8> {
        self.lock().to_board.drain(..).collect()
    }

    /// Returns the instant at which the frame of the last byte to the board began, nanoseconds since
    /// power-on. The byte arrives a frame later.
    #[must_use]
    pub fn last_began_ns(&self) -> Option<u64> {
        self.lock().last_began_ns
    }

    /// Takes all bytes that the board has sent since the last call; a dropped result forgets them.
    #[allow(clippy::must_use_candidate, reason = "called to forget as well")]
    pub fn receive(&self) -> Vec<u8> {
        self.lock().from_board.drain(..).map(|arrived| arrived.byte).collect()
    }

    /// Takes all bytes that the board has sent since the last call, with the time of each.
    #[must_use]
    pub fn receive_timed(&self) -> Vec<Arrived> {
        self.lock().from_board.drain(..).collect()
    }
}

/// The UART's end of a [`Line`].
#[derive(Debug)]
pub struct LineEnd(pub Line);

impl Store for LineEnd {}

impl Peer for LineEnd {
    fn receive(&mut self, word: u16, context: &mut Timeline<'_, '_>) {
        self.0.lock().from_board.push_back(Arrived { at_ns: context.now().0, byte: word as u8 });
    }

    fn transmit(&mut self, now: VirtualNanos) -> Option<u16> {
        let mut bytes = self.0.lock();
        let byte = bytes.to_board.pop_front()?;
        bytes.last_began_ns = Some(now.0);
        Some(u16::from(byte))
    }
}

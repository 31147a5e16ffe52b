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
    from_board: VecDeque<u8>,
}

/// Our end of the line. Bytes take their time on the wire: the UART accepts the next one when its frame is through.
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

    /// How many bytes are still on our side of the wire.
    #[must_use]
    pub fn unsent(&self) -> usize {
        self.lock().to_board.len()
    }

    /// Everything the board has sent since the last call; dropping it forgets it.
    #[allow(clippy::must_use_candidate, reason = "called to forget as well")]
    pub fn receive(&self) -> Vec<u8> {
        self.lock().from_board.drain(..).collect()
    }
}

/// The UART's end of a [`Line`].
#[derive(Debug)]
pub struct LineEnd(pub Line);

impl Store for LineEnd {}

impl Peer for LineEnd {
    fn receive(&mut self, word: u16, _: &mut Timeline<'_, '_>) {
        self.0.lock().from_board.push_back(word as u8);
    }

    fn transmit(&mut self, _: VirtualNanos) -> Option<u16> {
        self.0.lock().to_board.pop_front().map(u16::from)
    }
}

//! Patience with a slow peer: so much waiting in all, which bytes that move buy back.
//!
//! A limit on the time between two bytes alone would let a peer hold a connection for hours, a byte at a
//! time.

use crate::limits::BYTES_A_MS;

/// Time that was spent waiting for a peer.
#[derive(Clone, Debug)]
pub struct Patience {
    /// Low half of the time up to which waiting is counted.
    since_ms: u32,
    waited_ms: u32,
}

impl Patience {
    /// Begins to wait for a peer.
    pub const fn new(now_ms: u64) -> Self {
        Self { since_ms: now_ms as u32, waited_ms: 0 }
    }

    /// Notes that so many bytes have moved.
    pub const fn moved(&mut self, bytes: usize, now_ms: u64) {
        self.waited_ms = self.waited_ms(now_ms).saturating_sub(bytes as u32 / BYTES_A_MS);
        self.since_ms = now_ms as u32;
    }

    /// Notes that the peer was not waited for.
    pub const fn hold(&mut self, now_ms: u64) {
        self.since_ms = now_ms as u32;
    }

    /// Returns the time that counts.
    pub const fn waited_ms(&self, now_ms: u64) -> u32 {
        let since = (now_ms as u32).wrapping_sub(self.since_ms);
        // Time that seems to go back has not passed.
        self.waited_ms.saturating_add(if since > i32::MAX as u32 { 0 } else { since })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_buy_time_back_and_no_more_than_was_spent() {
        let mut patience = Patience::new(1_000);
        assert_eq!(patience.waited_ms(900), 0);
        patience.moved(10, 1_100);
        assert_eq!((patience.waited_ms(1_100), patience.waited_ms(1_150)), (90, 140));
        patience.hold(1_150);
        assert_eq!(patience.waited_ms(1_150), 90);
        patience.moved(100_000, 1_200);
        assert_eq!(patience.waited_ms(1_210), 10);
        let patience = Patience::new(u64::from(u32::MAX));
        assert_eq!(patience.waited_ms(u64::from(u32::MAX) + 5), 5);
    }
}

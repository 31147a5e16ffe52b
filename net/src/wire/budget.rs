//! Budget of broadcast frames: a storm of them must not take the time of all that is meant for the board.

use smoltcp::time::{Duration, Instant};

/// Broadcast frames that are listened to in each span.
const MOST: u32 = 200;
/// Span of time that is counted over.
const SPAN: Duration = Duration::from_millis(100);

/// Count of broadcast frames in the present span.
#[derive(Debug)]
pub struct Budget {
    since: Instant,
    count: u32,
}

impl Budget {
    /// Makes a budget of which nothing is spent.
    pub const fn new() -> Self {
        Self { since: Instant::ZERO, count: 0 }
    }

    /// Counts a broadcast frame. False if it is one too many.
    pub fn spend(&mut self, now: Instant) -> bool {
        if now >= self.since + SPAN || now < self.since {
            *self = Self { since: now, count: 0 };
        }
        self.count = self.count.saturating_add(1);
        self.count <= MOST
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_storm_is_cut_and_the_next_span_is_open_again() {
        let mut budget = Budget::new();
        let at = |ms: i64| Instant::from_millis(1_000 + ms);
        let heard = (0..1_000).filter(|_| budget.spend(at(0))).count();
        assert_eq!(heard, 200);
        assert!(!budget.spend(at(99)));
        assert!(budget.spend(at(100)));
    }
}

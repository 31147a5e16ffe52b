//! How many frames to groups are taken: devices that flood a network with broadcasts are no reason to starve
//! what is addressed to the board.

/// Frames to groups that are taken in each window.
const FRAMES: u32 = 200;
/// Length of a window, ms.
const WINDOW_MS: i64 = 100;

/// Frames to groups in the present window.
pub(super) struct Budget {
    since_ms: i64,
    taken: u32,
    dropped: u32,
}

impl Budget {
    pub(super) const fn new() -> Self {
        Self { since_ms: 0, taken: 0, dropped: 0 }
    }

    /// Whether another frame may be taken.
    pub(super) fn take(&mut self, now_ms: i64) -> bool {
        if now_ms.wrapping_sub(self.since_ms) >= WINDOW_MS {
            (self.since_ms, self.taken) = (now_ms, 0);
        }
        if self.taken >= FRAMES {
            self.dropped = self.dropped.wrapping_add(1);
            return false;
        }
        self.taken += 1;
        true
    }

    /// Returns the number of frames that were one too many.
    pub(super) const fn dropped(&self) -> u32 {
        self.dropped
    }
}

//! The console over RTT: a debug probe reads and writes it while everything runs.
//!
//! A probe comes and goes without a word. A user counts as present once a byte was typed, and as gone when
//! output stays unread for [`PATIENCE`].

use core::sync::atomic::{AtomicBool, Ordering};

use base::sessions::{Inbox, Intake};
use bsp_prime::rtt::{Down, Up};
use bsp_prime::time;
use units::Micros;

/// Most bytes taken at a poll, of which there are two thousand a second: so typing costs the step feed's task
/// little, and 32 kB/s are as much as a probe brings.
const AT_A_LOOK: usize = 16;
/// Time without a byte read from a full ring after which the reader counts as gone. Shorter than the time
/// after which sessions drop unread output, as they then would not ask any more.
const PATIENCE: Micros = Micros::from_seconds(1);

/// Whether the reader has gone, for the input side.
static LEFT: AtomicBool = AtomicBool::new(false);

/// Input of the console, for the task that polls it.
pub struct Typed {
    down: Down,
    intake: Intake,
}

impl Typed {
    /// Creates the input, of which nothing has been read.
    pub const fn new(down: Down) -> Self {
        Self { down, intake: Intake::new() }
    }

    /// Moves typed bytes to the inbox. Bytes without room wait at the probe. Returns whether there were any,
    /// or the user has gone.
    pub fn look(&mut self, inbox: &Inbox) -> bool {
        let has_left = LEFT.swap(false, Ordering::Relaxed);
        if has_left {
            inbox.set_open(false);
            self.intake = Intake::new();
        }
        let mut bytes = [0; AT_A_LOOK];
        let room = bytes.get_mut(..inbox.room().min(AT_A_LOOK)).unwrap_or_default();
        let count = self.down.read(room);
        if count == 0 {
            return has_left;
        }
        inbox.set_open(true);
        // There is room, as checked before the read.
        let _taken = inbox.receive_all(&mut self.intake, bytes.get(..count).unwrap_or_default());
        true
    }
}

/// Output of the console, for the executor.
pub struct Said {
    up: Up,
    /// Place of the reader, and the time since which it has not moved though the ring was full.
    stuck: Option<(u32, Micros)>,
}

impl Said {
    /// Creates the output, with a reader that keeps up.
    pub const fn new(up: Up) -> Self {
        Self { up, stuck: None }
    }

    /// Writes as many bytes as there is room for; without a reader, all bytes are dropped.
    pub fn write(&mut self, inbox: &Inbox, bytes: &[u8]) -> usize {
        if !inbox.is_open() {
            self.stuck = None;
            return bytes.len();
        }
        let taken = self.up.write(bytes);
        if taken > 0 {
            self.stuck = None;
            return taken;
        }
        let (place, now) = (self.up.read_place(), time::now());
        match self.stuck {
            Some((stuck_at, since)) if stuck_at == place => {
                if now.since(since) >= PATIENCE {
                    LEFT.store(true, Ordering::Relaxed);
                }
            }
            _ => self.stuck = Some((place, now)),
        }
        0
    }
}

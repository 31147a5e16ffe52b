//! The log: `defmt` over RTT's up channel 0.
//!
//! `rtt-target` and `defmt-rtt` bring loggers of their own. Both hold all interrupts off while a line is
//! formatted, the step interrupt too, and both (`defmt-rtt` by default) wait for the reader if a probe has
//! told them to. The logger here masks nothing and waits for nothing:
//!
//! - A line is put together in a buffer here, and handed over whole, or not at all where there is no room.
//! - A line that begins while another one is being put together is dropped. The dropped line is a task's that
//!   interrupts another one's line, and tasks end in the reverse order, so a depth is all there is to keep.
//!   Lines come from the lowest priority (events go through the ring first, `kept.rs`), so in practice none
//!   is.

use core::cell::RefCell;
use core::sync::atomic::{AtomicU32, Ordering};

use crate::rtt::Up;

/// The longest line, encoded.
const LINE_BYTES: usize = 384;

/// Lines that are being put together: each but the first interrupted the one before, and is dropped.
static DEPTH: AtomicU32 = AtomicU32::new(0);

struct Log {
    encoder: defmt::Encoder,
    line: [u8; LINE_BYTES],
    length: usize,
    /// The line is longer than its buffer.
    overflowed: bool,
    up: Option<Up>,
}

struct Shared(RefCell<Log>);

// SAFETY: borrowed only by whoever has raised DEPTH from zero, and until it lowers it again: whoever comes
// between finds a depth that is not zero, and leaves it alone. There is one core.
unsafe impl Sync for Shared {}

static LOG: Shared = Shared(RefCell::new(Log {
    encoder: defmt::Encoder::new(),
    line: [0; LINE_BYTES],
    length: 0,
    overflowed: false,
    up: None,
}));

impl Log {
    fn take(&mut self, bytes: &[u8]) {
        match self.line.get_mut(self.length..self.length + bytes.len()) {
            Some(place) => {
                place.copy_from_slice(bytes);
                self.length += bytes.len();
            }
            None => self.overflowed = true,
        }
    }

    /// Runs a step of the encoder, whose output goes into the line.
    fn encode(&mut self, step: impl FnOnce(&mut defmt::Encoder, &mut dyn FnMut(&[u8]))) {
        let mut encoder = core::mem::replace(&mut self.encoder, defmt::Encoder::new());
        step(&mut encoder, &mut |bytes| self.take(bytes));
        self.encoder = encoder;
    }
}

/// Sets the channel of the log. Lines before that are lost.
pub fn start(up: Up) {
    enter(|log| log.up = Some(up));
    leave();
}

/// Gives up the line that was being put together, so that a fault can be reported. For a handler that nothing
/// interrupts and that never returns.
pub fn take_over() {
    DEPTH.store(0, Ordering::Relaxed);
}

/// Raises the depth; calls `work` when this is the only line.
fn enter(work: impl FnOnce(&mut Log)) {
    // A load and a store suffice: an interrupt in between has lowered the depth again before this goes on.
    let depth = DEPTH.load(Ordering::Relaxed);
    DEPTH.store(depth + 1, Ordering::Relaxed);
    if depth == 0 {
        with(work);
    }
}

fn with(work: impl FnOnce(&mut Log)) {
    // The log is borrowed already after a fault in the middle of a step. The line of that fault is lost.
    if let Ok(mut log) = LOG.0.try_borrow_mut() {
        work(&mut log);
    }
}

fn leave() {
    DEPTH.store(DEPTH.load(Ordering::Relaxed).saturating_sub(1), Ordering::Relaxed);
}

fn is_alone() -> bool {
    DEPTH.load(Ordering::Relaxed) == 1
}

#[defmt::global_logger]
struct Logger;

// SAFETY: `defmt` calls these in turn for each line, from one place at a time and nested only by
// interruption; `Log` is reached by the outermost line alone.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        enter(|log| {
            (log.length, log.overflowed) = (0, false);
            log.encode(|encoder, out| encoder.start_frame(out));
        });
    }

    unsafe fn flush() {
        // Flushing does nothing, as the log never waits for a reader.
    }

    unsafe fn release() {
        if is_alone() {
            with(|log| {
                log.encode(|encoder, out| encoder.end_frame(out));
                let line = log.line.get(..log.length).unwrap_or_default();
                if let (false, Some(up)) = (log.overflowed, &mut log.up) {
                    // A line that does not fit is lost, but the next may fit.
                    let _lost = up.write_whole(line);
                }
            });
        }
        leave();
    }

    unsafe fn write(bytes: &[u8]) {
        if is_alone() {
            with(|log| log.encode(|encoder, out| encoder.write(bytes, out)));
        }
    }
}

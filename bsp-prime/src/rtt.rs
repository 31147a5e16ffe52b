//! RTT: rings in memory that a debug probe reads and writes while the image runs.
//!
//! | up | down | |
//! |---|---|---|
//! | 0, `defmt` | 0 | the log (`log.rs`); what is typed there is the console's too |
//! | 1, `console` | 1 | a console |
//!
//! Tools type into down channel 0 unless told otherwise, so both down channels lead to the console.
//!
//! **Nothing here ever waits.** The mode of a channel stands in the control block, and a debug probe that
//! attaches sets it: probe-rs has the log's channel block while its ring is full, "to avoid losing data"
//! (probe-rs issues 2184 and 2326). A writer that obeys stands still when the probe is pulled or the reader
//! is slow. So a write is never longer than there is room for: then no mode means anything. And the mode is
//! set back before each write, for a reader that takes its word back.
//!
//! The rings are in the DMA arena, which is not cached: a probe reads memory behind the cache's back.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use rtt_target::{ChannelMode, DownChannel, UpChannel, rtt_init};

/// Size of each up channel: a second of the log's usual lines, and the longest answer in one piece.
const UP_BYTES: usize = 1024;
/// Size of the console's down channel: a long line.
const DOWN_BYTES: usize = 256;

/// Up channel to the probe, written by one owner.
pub struct Up {
    channel: UpChannel,
    number: usize,
}

/// Down channels from the probe, whose bytes nobody has read yet.
pub struct Down([DownChannel; 2]);

/// Channels that the image holds.
pub struct Ends {
    /// Channel of the log.
    pub log: Up,
    /// Channel of the console's output.
    pub console: Up,
    /// Channels of the console's input.
    pub typed: Down,
}

/// Beginning of the control block by SEGGER's UM08001, "RTT control block", for values that `rtt-target` does
/// not offer.
#[repr(C)]
struct ControlBlock {
    id: [u8; 16],
    counts: [u32; 2],
    up: [Ring; 2],
}

#[repr(C)]
struct Ring {
    name: u32,
    buffer: u32,
    size: AtomicU32,
    /// Place where the image writes next.
    write: AtomicU32,
    /// Place where the probe reads next. Written by the probe.
    read: AtomicU32,
    mode: AtomicU32,
}

unsafe extern "C" {
    /// Made by `rtt_init!`, which gives it this name.
    #[link_name = "_SEGGER_RTT"]
    static CONTROL_BLOCK: ControlBlock;
}

static STARTED: AtomicBool = AtomicBool::new(false);

/// Makes the control block, which a probe looks for. `None` when that has been done. Needs the DMA arena, so
/// call it once the board is up, or has failed to come up.
pub fn start() -> Option<Ends> {
    if STARTED.swap(true, Ordering::Relaxed) {
        return None;
    }
    let channels = rtt_init! {
        up: {
            0: { size: UP_BYTES, mode: ChannelMode::NoBlockSkip, name: "defmt", section: ".dma_arena.rtt" }
            1: { size: UP_BYTES, mode: ChannelMode::NoBlockSkip, name: "console", section: ".dma_arena.rtt" }
        }
        down: {
            0: { size: 32, name: "console", section: ".dma_arena.rtt" }
            1: { size: DOWN_BYTES, name: "console", section: ".dma_arena.rtt" }
        }
    };
    Some(Ends {
        log: Up { channel: channels.up.0, number: 0 },
        console: Up { channel: channels.up.1, number: 1 },
        typed: Down([channels.down.0, channels.down.1]),
    })
}

impl Up {
    /// Writes as many bytes as there is room for, and returns their number.
    pub fn write(&mut self, bytes: &[u8]) -> usize {
        let fits = bytes.get(..self.room().min(bytes.len())).unwrap_or_default();
        if fits.is_empty() {
            return 0;
        }
        self.channel.set_mode(ChannelMode::NoBlockTrim);
        self.channel.write(fits)
    }

    /// Writes all bytes, or none and returns false.
    pub fn write_whole(&mut self, bytes: &[u8]) -> bool {
        bytes.len() <= self.room() && self.write(bytes) == bytes.len()
    }

    /// Bytes that fit at least. Only this end takes room, and the probe only gives some.
    pub fn room(&self) -> usize {
        let ring = self.ring();
        let size = ring.size.load(Ordering::Relaxed);
        let (write, read) = (ring.write.load(Ordering::Relaxed), ring.read.load(Ordering::Acquire));
        if read >= size || write >= size {
            // The ring has vanished. Asking sets it up anew (`rtt-target`), and there is room at the next
            // call.
            let _empty = self.channel.is_empty();
            return 0;
        }
        // A byte stays free, as a full ring would look like an empty one.
        ((read + size - write - 1) % size) as usize
    }

    /// Returns the place up to which the probe has read, to notice whether it does.
    pub fn read_place(&self) -> u32 {
        self.ring().read.load(Ordering::Relaxed)
    }

    fn ring(&self) -> &'static Ring {
        // SAFETY: an `Up` exists only after `rtt_init!` has made the block, whose layout is RTT's own. Every
        // field that is read here is atomic, and the probe changes them as such.
        unsafe { &CONTROL_BLOCK.up[self.number] }
    }
}

impl Down {
    /// Takes typed bytes, as many as fit, and returns their number.
    pub fn read(&mut self, bytes: &mut [u8]) -> usize {
        let Self([first, second]) = self;
        match first.read(bytes) {
            0 => second.read(bytes),
            count => count,
        }
    }
}

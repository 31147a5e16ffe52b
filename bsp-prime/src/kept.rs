//! Memory that a reset leaves alone, and the ring of events in it.
//!
//! The memory is the whole of SRAM4, in domain D3: the ROM's boot loader keeps nothing there (AN2606), no DMA
//! of ours reaches it, and its interface has its clock from reset on (RCC_AHB4ENR has no bit for it). A reset
//! of any kind changes no word of it; the supply's failing does.
//!
//! Three traps, and the remedies:
//! - After power came its contents do not match their check bits (AN5342), so they are written before they
//!   are read: [`prepare`] is told.
//! - A reset loses the data cache, and also the last part of a word that was written (RM0399 section 2.4,
//!   "Embedded SRAM"): the MPU has the region non-cacheable (`memory.rs`), and the ring stores whole words of
//!   32 bits, the unit of this memory's check.
//! - Exclusive accesses need a monitor on the bus there: the ring's count is in DTCM.

use core::sync::atomic::AtomicU32;

use events::{EventRing, Slots};

/// First address of the region; `memory.x` says the same.
pub(crate) const START: u32 = 0x3800_0000;
/// Size of the region in bytes.
pub(crate) const BYTES: u32 = 64 * 1024;

#[unsafe(link_section = ".kept")]
static SLOTS: Slots = Slots::new();
static NEXT: AtomicU32 = AtomicU32::new(0);

/// Returns the ring of events, which survives a reset.
#[must_use]
pub fn events() -> EventRing<'static> {
    EventRing::new(&SLOTS, &NEXT)
}

/// Keeps the region's contents, or clears them after a loss of power. Call once, when the MPU region is set,
/// and before any event is recorded.
pub(crate) fn prepare(had_no_power: bool) {
    if had_no_power {
        events().clear();
    } else {
        events().recover();
    }
}

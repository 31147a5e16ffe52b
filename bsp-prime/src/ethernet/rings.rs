//! Buffers of frames and their descriptors, in SRAM3: a ring to receive and a ring to send (RM0399 chapter
//! 61, "Descriptors").
//!
//! Bit OWN of a descriptor says whose it and its buffer are: the DMA's while it is set. What is ours is lent
//! to the stack as a slice: frames are never copied. The memory is not cacheable (the MPU, `memory.rs`), so
//! only the order of accesses matters: the buffer before OWN, OWN before the tail pointer that has the DMA
//! look.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

use smoltcp::phy::{RxToken, TxToken};
use stm32h7xx_hal::pac;

/// Number of descriptors and buffers to receive, and to send.
pub(super) const RECEIVE: usize = 6;
pub(super) const SEND: usize = 4;
/// Size of a buffer: the longest frame of 1,518 bytes, in whole bursts.
pub(super) const BUFFER_BYTES: usize = 1_536;
/// Longest frame that is sent, without its check sequence.
pub(super) const FRAME_BYTES: usize = 1_514;

/// Words of a descriptor, and their bits that are used here.
mod descriptor {
    pub const WORDS: usize = 4;
    pub const BYTES: u32 = 16;
    /// Words 0 (address of the buffer), 1, 2 and 3.
    pub const ADDRESS: usize = 0;
    pub const SECOND: usize = 1;
    pub const THIRD: usize = 2;
    pub const CONTROL: usize = 3;
    /// Word 3, both rings: the DMA's; first and last descriptor of the frame; something went wrong.
    pub const OWN: u32 = 1 << 31;
    pub const CONTEXT: u32 = 1 << 30;
    pub const FIRST: u32 = 1 << 29;
    pub const LAST: u32 = 1 << 28;
    pub const FAILED: u32 = 1 << 15;
    /// Word 3 to receive: interrupt at completion; the buffer's address is valid.
    pub const INTERRUPT: u32 = 1 << 30;
    pub const HAS_BUFFER: u32 = 1 << 24;
    /// Word 3 when received: word 1 is valid; the frame's length.
    pub const HAS_SECOND: u32 = 1 << 26;
    pub const LENGTH: u32 = 0x7FFF;
    /// Word 3 when received, where something went wrong: the errors (CE, GP, RWT, OE, RE, DE), and those of a
    /// frame that is whole after all. At 10 Mbit/s in RMII mode the controller takes half a byte too much now
    /// and then, and finds a dribble error and a wrong check sequence (errata ES0445, "Packets dropped in
    /// RMII 10 Mbps mode due to fake dribble and CRC error").
    pub const ERRORS: u32 = 0b11_1111 << 19;
    pub const FALSE_ALARM: u32 = 1 << 24 | 1 << 19;
    /// Word 1 when received: wrong checksum of the IP header, of what it carries.
    pub const WRONG_CHECKSUM: u32 = 1 << 3 | 1 << 7;
    /// Word 2 to send: interrupt at completion. Word 3 to send: insert the checksums of the IP header and of
    /// what it carries, with its pseudo-header.
    pub const SENT_INTERRUPT: u32 = 1 << 31;
    pub const INSERT_CHECKSUMS: u32 = 0b11 << 16;
}

use descriptor::{
    ADDRESS, BYTES, CONTEXT, CONTROL, ERRORS, FAILED, FALSE_ALARM, FIRST, HAS_BUFFER, HAS_SECOND, INSERT_CHECKSUMS,
    INTERRUPT, LAST, LENGTH, OWN, SECOND, SENT_INTERRUPT, THIRD, WORDS, WRONG_CHECKSUM,
};

#[repr(C, align(32))]
struct Memory {
    to_receive: [[u32; WORDS]; RECEIVE],
    to_send: [[u32; WORDS]; SEND],
    received: [[u8; BUFFER_BYTES]; RECEIVE],
    sent: [[u8; BUFFER_BYTES]; SEND],
}

struct Place(UnsafeCell<MaybeUninit<Memory>>);

// SAFETY: descriptors are read and written as single volatile words; a buffer is named only by the one ring
// that has it, while its descriptor is not the DMA's.
unsafe impl Sync for Place {}

#[unsafe(link_section = ".d2dma")]
static MEMORY: Place = Place(UnsafeCell::new(MaybeUninit::uninit()));

fn memory() -> *mut Memory {
    MEMORY.0.get().cast()
}

/// A word of a descriptor in the ring that begins here. The index must be below the ring's number.
unsafe fn word(ring: *mut u32, index: usize, word: usize) -> *mut u32 {
    // SAFETY: the caller vouches for the index; `word` is one of the four.
    unsafe { ring.add(index * WORDS + word) }
}

/// Ring of frames received, and the owner of their buffers.
pub(super) struct ReceiveRing {
    /// The descriptor of the next frame.
    next: usize,
    /// Frames handed on, and their bytes.
    pub frames: u32,
    pub bytes: u64,
    /// Frames that were longer than a buffer or damaged.
    pub damaged: u32,
    /// Whether frames were taken since the owner last asked: only then can others have been missed.
    pub took: bool,
}

/// Ring of frames to be sent, and the owner of their buffers.
pub(super) struct SendRing {
    next: usize,
    /// Whether frames go out: without a link they come to nothing.
    pub is_open: bool,
    pub frames: u32,
    pub bytes: u64,
    /// Frames that the controller gave up.
    pub failed: u32,
}

fn dma() -> &'static pac::ethernet_dma::RegisterBlock {
    // SAFETY: the tail pointers and the status are written as whole words, by the rings' one owner.
    unsafe { &*pac::ETHERNET_DMA::ptr() }
}

impl ReceiveRing {
    /// The only one. The memory may be used once its clock is on and it is zeroed (`memory::prepare_d2`).
    pub(super) const fn new() -> Self {
        Self { next: 0, frames: 0, bytes: 0, damaged: 0, took: false }
    }

    fn ring() -> *mut u32 {
        // SAFETY: a field of a static; no reference is made.
        unsafe { (&raw mut (*memory()).to_receive).cast() }
    }

    fn buffer(index: usize) -> *mut u8 {
        // SAFETY: a field of a static; no reference is made, and the index is below RECEIVE.
        unsafe { (&raw mut (*memory()).received).cast::<u8>().add(index * BUFFER_BYTES) }
    }

    /// Address of the first descriptor.
    pub(super) fn address() -> u32 {
        Self::ring() as u32
    }

    /// Gives all descriptors to the DMA, which must be stopped.
    pub(super) fn restart(&mut self) {
        self.next = 0;
        for index in 0..RECEIVE {
            Self::give(index);
        }
        cortex_m::asm::dsb();
    }

    /// Gives a descriptor to the DMA. Its first word was overwritten by the frame's status.
    fn give(index: usize) {
        // SAFETY: the index is below RECEIVE, and the descriptor is ours.
        unsafe {
            word(Self::ring(), index, ADDRESS).write_volatile(Self::buffer(index) as u32);
            word(Self::ring(), index, SECOND).write_volatile(0);
            word(Self::ring(), index, THIRD).write_volatile(0);
            // Nothing of the frame may be read after the DMA may write the next one.
            cortex_m::asm::dmb();
            word(Self::ring(), index, CONTROL).write_volatile(OWN | INTERRUPT | HAS_BUFFER);
        }
    }

    /// The tail pointer for the DMA: behind the ring's end, so that bit OWN alone stops it.
    pub(super) fn tail() -> u32 {
        Self::address() + RECEIVE as u32 * BYTES
    }

    fn control(&self) -> u32 {
        // SAFETY: `next` is below RECEIVE.
        unsafe { word(Self::ring(), self.next, CONTROL).read_volatile() }
    }

    /// Whether the DMA has written a frame that nobody has looked at.
    pub(super) fn has_frame(&self) -> bool {
        self.control() & OWN == 0
    }

    /// Length of the next good frame; those that are not are dropped.
    fn next_good_length(&mut self) -> Option<usize> {
        for _ in 0..RECEIVE {
            let control = self.control();
            if control & OWN != 0 {
                return None;
            }
            // Nothing of the frame may be read before OWN.
            cortex_m::asm::dmb();
            // SAFETY: `next` is below RECEIVE.
            let second = unsafe { word(Self::ring(), self.next, SECOND).read_volatile() };
            let is_whole = control & (FIRST | LAST | CONTEXT) == FIRST | LAST
                && (control & FAILED == 0 || control & ERRORS == FALSE_ALARM);
            let is_wrong = control & HAS_SECOND != 0 && second & WRONG_CHECKSUM != 0;
            let length = (control & LENGTH) as usize;
            if is_whole && !is_wrong && length <= BUFFER_BYTES {
                return Some(length);
            }
            self.damaged = self.damaged.wrapping_add(1);
            self.release();
        }
        None
    }

    /// Destination of the next frame is a group: broadcast or multicast.
    fn is_for_group(&self) -> bool {
        // SAFETY: the buffer of a descriptor that is ours.
        unsafe { Self::buffer(self.next).read() & 1 != 0 }
    }

    /// Drops frames that are damaged, and those for groups of which `drops` says that they are too many.
    /// Returns the length of the next frame that is neither.
    pub(super) fn next_length(&mut self, mut drops: impl FnMut() -> bool) -> Option<usize> {
        for _ in 0..RECEIVE {
            let length = self.next_good_length()?;
            if !(self.is_for_group() && drops()) {
                return Some(length);
            }
            self.release();
        }
        None
    }

    /// Takes the next frame, of the length that [`Self::next_length`] has returned.
    pub(super) fn take(&mut self, length: usize) -> Received<'_> {
        Received { ring: self, length }
    }

    /// Gives the next descriptor back.
    fn release(&mut self) {
        Self::give(self.next);
        self.next = if self.next + 1 < RECEIVE { self.next + 1 } else { 0 };
        self.took = true;
        cortex_m::asm::dsb();
        // A DMA that found no descriptor waits until the tail pointer is written (ETH_DMACRxDTPR); its flag,
        // RBU, is cleared before. No interrupt and so no summary comes of that flag. SAFETY: this bit clears
        // a flag; any value of the tail pointer has the DMA look at its descriptor.
        unsafe {
            dma().dmacsr.write(|w| w.bits(1 << 7));
            dma().dmacrx_dtpr.write(|w| w.bits(Self::tail()));
        }
    }
}

/// A frame received. Its buffer is given back when it is consumed; otherwise it is the next one again.
pub struct Received<'a> {
    ring: &'a mut ReceiveRing,
    length: usize,
}

impl RxToken for Received<'_> {
    fn consume<R, F: FnOnce(&[u8]) -> R>(self, look: F) -> R {
        let Self { ring, length } = self;
        ring.frames = ring.frames.wrapping_add(1);
        ring.bytes = ring.bytes.wrapping_add(length as u64);
        // SAFETY: the buffer is ours until `release`, nobody else names it, and the length was held against
        // its size; every byte was zeroed at start or written by the DMA.
        let frame = unsafe { core::slice::from_raw_parts(ReceiveRing::buffer(ring.next), length) };
        let answer = look(frame);
        ring.release();
        answer
    }
}

impl SendRing {
    /// The only one.
    pub(super) const fn new() -> Self {
        Self { next: 0, is_open: false, frames: 0, bytes: 0, failed: 0 }
    }

    fn ring() -> *mut u32 {
        // SAFETY: a field of a static; no reference is made.
        unsafe { (&raw mut (*memory()).to_send).cast() }
    }

    fn buffer(index: usize) -> *mut u8 {
        // SAFETY: a field of a static; no reference is made, and the index is below SEND.
        unsafe { (&raw mut (*memory()).sent).cast::<u8>().add(index * BUFFER_BYTES) }
    }

    /// Address of the first descriptor.
    pub(super) fn address() -> u32 {
        Self::ring() as u32
    }

    /// Takes all descriptors back from the DMA, which must be stopped: frames that were not sent are lost.
    pub(super) fn restart(&mut self) {
        self.next = 0;
        for index in 0..SEND {
            // SAFETY: the index is below SEND, and the DMA is stopped.
            unsafe { word(Self::ring(), index, CONTROL).write_volatile(0) };
        }
        cortex_m::asm::dsb();
    }

    /// Whether the next descriptor is ours, so that a frame can be taken.
    pub(super) fn has_room(&self) -> bool {
        // SAFETY: `next` is below SEND.
        !self.is_open || unsafe { word(Self::ring(), self.next, CONTROL).read_volatile() } & OWN == 0
    }

    /// Room for a frame.
    pub(super) fn room(&mut self) -> Option<Outgoing<'_>> {
        self.has_room().then_some(Outgoing { ring: self })
    }

    /// Hands the next buffer to the DMA, with this many bytes of a frame in it.
    fn send(&mut self, length: usize) {
        // SAFETY: `next` is below SEND, and the descriptor is ours.
        unsafe {
            if word(Self::ring(), self.next, CONTROL).read_volatile() & FAILED != 0 {
                self.failed = self.failed.wrapping_add(1);
            }
            word(Self::ring(), self.next, ADDRESS).write_volatile(Self::buffer(self.next) as u32);
            word(Self::ring(), self.next, SECOND).write_volatile(0);
            word(Self::ring(), self.next, THIRD).write_volatile(SENT_INTERRUPT | length as u32);
            // All of the frame is written before the DMA may read it.
            cortex_m::asm::dmb();
            let control = OWN | FIRST | LAST | INSERT_CHECKSUMS | length as u32;
            word(Self::ring(), self.next, CONTROL).write_volatile(control);
        }
        self.next = if self.next + 1 < SEND { self.next + 1 } else { 0 };
        self.frames = self.frames.wrapping_add(1);
        self.bytes = self.bytes.wrapping_add(length as u64);
        cortex_m::asm::dsb();
        // ETH_DMACTxDTPR: the descriptor behind the last one that is to be sent.
        let tail = Self::address() + self.next as u32 * BYTES;
        // SAFETY: any value of the tail pointer has the DMA look at its descriptor.
        unsafe { dma().dmactx_dtpr.write(|w| w.bits(tail)) };
    }
}

/// Room for a frame to be sent.
pub struct Outgoing<'a> {
    ring: &'a mut SendRing,
}

impl TxToken for Outgoing<'_> {
    fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, length: usize, fill: F) -> R {
        let Self { ring } = self;
        let length = length.min(FRAME_BYTES);
        // SAFETY: the descriptor is ours, so the buffer is, and nobody else names it; the length is below its
        // size, and every byte was zeroed at start.
        let frame = unsafe { core::slice::from_raw_parts_mut(SendRing::buffer(ring.next), length) };
        let answer = fill(frame);
        if ring.is_open {
            ring.send(length);
        }
        answer
    }
}

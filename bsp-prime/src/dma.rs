//! Memory that a DMA reads or writes: only to be had through [`dma_buffer!`](crate::dma_buffer), which places
//! it in memory that no cache touches.
//!
//! Access is volatile and by value. No reference into such memory ever exists, because the other side changes
//! it at any time.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

use crate::memory::{D2_DMA_BYTES, D2_DMA_START, DMA_ARENA_BYTES, DMA_ARENA_START};

/// A word a DMA can move: plain numbers, for which every bit pattern is a value.
pub trait DmaWord: Copy + sealed::Sealed {}

mod sealed {
    pub trait Sealed {}
    impl Sealed for u8 {}
    impl Sealed for u16 {}
    impl Sealed for u32 {}
}

impl DmaWord for u8 {}
impl DmaWord for u16 {}
impl DmaWord for u32 {}

/// `LENGTH` words in the arena. Made by [`dma_buffer!`](crate::dma_buffer).
#[repr(C, align(32))]
#[derive(Debug)]
pub struct DmaBuffer<W, const LENGTH: usize>(UnsafeCell<MaybeUninit<[W; LENGTH]>>);

// SAFETY: all access is by volatile single-word reads and writes of plain numbers; the contents are as shared
// as a register.
unsafe impl<W: DmaWord, const LENGTH: usize> Sync for DmaBuffer<W, LENGTH> {}

impl<W: DmaWord, const LENGTH: usize> DmaBuffer<W, LENGTH> {
    /// Only for [`dma_buffer!`](crate::dma_buffer): elsewhere the buffer would not be in the arena.
    #[doc(hidden)]
    #[must_use]
    pub const fn placed_by_macro() -> Self {
        Self(UnsafeCell::new(MaybeUninit::uninit()))
    }

    /// Returns the address for the DMA. `None` when the linker did not put the buffer into the arena, in
    /// which case it must not be used.
    pub fn address(&self) -> Option<u32> {
        let address = self.0.get() as u32;
        let in_arena = (DMA_ARENA_START..DMA_ARENA_START + DMA_ARENA_BYTES).contains(&address);
        let in_d2 = (D2_DMA_START..D2_DMA_START + D2_DMA_BYTES).contains(&address);
        (in_arena || in_d2).then_some(address)
    }

    /// Returns the word at `index`, or `None` beyond the end.
    #[inline]
    pub fn read(&self, index: usize) -> Option<W> {
        // SAFETY: within the array; the arena was zeroed at start-up, so the word is initialised, and any
        // pattern is a value.
        (index < LENGTH).then(|| unsafe { self.0.get().cast::<W>().add(index).read_volatile() })
    }

    /// Writes the word at `index`; returns false, and writes nothing, beyond the end.
    #[inline]
    pub fn write(&self, index: usize, word: W) -> bool {
        if index >= LENGTH {
            return false;
        }
        // SAFETY: within the array; nobody holds a reference into it.
        unsafe { self.0.get().cast::<W>().add(index).write_volatile(word) };
        true
    }
}

impl<const LENGTH: usize> DmaBuffer<u32, LENGTH> {
    /// Reads words from `index` on into whole groups of four bytes, low byte first; false when there are not
    /// so many.
    pub fn load(&self, index: usize, bytes: &mut [u8]) -> bool {
        if index + bytes.len() / 4 > LENGTH {
            return false;
        }
        for (offset, four) in bytes.chunks_exact_mut(4).enumerate() {
            // SAFETY: within the array, as was seen above; the arena was zeroed at start-up.
            let word = unsafe { self.0.get().cast::<u32>().add(index + offset).read_volatile() };
            four.copy_from_slice(&word.to_le_bytes());
        }
        true
    }

    /// Writes words from `index` on; false when there are not so many.
    pub fn store(&self, index: usize, bytes: &[u8]) -> bool {
        if index + bytes.len() / 4 > LENGTH {
            return false;
        }
        for (offset, four) in bytes.chunks_exact(4).enumerate() {
            let word = u32::from_le_bytes(four.try_into().unwrap_or_default());
            // SAFETY: within the array, as was seen above; nobody holds a reference into it.
            unsafe { self.0.get().cast::<u32>().add(index + offset).write_volatile(word) };
        }
        true
    }
}

/// Declares a static in the DMA arena: `dma_buffer!(static SAMPLES: [u16; 256]);`; or, for DMA1 and DMA2
/// alone, in SRAM3: `dma_buffer!(in D2, static SAMPLES: [u16; 256]);`
#[macro_export]
macro_rules! dma_buffer {
    (in D2, $(#[$attribute:meta])* $visibility:vis static $name:ident: [$word:ty; $length:expr]) => {
        $(#[$attribute])*
        #[unsafe(link_section = ".d2dma")]
        $visibility static $name: $crate::dma::DmaBuffer<$word, { $length }> = $crate::dma::DmaBuffer::placed_by_macro();
    };
    ($(#[$attribute:meta])* $visibility:vis static $name:ident: [$word:ty; $length:expr]) => {
        $(#[$attribute])*
        #[unsafe(link_section = ".dma_arena")]
        $visibility static $name: $crate::dma::DmaBuffer<$word, { $length }> = $crate::dma::DmaBuffer::placed_by_macro();
    };
}

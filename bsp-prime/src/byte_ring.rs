//! A byte queue between an interrupt and a task: one writer, one reader, no lock.
//!
//! The writer alone stores `written`, the reader alone stores `read`; a byte is published by the release
//! store of `written`. A full ring refuses, and the refusals are counted, so that a lost byte is always
//! known.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

/// A ring of `SIZE` bytes, a power of two. Lives in a `static`.
#[derive(Debug)]
pub struct ByteRing<const SIZE: usize> {
    bytes: [AtomicU8; SIZE],
    written: AtomicU32,
    read: AtomicU32,
    refused: AtomicU32,
}

impl<const SIZE: usize> Default for ByteRing<SIZE> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const SIZE: usize> ByteRing<SIZE> {
    const MASK: u32 = {
        assert!(SIZE.is_power_of_two(), "a ring's size is a power of two, so that wrapping is a mask");
        SIZE as u32 - 1
    };

    /// Returns an empty ring.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            bytes: [const { AtomicU8::new(0) }; SIZE],
            written: AtomicU32::new(0),
            read: AtomicU32::new(0),
            refused: AtomicU32::new(0),
        }
    }

    /// Returns the number of bytes that wait.
    #[must_use]
    pub fn len(&self) -> usize {
        self.written.load(Ordering::Acquire).wrapping_sub(self.read.load(Ordering::Acquire)) as usize
    }

    /// Returns whether no byte waits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the number of bytes that fit now.
    #[must_use]
    pub fn room(&self) -> usize {
        SIZE - self.len().min(SIZE)
    }

    /// Returns the number of bytes refused so far because the ring was full.
    #[must_use]
    pub fn refused(&self) -> u32 {
        self.refused.load(Ordering::Relaxed)
    }

    /// Writer: appends a byte, or refuses and counts it.
    pub fn push(&self, byte: u8) -> bool {
        let written = self.written.load(Ordering::Relaxed);
        if written.wrapping_sub(self.read.load(Ordering::Acquire)) >= SIZE as u32 {
            self.refused.store(self.refused.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
            return false;
        }
        self.bytes[(written & Self::MASK) as usize].store(byte, Ordering::Relaxed);
        self.written.store(written.wrapping_add(1), Ordering::Release);
        true
    }

    /// Writer: appends as much of `bytes` as fits and returns the number of bytes taken. The rest is not
    /// counted as refused: the caller still has it.
    pub fn push_some(&self, bytes: &[u8]) -> usize {
        let count = bytes.len().min(self.room());
        for &byte in bytes.iter().take(count) {
            self.push(byte);
        }
        count
    }

    /// Reader: takes the oldest byte.
    pub fn pop(&self) -> Option<u8> {
        let read = self.read.load(Ordering::Relaxed);
        if read == self.written.load(Ordering::Acquire) {
            return None;
        }
        let byte = self.bytes[(read & Self::MASK) as usize].load(Ordering::Relaxed);
        self.read.store(read.wrapping_add(1), Ordering::Release);
        Some(byte)
    }

    /// Reader: drops the waiting bytes.
    pub fn clear(&self) {
        self.read.store(self.written.load(Ordering::Acquire), Ordering::Release);
    }

    /// Reader: moves waiting bytes into `into` and returns their number.
    pub fn pop_into(&self, into: &mut [u8]) -> usize {
        let mut count = 0;
        for slot in into {
            let Some(byte) = self.pop() else { break };
            *slot = byte;
            count += 1;
        }
        count
    }
}

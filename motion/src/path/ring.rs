//! The curves of the blocks that wait, first in first out. Apart from the blocks, so that lines need no room
//! for them.

use super::Curve;

/// Curves that may wait at once; a block for which there is no room waits outside.
pub const MOST_CURVES: usize = 32;
/// Capacity of the ring: as many more curves stay behind the waiting ones, should their blocks be taken back.
/// A power of two.
const CAPACITY: usize = 2 * MOST_CURVES;

/// The ring; counts wrap.
#[derive(Debug)]
pub(crate) struct CurveRing {
    curves: [Curve; CAPACITY],
    first: u32,
    end: u32,
}

impl CurveRing {
    /// Creates an empty ring.
    pub const fn new() -> Self {
        Self { curves: [Curve::Line; CAPACITY], first: 0, end: 0 }
    }

    /// Whether no curve can be appended.
    pub const fn is_full(&self) -> bool {
        self.end.wrapping_sub(self.first) as usize >= MOST_CURVES
    }

    /// Whether the ring is full, or was before one curve was taken out.
    pub const fn was_full(&self) -> bool {
        self.end.wrapping_sub(self.first) as usize + 1 >= MOST_CURVES
    }

    /// Appends a curve. Not when full.
    pub fn push(&mut self, curve: Curve) {
        // The remainder is always in range: the check disappears.
        self.curves[self.end as usize % CAPACITY] = curve;
        self.end = self.end.wrapping_add(1);
    }

    /// Takes the oldest out.
    pub fn pop(&mut self) -> Curve {
        if self.first == self.end {
            return Curve::Line;
        }
        let curve = self.curves[self.first as usize % CAPACITY];
        self.first = self.first.wrapping_add(1);
        curve
    }

    /// Whether the last `count` curves taken out are still there.
    pub const fn keeps(&self, count: u32) -> bool {
        self.end.wrapping_sub(self.first.wrapping_sub(count)) as usize <= CAPACITY
    }

    /// Puts the last `count` curves taken out back; there must be so many.
    pub const fn take_back(&mut self, count: u32) {
        self.first = self.first.wrapping_sub(count);
    }

    /// Drops all curves that wait.
    pub const fn clear(&mut self) {
        self.first = self.end;
    }
}

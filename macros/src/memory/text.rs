//! Texts in memory, as parts of it.

/// A text in memory, in one word: where its first byte is, and above that its length in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Text(u32);

impl Text {
    /// The text at a place, of a length in bytes.
    pub fn new(at: usize, len: usize) -> Self {
        Self(at as u32 & 0xffff | (len as u32) << 16)
    }

    /// The text with this word.
    pub fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// The word that the text is.
    pub fn bits(self) -> u32 {
        self.0
    }

    /// Place of the first byte.
    pub fn at(self) -> usize {
        self.0 as u16 as usize
    }

    /// Length of the text, bytes.
    pub fn len(self) -> usize {
        (self.0 >> 16) as usize
    }

    /// The part of the text from one byte up to another.
    #[inline(never)]
    pub fn part(self, from: usize, to: usize) -> Self {
        let to = to.min(self.len());
        let from = from.min(to);
        Self::new(self.at() + from, to - from)
    }

    /// The text from a byte on.
    #[inline(never)]
    pub fn rest(self, from: usize) -> Self {
        self.part(from, usize::MAX)
    }
}

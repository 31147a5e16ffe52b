//! Answers of a few bytes, in the making.

/// The longest answer.
pub const REPLY_BYTES: usize = 64;

/// An answer.
#[derive(Clone, Debug, Default)]
pub struct Reply(heapless::Vec<u8, REPLY_BYTES>);

impl Reply {
    /// Empty.
    pub const fn new() -> Self {
        Self(heapless::Vec::new())
    }

    /// What it says.
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// Says this next. Every answer of this crate is shorter than there is room for.
    pub fn add(mut self, bytes: &[u8]) -> Self {
        let _fits = self.0.extend_from_slice(bytes);
        self
    }

    /// Says a text next, with blanks behind it up to its width.
    pub fn text(mut self, text: &str, width: usize) -> Self {
        let padded = text.bytes().chain(core::iter::repeat(b' ')).take(width);
        self.0.extend(padded);
        self
    }

    /// No more than so many bytes, the allocation length of a command (SPC-4 section 4.2.5.6).
    pub fn at_most(mut self, bytes: u32) -> Self {
        self.0.truncate(bytes as usize);
        self
    }
}

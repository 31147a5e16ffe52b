//! Builder for short answers to commands.

/// Longest answer to a command.
pub const REPLY_BYTES: usize = 64;

/// Answer to a command, as bytes.
#[derive(Clone, Debug, Default)]
pub struct Reply(heapless::Vec<u8, REPLY_BYTES>);

impl Reply {
    /// Creates an empty answer.
    pub const fn new() -> Self {
        Self(heapless::Vec::new())
    }

    /// Returns the bytes of the answer.
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// Appends bytes. Every answer of this crate fits the capacity.
    pub fn add(mut self, bytes: &[u8]) -> Self {
        let _fits = self.0.extend_from_slice(bytes);
        self
    }

    /// Appends a text, padded with blanks to a width.
    pub fn text(mut self, text: &str, width: usize) -> Self {
        let padded = text.bytes().chain(core::iter::repeat(b' ')).take(width);
        self.0.extend(padded);
        self
    }

    /// Truncates the answer to the allocation length of a command (SPC-4 section 4.2.5.6).
    pub fn at_most(mut self, bytes: u32) -> Self {
        self.0.truncate(bytes as usize);
        self
    }
}

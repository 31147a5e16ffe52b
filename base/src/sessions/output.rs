//! Output of a session that waits to be sent.

use core::fmt::{self, Write};

use heapless::Deque;

/// Bytes of output by which a session can be behind; more than the longest reply of one line.
pub(super) const OUTPUT_BYTES: usize = 2_048;

/// Output that waits to be sent.
#[derive(Debug)]
pub(super) struct Output {
    pub(super) bytes: Deque<u8, OUTPUT_BYTES>,
}

impl Output {
    /// Makes an output in which nothing waits.
    pub(super) const fn new() -> Self {
        Self { bytes: Deque::new() }
    }
}

impl Write for Output {
    /// Writes whole pieces or nothing: a reader that fell 2 kB behind gets gaps between words, never within.
    fn write_str(&mut self, text: &str) -> fmt::Result {
        if text.len() <= OUTPUT_BYTES - self.bytes.len() {
            for byte in text.bytes() {
                // Writing fits, as the length was checked.
                let _ = self.bytes.push_back(byte);
            }
        }
        Ok(())
    }
}

//! Memory of the site that may be slow: what was said, temperatures, heights of the bed.

use crate::console::SAID_BYTES;
use crate::mesh::Heights;
use crate::temperatures::Temperatures;

/// Memory of the site that is large and seldom used: a board gives it the slowest that it has. All zero at
/// first.
#[derive(Debug)]
pub struct Memory {
    pub(crate) said: [u8; SAID_BYTES],
    pub(crate) temperatures: Temperatures,
    pub(crate) heights: Heights,
}

impl Default for Memory {
    fn default() -> Self {
        Self::new()
    }
}

impl Memory {
    /// Makes a memory of nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self { said: [0; SAID_BYTES], temperatures: Temperatures::new(), heights: Heights::new() }
    }
}

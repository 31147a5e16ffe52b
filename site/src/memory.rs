//! Memory of the site that may be slow: what was said, temperatures, heights of the bed.

use crate::console::SAID_BYTES;
use crate::macros::Macros;
use crate::mesh::Heights;
use crate::temperatures::Temperatures;

/// Memory of the site that is large and seldom used: a board gives it the slowest that it has. All zero at
/// first.
#[derive(Debug)]
pub struct Memory {
    pub(crate) said: [u8; SAID_BYTES],
    pub(crate) stores: Stores,
}

/// Stores of what answers tell and snapshots have no room for.
#[derive(Debug)]
pub struct Stores {
    /// Temperatures of the last minutes.
    pub temperatures: Temperatures,
    /// Heights of the bed.
    pub heights: Heights,
    /// Macros that were told last.
    pub macros: Macros,
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
        let stores = Stores { temperatures: Temperatures::new(), heights: Heights::new(), macros: Macros::new() };
        Self { said: [0; SAID_BYTES], stores }
    }
}

//! Modes that are kept by names.

use heapless::Vec;
use program::Saved;

/// Most names that modes are kept by. Macros that call each other are seldom deeper.
const MOST: usize = 4;

/// Modes, and where the program was.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kept {
    /// Number made of the name.
    pub name: u32,
    pub modes: Saved,
    /// Machine coordinates, X Y Z in mm.
    pub at: [f64; 3],
    /// Place of the extruder in the work's coordinates.
    pub extruder: f64,
}

/// Modes by names, the one kept last at the end.
#[derive(Clone, Debug)]
pub(super) struct KeptModes(Vec<Kept, MOST>);

impl KeptModes {
    /// No modes are kept.
    pub const fn new() -> Self {
        Self(Vec::new())
    }

    /// Forgets all of them.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Keeps modes, in place of those of the same name.
    pub fn keep(&mut self, kept: Kept) {
        self.0.retain(|known| known.name != kept.name);
        if self.0.is_full() {
            self.0.remove(0);
        }
        // There is room, as was made.
        let _ = self.0.push(kept);
    }

    /// Returns the modes of a name.
    pub fn find(&self, name: u32) -> Option<Kept> {
        self.0.iter().find(|kept| kept.name == name).copied()
    }
}

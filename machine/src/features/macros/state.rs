//! State of the feature of macros.

use heapless::{String, Vec};
use printer_cfg::Memory;
use program::Saved;
use units::Micros;

/// Most names that modes are kept by.
const MOST: usize = 6;
/// Longest name, bytes.
const NAME: usize = 24;

/// Longest text of M117 that is kept, bytes.
const MESSAGE: usize = 64;

/// Modes, and where the program was.
#[derive(Clone, Debug)]
pub(crate) struct Kept {
    pub name: String<NAME>,
    pub modes: Saved,
    /// Machine coordinates, X Y Z in mm.
    pub at: [f64; 3],
    /// Place of the extruder in the work's coordinates.
    pub extruder: f64,
}

/// Modes by names, the one kept last at the end.
#[derive(Clone, Debug)]
pub(crate) struct KeptModes {
    pub kept: Vec<Kept, MOST>,
}

impl KeptModes {
    /// No modes are kept.
    pub const fn new() -> Self {
        Self { kept: Vec::new() }
    }
}

/// Macros under way, what they keep, and when the machine has been idle for long.
pub(crate) struct Macros<'c> {
    /// Memory that they are rendered in, and what is known of the configuration.
    pub memory: Memory<'c>,
    /// Times that the configuration was read.
    pub readings: u32,
    /// G-code is due: every line looks at it.
    pub is_due: bool,
    /// Time since which the machine has had nothing to do.
    pub idle_since: Micros,
    /// Time without work after which the G-code of `[idle_timeout]` is carried out; none: never.
    pub idle_timeout: Option<Micros>,
    /// The machine has been idle for so long.
    pub is_idle: bool,
    /// Modes of the program, kept by names.
    pub modes: KeptModes,
    /// Numbers that macros take at random.
    pub random: u32,
    /// Beginning of the text that was last shown to the operator (M117).
    pub message: String<MESSAGE>,
}

impl<'c> Macros<'c> {
    /// Starts without any macro.
    pub const fn new(memory: Memory<'c>) -> Self {
        Self {
            memory,
            readings: 0,
            is_due: false,
            idle_since: Micros(0),
            idle_timeout: None,
            is_idle: false,
            modes: KeptModes::new(),
            random: 0,
            message: String::new(),
        }
    }

    /// Whether the machine has been idle for too long, and nothing has been done about it.
    pub fn is_idle_too_long(&self, now: Micros) -> bool {
        !self.is_idle && self.idle_timeout.is_some_and(|timeout| now.since(self.idle_since) >= timeout)
    }
}

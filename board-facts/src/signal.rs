//! Facts about a signal of the board.

use crate::Proof;

/// State into which the circuit brings a pin that nobody drives, as in reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// Held high, by this part.
    High(&'static str),
    /// Held low, by this part.
    Low(&'static str),
    /// Held by no part of the circuit.
    Floats,
    /// Driven by the far end.
    Driven(&'static str),
}

/// State into which the microcontroller brings a pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Not driven: analog, or an open-drain output that is let go.
    Released,
    /// An input with the chip's pull-up.
    PulledUp,
    /// Driven to the low level.
    Low,
    /// Driven to the high level.
    High,
    /// Driven, to the level that the last action has left.
    Either,
    /// Alternate function of a peripheral, by its number (DS12923, table of alternate functions).
    Function(u8),
}

/// Rise and fall time of a driven pin's edges (RM0399 section 12.4.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Speed {
    /// Edges of 17 ns at 50 pF.
    Low = 0,
    /// Edges of 5 ns.
    Medium = 1,
    /// Edges of 4 ns.
    High = 2,
    /// Edges of 3 ns.
    VeryHigh = 3,
}

/// A signal, or several that are alike.
#[derive(Clone, Copy, Debug)]
pub struct Signal {
    /// Name of the signal.
    pub name: &'static str,
    /// Pins of the signal.
    pub pins: &'static [&'static str],
    /// State of the pin in reset.
    pub rest: Rest,
    /// Level with the image up and nothing wired.
    pub boot: Level,
    /// Level when the pin is wired, and nothing is asked of it.
    pub idle: Level,
    /// Meaning of the levels while the signal is in use.
    pub active: &'static str,
    /// Level after a halt.
    pub halted: Level,
    /// Speed of the edges, if the chip drives the pin.
    pub speed: Option<Speed>,
    /// Source of these facts.
    pub origin: &'static str,
    /// Tests that look at the signal while it is in use; [`LEVELS`](crate::signals::LEVELS) looks at every
    /// row in the other states.
    pub proofs: &'static [Proof],
}

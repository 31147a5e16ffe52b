//! What is known of a signal.

use crate::Proof;

/// What the circuit makes of a pin that nobody drives, as in reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// Held high, and by what.
    High(&'static str),
    /// Held low, and by what.
    Low(&'static str),
    /// Held by nothing.
    Floats,
    /// The far end drives it.
    Driven(&'static str),
}

/// What the microcontroller does to a pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Nothing: analog, or an open-drain output that is let go.
    Released,
    /// An input with the chip's pull-up.
    PulledUp,
    /// Driven low.
    Low,
    /// Driven high.
    High,
    /// Driven, to the level that what was done before has left.
    Either,
    /// Belongs to a peripheral: its alternate function (DS12923, table of alternate functions).
    Function(u8),
}

/// How steep a driven pin's edges are (RM0399 section 12.4.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Speed {
    /// 17 ns at 50 pF.
    Low = 0,
    /// 5 ns.
    Medium = 1,
    /// 4 ns.
    High = 2,
    /// 3 ns.
    VeryHigh = 3,
}

/// One signal, or several that are alike.
#[derive(Clone, Copy, Debug)]
pub struct Signal {
    /// What it is.
    pub name: &'static str,
    /// Its pins.
    pub pins: &'static [&'static str],
    /// In reset.
    pub rest: Rest,
    /// With the image up and nothing wired.
    pub boot: Level,
    /// Wired, and nothing asked of it.
    pub idle: Level,
    /// In use: which level means what.
    pub active: &'static str,
    /// After a halt.
    pub halted: Level,
    /// Of its edges, where the chip drives it.
    pub speed: Option<Speed>,
    /// Where this is known from.
    pub origin: &'static str,
    /// The tests that look at it while it is in use; [`LEVELS`](crate::signals::LEVELS) looks at every row in
    /// the other states.
    pub proofs: &'static [Proof],
}

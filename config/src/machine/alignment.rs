//! `[z alignment]`, `[bed screws]` and `[axis twist compensation]`: what carries the bed or the gantry, by
//! motors and by hand.

use heapless::Vec;
use units::Mm;

/// Motors of the Z axis at most: gamma and the three that can be slaved to it.
pub const MAX_Z_MOTORS: usize = 4;
/// Screws of a bed at most.
pub const MAX_SCREWS: usize = 8;
/// Points of a procedure at most.
pub const MAX_POINTS: usize = 12;

/// `[z alignment]`
#[derive(Clone, Debug, Default)]
pub struct ZAlignment {
    /// Where each Z motor carries the bed or the gantry, X and Y, mm: gamma first, then its slaves in their
    /// order. Empty: nothing is aligned.
    pub motors: Vec<[f64; 2], MAX_Z_MOTORS>,
    /// Where the bed is touched, mm.
    pub points: Vec<[f64; 2], MAX_POINTS>,
    /// Four motors take out a twist, too.
    pub twist: bool,
    /// The motors are aligned when none is off by more.
    pub tolerance: Mm,
    /// Rounds after the first one, at most.
    pub retries: u8,
    /// A motor that is off by more is not moved.
    pub max_adjust: Mm,
    /// Height from which the bed is searched for.
    pub initial_height: Mm,
}

/// What a turn of a screw does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Thread {
    /// Way of one turn, mm; zero: not said.
    pub pitch: f64,
    /// Turned clockwise it raises the bed.
    pub clockwise_raises: bool,
}

/// Places that tell of an axis's twist at most.
pub const MOST_TWIST_POINTS: usize = 8;

/// `[axis twist compensation]`
#[derive(Clone, Debug, Default)]
pub struct AxisTwist {
    /// The twist changes along Y; else along X.
    pub along_y: bool,
    /// Places along it and what the probe reads too high there, mm. Empty: not known.
    pub points: Vec<[f64; 2], MOST_TWIST_POINTS>,
    /// Where it is measured.
    pub start: Mm,
    /// To here.
    pub end: Mm,
    /// On this line of the other axis.
    pub line: Mm,
    /// At so many places.
    pub samples: u8,
    /// Height from which the bed is searched for.
    pub initial_height: Mm,
}

/// `[bed screws]`
#[derive(Clone, Debug, Default)]
pub struct BedScrews {
    /// Where they are, X and Y, mm; the first one is the reference. Empty: the bed has none.
    pub screws: Vec<[f64; 2], MAX_SCREWS>,
    /// Their thread.
    pub thread: Thread,
    /// Height from which the bed is searched for.
    pub initial_height: Mm,
    /// Height of the tool over a screw that a person turns by paper.
    pub paper_height: Mm,
    /// The bed is level when no screw is off by more.
    pub tolerance: Mm,
}

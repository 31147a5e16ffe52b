//! Sections `[z alignment]`, `[bed screws]` and `[axis twist compensation]`: tilt and twist of the bed or the
//! gantry, corrected by motors or by hand.

use heapless::Vec;
use units::Mm;

/// Greatest number of Z motors: gamma and the three that can be slaved to it.
pub const MAX_Z_MOTORS: usize = 4;
/// Greatest number of bed screws.
pub const MAX_SCREWS: usize = 8;
/// Greatest number of probed points.
pub const MAX_POINTS: usize = 12;

/// Section `[z alignment]`: leveling by Z motors.
#[derive(Clone, Debug, Default)]
pub struct ZAlignment {
    /// Positions at which each Z motor carries the bed or the gantry, X and Y, mm: gamma first, then its
    /// slaves in their order. Empty: nothing is aligned.
    pub motors: Vec<[f64; 2], MAX_Z_MOTORS>,
    /// Positions at which the bed is probed, mm.
    pub points: Vec<[f64; 2], MAX_POINTS>,
    /// Whether four motors take out a twist, too.
    pub twist: bool,
    /// Greatest height error of a motor that counts as aligned.
    pub tolerance: Mm,
    /// Greatest number of rounds after the first one.
    pub retries: u8,
    /// Greatest height error that is corrected; a motor with a larger one is not moved.
    pub max_adjust: Mm,
    /// Height from which the search for the bed begins.
    pub initial_height: Mm,
}

/// Thread of a bed screw.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Thread {
    /// Height change per turn, mm; zero: not given.
    pub pitch: f64,
    /// Whether a clockwise turn raises the bed.
    pub clockwise_raises: bool,
}

/// Greatest number of points along a twisted axis.
pub const MOST_TWIST_POINTS: usize = 8;

/// Section `[axis twist compensation]`.
#[derive(Clone, Debug, Default)]
pub struct AxisTwist {
    /// Whether the twist changes along Y instead of X.
    pub along_y: bool,
    /// Positions along the axis and the probe's reading error there (positive: too high), mm. Empty: not
    /// known.
    pub points: Vec<[f64; 2], MOST_TWIST_POINTS>,
    /// First position of the measurement.
    pub start: Mm,
    /// Last position of the measurement.
    pub end: Mm,
    /// Position of the other axis during the measurement.
    pub line: Mm,
    /// Number of measured positions.
    pub samples: u8,
    /// Height from which the search for the bed begins.
    pub initial_height: Mm,
}

/// Section `[bed screws]`: leveling by hand.
#[derive(Clone, Debug, Default)]
pub struct BedScrews {
    /// Positions of the screws, X and Y, mm; the first one is the reference. Empty: the bed has none.
    pub screws: Vec<[f64; 2], MAX_SCREWS>,
    /// Thread of the screws.
    pub thread: Thread,
    /// Height from which the search for the bed begins.
    pub initial_height: Mm,
    /// Height of the tool over a screw that a person turns by paper.
    pub paper_height: Mm,
    /// Greatest height error of a screw that counts as level.
    pub tolerance: Mm,
}

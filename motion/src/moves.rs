//! Requests of the executor to the motion object, and reasons to refuse them.

use units::{Axis, MmPerSecond, PerAxis};

use crate::{laser::Power, path::Curve};

/// Kind of a move: decides the override that applies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Positioning (G0): the rapid override applies; a laser stays off.
    Rapid,
    /// Working (G1 to G3): the feed override applies.
    #[default]
    Feed,
}

/// Treatment of the corner between a move and the one before it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Corner {
    /// Sharp, and taken at the speed of the junction deviation (G61).
    #[default]
    Sharp,
    /// Sharp, with a standstill in the corner (G61.1).
    Stop,
    /// Rounded by an arc that leaves the corner by this much at most, mm (G64 P), between two straight moves
    /// of one mode and power.
    Rounded(f64),
}

/// Purpose of a move, numbered by the submitter: a line of a file, say. Motion hands the tag back while the
/// motors make the move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tag(pub u32);

impl Tag {
    /// Tag of a move without particular purpose.
    pub const NONE: Self = Self(0);
}

/// Part of the work that a move belongs to, numbered by the submitter: an object of a print, say. Waiting
/// moves of a part can be left out ([`crate::Motion::go_round`]). Zero: none.
pub type Part = u8;

/// A move from wherever the previous one ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Move {
    /// End of the move, in machine space: X Y Z in mm, A B C in mm (filament) or degrees.
    pub target: PerAxis<f64>,
    /// Speed along the path of X Y Z; along the auxiliary axes when X Y Z stand still.
    pub feed_rate: MmPerSecond,
    /// Kind of move: rapid or feed.
    pub mode: Mode,
    /// Power of a laser; rapids have none, whatever they ask for.
    pub power: Power,
    /// Curve of X, Y and Z, seen from the end of the previous move; a line for a straight move. The move ends
    /// at the target in any case: a difference between the two is spread over the whole way.
    pub curve: Curve,
    /// The corner at its beginning.
    pub corner: Corner,
    /// Purpose of the move.
    pub tag: Tag,
    /// Part of the work that the move belongs to.
    pub part: Part,
}

impl Move {
    /// A working move without power.
    #[must_use]
    pub const fn feed(target: PerAxis<f64>, feed_rate: MmPerSecond) -> Self {
        Self {
            target,
            feed_rate,
            mode: Mode::Feed,
            power: Power::OFF,
            curve: Curve::Line,
            corner: Corner::Sharp,
            tag: Tag::NONE,
            part: 0,
        }
    }

    /// A positioning move (rapid).
    #[must_use]
    pub const fn rapid(target: PerAxis<f64>, feed_rate: MmPerSecond) -> Self {
        Self { mode: Mode::Rapid, ..Self::feed(target, feed_rate) }
    }
}

/// Reason for which [`crate::Motion`] did not do what it was asked. Nothing was changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Refusal {
    /// The look-ahead queue is full. Not an error: ask again later.
    Full,
    /// A stop or an abort is under way. Ask again when idle.
    Stopping,
    /// Only possible while nothing moves and nothing is queued.
    Busy,
    /// [`crate::Motion::configure`] has not succeeded yet.
    NotConfigured,
    /// A coordinate or the feed rate is not a finite number, or lies beyond what steps can count.
    NotFinite,
    /// The feed rate is zero or negative.
    NoFeedRate,
    /// The move names an axis that no motor drives.
    NoActuator(Axis),
    /// The machine's arms cannot reach every place of the move.
    Unreachable,
}

impl core::fmt::Display for Refusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Full => f.write_str("the look-ahead queue is full"),
            Self::Stopping => f.write_str("the machine is stopping"),
            Self::Busy => f.write_str("the machine is moving"),
            Self::NotConfigured => f.write_str("motion is not configured"),
            Self::NotFinite => f.write_str("a coordinate or the feed rate is not a usable number"),
            Self::NoFeedRate => f.write_str("undefined feed rate"),
            Self::Unreachable => f.write_str("illegal move: it leaves the space the machine can reach"),
            Self::NoActuator(axis) => write!(f, "no motor drives axis {}", axis.letter()),
        }
    }
}

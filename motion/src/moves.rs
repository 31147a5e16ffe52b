//! What the dispatcher asks for, and why it may be refused.

use units::{Axis, MmPerSecond, PerAxis};

use crate::path::Curve;

/// Which speed limit of the program a move obeys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Positioning (G0): the rapid override applies; a laser stays off.
    Rapid,
    /// Working (G1 to G3): the feed override applies.
    #[default]
    Feed,
}

/// What becomes of the corner between a move and the one before it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Corner {
    /// It stays as sharp as it is, and is taken at the speed of the junction deviation (G61).
    #[default]
    Sharp,
    /// It stays sharp, and the machine stands still in it (G61.1).
    Stop,
    /// Between two straight moves of one mode and power it is rounded by an arc that leaves it by this much
    /// at most, mm (G64 P).
    Rounded(f64),
}

/// What a move is made for, as whoever submits it counts: a line of a file, say. Motion hands it back while
/// the motors make the move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tag(pub u32);

impl Tag {
    /// For nothing in particular.
    pub const NONE: Self = Self(0);
}

/// Which part of the work a move belongs to, as whoever submits it counts: an object of a print, say. What
/// waits of a part can be left out ([`crate::Motion::go_round`]). Zero: none.
pub type Part = u8;

/// A move from wherever the previous one ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Move {
    /// Where it ends, in machine space: X Y Z in mm, A B C in mm (filament) or degrees.
    pub target: PerAxis<f64>,
    /// Speed along the path of X Y Z; along the auxiliary axes when X Y Z stand still.
    pub feed_rate: MmPerSecond,
    /// Rapid or feed.
    pub mode: Mode,
    /// The program's S value, for a laser.
    pub power: f32,
    /// What X, Y and Z do on the way, seen from where the previous move ends; a line for a straight move. The
    /// target is where it ends in any case: what the two differ by is spread over the whole way.
    pub curve: Curve,
    /// The corner at its beginning.
    pub corner: Corner,
    /// What it is made for.
    pub tag: Tag,
    /// Which part of the work it belongs to.
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
            power: 0.0,
            curve: Curve::Line,
            corner: Corner::Sharp,
            tag: Tag::NONE,
            part: 0,
        }
    }

    /// A positioning move.
    #[must_use]
    pub const fn rapid(target: PerAxis<f64>, feed_rate: MmPerSecond) -> Self {
        Self { mode: Mode::Rapid, ..Self::feed(target, feed_rate) }
    }
}

/// Why [`crate::Motion`] did not do what it was asked. Nothing was changed.
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
    /// A coordinate, the feed rate or the power is not a finite number, or lies beyond what steps can count.
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

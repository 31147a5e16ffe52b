//! The last block in the queue, while moves that go straight on may become part of it.

use units::{MAX_AXES, PerAxis};

use super::Power;
use crate::moves::{Part, Tag};

/// Moves that become one block, at most: the last block counts for nothing in the plan while it grows, and a
/// slow sender must not wait for it for ever.
pub(crate) const MOST_MOVES: u16 = 128;

/// Beginning of a block that may grow, and what its moves have in common. At the start all bits are zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Growth {
    /// Number of moves in the block; zero: no block may grow.
    pub moves: u16,
    /// Count of the block.
    pub block: u32,
    /// Beginning of the block, in machine space.
    pub origin: PerAxis<f64>,
    /// Unit direction of its first move.
    pub direction: [f64; 3],
    /// Path speed that was asked for, mm/s.
    pub requested: f64,
    /// Power of its first move.
    pub power: Power,
    /// Level of its last move.
    pub level: u16,
    pub tag: Tag,
    pub part: Part,
}

impl Growth {
    /// No block may grow.
    pub const NONE: Self = Self {
        moves: 0,
        block: 0,
        origin: PerAxis([0.0; MAX_AXES]),
        direction: [0.0; 3],
        requested: 0.0,
        power: Power::OFF,
        level: 0,
        tag: Tag::NONE,
        part: 0,
    };
}

//! Ends of moves, for whoever draws the path that the machine makes.
//!
//! While somebody watches, each block's end is noted as the block begins on the trajectory, and told when the
//! motors have made it. A place that the path comes to otherwise, because a move was cut off or a position
//! was declared, is noted as the next block begins there.

use units::Ring;

/// Ends that can wait: those of the trajectory ahead of the motors and of the time between two looks.
const WAITING: usize = 48;
/// Difference of coordinates that counts as none, mm.
const SAME: f32 = 0.002;

/// End of a move that the motors have made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MoveEnd {
    /// X, Y and Z in machine space, mm.
    pub at: [f32; 3],
    /// Whether the move was one of work, and not a rapid.
    pub is_work: bool,
    /// Whether an axis beside X, Y and Z went forward on the way, as an extruder does.
    pub extrudes: bool,
}

/// End of the block of this count.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    block: u32,
    end: MoveEnd,
}

/// Ends of moves between the trajectory and whoever draws the path.
#[derive(Clone, Debug)]
pub(crate) struct MoveEnds {
    is_watched: bool,
    waiting: Ring<Waiting, WAITING>,
    /// Place that the path has come to, if it is known.
    at: Option<[f32; 3]>,
}

impl MoveEnds {
    /// Creates it with nobody watching.
    pub const fn new() -> Self {
        const NONE: Waiting = Waiting { block: 0, end: MoveEnd { at: [0.0; 3], is_work: false, extrudes: false } };
        Self { is_watched: false, waiting: Ring::new(NONE), at: None }
    }

    /// Whether ends are to be noted.
    pub const fn is_watched(&self) -> bool {
        self.is_watched
    }

    /// Begins or ends to note ends of moves.
    pub fn watch(&mut self, is_watched: bool) {
        if self.is_watched != is_watched {
            self.is_watched = is_watched;
            self.restart();
        }
    }

    /// Begins a new path: where it begins is told with its first move.
    pub fn restart(&mut self) {
        self.waiting.clear();
        self.at = None;
    }

    /// The block of this count begins at `from`.
    pub fn begin(&mut self, block: u32, from: [f32; 3], end: MoveEnd) {
        self.drop_from(block);
        let is_there = self.at.is_some_and(|at| at.iter().zip(from).all(|(at, from)| (at - from).abs() <= SAME));
        if !is_there {
            self.push(Waiting { block: block.wrapping_sub(1), end: MoveEnd { at: from, ..MoveEnd::default() } });
        }
        self.push(Waiting { block, end });
    }

    fn push(&mut self, next: Waiting) {
        self.at = Some(next.end.at);
        if !self.waiting.push(next)
            && let Some(last) = self.waiting.last_mut()
        {
            // Nobody has looked for long: the path is drawn straight from the last place that has room.
            *last = next;
        }
    }

    /// Forgets the ends of this block and of those behind it, which are not made as they were begun.
    pub fn drop_from(&mut self, block: u32) {
        while self.waiting.last_mut().is_some_and(|last| last.block.wrapping_sub(block) as i32 >= 0) {
            self.waiting.drop_last();
            self.at = None;
        }
    }

    /// Takes the oldest end, if it is one of a block before this one.
    pub fn take_before(&mut self, block: u32) -> Option<MoveEnd> {
        let first = self.waiting.get(0).filter(|first| block.wrapping_sub(first.block) as i32 > 0)?;
        self.waiting.drop_first();
        Some(first.end)
    }
}

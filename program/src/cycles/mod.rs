//! Canned cycles of a program: the words that hold from hole to hole, and the block that is being drilled.

pub(crate) mod holes;
pub(crate) mod thread_passes;

use heapless::Vec;
use units::{Micros, PerAxis, Plane};

use crate::action::Action;
use crate::cycles::holes::{Holes, Next};
use crate::cycles::thread_passes::Passes;
use crate::state::auxiliary::Spindle;
use crate::state::cycle::Cycle;

/// Positions that a block reaches.
pub type ToCome = Vec<PerAxis<f64>, 8>;

/// Words that hold from hole to hole, until another plane or a motion code that is no cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Series {
    /// Plane in which the series began.
    pub plane: Plane,
    /// Machine position of the drilling axis at the beginning of the series, mm.
    pub initial: f64,
    /// Z in the plane of X and Y, mm: a position after G90, a distance from R after G91.
    pub depth: Option<f64>,
    /// R word, mm: a position or a distance, like the depth.
    pub retract: Option<f64>,
    /// Depth of a peck, Q word, mm.
    pub peck: Option<f64>,
    /// Dwell at the bottom, P word.
    pub dwell: Option<Micros>,
}

/// State of a program's cycles, with the block that is being drilled.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cycles {
    series: Series,
    /// Whether part of the block remains.
    has_more: bool,
    /// Whether the last block was a cycle's and none of its actions has been taken.
    is_first: bool,
    /// Series before that block.
    before: Series,
    /// Current block, and its next action.
    block: Option<(Block, Next)>,
    /// Number of blocks begun.
    begun: u32,
}

/// Hole that the operator draws the tool out of, with the rest of its block (G88). Meanwhile the operator may
/// have the machine do anything but drill.
#[derive(Clone, Debug)]
pub struct LeftHole {
    series: Series,
    cycle: Cycle,
    /// Number of blocks begun, including the block of this hole.
    begun: u32,
}

impl LeftHole {
    /// Returns the cycle of the hole.
    pub(crate) const fn cycle(&self) -> Cycle {
        self.cycle
    }
}

/// Source of a block's actions.
#[derive(Clone, Debug)]
enum Block {
    Holes(Holes),
    Passes(Passes),
}

impl Block {
    fn next(&mut self) -> Option<Next> {
        match self {
            Self::Holes(holes) => holes.next(),
            Self::Passes(passes) => passes.next().map(Next::Action),
        }
    }

    fn reach(&self) -> Vec<PerAxis<f64>, 7> {
        match self {
            Self::Holes(holes) => holes.reach(),
            Self::Passes(passes) => passes.reach(),
        }
    }
}

impl Cycles {
    /// Returns the words that hold from hole to hole.
    pub(crate) const fn series(&self) -> &Series {
        &self.series
    }

    /// Replaces the words that hold from hole to hole.
    pub(crate) const fn set_series(&mut self, series: Series) {
        self.series = series;
    }

    /// Begins a block of holes and replaces the series. Returns the first action; `None` when nothing moves.
    pub(crate) fn begin(&mut self, series: Series, holes: Holes) -> Option<Action<'static>> {
        self.before = core::mem::replace(&mut self.series, series);
        self.is_first = true;
        self.begin_block(Block::Holes(holes))
    }

    /// Begins a block that cuts a thread. Returns the first action.
    pub(crate) fn begin_thread(&mut self, passes: Passes) -> Option<Action<'static>> {
        self.begin_block(Block::Passes(passes))
    }

    fn begin_block(&mut self, mut block: Block) -> Option<Action<'static>> {
        let first = block.next();
        let next = block.next();
        self.begun = self.begun.wrapping_add(1);
        self.block = next.map(|next| (block, next));
        self.has_more = self.block.is_some();
        match first {
            Some(Next::Action(action)) => Some(action),
            // A hole is cut, or waited in, before the spindle turns otherwise.
            Some(Next::Turn(_)) | None => None,
        }
    }

    /// Stops the block while the operator draws the tool out of the hole.
    pub(crate) const fn leave_hole(&mut self, cycle: Cycle) -> LeftHole {
        self.stop();
        LeftHole { series: self.series, cycle, begun: self.begun }
    }

    /// Goes on from the machine's position after the operator has drawn the tool out. Returns false when the
    /// operator has drilled other holes meanwhile.
    pub(crate) fn return_to(&mut self, left: &LeftHole, here: PerAxis<f64>) -> bool {
        let Some((Block::Holes(holes), next)) = self.block.as_mut().filter(|_| left.begun == self.begun) else {
            return false;
        };
        holes.drawn_out(here);
        self.series = left.series;
        if let Some(first) = holes.next() {
            *next = first;
            self.has_more = true;
        }
        true
    }

    /// Returns the direction that the spindle needs before the rest of the block.
    pub(crate) fn turning(&self) -> Option<Spindle> {
        match self.block {
            Some((_, Next::Turn(spindle))) if self.has_more => Some(spindle),
            _ => None,
        }
    }

    /// Drops the rest of a block.
    pub(crate) const fn stop(&mut self) {
        // Every line of a program calls this function, so the block itself stays in place.
        self.has_more = false;
        self.is_first = false;
    }

    /// Whether no part of a block remains.
    pub(crate) const fn is_done(&self) -> bool {
        !self.has_more
    }

    /// Returns the next action of the block, after the machine has taken the previous one.
    pub(crate) fn next(&mut self) -> Option<Next> {
        let (block, next) = self.block.as_mut().filter(|_| self.has_more)?;
        let now = *next;
        self.is_first = false;
        match block.next() {
            Some(behind) => *next = behind,
            None => self.has_more = false,
        }
        Some(now)
    }

    /// Drops the block because the last action was refused. If no action was taken before, the series is
    /// restored, too.
    pub(crate) const fn take_back(&mut self) {
        if self.is_first {
            self.series = self.before;
        }
        self.stop();
    }

    /// Returns positions, in order, whose path bounds everything that remains behind the last action.
    pub(crate) fn to_come(&self) -> ToCome {
        let mut places = ToCome::new();
        if let Some((block, next)) = self.block.as_ref().filter(|_| self.has_more) {
            if let Next::Action(Action::Move(request)) = next {
                places.extend([request.target]);
            }
            places.extend(block.reach());
        }
        places
    }
}

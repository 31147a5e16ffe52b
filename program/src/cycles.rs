//! The canned cycles of a program: the words that hold from hole to hole, and the block that is being
//! drilled.

use heapless::Vec;
use units::{Micros, PerAxis, Plane};

use crate::action::Action;
use crate::holes::Holes;
use crate::passes::Passes;

/// Places that a block reaches.
pub type ToCome = Vec<PerAxis<f64>, 8>;

/// What holds from hole to hole, until a motion code that is no cycle or another plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Series {
    /// The plane it was begun in.
    pub plane: Plane,
    /// Where the drilling axis was at its beginning, machine position in mm.
    pub initial: f64,
    /// Z in the plane of X and Y: a place, or a distance from R, as G90 and G91 say, mm.
    pub depth: Option<f64>,
    /// R, in the same way.
    pub retract: Option<f64>,
    /// Q, mm.
    pub peck: Option<f64>,
    /// P.
    pub dwell: Option<Micros>,
}

/// The cycles of a program, and the block of one that is being drilled.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cycles {
    series: Series,
    /// Something of the block is still to come.
    has_more: bool,
    /// The last block was one of a cycle, and nothing of it has been taken yet.
    is_first: bool,
    /// The series as it was before that block.
    before: Series,
    /// The block, and what of it comes behind the action that was given last.
    block: Option<(Block, Action<'static>)>,
}

/// What a block of a cycle makes.
#[derive(Clone, Debug)]
enum Block {
    Holes(Holes),
    Passes(Passes),
}

impl Block {
    fn next(&mut self) -> Option<Action<'static>> {
        match self {
            Self::Holes(holes) => holes.next(),
            Self::Passes(passes) => passes.next(),
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
    /// What holds.
    pub(crate) const fn series(&self) -> &Series {
        &self.series
    }

    /// This holds from now on.
    pub(crate) const fn set_series(&mut self, series: Series) {
        self.series = series;
    }

    /// Drills these holes, and from now on the series is this one. The first action; none when nothing moves.
    pub(crate) fn begin(&mut self, series: Series, holes: Holes) -> Option<Action<'static>> {
        self.before = core::mem::replace(&mut self.series, series);
        self.is_first = true;
        self.begin_block(Block::Holes(holes))
    }

    /// Cuts this thread. The first action.
    pub(crate) fn begin_thread(&mut self, passes: Passes) -> Option<Action<'static>> {
        self.begin_block(Block::Passes(passes))
    }

    fn begin_block(&mut self, mut block: Block) -> Option<Action<'static>> {
        let first = block.next();
        let next = block.next();
        self.block = next.map(|next| (block, next));
        self.has_more = self.block.is_some();
        first
    }

    /// What is left of a block is forgotten.
    pub(crate) const fn stop(&mut self) {
        // Every line of a program does this: so no more than that.
        self.has_more = false;
        self.is_first = false;
    }

    /// Nothing is left of a block.
    pub(crate) const fn is_done(&self) -> bool {
        !self.has_more
    }

    /// The next action of the block: what was given before it has been taken.
    pub(crate) fn next(&mut self) -> Option<Action<'static>> {
        let (block, next) = self.block.as_mut().filter(|_| self.has_more)?;
        let action = *next;
        self.is_first = false;
        match block.next() {
            Some(behind) => *next = behind,
            None => self.has_more = false,
        }
        Some(action)
    }

    /// The action given last was refused, and nothing of the block goes on. When it was the first one, the
    /// series is what it was before.
    pub(crate) const fn take_back(&mut self) {
        if self.is_first {
            self.series = self.before;
        }
        self.stop();
    }

    /// Places, in order, between which all lies that is still to be done behind the action given last.
    pub(crate) fn to_come(&self) -> ToCome {
        let mut places = ToCome::new();
        if let Some((block, next)) = self.block.as_ref().filter(|_| self.has_more) {
            if let Action::Move(request) = next {
                places.extend([request.target]);
            }
            places.extend(block.reach());
        }
        places
    }
}

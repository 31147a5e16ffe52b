//! The canned cycles of a program: the words that hold from hole to hole, and the block that is being
//! drilled.

use heapless::Vec;
use units::{Micros, PerAxis, Plane};

use crate::action::Action;
use crate::auxiliary::Spindle;
use crate::cycle::Cycle;
use crate::holes::{Holes, Next};
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
    block: Option<(Block, Next)>,
    /// Blocks that were begun.
    begun: u32,
}

/// A hole that the operator draws the tool out of, and what follows it (G88). Meanwhile he may have the
/// machine do anything but drill.
#[derive(Clone, Debug)]
pub struct LeftHole {
    series: Series,
    cycle: Cycle,
    /// Blocks that were begun, its own the last one.
    begun: u32,
}

impl LeftHole {
    /// The cycle that it is a hole of.
    pub(crate) const fn cycle(&self) -> Cycle {
        self.cycle
    }
}

/// What a block of a cycle makes.
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
        self.begun = self.begun.wrapping_add(1);
        self.block = next.map(|next| (block, next));
        self.has_more = self.block.is_some();
        match first {
            Some(Next::Action(action)) => Some(action),
            // Before the spindle turns otherwise a hole is cut, or waited in.
            Some(Next::Turn(_)) | None => None,
        }
    }

    /// The operator draws the tool out of the hole: nothing of the block goes on until then.
    pub(crate) const fn leave_hole(&mut self, cycle: Cycle) -> LeftHole {
        self.stop();
        LeftHole { series: self.series, cycle, begun: self.begun }
    }

    /// He has, and the machine is here now. False when he has drilled other holes meanwhile.
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

    /// How the spindle is to turn before anything else of the block.
    pub(crate) fn turning(&self) -> Option<Spindle> {
        match self.block {
            Some((_, Next::Turn(spindle))) if self.has_more => Some(spindle),
            _ => None,
        }
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

    /// What comes next of the block: what was given before it has been taken.
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
            if let Next::Action(Action::Move(request)) = next {
                places.extend([request.target]);
            }
            places.extend(block.reach());
        }
        places
    }
}

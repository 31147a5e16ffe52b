//! The path that the motors have made, for whoever draws it.

use units::{Axis, PerAxis};

use super::Motion;
use crate::{move_ends::MoveEnd, moves::Mode, run::Run};

impl Motion {
    /// Has ends of moves noted from now on, or no more. Notes that wait are dropped by a change.
    pub fn watch_path(&mut self, is_watched: bool) {
        self.timeline.ends.watch(is_watched);
    }

    /// Begins a new path, as a job does: where it begins is told with its first move.
    pub fn begin_path(&mut self) {
        self.timeline.ends.restart();
    }

    /// Takes the oldest end of a move that the motors have made since moves are watched.
    pub fn take_end_of_move(&mut self) -> Option<MoveEnd> {
        self.timeline.take_end()
    }

    /// Returns the place of the cursor where a curve is being made, whose end says little of its way: at most
    /// 1.5 ms ahead of the motors. None while an end before it waits to be reached.
    #[must_use]
    pub fn place_on_curve(&self) -> Option<MoveEnd> {
        let run = self.run.as_ref().filter(|run| run.block.curved)?;
        let is_made = self.timeline.is_under_way(self.planner.released().wrapping_sub(1));
        is_made.then(|| MoveEnd { at: place(&run.point()), ..end_of(run).1 })
    }
}

fn place(point: &PerAxis<f64>) -> [f32; 3] {
    Axis::PRIMARY.map(|axis| point[axis] as f32)
}

/// Returns where a block begins, and its end.
#[inline(never)]
pub(super) fn end_of(run: &Run) -> ([f32; 3], MoveEnd) {
    let (origin, target) = (&run.path.origin, &run.block.target);
    let extrudes = origin.0.iter().zip(&target.0).skip(Axis::PRIMARY.len()).any(|(from, to)| to > from);
    (place(origin), MoveEnd { at: place(target), is_work: run.block.mode == Mode::Feed, extrudes })
}

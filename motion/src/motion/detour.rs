//! Leaving out moves that wait, and going another way to those behind them.
//!
//! A detour is made behind a [`Motion::hold`], once the motors stand: the rest of the move under way and the
//! first blocks that wait are dropped, and the blocks of a new way are put in front of the others, which stay
//! as they are. The first of the others is entered from rest.

use units::PerAxis;

use super::{Motion, State};
use crate::{
    moves::{Corner, Move, Part, Refusal},
    path::Curve,
    planner::MOST_OF_DETOUR,
};

/// A move that waits, or what is left of the one that was under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waiting {
    /// The move as it was asked for. Of a curve only the end.
    pub request: Move,
    /// Whether the move is straight.
    pub is_straight: bool,
}

impl Motion {
    /// Returns whether a hold is in force and the motors have come to rest, with a laser off.
    #[must_use]
    pub fn is_held_still(&self) -> bool {
        self.state == State::Held && self.filters.drained && self.report.drained && self.laser.is_quiet()
    }

    /// Returns the place where a hold has come to rest, or otherwise the place of the trajectory.
    #[must_use]
    pub fn held_at(&self) -> PerAxis<f64> {
        self.run.as_ref().map_or(self.place, crate::run::Run::point)
    }

    /// Returns the moves left to be made, in order: the rest of the move under way, if one is, and those that
    /// wait.
    pub fn waiting(&self) -> impl Iterator<Item = Waiting> {
        let under_way = self.run.as_ref().map(|run| &run.block);
        let behind = (0..self.planner.len()).map_while(|index| self.planner.ahead(index));
        under_way.into_iter().chain(behind).map(|block| {
            let request = Move {
                target: block.target,
                feed_rate: units::MmPerSecond(block.requested),
                mode: block.mode,
                power: block.power,
                curve: Curve::Line,
                corner: Corner::Sharp,
                tag: block.tag,
                part: block.part,
            };
            Waiting { request, is_straight: !block.curved }
        })
    }

    /// Returns the part of the move under way, or of the next one while none is; `None` when nothing waits.
    #[must_use]
    pub fn part_now(&self) -> Option<Part> {
        self.run.as_ref().map(|run| &run.block).or_else(|| self.planner.front()).map(|block| block.part)
    }

    /// Drops the first `dropped` moves of [`Self::waiting`] behind a hold, declares that the machine stands
    /// at `here`, and goes along `way` to the beginning of the next waiting move, which must exist.
    ///
    /// # Errors
    /// [`Refusal::Busy`] unless it [`is_held_still`](Self::is_held_still), [`Refusal::Full`] for a way
    /// that is too long; nothing was changed then. After any other refusal of the way everything that waits
    /// has been dropped, as by [`Self::stop`].
    pub fn go_round(&mut self, dropped: usize, here: PerAxis<f64>, way: &[Move]) -> Result<(), Refusal> {
        let config = self.config.as_ref().ok_or(Refusal::NotConfigured)?;
        let rest_sq = config.limits.minimum_speed.get() * config.limits.minimum_speed.get();
        if !self.is_held_still() {
            return Err(Refusal::Busy);
        }
        let of_queue = dropped.saturating_sub(usize::from(self.run.is_some())).min(self.planner.len());
        if way.len() > MOST_OF_DETOUR || !self.planner.has_room_before() {
            return Err(Refusal::Full);
        }
        let curved = (0..of_queue).filter(|index| self.planner.ahead(*index).is_some_and(|block| block.curved)).count();
        for _ in 0..curved {
            let _dropped = self.curves.pop();
        }
        self.run = None;
        let (planned, last) = (self.planned, self.last);
        let behind = self.planner.open(of_queue);
        self.laser.growth.moves = 0;
        self.settle_at(here);
        let taken = way.iter().try_for_each(|request| {
            self.laser.growth.moves = 0;
            self.accept(request, MOST_OF_DETOUR)
        });
        self.end_growth();
        self.planner.close(&behind, rest_sq);
        self.laser.skip_levels(self.planner.released(), behind.first);
        if let Err(refusal) = taken {
            self.stop();
            return Err(refusal);
        }
        if !behind.is_empty() {
            (self.planned, self.last) = (planned, last);
        }
        // Blocks behind the way begin from rest, so later blocks change nothing there.
        if (self.flushed.wrapping_sub(behind.first) as i32) < 0 {
            self.flushed = behind.first;
        }
        self.timeline.enter_anew(self.planner.released());
        let cruise = self.planner.front().map_or(0.0, |front| front.cruise(&self.overrides));
        self.planner.replan(cruise, &self.overrides);
        Ok(())
    }
}

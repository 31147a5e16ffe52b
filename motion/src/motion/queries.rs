//! Queries to the motion object: state, positions, speeds, limits and counters.

use units::{Axis, MmPerSecond, PerActuator, PerAxis, StepCount};

use super::{Counters, Motion, State};
use crate::{
    filters::FilterConfig,
    knots::point_of_steps,
    planner::Block,
    timeline::Passed,
    trajectory::{Piece, TakenBack},
    trigger::Trigger,
};

impl Motion {
    /// Returns the state of the motion object.
    #[must_use]
    pub const fn state(&self) -> State {
        self.state
    }

    /// Blocks that wait in the look-ahead queue, and how many fit.
    #[must_use]
    pub fn queue_level(&self) -> (usize, usize) {
        (self.planner.len(), self.config.as_ref().map_or(0, |config| config.queue_size))
    }

    /// Whether the next move has to wait for room.
    #[must_use]
    pub fn is_full(&self) -> bool {
        let (used, size) = self.queue_level();
        used + usize::from(self.wants_two) >= size || self.curves.is_full() || self.has_full_levels()
    }

    /// Returns the end of the last accepted move.
    #[must_use]
    pub const fn commanded_position(&self) -> PerAxis<f64> {
        self.planned
    }

    /// Step counts that the motors have played, as of the feed's last look (every 16 ms; exact when idle).
    #[must_use]
    pub const fn steps(&self) -> PerActuator<StepCount> {
        self.report.played
    }

    /// Returns each motor's steps made since the beginning, forward less backward, when it had this count:
    /// declaring a position changes the count but not the steps made. Wraps around.
    #[must_use]
    pub fn steps_made(&self, at: &PerActuator<StepCount>) -> PerActuator<StepCount> {
        let made = at.0.into_iter().zip(self.set_back.0).map(|(count, set_back)| count.wrapping_add(set_back));
        let mut steps = PerActuator::default();
        steps.0.iter_mut().zip(made).for_each(|(slot, made)| *slot = made);
        steps
    }

    /// Machine position of the motors, from [`Self::steps`].
    #[must_use]
    pub fn live_position(&self) -> PerAxis<f64> {
        self.position_of_steps(&self.report.played)
    }

    /// Machine position of the program where the motors have these step counts, as in a [`Trigger`].
    #[must_use]
    pub fn position_of_steps(&self, steps: &PerActuator<StepCount>) -> PerAxis<f64> {
        self.config.as_ref().map_or(self.place, |config| self.compensation.program(&point_of_steps(config, steps)))
    }

    /// Returns the tag of the move that the motors are making, and the last mark they have reached, as of the
    /// feed's last run.
    #[must_use]
    pub const fn passed(&self) -> Passed {
        self.passed
    }

    /// Path speed at the cursor, 1.5 ms at most and the filters' latency ahead of the motors.
    #[must_use]
    pub fn speed(&self) -> MmPerSecond {
        MmPerSecond(self.run.as_ref().map_or(0.0, |run| run.speed))
    }

    /// Speed of each motor at the cursor, mm/s of its own, before any filter; `None` where nothing moves.
    #[must_use]
    pub fn motor_speeds(&self) -> Option<PerActuator<f64>> {
        let run = self.run.as_ref()?;
        let mut speeds = run.rates?;
        speeds.0.iter_mut().for_each(|rate| *rate *= run.speed);
        Some(speeds)
    }

    /// The block the cursor is in.
    #[must_use]
    pub fn current_block(&self) -> Option<&Block> {
        self.run.as_ref().map(|run| &run.block)
    }

    /// The least and the greatest place of an axis that it may come to within so many seconds, as far as
    /// moves have been accepted: those of the motors now, of the block the cursor is in, and of the blocks
    /// that may have begun by then. No block takes less time than its length at the speed that was asked for,
    /// so none is left out. Visits those blocks.
    #[must_use]
    pub fn range_ahead(&self, axis: Axis, seconds: f64) -> [f64; 2] {
        let here = self.live_position()[axis];
        let wider = |[least, most]: [f64; 2], place: f64| [least.min(place), most.max(place)];
        let (mut range, mut time) = ([here; 2], 0.0);
        if let Some(run) = &self.run {
            range = wider(range, run.block.target[axis]);
            time = (run.block.length - run.travelled) / run.block.cruise(&self.overrides());
        }
        for block in (0..self.planner.len()).map_while(|index| self.planner.ahead(index)) {
            if time > seconds {
                break;
            }
            range = wider(range, block.target[axis]);
            time += block.length / block.cruise(&self.overrides());
        }
        range
    }

    /// The piece of ideal trajectory that the last segment taken belongs to, for whoever checks step times.
    #[must_use]
    pub const fn last_piece(&self) -> Option<&Piece> {
        self.piece.as_ref()
    }

    /// The last time that trajectory was taken back, for whoever checks step times.
    #[must_use]
    pub const fn last_taken_back(&self) -> Option<&TakenBack> {
        self.taken_back.as_ref()
    }

    /// The filters that the last segment taken went through: none while they are bypassed.
    #[must_use]
    pub fn filters_in_force(&self) -> FilterConfig {
        match &self.config {
            Some(config) if self.filters.engaged() => config.filters,
            _ => FilterConfig::NONE,
        }
    }

    /// The trigger that stopped the motion, once.
    pub fn take_trigger(&mut self) -> Option<Trigger> {
        self.trigger.take()
    }

    /// Returns the counts of faults so far.
    #[must_use]
    pub fn counters(&self) -> Counters {
        Counters { swallowed: self.laser.at.swallowed, ..self.counters }
    }
}

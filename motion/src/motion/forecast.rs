//! Forecast of the duration of moves, without making a step of them.
//!
//! A second motion object, to which nobody hangs a feed, is given the same moves; instead of slice by slice
//! its blocks are passed whole. Look-ahead, limits, curves, rounded corners and profiles are those of the
//! object that moves, because they are the same code; so a block takes here what it takes there, as long as
//! the sender of moves keeps up. The additional time at each standstill is in [`Motion::settling`]. Input
//! shapers and pressure advance delay every axis alike and change no duration: here there are none.

use units::{MmPerSecond, Ticks};

use super::{Motion, State};
use crate::{
    config::MotionConfig, feed_schedule::START_BY_PERIOD, filters::FilterConfig, moves::Refusal, path::Path,
    planner::Block, run::Passage,
};

/// No time passes while blocks are passed.
const NOW: Ticks = Ticks(0);
/// Time between the last step and its report, seconds: two runs of the feed.
const REPORTED_SECONDS: f64 = 0.001;
/// Profiles of one block at most; a bound for what rounding could do.
const MOST_PROFILES: u32 = 64;

impl Motion {
    /// Set up as `other` is, to pass blocks: the same limits, overrides as programmed, no filters.
    ///
    /// # Errors
    /// Not that anybody knows: `other` was set up with the same.
    pub fn configure_to_pass(&mut self, other: &MotionConfig) -> Result<(), crate::ConfigError> {
        self.abort();
        let _orders = self.feed_orders();
        self.state = State::Running;
        self.set_overrides(1.0, 1.0);
        self.configure(MotionConfig { filters: FilterConfig::NONE, ..*other })
    }

    /// Set up as `other` is now, to pass blocks: limits, factors, compensation and position.
    ///
    /// # Errors
    /// [`Refusal::NotConfigured`] when `other` is not.
    pub fn pass_as(&mut self, other: &Self) -> Result<(), Refusal> {
        let config = other.config.as_ref().ok_or(Refusal::NotConfigured)?;
        self.configure_to_pass(config).map_err(|_| Refusal::NotConfigured)?;
        self.compensation.copy(&other.compensation);
        self.settle_at(other.planned);
        let _orders = self.feed_orders();
        self.set_overrides(other.overrides.feed, other.overrides.rapid);
        Ok(())
    }

    /// Passes the next block. `None`: what follows depends on what is submitted next, or nothing waits.
    ///
    /// Only for an object without a feed.
    pub fn pass_block(&mut self) -> Option<Passage> {
        self.enter_next()?;
        let mut passage = self.run.as_ref().map(|run| Passage {
            tag: run.block.tag,
            mode: run.block.mode,
            length: run.block.length,
            requested: MmPerSecond(run.block.requested),
            limit: MmPerSecond(run.block.speed_limit),
            peak: run.speed,
            ..Passage::default()
        })?;
        for _ in 0..MOST_PROFILES {
            let Some(run) = &mut self.run else { break };
            run.pass(&mut passage);
            if run.is_over() {
                break;
            }
            // A jerk-limited plan may end before its block does.
            self.follow_plan();
        }
        Some(passage)
    }

    /// The way of the block passed last, and its length, mm.
    #[must_use]
    pub fn passed_path(&self) -> Option<(&Path, f64)> {
        self.run.as_ref().map(|run| (&run.path, run.block.length))
    }

    /// Blocks submitted so far, wrapping.
    #[must_use]
    pub const fn submitted(&self) -> u32 {
        self.planner.pushed()
    }

    /// The blocks submitted since [`Self::submitted`] was `since`, while they wait.
    pub fn submitted_since(&self, since: u32) -> impl Iterator<Item = &Block> {
        let count = self.planner.pushed().wrapping_sub(since);
        (0..count).filter_map(move |number| self.planner.any_block(since.wrapping_add(number)))
    }

    /// Returns the additional time of a standstill after the moves before it, seconds: until the last step is
    /// made and known to be, and the next move begins. `config` is that of the object that moves.
    #[must_use]
    pub fn settling(config: &MotionConfig) -> f64 {
        config.filters.latency() + START_BY_PERIOD.nanoseconds() as f64 * 1e-9 + REPORTED_SECONDS
    }

    /// The block that may be begun now.
    fn enter_next(&mut self) -> Option<()> {
        let Some(run) = &self.run else { return self.begin_from_rest(NOW) };
        let (speed, carried, point) = (run.speed, run.ramp(), run.point());
        if !self.planner.is_empty() && !self.may_release(NOW) {
            return None;
        }
        self.place = point;
        self.run = None;
        self.begin_next(speed, carried, NOW)
    }
}

//! Taking back trajectory that runs ahead of the motors, so that a hold, a stop or an override is felt at
//! once.
//!
//! With filters on, the trajectory's head is up to the latency ahead of what an axis does. A new plan from
//! the head would be felt that much later; so the head goes back to the earliest place of which no moving
//! axis has used anything yet ([`crate::filters`]). Blocks begun since then wait again, in the places they
//! have not left ([`crate::planner`]), their curves too. The feed then settles the trajectory anew as far as
//! it was before it puts out any more.
//!
//! An axis that stood still over the part it used must do so again. A hold or a stop in trapezoids is nowhere
//! faster than what it replaces, so it comes no farther along the path. Other changes may come farther: they
//! must not reach the axis' next way in time however fast they are, or must surely rest before, else less is
//! taken back.

use units::{Axis, MAX_AXES, PerAxis};

use super::Motion;
use crate::{
    filters::{Place, Source, is_before, moves},
    least,
    path::{Curve, Path},
    planner::{Block, ROUNDING},
    ramp::Ramp,
    run::Run,
    trajectory::{TakenBack, TickTime, seconds_of},
};

/// Pace of the new plan, compared with the trajectory taken back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pace {
    /// The new plan brakes as hard as it may.
    Slower,
    /// Nothing is known of the new plan's speeds.
    Any,
}

impl Motion {
    /// Takes back as much of the trajectory as a new plan may replace. The caller plans anew, in the same
    /// breath.
    pub(super) fn take_back(&mut self, pace: Pace) {
        if !self.filters.engaged() || self.filters.drained {
            return;
        }
        if let Some(place) = self.place_to_begin(pace) {
            self.begin_again(&place);
        }
    }

    /// Whether the trajectory that was taken back has not been replaced yet.
    pub(super) fn is_behind(&self) -> bool {
        self.filters.engaged() && self.clock < self.filters.out
    }

    fn place_to_begin(&self, pace: Pace) -> Option<Place> {
        let head = self.clock.to_bits() as u64;
        let mut careful = [false; MAX_AXES];
        // Ends: each turn is careful about one more axis.
        loop {
            let from = self.filters.unused_from(head, careful);
            let place = self.filters.place_from(from, head, |source, travelled| self.is_kept(source, travelled))?;
            let Some(axis) = self.disturbed(&place, pace) else { return Some(place) };
            *careful.get_mut(axis).filter(|careful| !**careful)? = true;
        }
    }

    /// Whether the block can be begun again, and the blocks behind it too.
    fn is_kept(&self, source: &Source, travelled: f64) -> bool {
        let behind = self.curves_behind(source.block);
        self.planner.released_block(source.block).is_some_and(|block| travelled < block.length)
            && self.curves.keeps(behind)
            && self.laser.keeps(source.block)
    }

    /// Returns the number of curved blocks among those released behind this one.
    fn curves_behind(&self, block: u32) -> u32 {
        let behind = self.planner.released().wrapping_sub(block).wrapping_sub(1).min(crate::config::MOST_BLOCKS as u32);
        let curved = |n: &u32| self.planner.any_block(block.wrapping_add(1 + n)).is_some_and(|block| block.curved);
        (0..behind).filter(curved).count() as u32
    }

    /// Returns the first axis that stood still over the trajectory it has used from this place on, and might
    /// not any more.
    fn disturbed(&self, place: &Place, pace: Pace) -> Option<usize> {
        let block = self.planner.released_block(place.source.block)?;
        let rests = pace == Pace::Slower && place.travelled + rest_length(place, block) <= block.length + ROUNDING;
        let fastest = match (pace, place.ramp()) {
            (Pace::Slower, _) if block.jerk == 0.0 => return None,
            // A ramp up cannot be ended at once.
            (Pace::Slower, Some((ramp, elapsed))) if ramp.rises() => ramp.soonest(elapsed),
            (Pace::Slower, _) => place.speed,
            (Pace::Any, _) => f64::INFINITY,
        };
        let used = self.filters.used_until();
        let is_disturbed = |axis: &usize| {
            let used = used.get(*axis).copied().unwrap_or(place.time);
            if !is_before(place.time, used) || self.filters.is_advanced(*axis) {
                return false;
            }
            let rests_before = rests && moves(&place.path).get(*axis) == Some(&false);
            let seconds = seconds_of(used.wrapping_sub(place.time));
            !rests_before && !self.stays(*axis, place, fastest, pace, seconds)
        };
        (0..MAX_AXES).find(is_disturbed)
    }

    /// Whether an axis cannot begin to move within `seconds` from a place, no block being passed faster than
    /// `fastest`.
    fn stays(&self, axis: usize, place: &Place, fastest: f64, pace: Pace, seconds: f64) -> bool {
        let moves = |path: &Path| moves(path).get(axis) == Some(&true);
        let mut left = seconds;
        let mut count = place.source.block;
        let Some(mut block) = self.planner.any_block(count) else { return false };
        let (mut length, mut is_moved) = (block.length - place.travelled, moves(&place.path));
        loop {
            if is_moved {
                return false;
            }
            left -= length / least(fastest, block.speed_limit);
            if left < 0.0 {
                return true;
            }
            count = count.wrapping_add(1);
            let Some(next) = self.planner.any_block(count) else {
                // More blocks may come before the motion gets there; but a braking plan rests by then.
                return pace == Pace::Slower;
            };
            (length, is_moved) = (next.length, moves_axis(axis, &block.target, next));
            block = next;
        }
    }

    /// Moves the cursor back to the place.
    fn begin_again(&mut self, place: &Place) {
        let source = &place.source;
        let Some(block) = self.planner.released_block(source.block).copied() else { return };
        let released = self.planner.released();
        self.curves.take_back(self.curves_behind(source.block));
        self.planner.take_back(source.block);
        // The blocks taken back were released once, so they may be released again although the queue is not
        // full.
        if self.flushed.wrapping_sub(released) as i32 <= 0 {
            self.flushed = released;
        }
        // A block that is executed again does not grow, and is not shortened any more for a rounded corner.
        if self.laser.growth.block == source.block {
            self.laser.growth.moves = 0;
        }
        if let Some(last) = &mut self.last {
            last.line = None;
        }
        let back = (self.clock.to_bits() as u64).wrapping_sub(place.time);
        self.clock = self.clock.saturating_sub(TickTime::from_bits(u128::from(back)));
        self.run = Some(Run::within(block, place.path, place.travelled, self.clock, place.speed, place.ramp()));
        self.laser.take_back(place.time);
        self.laser.run_block(source.block, block.power.level, place.travelled);
        if self.planner.keeps_cruise_ratio() {
            self.peak_sq = self.planner.cruise_peak_sq(source.block).unwrap_or(self.peak_sq);
        }
        self.resting = false;
        self.piece = None;
        self.filters.take_back(place);
        self.timeline.take_back(self.clock);
        self.planner.replan(block.cruise(&self.overrides), &self.overrides);
        let count = self.taken_back.map_or(0, |taken| taken.count);
        let (count, from, out) = (count.wrapping_add(1), self.clock, self.filters.out);
        self.taken_back = Some(TakenBack { count, from, out });
    }
}

/// Returns the distance from a place to rest by [`crate::jerk_limited`], if rest is within the block.
fn rest_length(place: &Place, block: &Block) -> f64 {
    let own = block.bounds();
    let Some((ramp, elapsed)) = place.ramp() else { return own.length(place.speed, 0.0) };
    let ramp = if ramp.bounds != own || ramp.is_closing(elapsed) {
        ramp
    } else if ramp.rises() {
        Ramp::new(ramp.from, ramp.soonest(elapsed), own)
    } else {
        Ramp::new(ramp.from, 0.0, own)
    };
    ramp.length() - ramp.distance(elapsed) + own.length(ramp.to, 0.0)
}

/// Whether a block that begins there moves an axis. Of a curve only what it does at its ends is looked at
/// here, and it counts for all that it may bend.
fn moves_axis(axis: usize, from: &PerAxis<f64>, block: &Block) -> bool {
    let line = Path::new(*from, &block.target, block.length, Curve::Line);
    moves(&line).get(axis) == Some(&true) || (block.curved && axis < Axis::PRIMARY.len())
}

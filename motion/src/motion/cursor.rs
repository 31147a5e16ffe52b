//! The cursor moves along the trajectory, slice by slice, and segments are made of the slices.

use units::{PerActuator, StepPosition, Ticks};

use super::{Motion, State, path_made::end_of};
use crate::{
    compensation::{Compensation, Warped},
    config::MotionConfig,
    feed_schedule::{Lead, Window},
    knots::{Segment, Span, step_positions_after},
    least,
    path::Curve,
    planner::Block,
    ramp::Ramp,
    run::{Run, Slice},
    trajectory::{at_tick, whole_ticks},
};

impl Motion {
    /// The next slice of trajectory; it begins at the clock. `None`: there is none now, or it would end too
    /// late.
    pub(super) fn next_slice(&mut self, window: &Window) -> Option<Slice> {
        let now = window.now;
        // Ends: each turn of the loop consumes a block or returns.
        loop {
            if self.run.is_none() {
                self.begin_from_rest(now)?;
            }
            if self.resting && self.state == State::Running {
                if window.is_bounded() {
                    // Under a bounded window the start would be fixed now, and the slice might be taken too
                    // late for it.
                    return None;
                }
                self.start_clock(window.start);
            }
            let longest = self.lead().longest_segment_seconds();
            let run = self.run.as_mut()?;
            if let Some(piece) = run.new_piece() {
                self.piece = Some(piece);
                // Asked for when trajectory is taken back only.
                self.piece_ramp = if self.filters.engaged() { run.ramp() } else { None };
            }
            let block = self.planner.released().wrapping_sub(1);
            if !self.timeline.has_begun(block) {
                self.timeline.begin(block, run.block.tag, self.clock);
                if self.timeline.ends.is_watched() {
                    let (from, end) = end_of(run);
                    self.timeline.ends.begin(block, from, end);
                }
            }
            if let Some(slice) = run.advance(at_tick(window.latest), longest) {
                return Some(slice);
            }
            if run.has_more() {
                return None;
            }
            self.end_of_profile(now)?;
        }
    }

    /// Ends the profile of the running block: standstill, or on to the next block.
    fn end_of_profile(&mut self, now: Ticks) -> Option<()> {
        let run = self.run.as_ref()?;
        let (finished, speed, point) = (run.is_over(), run.speed, run.point());
        match self.state {
            // A way to rest may have more ramps than one profile holds.
            State::Holding | State::Stopping if !finished && speed > 0.0 && self.is_jerk_limited() => {
                self.brake();
                Some(())
            }
            State::Holding if !finished || speed <= 0.0 || self.planner.is_empty() => {
                self.state = State::Held;
                self.resting = true;
                self.place = point;
                if finished {
                    self.run = None;
                }
                None
            }
            State::Held => None,
            State::Stopping if !finished || speed <= 0.0 || self.planner.is_empty() => {
                self.rest_here();
                None
            }
            State::Running if !finished && self.is_jerk_limited() => {
                // A jerk-limited plan may end before its block does.
                self.follow_plan();
                Some(())
            }
            _ => {
                self.place = point;
                let carried = run.ramp();
                self.run = None;
                self.begin_next(speed, carried, now)
            }
        }
    }

    /// Starts the next block at the cursor with this speed.
    pub(super) fn begin_next(&mut self, speed: f64, carried: Option<(Ramp, f64)>, now: Ticks) -> Option<()> {
        self.planner.plan();
        let starved = !self.planner.is_empty() && !self.planner.front_is_settled() && !self.may_release(now);
        if starved && self.state == State::Running {
            self.counters.starved = self.counters.starved.saturating_add(1);
        }
        let Some(block) = self.planner.release() else {
            self.resting = true;
            return None;
        };
        let curve = self.curve_of(&block);
        self.begin_power(&block);
        self.run = Some(Run::new(block, curve, self.place, self.clock, speed, carried));
        match self.state {
            State::Running => self.follow_plan(),
            _ => self.brake(),
        }
        Some(())
    }

    /// Starts the clock after a standstill: motion begins at `start`, a moment ahead of now.
    fn start_clock(&mut self, start: Ticks) {
        self.resting = false;
        let wait = at_tick(start).saturating_sub(self.clock);
        self.clock += wait;
        if let Some(run) = &mut self.run {
            run.shift(wait);
        }
        if self.filters.drained {
            self.filters.settle(self.place, self.clock);
        }
    }

    /// Starts the next block after a standstill.
    pub(super) fn begin_from_rest(&mut self, now: Ticks) -> Option<()> {
        let front = self.planner.front()?;
        if self.state != State::Running || !self.may_release(now) {
            return None;
        }
        let minimum = self.config.as_ref()?.limits.minimum_speed.get();
        let entry = least(minimum, front.cruise(&self.overrides));
        self.planner.plan();
        let block = self.planner.release()?;
        let curve = self.curve_of(&block);
        self.begin_power(&block);
        self.run = Some(Run::new(block, curve, self.place, self.clock, entry, None));
        self.follow_plan();
        Some(())
    }

    /// The curve of the block just released.
    fn curve_of(&mut self, block: &Block) -> Curve {
        if block.curved { self.curves.pop() } else { Curve::Line }
    }

    /// Whether the next block may be released: a plan is only used when its result cannot depend on the
    /// arrival of the next block.
    pub(super) fn may_release(&self, now: Ticks) -> bool {
        let Some(config) = &self.config else { return false };
        let flushed = self.flushed.wrapping_sub(self.planner.released()) as i32 > 0;
        flushed
            || self.planner.len() + usize::from(self.wants_two) >= config.queue_size
            || self.curves.is_full()
            || self.has_full_levels()
            || now.since(self.seen.1) >= config.queue_delay
    }

    /// Turns a slice of trajectory into motor positions and speeds at its ends.
    pub(super) fn segment(&mut self, slice: &Slice, window: &Window, segment: &mut Segment) {
        segment.start = self.clock;
        segment.duration = slice.end.saturating_sub(self.clock);
        if let (Some(config), Some(run)) = (&self.config, &mut self.run) {
            let (ends, entry, exit) = if self.compensation.is_active() {
                compensated(config, &self.compensation, run, slice, &self.knots)
            } else {
                let ends = step_positions_after(config, &slice.point, &self.knots);
                let velocities = |point, s| config.kinematics.velocities(point, &run.path.tangent(s));
                let entry = run.rates.unwrap_or_else(|| velocities(&run.path.origin, 0.0));
                let is_straight = config.kinematics.is_linear() && run.path.curve.is_line();
                (ends, entry, if is_straight { entry } else { velocities(&slice.point, run.travelled) })
            };
            for actuator in units::Actuator::ALL {
                let steps = config.steps_per_mm(actuator);
                segment.motors[actuator] = Span {
                    start: self.knots[actuator],
                    end: ends[actuator],
                    entry: entry[actuator] * steps * slice.seconds * slice.entry,
                    exit: exit[actuator] * steps * slice.seconds * slice.exit,
                };
            }
            run.rates = Some(exit);
            self.knots = ends;
        }
        self.clock = slice.end;
        self.shift_if_late(segment, window);
        self.power_of_slice(slice, segment.start);
    }

    /// Shifts the rest of the trajectory in time when the segment begins in the past and cannot be played.
    pub(super) fn shift_if_late(&mut self, segment: &mut Segment, window: &Window) {
        if whole_ticks(segment.start) >= window.now {
            return;
        }
        self.counters.late = self.counters.late.saturating_add(1);
        let shift = at_tick(window.start).saturating_sub(segment.start);
        segment.start += shift;
        self.clock += shift;
        if let Some(piece) = &mut self.piece {
            piece.start += shift;
        }
        if let Some(run) = &mut self.run {
            run.shift(shift);
        }
        self.filters.shift(shift);
        self.laser.shift(shift);
        self.timeline.shift(segment.start.saturating_sub(shift), shift);
    }

    /// Returns the time that the feed keeps written ahead: a plan must not make the feed late.
    pub(super) fn lead(&self) -> Lead {
        let next = self.run.as_ref().map(|run| &run.block).or(self.planner.front());
        match next {
            Some(block) if block.jerk > 0.0 => Lead::over_plans_of(self.planner.len()),
            _ => Lead::Short,
        }
    }
}

/// Motor positions at the end of a slice, and what each motor does for a millimetre of path at both ends,
/// through the compensation.
#[inline(never)]
fn compensated(
    config: &MotionConfig,
    compensation: &Compensation,
    run: &Run,
    slice: &Slice,
    before: &PerActuator<StepPosition>,
) -> (PerActuator<StepPosition>, PerActuator<f64>, PerActuator<f64>) {
    let rates = |at: &Warped, s| {
        let direction = compensation.along(at, &run.path.tangent(s));
        config.kinematics.velocities(&at.point, &direction)
    };
    let end = compensation.at(&slice.point);
    let entry = run.rates.unwrap_or_else(|| rates(&compensation.at(&run.path.origin), 0.0));
    let is_straight = config.kinematics.is_linear() && run.path.curve.is_line() && compensation.is_linear();
    let exit = if is_straight { entry } else { rates(&end, run.travelled) };
    (step_positions_after(config, &end.point, before), entry, exit)
}

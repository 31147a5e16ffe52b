//! The feed's side of the motion object: the cursor moves along the trajectory, slice by slice.

use units::{PerActuator, StepCount, StepPosition, Ticks};

use super::{Motion, State};
use crate::{
    compensation::{Compensation, Warped},
    config::MotionConfig,
    feed::{FeedOrders, FeedReport, Supply},
    feed_schedule::{Lead, Window},
    greatest,
    knots::{Segment, Span, step_positions_after, steps_per_mm},
    least,
    path::Curve,
    planner::Block,
    profile::Profile,
    ramp::Ramp,
    run::{Run, Slice},
    square_root,
    timeline::Passed,
    trajectory::{at_tick, whole_ticks},
    trigger::Trigger,
};

impl Motion {
    /// The next segment of trajectory, written to `segment`.
    ///
    /// Never inlined: once a slice, it would take registers from the feed's loop over the steps.
    #[inline(never)]
    pub(crate) fn take_segment(&mut self, window: &Window, segment: &mut Segment) -> Supply {
        if self.planner.pushed() != self.seen.0 {
            self.seen = (self.planner.pushed(), window.now);
        }
        if self.filters.bypassed != self.filters.bypass_wanted {
            self.obey_bypass();
        }
        if self.filters.engaged() {
            return self.filtered_segment(window, segment);
        }
        let Some(slice) = self.next_slice(window) else {
            let has_more = self.run.as_ref().is_some_and(Run::has_more);
            return if has_more { Supply::Enough } else { Supply::Nothing };
        };
        self.segment(&slice, window, segment);
        Supply::Segment
    }

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
            || now.since(self.seen.1) >= config.queue_delay
    }

    /// Gives the running block the planned profile from the cursor on.
    pub(super) fn follow_plan(&mut self) {
        if self.is_jerk_limited() {
            return self.follow_jerk_limited();
        }
        let Some(run) = &mut self.run else { return };
        self.planner.plan();
        let (length, acceleration) = (run.remaining(), run.block.acceleration);
        if length <= 0.0 {
            return;
        }
        let (gain_sq, entry_sq) = (2.0 * acceleration * length, run.speed * run.speed);
        let highest_sq = least(self.planner.next_entry_sq(), entry_sq + gain_sq);
        let exit = square_root(greatest(highest_sq, greatest(entry_sq - gain_sq, 0.0)));
        let cruise = run.block.cruise(&self.overrides);
        let (cruise, exit) = if self.planner.keeps_cruise_ratio() {
            self.peak_sq = run.block.cruise_plan().peak_sq().unwrap_or(self.peak_sq);
            let cruise = least(cruise, square_root(self.peak_sq));
            // The exit is no faster than the cruise plan's peak, if the block can brake so far.
            (cruise, greatest(least(exit, cruise), square_root(greatest(entry_sq - gain_sq, 0.0))))
        } else {
            (cruise, exit)
        };
        run.follow(Profile::trapezoid(length, run.speed, cruise, exit, acceleration), self.clock);
    }

    /// Gives the running block a profile that brakes from the cursor on.
    pub(super) fn brake(&mut self) {
        if self.is_jerk_limited() {
            return self.follow_jerk_limited();
        }
        match &mut self.run {
            Some(run) if run.remaining() > 0.0 => {
                let profile = Profile::brake(run.remaining(), run.speed, run.block.acceleration);
                run.follow(profile, self.clock);
            }
            Some(_) => {}
            None => self.rest_here(),
        }
    }

    /// Ends a hold or a stop at rest.
    pub(super) fn rest_here(&mut self) {
        if self.state == State::Holding {
            self.state = State::Held;
            return;
        }
        if let Some(run) = self.run.take() {
            self.place = run.point();
        }
        self.planner.clear();
        self.curves.clear();
        self.timeline.clear(self.planner.pushed());
        self.planned = self.place;
        self.last = None;
        self.resting = true;
        self.state = State::Running;
    }

    /// Turns a slice of trajectory into motor positions and speeds at its ends.
    fn segment(&mut self, slice: &Slice, window: &Window, segment: &mut Segment) {
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
                let steps = steps_per_mm(config, actuator);
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

    /// Takes the orders for the feed's next run.
    pub(crate) fn feed_orders(&mut self) -> FeedOrders {
        let lead = self.lead();
        FeedOrders { searching: self.filters.bypass_wanted, lead, ..core::mem::take(&mut self.orders) }
    }

    /// Takes the feed's report of a run.
    pub(crate) fn feed_reports(&mut self, now: Ticks, report: FeedReport, urgent: bool, squeezed: u32) -> Passed {
        self.report = report;
        self.counters.urgent = self.counters.urgent.saturating_add(u32::from(urgent));
        self.counters.squeezed = self.counters.squeezed.saturating_add(squeezed);
        let rests = self.is_idle();
        self.passed = self.timeline.pass(now, rests, self.planner.pushed());
        self.passed
    }

    /// Stops the motion, as an armed input has fired.
    pub(crate) fn triggered(&mut self, trigger: Trigger) {
        self.trigger = Some(trigger);
        self.stop();
    }

    /// Lets the motors stand at these steps after the queue was cut, and forgets everything else.
    pub(crate) fn resume_from_cut(&mut self, steps: PerActuator<StepCount>) {
        self.abort();
        let (position, set_back) = (self.position_of_steps(&steps), self.set_back);
        self.settle_at(position);
        // Whole steps, not their image through two roundings; and the feed knows them.
        self.knots = PerActuator(steps.0.map(|count| StepPosition::from_bits(i64::from(count) << 24)));
        self.set_back = set_back;
        self.orders.rebase = None;
        self.orders.cut = false;
        self.report.played = steps;
        self.state = State::Running;
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

//! The step feed: takes segments of trajectory, solves them for steps, merges the motors, fills the step
//! queue.
//!
//! The [`FeedSchedule`] sets the run times and the lead over the motors: a shorter lead would let a late run
//! starve the interrupt, a longer one would delay a hold. The feed locks the motion object only to take a
//! segment (its knots are computed there, a few hundred instructions) and to report; solving happens without
//! the lock.

use units::{MAX_ACTUATORS, PerActuator, StepCount, Ticks};

use crate::{
    event_merge::{EventMerge, NEVER},
    feed_exchange::{FeedOrders, FeedReport, Supply},
    feed_schedule::{FeedSchedule, Lead, PERIOD},
    knots::Segment,
    laser::NextChange,
    motion::Access,
    motor::{LONG_AGO, Motor},
    queue::{StepEvent, StepQueue},
    rewind::Rewind,
    series::Scale,
    timeline::Passed,
    trajectory::whole_ticks,
    trigger::{Fired, Latch, Trigger},
};

/// Greatest time ahead of now up to which the queue is written: 1.5 ms.
pub const HORIZON: Ticks = Ticks::from_micros(1_500);
/// Number of events published together: the first ones of a segment are not to wait for its last ones.
/// Solving them takes some 25 us.
pub const BATCH: u32 = 128;
/// Runs between two computations of the played positions, each a walk over the unplayed events.
const RUNS_PER_LOOK: u8 = 32;

/// At least the motors, and a power of two: an index reduced to it needs no check.
const SLOTS: usize = 8;

/// Greatest offset in a key, ticks: a segment is far shorter.
const MOST_OFFSET: u64 = (1 << (32 - StepEvent::BITS)) - 2;

/// Bits of a key that are the event's word.
const WORD: u32 = (1 << StepEvent::BITS) - 1;

/// The feed. Exactly one context owns the feed.
#[derive(Debug)]
pub struct StepFeed {
    motors: [Motor; SLOTS],
    merge: EventMerge,
    /// First tick of the current segment.
    base: Ticks,
    scale: Scale,
    /// Offset of the newest event.
    newest: i32,
    /// Tick up to which everything is written.
    end: Ticks,
    /// Count of the first event since the positions were last declared.
    since: u32,
    played: PerActuator<StepCount>,
    runs: u8,
    moving: bool,
    /// Schedule as asked for, and at the last run.
    wanted: FeedSchedule,
    schedule: FeedSchedule,
    lead: Lead,
    /// Function that has the interrupt look at the queue again.
    wake: fn(),
    /// Duration of the last segment.
    last: Ticks,
    /// Change of a laser's power that is written next, if one is due in what is asked for.
    power: NextChange,
}

impl Default for StepFeed {
    fn default() -> Self {
        Self::new(FeedSchedule::ByPeriod, || {})
    }
}

impl StepFeed {
    /// Creates a feed with nothing written. `wake` is called when steps are written that nothing is played
    /// before: a run may write for longer than the first of them may wait for its end.
    #[must_use]
    pub const fn new(schedule: FeedSchedule, wake: fn()) -> Self {
        Self {
            motors: [Motor::NONE; SLOTS],
            merge: EventMerge::EMPTY,
            base: Ticks(0),
            scale: Scale { length: 0.0, offset: 0.0 },
            newest: LONG_AGO,
            end: Ticks(0),
            since: 0,
            played: PerActuator([0; MAX_ACTUATORS]),
            runs: 0,
            moving: false,
            wanted: schedule,
            schedule,
            lead: Lead::Short,
            wake,
            last: Ticks(0),
            power: NextChange::None,
        }
    }

    /// Runs the feed task once, due as [`Self::wait`] said. Writes the queue up to [`HORIZON`] ahead of `now`
    /// at most, stops the motion if the latch has fired, clears up after a cut. The caller then makes sure
    /// the step timer is armed. Returns the progress of the motors.
    pub fn run(&mut self, now: Ticks, motion: &mut impl Access, queue: &StepQueue, latch: &Latch) -> Passed {
        let orders = motion.with(|motion| motion.feed_orders());
        self.schedule = if orders.searching { FeedSchedule::ByPeriod } else { self.wanted };
        self.lead = orders.lead;
        self.obey(&orders, queue);
        if queue.is_cut() {
            self.clear_up(now, motion, queue);
        }
        if let Some(fired) = latch.take() {
            let trigger = self.locate(fired, now, queue);
            motion.with(|motion| motion.triggered(trigger));
        }
        let urgent = self.moving && self.end < now.plus(Lead::URGENT);
        let mut segment = Segment::default();
        // Ends: each turn brings the segments, or the trajectory that comes before them, on in time.
        while self.emit(motion, queue)
            && let Some(window) = self.schedule.window(now, self.end, self.lead, self.last)
        {
            match motion.with(|motion| motion.take_segment(&window, &mut segment)) {
                Supply::Segment => self.load(&segment, motion),
                Supply::Later => {}
                Supply::Enough => break,
                Supply::Nothing => {
                    self.moving = false;
                    break;
                }
            }
        }
        if !self.moving {
            self.emit_power_at_rest(now, motion, queue);
        }
        let report = self.report(queue);
        let squeezed = self.motors.iter_mut().map(|motor| core::mem::take(&mut motor.squeezed)).sum();
        motion.with(|motion| motion.feed_reports(now, report, urgent, squeezed))
    }

    /// Whether motion is being written.
    #[must_use]
    pub const fn is_moving(&self) -> bool {
        self.moving
    }

    /// Returns the time from `now`, at the end of a run, to the next run.
    #[must_use]
    pub fn wait(&self, now: Ticks) -> Ticks {
        if !self.moving {
            let NextChange::Later(at) = self.power else { return PERIOD };
            return self.schedule.wait(now, at, self.lead);
        }
        // With the queue full, the segment is not written to its end.
        let written = self.base.0.saturating_add_signed(i64::from(self.newest));
        self.schedule.wait(now, if self.merge.is_empty() { self.end } else { Ticks(written) }, self.lead)
    }

    fn obey(&mut self, orders: &FeedOrders, queue: &StepQueue) {
        if let Some(setup) = orders.setup {
            for (motor, setup) in self.motors.iter_mut().zip(setup.0) {
                motor.setup = setup;
            }
            // Pins may have been handed out anew.
            self.forget_directions();
        }
        if let Some(steps) = orders.rebase {
            self.stand_at(steps, queue);
        }
        if orders.cut {
            queue.cut();
        }
    }

    /// Forgets the pins' directions: each is written again before the motor's next step.
    fn forget_directions(&mut self) {
        for motor in &mut self.motors {
            motor.forget_direction();
        }
    }

    fn stand_at(&mut self, steps: PerActuator<StepCount>, queue: &StepQueue) {
        for (motor, steps) in self.motors.iter_mut().zip(steps.0) {
            motor.stand_at(steps);
        }
        self.played = steps;
        self.since = queue.written();
    }

    /// Clears up after a cut: the motors stand where the last event played left them.
    fn clear_up(&mut self, now: Ticks, motion: &mut impl Access, queue: &StepQueue) {
        let real = self.rewind(queue).to_played(queue);
        queue.restart();
        for (index, motor) in self.motors.iter_mut().enumerate() {
            // A turn that was never played leaves the pin as it was before, which need not be known.
            motor.drop_batch(real.turns_later(index));
        }
        self.merge = EventMerge::EMPTY;
        self.power = NextChange::None;
        self.moving = false;
        self.stand_at(real.steps, queue);
        motion.with(|motion| motion.resume_from_cut(real.steps, now));
    }

    fn rewind(&self, queue: &StepQueue) -> Rewind {
        let forward =
            (0..MAX_ACTUATORS).filter(|index| self.motors[*index].facing() > 0).fold(0, |mask, n| mask | 1 << n);
        Rewind::new(queue, self.steps(), forward, self.since)
    }

    fn steps(&self) -> PerActuator<StepCount> {
        let mut steps = PerActuator([0; MAX_ACTUATORS]);
        for (steps, motor) in steps.0.iter_mut().zip(&self.motors) {
            *steps = motor.steps();
        }
        steps
    }

    /// Finds the motors' step counts at the moment an input fired.
    fn locate(&self, fired: Fired, now: Ticks, queue: &StepQueue) -> Trigger {
        // The report lies less than half a turn of the 32-bit clock (10 s) from now, on either side.
        let ago = (now.0 as u32).wrapping_sub(fired.at) as i32;
        let at = now.0.saturating_add_signed(-i64::from(ago));
        let newest = self.base.0.saturating_add_signed(i64::from(self.newest));
        let steps = self.rewind(queue).to_tick(queue, at, newest).steps;
        Trigger { input: fired.input, at: Ticks(at), steps }
    }

    fn report(&mut self, queue: &StepQueue) -> FeedReport {
        let drained = queue.is_empty() && self.merge.is_empty() && !self.power.is_due();
        self.runs += 1;
        if drained {
            self.played = self.steps();
        } else if self.runs >= RUNS_PER_LOOK {
            self.played = self.rewind(queue).to_played(queue).steps;
        }
        if self.runs >= RUNS_PER_LOOK {
            self.runs = 0;
        }
        FeedReport { played: self.played, drained }
    }

    /// Makes this the tick that offsets count from. Returns the ticks passed since the one before.
    fn move_base(&mut self, base: Ticks) -> i32 {
        let passed = base.since(self.base).0.min(1 << 30) as i32;
        self.newest = (self.newest - passed).max(LONG_AGO);
        self.base = base;
        passed
    }

    /// Makes a segment the current one. The one before is written out.
    fn load(&mut self, segment: &Segment, motion: &mut impl Access) {
        let base = whole_ticks(segment.start);
        let passed = self.move_base(base);
        self.scale = Scale::of(segment);
        self.end = whole_ticks(segment.start + segment.duration);
        self.last = self.end.since(base);
        self.moving = true;
        // Nothing happens before what is written already; events of two motors may share a tick.
        let floor = self.newest.max(0);
        for (index, motor) in self.motors.iter_mut().take(MAX_ACTUATORS).enumerate() {
            motor.pass(passed);
            // A slave goes its master's way.
            let Some(span) = segment.motors.0.get(usize::from(motor.setup.master)) else { continue };
            if motor.setup.fitted && motor.solver.load(span) {
                self.merge.insert(motor.begin(index as u32, &self.scale, floor));
            }
        }
        if segment.has_power {
            self.ask_for_power(self.end, motion);
        }
    }

    /// Takes the next change of power that is due before `until`.
    #[inline(never)]
    fn ask_for_power(&mut self, until: Ticks, motion: &mut impl Access) {
        self.power = motion.with(|motion| motion.take_power(until));
    }

    /// Writes the changes of power that no motion goes with, up to where the next motion may begin.
    #[inline(never)]
    fn emit_power_at_rest(&mut self, now: Ticks, motion: &mut impl Access, queue: &StepQueue) {
        let until = now.plus(self.schedule.before_start(self.lead));
        // Ends: each turn but the last writes a change.
        loop {
            if !self.power.is_due() {
                self.ask_for_power(until, motion);
            }
            let NextChange::Due(at, duty) = self.power else { return };
            // Never before what is written already.
            let at = at.max(self.base.plus(Ticks(u64::from(self.newest.max(0) as u32))));
            let written = queue.written();
            if !queue.push(StepEvent::power(at.0 as u32, duty)) {
                return;
            }
            self.power = NextChange::None;
            let passed = self.move_base(at);
            self.newest = 0;
            self.motors.iter_mut().for_each(|motor| motor.pass(passed));
            self.wake_if_idle(queue, written);
        }
    }

    /// Writes events in time order until the current segment is done (true) or the queue is full.
    fn emit(&mut self, motion: &mut impl Access, queue: &StepQueue) -> bool {
        loop {
            let written = queue.written();
            let done = self.emit_batch(queue);
            if done && self.power.is_due() && self.emit_power(queue) {
                self.wake_if_idle(queue, written);
                self.ask_for_power(self.end, motion);
                continue;
            }
            self.wake_if_idle(queue, written);
            if done && !self.power.is_due() {
                return true;
            }
            if queue.free() == 0 {
                return false;
            }
        }
    }

    /// Wakes the interrupt when nothing is played before the steps written since: the interrupt may stand.
    /// (Apart, or the function would take registers from the loop over the steps.)
    #[inline(never)]
    fn wake_if_idle(&self, queue: &StepQueue, written: u32) {
        let batch = queue.written().wrapping_sub(written);
        if batch > 0 && queue.len() <= batch as usize {
            (self.wake)();
        }
    }

    /// Key of the change of power that is next: [`NEVER`] without one.
    fn power_key(&self) -> u32 {
        let NextChange::Due(at, _) = self.power else { return NEVER };
        // Never before what is written already.
        let offset = at.since(self.base).0.min(MOST_OFFSET) as i32;
        (offset.max(self.newest) as u32) << StepEvent::BITS | StepEvent::TURN | StepEvent::LASER
    }

    /// Writes the change of power, which is next. False when the queue is full.
    #[inline(never)]
    fn emit_power(&mut self, queue: &StepQueue) -> bool {
        let key = self.power_key();
        let NextChange::Due(_, duty) = self.power else { return true };
        let written = queue.push(StepEvent::power((self.base.0 as u32).wrapping_add(key >> StepEvent::BITS), duty));
        if written {
            self.newest = (key >> StepEvent::BITS) as i32;
            self.power = NextChange::None;
        }
        written
    }

    /// Writes and publishes the next [`BATCH`] of events, or up to where the current segment or the next
    /// change of power is reached (true) or the queue is full.
    fn emit_batch(&mut self, queue: &StepQueue) -> bool {
        let mut writer = queue.writer(BATCH);
        let base = self.base.0 as u32;
        let mut newest = None;
        // One comparison tells both the end of the steps and the place of a change of power.
        let limit = self.power_key();
        let done = loop {
            let key = self.merge.first();
            if key >= limit {
                break true;
            }
            let event = StepEvent { at: base.wrapping_add(key >> StepEvent::BITS), word: key & WORD };
            if !writer.push(event) {
                break false;
            }
            newest = Some(key);
            let index = event.motor();
            let next = self.motors[index].take(index as u32, &self.scale);
            self.merge.replace_first(next);
        };
        if let Some(key) = newest {
            self.newest = (key >> StepEvent::BITS) as i32;
        }
        done
    }
}

//! A motor in the feed: from the crossings that its step solver finds to steps and direction changes at whole
//! ticks, with the distances its driver needs.
//!
//! Times here are offsets in ticks from the beginning of the current segment. Events are solved in batches;
//! the feed takes them one by one as [`key`](crate::series::key)s.

use units::{Actuator, MAX_ACTUATORS, PerActuator, StepCount};

use crate::{
    config::MotionConfig, convert::float_of_u64, event_merge::NEVER, knots::Segment, queue::StepEvent, series::Scale,
    step_solver::StepSolver,
};

/// Properties of a motor that the feed must know.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct MotorSetup {
    /// Motor whose movement is followed: the motor itself, or its master.
    pub master: u8,
    /// The motor exists.
    pub fitted: bool,
    direction_setup: i32,
    step_interval: i32,
}

impl MotorSetup {
    const NONE: Self = Self { master: 0, fitted: false, direction_setup: 0, step_interval: 0 };

    /// Returns the setup of every motor of a configuration.
    pub fn all(config: &MotionConfig) -> PerActuator<Self> {
        let mut setups = PerActuator([Self::default(); MAX_ACTUATORS]);
        let master_of = |actuator| config.actuators[actuator].and_then(|fitted| fitted.slaved_to).unwrap_or(actuator);
        for actuator in Actuator::ALL {
            let Some(fitted) = config.actuators[actuator] else { continue };
            let master = master_of(actuator);
            setups[actuator].fitted = true;
            setups[actuator].master = master as u8;
            // A slave steps when its master does: all of them with the slowest timing among them.
            for other in Actuator::ALL.into_iter().filter(|other| master_of(*other) == master) {
                let setup = &mut setups[other];
                setup.direction_setup = setup.direction_setup.max(fitted.direction_setup.min(MAX_TIMING) as i32);
                // A motor's two steps are two events, so they lie at least a tick apart.
                setup.step_interval = setup.step_interval.max(fitted.step_interval.clamp(1, MAX_TIMING) as i32);
            }
        }
        setups
    }
}

/// Greatest setup or interval time, ticks: no step driver needs more than a millisecond.
const MAX_TIMING: u32 = 200_000;
/// Offset of what happened so long ago that it does not matter.
pub(crate) const LONG_AGO: i32 = -(1 << 30);
/// Fixed-point units of time in a tick.
const TICK_UNITS: f32 = 4_294_967_296.0;
/// Steps solved at a time: with the turn and the end, a power of two.
const BATCH: usize = PLACES - 2;
const PLACES: usize = 32;
/// Index of a batch's first step; a turn before it, if needed, is at index 0.
const FIRST_STEP: usize = 1;

impl Scale {
    /// Local times of a segment in ticks.
    pub fn of(segment: &Segment) -> Self {
        // Both fit: the fraction is the lower 32 bits, and a segment is far shorter than 2^32 ticks.
        let fraction = segment.start.to_bits() as u32 as f32 / TICK_UNITS;
        let length = float_of_u64(segment.duration.to_bits() as u64) as f32 / TICK_UNITS;
        Self { length, offset: fraction + 0.5 }
    }
}

/// State of one motor in the feed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motor {
    pub setup: MotorSetup,
    pub solver: StepSolver,
    /// The batch: a turn or not, steps, then [`NEVER`].
    keys: [u32; PLACES],
    /// The event that is next.
    next: usize,
    /// Count before the batch.
    steps: StepCount,
    /// Direction of the batch, and before it: 1 forward, -1 backward, 0 not known.
    facing: StepCount,
    faced: StepCount,
    /// Tick of the batch's last step.
    last: i32,
    /// Steps may come closer than the driver allows: each must be looked at.
    tight: bool,
    /// Steps that had to move to keep the driver's distances.
    pub squeezed: u32,
}

impl Motor {
    /// A motor that is not fitted.
    pub const NONE: Self = Self {
        setup: MotorSetup::NONE,
        solver: StepSolver::NONE,
        keys: [NEVER; PLACES],
        next: FIRST_STEP,
        steps: 0,
        facing: 0,
        faced: 0,
        last: LONG_AGO,
        tight: false,
        squeezed: 0,
    };

    /// Steps taken by the feed.
    pub fn steps(&self) -> StepCount {
        self.steps + self.facing * (self.next.max(FIRST_STEP) - FIRST_STEP) as StepCount
    }

    /// Direction after the last event taken: 1 forward, -1 backward, 0 not known.
    pub fn facing(&self) -> StepCount {
        if self.next < FIRST_STEP { self.faced } else { self.facing }
    }

    /// Lets the motor stand at `steps` and drops the solved steps.
    pub fn stand_at(&mut self, steps: StepCount) {
        self.facing = self.facing();
        self.solver.clear();
        self.end_batch();
        self.steps = steps;
    }

    /// Drops the solved steps, and the direction too, when its last change was not played.
    pub fn drop_batch(&mut self, forget_direction: bool) {
        let facing = self.facing();
        self.forget_direction();
        if !forget_direction {
            self.facing = facing;
        }
    }

    /// Forgets the direction: it is written again before the next step.
    pub fn forget_direction(&mut self) {
        self.steps = self.steps();
        self.end_batch();
        self.facing = 0;
    }

    fn end_batch(&mut self) {
        self.next = FIRST_STEP;
        self.keys[FIRST_STEP] = NEVER;
    }

    /// Begins a new segment, `passed` ticks after the one before, which is done.
    #[inline]
    pub fn pass(&mut self, passed: i32) {
        self.last = (self.last - passed).max(LONG_AGO);
    }

    /// Takes up the segment that the solver was loaded with: its first event's key. Nothing happens before
    /// `floor`.
    pub fn begin(&mut self, word: u32, scale: &Scale, floor: i32) -> u32 {
        // Times in ticks: way over speed. A tenth and two ticks more for rounding.
        self.tight = self.solver.speed_bound() * (1.1 * self.setup.step_interval as f32 + 2.0) > scale.length;
        self.solve(word, scale, floor)
    }

    /// The event after the one taken; `word` is the motor's place.
    #[inline(always)]
    pub fn take(&mut self, word: u32, scale: &Scale) -> u32 {
        self.next += 1;
        let key = self.keys[self.next % PLACES];
        if key == NEVER { self.solve(word, scale, 0) } else { key }
    }

    /// Solves the next batch: the first event's key, or [`NEVER`] when the segment has no more.
    #[inline(never)]
    fn solve(&mut self, word: u32, scale: &Scale, floor: i32) -> u32 {
        self.steps = self.steps();
        self.end_batch();
        if !self.solver.has_more() {
            return NEVER;
        }
        let (sign, mut first) = (self.solver.sign(), FIRST_STEP);
        let count = self.solver.fill(scale, word, &mut self.keys[FIRST_STEP..=BATCH]);
        self.keys[FIRST_STEP + count] = NEVER;
        let mut soonest = (self.last + self.setup.step_interval).max(floor);
        if sign != self.facing {
            let turn = self.turn_before(tick_of(self.keys[FIRST_STEP]), floor);
            soonest = soonest.max(turn + self.setup.direction_setup);
            let forward = if sign > 0 { StepEvent::FORWARD } else { 0 };
            self.keys[0] = (turn as u32) << StepEvent::BITS | StepEvent::TURN | forward | word;
            first = 0;
        }
        self.keep_distance(soonest, count);
        self.last = tick_of(self.keys[FIRST_STEP + count - 1]);
        self.faced = self.facing;
        self.facing = sign;
        self.next = first;
        self.keys[first]
    }

    /// The direction changes as late as the driver allows, but not right after the last step.
    #[cold]
    fn turn_before(&self, step: i32, floor: i32) -> i32 {
        let setup = self.setup.direction_setup;
        (step - setup).max(self.last + setup).max(floor)
    }

    /// Moves steps that come sooner than the driver allows. In a segment that is slow enough throughout, only
    /// the first can come too soon.
    #[inline]
    fn keep_distance(&mut self, mut soonest: i32, count: usize) {
        for slot in &mut self.keys[FIRST_STEP..FIRST_STEP + count] {
            if tick_of(*slot) < soonest {
                *slot = (soonest as u32) << StepEvent::BITS | *slot & ((1 << StepEvent::BITS) - 1);
                self.squeezed += 1;
            } else if !self.tight {
                return;
            }
            soonest = tick_of(*slot) + self.setup.step_interval;
        }
    }
}

/// The tick in a key.
#[inline(always)]
fn tick_of(key: u32) -> i32 {
    (key >> StepEvent::BITS) as i32
}

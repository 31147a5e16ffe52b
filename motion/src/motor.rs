//! One motor in the feed: from the crossings its lane solves to steps and direction changes at whole ticks, with the
//! distances its driver needs.
//!
//! Times here are offsets in ticks from the beginning of the current segment.

use units::{Actuator, MAX_ACTUATORS, PerActuator, StepCount};

use crate::{config::MotionConfig, knots::Segment, lane::Lane};

/// What the feed must know of a motor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct MotorSetup {
    /// This motor and its slaves, one bit each. Zero: not fitted, or a slave.
    pub mask: u8,
    direction_setup: i32,
    step_interval: i32,
}

impl MotorSetup {
    pub fn all(config: &MotionConfig) -> PerActuator<Self> {
        let mut setups = PerActuator([Self::default(); MAX_ACTUATORS]);
        for actuator in Actuator::ALL {
            let Some(fitted) = config.actuators[actuator] else { continue };
            // A slave joins its master's mask, and asks for the slower timing of the two.
            let setup = &mut setups[fitted.slaved_to.unwrap_or(actuator)];
            setup.mask |= actuator.bit();
            setup.direction_setup = setup.direction_setup.max(fitted.direction_setup.min(MAX_TIMING) as i32);
            // At least a tick: two steps of a motor are two events.
            setup.step_interval = setup.step_interval.max(fitted.step_interval.clamp(1, MAX_TIMING) as i32);
        }
        setups
    }
}

/// Setup and interval times beyond a millisecond are no step driver's.
const MAX_TIMING: u32 = 200_000;
/// Offset of what happened so long ago that it does not matter.
pub(crate) const LONG_AGO: i32 = -(1 << 30);
/// Fixed-point units of time in a tick.
const TICK_UNITS: f32 = 4_294_967_296.0;

/// From local time of a lane (0 to 1) to ticks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    /// Length of the segment in ticks.
    pub length: f32,
    /// By which part of a tick the segment begins after its first tick.
    pub fraction: f32,
}

impl Grid {
    pub fn new(segment: &Segment) -> Self {
        // Both fit: the fraction is the lower 32 bits, and a segment is far shorter than 2^32 ticks.
        let fraction = segment.start.to_bits() as u32 as f32 / TICK_UNITS;
        let length = segment.duration.to_bits() as u64 as f32 / TICK_UNITS;
        Self { length, fraction }
    }
}

/// One motor's state in the feed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motor {
    pub setup: MotorSetup,
    pub lane: Lane,
    /// Steps written.
    pub steps: StepCount,
    /// Direction written last: 1 forward, -1 backward, 0 not known.
    pub facing: StepCount,
    /// The motor's next event is a direction change; the step after it is due at `step_due`.
    pub turning: bool,
    step_due: i32,
    /// When the last step was.
    last: i32,
    /// Steps that had to move to keep the driver's distances.
    pub squeezed: u32,
}

impl Motor {
    pub const NONE: Self = Self {
        setup: MotorSetup { mask: 0, direction_setup: 0, step_interval: 0 },
        lane: Lane::NONE,
        steps: 0,
        facing: 0,
        turning: false,
        step_due: 0,
        last: LONG_AGO,
        squeezed: 0,
    };

    /// A new segment begins `passed` ticks after the one before.
    pub fn pass(&mut self, passed: i32) {
        self.last = (self.last - passed).max(LONG_AGO);
    }

    /// Solves the next step. Gives when it, or the direction change before it, is due.
    #[inline]
    pub fn schedule(&mut self, grid: &Grid) -> i32 {
        let at = (self.lane.solve() * grid.length + (grid.fraction + 0.5)) as i32;
        let soonest = self.last + self.setup.step_interval;
        let at = self.no_sooner(at, soonest);
        if self.lane.sign() == self.facing { at } else { self.schedule_turn(at) }
    }

    #[inline]
    fn no_sooner(&mut self, at: i32, soonest: i32) -> i32 {
        if at >= soonest {
            return at;
        }
        self.squeezed += 1;
        soonest
    }

    /// The direction changes as late as the driver allows, but not right after the last step.
    #[cold]
    fn schedule_turn(&mut self, step: i32) -> i32 {
        let setup = self.setup.direction_setup;
        let turn = (step - setup).max(self.last + setup).max(0);
        self.step_due = self.no_sooner(step, turn + setup);
        self.turning = true;
        turn
    }

    /// The direction changes at `at`. Gives when the step is due, and whether it goes forward.
    pub fn turn(&mut self, at: i32) -> (i32, bool) {
        self.turning = false;
        self.facing = self.lane.sign();
        (self.step_due.max(at + self.setup.direction_setup), self.facing > 0)
    }

    /// The motor steps at `at`. Gives when its next event is due in this segment.
    #[inline]
    pub fn step(&mut self, at: i32, grid: &Grid) -> Option<i32> {
        self.last = at;
        self.steps += self.facing;
        if self.lane.advance() { Some(self.schedule(grid)) } else { None }
    }
}

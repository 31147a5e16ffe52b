//! Holds step edges against the oracle: the ideal trajectory in `f64`, which shares no arithmetic with the
//! step solver.
//!
//! The native runner's own edges are compared as they are played ([`Watch::comparing`]). Edges of another
//! board come without their trajectory; they are compared with the one that the native runner plans for the
//! same job ([`plan`], [`against`]).

pub mod against;
pub mod plan;

use std::sync::Arc;

use motion::oracle::{Ideal, StepError, Warp};
use motion::queue::StepEvent;
use motion::trajectory::Piece;
use motion::{Access, FilterConfig, Motion, MotionConfig};
use units::{Actuator, PerActuator, StepCount};

use plan::Plan;

/// Pieces that ended this long before the present edge are forgotten.
const MEMORY_NS: f64 = 1e7;
/// Steps between two times of forgetting.
const FORGET_EVERY: u64 = 4_096;
/// Trajectory that goes on this long after its last piece has ended, seconds, has rested in between.
const REST_SECONDS: f64 = 1e-6;

/// One step of one motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    pub actuator: Actuator,
    /// Nanoseconds from boot.
    pub at: f64,
    /// Where the motor stands after it.
    pub count: StepCount,
    /// Which way it turned, 1 or -1.
    pub sign: StepCount,
}

/// Watches one run: keeps count of where the motors stand, and tells apart the motions from rest to rest.
pub struct Watch {
    config: MotionConfig,
    /// The compensation in force, and which change of it that is.
    warp: (Option<u32>, Option<Arc<Warp>>),
    last: Option<Piece>,
    /// Count of the last time that trajectory was taken back.
    taken_back: u32,
    /// Where each motor stands, and which way it turns.
    counts: PerActuator<StepCount>,
    signs: PerActuator<StepCount>,
    /// Nothing has been played since the motors rested.
    resting: bool,
    /// The next piece begins from rest.
    fresh: bool,
    task: Task,
}

/// What is done with what is seen.
enum Task {
    Compare(Box<Comparison>),
    Record(Plan),
}

struct Comparison {
    ideal: Ideal,
    error: StepError,
    /// Edges without an ideal crossing within a millisecond.
    strays: u64,
}

impl Watch {
    const fn new(config: MotionConfig, task: Task) -> Self {
        Self {
            config,
            warp: (None, None),
            last: None,
            taken_back: 0,
            counts: PerActuator([0; units::MAX_ACTUATORS]),
            signs: PerActuator([1; units::MAX_ACTUATORS]),
            resting: true,
            fresh: true,
            task,
        }
    }

    /// Compares every edge of the machine with this configuration.
    pub fn comparing(config: MotionConfig) -> Self {
        let (ideal, error) = (Ideal::new(config), StepError::default());
        Self::new(config, Task::Compare(Box::new(Comparison { ideal, error, strays: 0 })))
    }

    /// Records what is ideal, to hold another board's edges against it.
    pub const fn recording(config: MotionConfig) -> Self {
        Self::new(config, Task::Record(Plan::new()))
    }

    /// Before and after each run of the feed: it may find the motors at rest, and from then on until the next
    /// step where they stand may be declared anew.
    pub fn look(&mut self, motion: &Motion) {
        if motion.is_idle() {
            self.resting = true;
            self.fresh = true;
        }
        if self.resting {
            self.counts = motion.steps();
        }
    }

    /// Trajectory that was taken back since the last look is no longer ideal.
    fn taken_back(&mut self, motion: &Motion) {
        let Some(taken) = motion.last_taken_back().filter(|taken| taken.count != self.taken_back) else { return };
        self.taken_back = taken.count;
        self.last = None;
        match &mut self.task {
            Task::Compare(comparison) => comparison.ideal.take_back(taken),
            Task::Record(plan) => plan.take_back(taken),
        }
    }

    fn piece(&mut self, piece: &Piece, motion: &Motion) {
        if self.last.as_ref() == Some(piece) {
            return;
        }
        let filters = motion.filters_in_force();
        let changes = motion.compensation().changes();
        if self.warp.0 != Some(changes) {
            self.warp = (Some(changes), Warp::of(motion.compensation()).map(Arc::new));
        }
        // While filters run out, what follows a rest still overlaps what was before it.
        let rested = filters == FilterConfig::NONE
            && self.last.is_some_and(|last| {
                let seconds =
                    piece.start.saturating_sub(last.start).to_num::<f64>() * f64::from(units::TICK_NANOSECONDS);
                seconds * 1e-9 > last.duration + REST_SECONDS
            });
        let begins = std::mem::take(&mut self.fresh) || rested;
        self.last = Some(*piece);
        if begins && let Some(config) = motion.config() {
            self.config = *config;
        }
        match &mut self.task {
            Task::Compare(comparison) => {
                if begins {
                    comparison.ideal.configure(self.config);
                }
                comparison.ideal.set_filters(filters);
                comparison.ideal.set_warp(self.warp.1.clone());
                comparison.ideal.push(piece);
            }
            Task::Record(plan) => {
                plan.push(begins.then(|| (self.config, self.warp.1.clone())), piece, filters);
            }
        }
    }

    /// An event is played at this time.
    pub fn played(&mut self, event: StepEvent, at_ns: u64) {
        self.resting = false;
        for actuator in Actuator::ALL {
            let bit = actuator.bit();
            if event.turning_forward() & bit != 0 {
                self.signs[actuator] = 1;
            } else if event.turning_backward() & bit != 0 {
                self.signs[actuator] = -1;
            }
            // A slave copies its master's edges: they are the same event.
            let is_master = self.config.actuators[actuator].is_some_and(|motor| motor.slaved_to.is_none());
            if event.stepping() & bit == 0 || !is_master {
                continue;
            }
            let before = self.counts;
            let sign = self.signs[actuator];
            self.counts[actuator] += sign;
            let step = Step { actuator, at: at_ns as f64, count: self.counts[actuator], sign };
            match &mut self.task {
                Task::Compare(comparison) => comparison.take(&step),
                Task::Record(plan) => plan.take(&step, &before),
            }
        }
    }

    /// When comparing: how far the edges were off, and how many had no ideal crossing at all.
    pub fn result(&self) -> Option<(StepError, u64)> {
        match &self.task {
            Task::Compare(comparison) => Some((comparison.error, comparison.strays)),
            Task::Record(_) => None,
        }
    }

    /// The machine begins to search for a switch.
    pub const fn search_begins(&mut self) {
        if let Task::Record(plan) = &mut self.task {
            plan.search_begins();
        }
    }

    /// When recording: what was recorded so far.
    pub const fn plan(&self) -> Option<&Plan> {
        match &self.task {
            Task::Record(plan) => Some(plan),
            Task::Compare(_) => None,
        }
    }

    /// When recording: what was recorded.
    pub fn into_plan(self) -> Option<Plan> {
        match self.task {
            Task::Record(plan) => Some(plan),
            Task::Compare(_) => None,
        }
    }
}

impl Comparison {
    fn take(&mut self, step: &Step) {
        match self.ideal.edge_error(step.actuator, step.at, step.count, step.sign) {
            Some(error) => self.error.add(error),
            None => self.strays += 1,
        }
        if self.error.edges.is_multiple_of(FORGET_EVERY) {
            self.ideal.forget_before(step.at - MEMORY_NS);
        }
    }
}

/// The motion object, watched for new pieces of trajectory.
pub struct Watched<'a> {
    pub motion: &'a mut Motion,
    pub watch: Option<&'a mut Watch>,
}

impl Access for Watched<'_> {
    fn with<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R {
        let result = f(self.motion);
        if let Some(watch) = self.watch.as_deref_mut() {
            watch.taken_back(self.motion);
            if let Some(piece) = self.motion.last_piece() {
                watch.piece(piece, self.motion);
            }
        }
        result
    }
}

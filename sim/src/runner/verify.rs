//! The comparison of step edges with the oracle: the ideal trajectory in `f64`, which shares no arithmetic
//! with the step solver.
//!
//! The native runner's own edges are compared as they are played ([`Watch::comparing`]). Edges of another
//! board come without their trajectory; they are compared with the trajectory that the native runner plans
//! for the same job ([`plan`], [`other_board`]).

pub mod other_board;
pub mod plan;
mod step;

use std::sync::Arc;

use motion::oracle::{Ideal, StepError, Warp};
use motion::queue::StepEvent;
use motion::trajectory::Piece;
use motion::{Access, FilterConfig, Motion, MotionConfig};
use units::{Actuator, PerActuator, StepCount};

use plan::Plan;
use step::Step;

/// Age before the present edge at which ended pieces are forgotten.
const MEMORY_NS: f64 = 1e7;
/// Number of steps between two times of forgetting.
const FORGET_EVERY: u64 = 4_096;
/// Pause after the end of the last piece, seconds, from which trajectory has rested in between.
const REST_SECONDS: f64 = 1e-6;

/// Observer of a run: keeps count of the motors' positions, and tells apart the motions from rest to rest.
pub struct Watch {
    config: MotionConfig,
    /// Compensation in force, and the number of its change.
    warp: (Option<u32>, Option<Arc<Warp>>),
    last: Option<Piece>,
    /// Count of the last time that trajectory was taken back.
    taken_back: u32,
    /// Position of each motor, and the direction in which it turns.
    counts: PerActuator<StepCount>,
    signs: PerActuator<StepCount>,
    /// Nothing has been played since the motors rested.
    resting: bool,
    /// The next piece begins from rest.
    fresh: bool,
    task: Task,
}

/// Task of the observer.
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

    /// Makes an observer that compares every edge of the machine with this configuration.
    pub fn comparing(config: MotionConfig) -> Self {
        let (ideal, error) = (Ideal::new(config), StepError::default());
        Self::new(config, Task::Compare(Box::new(Comparison { ideal, error, strays: 0 })))
    }

    /// Makes an observer that records the ideal motion, to compare another board's edges with it.
    pub const fn recording(config: MotionConfig) -> Self {
        Self::new(config, Task::Record(Plan::new()))
    }

    /// Looks before and after each run of the feed: it may find the motors at rest, and from then on until
    /// the next step their positions may be declared anew.
    pub fn look(&mut self, motion: &Motion) {
        if motion.is_idle() {
            self.resting = true;
            self.fresh = true;
        }
        if self.resting {
            self.counts = motion.steps();
        }
    }

    /// Forgets trajectory that was taken back since the last look, which is no longer ideal.
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
        // While filters run out, the motion after a rest still overlaps the motion before it.
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

    /// Takes an event that is played at this time.
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

    /// Returns, when comparing, the distances of the edges, and the number without any ideal crossing.
    pub fn result(&self) -> Option<(StepError, u64)> {
        match &self.task {
            Task::Compare(comparison) => Some((comparison.error, comparison.strays)),
            Task::Record(_) => None,
        }
    }

    /// Notes that the machine begins to search for a switch.
    pub const fn search_begins(&mut self) {
        if let Task::Record(plan) = &mut self.task {
            plan.search_begins();
        }
    }

    /// Returns, when recording, the plan so far.
    pub const fn plan(&self) -> Option<&Plan> {
        match &self.task {
            Task::Record(plan) => Some(plan),
            Task::Compare(_) => None,
        }
    }

    /// Returns, when recording, the whole plan.
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

/// Motion object that is watched for new pieces of trajectory.
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

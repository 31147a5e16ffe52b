//! The motion object: look-ahead queue, block in execution, trajectory clock and position, behind one brief
//! lock.
//!
//! States and their exits:
//!
//! | state | submit | leaves it |
//! |---|---|---|
//! | `Running` | yes | `hold` to `Holding`; `stop` to `Stopping`; `abort` to `Aborting` |
//! | `Holding` (braking) | yes | standstill to `Held`; `resume` to `Running` |
//! | `Held` | yes | `resume` to `Running`; `stop` drops everything, to `Running` |
//! | `Stopping` (braking) | no | standstill drops everything, to `Running` |
//! | `Aborting` | no | the feed reports where the motors stand, to `Running` |
//!
//! `abort` leads from everywhere to `Aborting`. A hold, a stop and an override are new plans from the cursor:
//! the end of what the feed has taken, at most 1.5 ms ahead of the motors.

mod compensation;
mod control;
mod corner;
mod cursor;
mod detour;
mod feed_side;
mod filtered;
mod forecast;
mod growth;
mod path_made;
mod power;
mod profiles;
mod queries;
mod submit;
mod taking_back;

pub use detour::Waiting;
use units::{AxisSet, PerActuator, PerAxis, StepCount, StepPosition, Ticks};

use crate::{
    compensation::{Compensation, Surface},
    config::{ConfigError, Limits, MOST_BLOCKS, MotionConfig},
    elsewhere::Elsewhere,
    feed_exchange::{FeedOrders, FeedReport},
    feed_schedule::Lead,
    filters::{Filters, History},
    knots::{countable_within, is_countable, nearest_step, step_positions},
    laser::{Laser, Power},
    motor::MotorSetup,
    moves::{Mode, Refusal, Tag},
    path::{self, CurveRing, Path},
    planner::{Block, BlockRing, KEPT, MOST_OF_DETOUR, Overrides, Planner},
    ramp::Ramp,
    run::Run,
    timeline::{Mark, Passed, Timeline},
    trajectory::{Piece, TakenBack, TickTime},
    trigger::Trigger,
};

/// Access of the feed to the motion object: a resource lock on the board, the object itself elsewhere.
pub trait Access {
    /// Runs `f` with the lock held. Every `f` this crate passes is brief.
    fn with<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R;
}

impl Access for Motion {
    fn with<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R {
        f(self)
    }
}

/// State of the motion object; see the module's table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs, reason = "the module's table explains them")]
pub enum State {
    #[default]
    Running,
    Holding,
    Held,
    Stopping,
    Aborting,
}

/// Events worth knowing about; all count from the start and saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Blocks released while moving although more look-ahead could have made them faster: the sender is too
    /// slow.
    pub starved: u32,
    /// Runs of the feed that found less than a quarter of a millisecond written ahead while moving.
    pub urgent: u32,
    /// Runs of the feed that came too late: the trajectory had to be shifted in time.
    pub late: u32,
    /// Steps moved because a direction change or the least step interval needed the room.
    pub squeezed: u32,
    /// Runs of pieces too short for the filters' memory, which were made into one.
    pub lumped: u32,
    /// Pulses and gaps of a laser's power that were lost or lost their beginning, as one edge's delay was
    /// longer than the other's by more than they lasted, or as too many changes waited.
    pub swallowed: u32,
}

/// The motion object. Build it in a `static`, then [`Self::configure`] it.
#[derive(Debug)]
pub struct Motion {
    pub(crate) config: Option<MotionConfig>,
    /// Axes that no motor of this machine moves.
    orphans: AxisSet,
    /// Distance from the origin within which steps can surely be counted, mm.
    countable: f64,
    planner: Planner,
    curves: Elsewhere<CurveRing>,
    overrides: Overrides,
    state: State,
    run: Option<Run>,
    /// Greatest squared speed of the run up or down under way, where a minimum cruise ratio is kept.
    peak_sq: f64,
    piece: Option<Piece>,
    /// The ramp at the beginning of that piece, and how many seconds of it were over.
    piece_ramp: Option<(Ramp, f64)>,
    /// Time up to which the trajectory is settled.
    clock: TickTime,
    /// Filters that the trajectory goes through when any is on.
    filters: Filters,
    /// Compensation between the filters and the kinematics.
    compensation: Compensation,
    /// Tags of the moves, and marks between them.
    timeline: Elsewhere<Timeline>,
    /// Progress of the motors at the feed's last run.
    passed: Passed,
    /// Machine position at `clock` while nothing runs.
    place: PerAxis<f64>,
    /// The last time that trajectory was taken back.
    taken_back: Option<TakenBack>,
    /// Go on as soon as the trajectory is settled as far as it was before some was taken back.
    resume_wanted: bool,
    /// Motor positions at `clock`, or at the filters' output.
    knots: PerActuator<StepPosition>,
    /// End of the last submitted block, in machine space.
    planned: PerAxis<f64>,
    /// The last submitted block, for the corner after it. `None`: begins from rest.
    last: Option<Last>,
    /// Whether a move waits for room for itself and the arc that rounds its corner.
    wants_two: bool,
    /// Blocks before this count may be released although the queue is not full.
    flushed: u32,
    /// Count of blocks when the queue last grew, and since when it has not.
    seen: (u32, Ticks),
    /// Whether the motors stand still at `clock`: the next motion begins a moment from now, not at `clock`.
    resting: bool,
    report: FeedReport,
    /// Sum by which declared positions have set the step counts back.
    set_back: PerActuator<StepCount>,
    orders: FeedOrders,
    trigger: Option<Trigger>,
    laser: Elsewhere<Laser>,
    pub(crate) counters: Counters,
}

#[derive(Clone, Copy, Debug)]
struct Last {
    exit: Exit,
    length: f64,
    acceleration: f64,
    /// Speeds, mode and power of its block.
    speed_limit: f64,
    requested: f64,
    mode: Mode,
    power: Power,
    /// For a straight move of X, Y or Z: movement of each axis for a millimetre, and length before any corner
    /// was rounded, mm.
    line: Option<(PerAxis<f64>, f64)>,
}

impl Last {
    fn new(block: &Block, exit: Exit) -> Self {
        let Block { length, acceleration, speed_limit, requested, mode, power, .. } = *block;
        Self { exit, length, acceleration, speed_limit, requested, mode, power, line: None }
    }

    /// Returns the cruise speed under these overrides, mm/s.
    fn cruise(&self, overrides: &Overrides) -> f64 {
        overrides.cruise(self.speed_limit, self.requested, self.mode)
    }
}

/// End of a move, for the corner behind it.
#[derive(Clone, Copy, Debug)]
struct Exit {
    /// Unit direction of X Y Z, if any of them moves.
    direction: Option<[f64; 3]>,
    /// Bend of X Y Z. Single precision will do, as the bend only bounds a speed.
    bend: [f32; 3],
}

impl Exit {
    const fn straight(direction: Option<[f64; 3]>) -> Self {
        Self { direction, bend: [0.0; 3] }
    }

    /// Returns the end of a path along a curve of this length.
    fn of(path: &Path, length: f64) -> Self {
        Self { direction: Some(path::unit(path, length)), bend: path.curve.bend(length).map(|part| part as f32) }
    }
}

#[cfg(any(test, feature = "oracle"))]
impl Default for Motion {
    fn default() -> Self {
        Self::new()
    }
}

impl Motion {
    /// Creates a motion object that is not configured: it refuses every move.
    #[cfg(any(test, feature = "oracle"))]
    #[must_use]
    pub fn new() -> Self {
        use std::boxed::Box;
        let crate::Store { history, curves, surface, timeline, mut laser } = crate::Store::new();
        laser.store = Some(Box::default());
        Self::over(
            Box::default(),
            Box::new(history),
            Box::new(curves),
            Box::new(surface),
            Box::new(timeline),
            Box::new(laser),
        )
    }

    /// Creates a motion object that is not configured: it refuses every move. Keeps its queue in `blocks`,
    /// and its other large data in `store`.
    #[cfg(not(any(test, feature = "oracle")))]
    #[must_use]
    pub const fn new(blocks: &'static mut BlockRing, store: &'static mut crate::Store) -> Self {
        Self::over(
            blocks,
            &mut store.history,
            &mut store.curves,
            &mut store.surface,
            &mut store.timeline,
            &mut store.laser,
        )
    }

    const fn over(
        blocks: Elsewhere<BlockRing>,
        history: Elsewhere<History>,
        curves: Elsewhere<CurveRing>,
        surface: Elsewhere<Surface>,
        timeline: Elsewhere<Timeline>,
        laser: Elsewhere<Laser>,
    ) -> Self {
        Self {
            config: None,
            orphans: AxisSet::NONE,
            countable: 0.0,
            planner: Planner::new(blocks),
            curves,
            overrides: Overrides { feed: 1.0, rapid: 1.0 },
            state: State::Running,
            run: None,
            peak_sq: f64::INFINITY,
            piece: None,
            piece_ramp: None,
            taken_back: None,
            resume_wanted: false,
            clock: TickTime::ZERO,
            place: PerAxis([0.0; units::MAX_AXES]),
            knots: PerActuator([StepPosition::ZERO; units::MAX_ACTUATORS]),
            planned: PerAxis([0.0; units::MAX_AXES]),
            last: None,
            wants_two: false,
            flushed: 0,
            seen: (0, Ticks(0)),
            resting: true,
            report: FeedReport::RESTING,
            set_back: PerActuator([0; units::MAX_ACTUATORS]),
            orders: FeedOrders { cut: false, rebase: None, setup: None, searching: false, lead: Lead::Short },
            trigger: None,
            counters: Counters { starved: 0, urgent: 0, late: 0, squeezed: 0, lumped: 0, swallowed: 0 },
            filters: Filters::new(history),
            compensation: Compensation::new(surface),
            timeline,
            laser,
            passed: Passed { tag: Tag::NONE, mark: Mark(0) },
        }
    }

    // --- setting up ---

    /// Sets the machine up, or changes it. Keeps the machine position.
    ///
    /// # Errors
    /// The first thing wrong with it, or that something moves; nothing was changed then.
    pub fn configure(&mut self, config: MotionConfig) -> Result<(), ConfigError> {
        if !self.is_idle() {
            return Err(ConfigError::Busy);
        }
        config.check()?;
        // Room for a way round what is left out; where trajectory may be taken back, its blocks must not have
        // been overwritten.
        let spare = if config.filters.latency() > 0.0 { KEPT } else { MOST_OF_DETOUR };
        let queue_size = config.queue_size.min(MOST_BLOCKS - spare);
        self.config = Some(MotionConfig { queue_size, ..config });
        self.orphans = config.orphans();
        self.countable = countable_within(&config);
        self.orders.setup = Some(MotorSetup::all(&config));
        self.filters.configure(&config.filters);
        self.settle_at(self.planned);
        Ok(())
    }

    /// Returns the configuration set by [`Self::configure`], with the limits now in force.
    #[must_use]
    pub fn config(&self) -> Option<&MotionConfig> {
        self.config.as_ref()
    }

    /// Changes the limits for moves submitted from now on.
    ///
    /// # Errors
    /// The first limit that is wrong; nothing was changed then.
    pub fn set_limits(&mut self, limits: Limits) -> Result<(), ConfigError> {
        let Some(config) = &mut self.config else { return limits.check() };
        let changed = MotionConfig { limits, ..*config };
        changed.check()?;
        *config = changed;
        Ok(())
    }

    /// Declares the position of the machine.
    ///
    /// # Errors
    /// [`Refusal::Busy`] unless idle, [`Refusal::NotFinite`] for a position that steps cannot count.
    pub fn set_position(&mut self, position: PerAxis<f64>) -> Result<(), Refusal> {
        if !self.is_idle() {
            return Err(Refusal::Busy);
        }
        let config = self.config.as_ref().ok_or(Refusal::NotConfigured)?;
        if !is_countable(config, &self.compensation.motors(&position)) {
            return Err(Refusal::NotFinite);
        }
        self.settle_at(position);
        Ok(())
    }

    /// Whether nothing is queued or on its way, and the motors have played every step.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        let stands = self.run.is_none() && self.planner.is_empty() && self.state == State::Running;
        stands && self.filters.drained && self.report.drained && self.laser.is_quiet()
    }

    /// Sets the machine at rest exactly at `position`.
    fn settle_at(&mut self, position: PerAxis<f64>) {
        self.place = position;
        self.planned = position;
        self.last = None;
        self.laser.growth.moves = 0;
        self.filters.settle(position, self.clock);
        if let Some(config) = &self.config {
            self.knots = step_positions(config, &self.compensation.motors(&position));
        }
        let steps = PerActuator(self.knots.0.map(nearest_step));
        for (set_back, (before, now)) in self.set_back.0.iter_mut().zip(self.report.played.0.into_iter().zip(steps.0)) {
            *set_back = set_back.wrapping_add(before).wrapping_sub(now);
        }
        self.orders.rebase = Some(steps);
        self.report.played = steps;
    }

    /// Runs one bounded slice of planning: the reverse pass over new blocks.
    pub fn plan(&mut self) {
        self.planner.plan();
    }

    /// Runs the queued blocks without waiting for the queue to fill, as nothing more will come soon.
    pub fn flush(&mut self) {
        self.flushed = self.planner.pushed();
        // A block that may run now does not grow, and is not shortened any more for a rounded corner.
        self.laser.growth.moves = 0;
        self.planner.set_reserve(0.0);
        if let Some(last) = &mut self.last {
            last.line = None;
        }
    }

    /// Factors in force, feed and rapid.
    #[must_use]
    pub const fn overrides(&self) -> Overrides {
        self.overrides
    }
}

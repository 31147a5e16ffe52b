//! A machine on the desk: motion, feed and queue, an interrupt that plays events exactly when due, and a
//! record.

use std::{boxed::Box, vec::Vec};

use proptest::test_runner::Config as ProptestConfig;
use units::{Actuator, MmPerSecond, MmPerSecond2, PerActuator, PerAxis, Ticks};

use crate::{
    ActuatorConfig, FeedSchedule, Kinematics, Latch, Limits, Motion, MotionConfig, Move, Refusal, StepFeed,
    motion::Access,
    queue::{StepEvent, StepQueue},
    trajectory::{Piece, TakenBack},
};

/// Period of the feed task.
pub const PERIOD: Ticks = Ticks::from_micros(500);

/// Number of times that a property is tried: `usual`, or as PROPTEST_CASES says.
pub fn cases(usual: u32) -> ProptestConfig {
    let wanted = ProptestConfig::default();
    if std::env::var_os("PROPTEST_CASES").is_some() { wanted } else { ProptestConfig { cases: usual, ..wanted } }
}

/// A step as it was played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    pub at: u64,
    pub actuator: Actuator,
    pub sign: i32,
    /// Count after the step.
    pub count: i32,
}

/// Records every piece of ideal trajectory the feed is given.
pub struct Recorder {
    pub motion: Box<Motion>,
    /// Pieces that hold in the end, without those taken back.
    pub pieces: Vec<Piece>,
    /// Log of all pieces in the order in which they came, and of those taken back.
    pub log: Vec<Entry>,
    last: Option<Piece>,
    taken: u32,
}

/// Event that happened to the trajectory.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant, reason = "nearly all are pieces")]
pub enum Entry {
    Piece(Piece),
    TakenBack(TakenBack),
}

impl Recorder {
    fn new(motion: Box<Motion>) -> Self {
        Self { motion, pieces: Vec::new(), log: Vec::new(), last: None, taken: 0 }
    }

    fn look(&mut self) {
        if let Some(taken) = self.motion.last_taken_back()
            && self.taken != taken.count
        {
            self.taken = taken.count;
            self.log.push(Entry::TakenBack(*taken));
            self.pieces.retain(|piece| piece.start < taken.from);
            self.last = None;
        }
        if let Some(piece) = self.motion.last_piece()
            && self.last.as_ref() != Some(piece)
        {
            self.last = Some(*piece);
            self.pieces.push(*piece);
            self.log.push(Entry::Piece(*piece));
        }
    }
}

impl Access for Recorder {
    fn with<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R {
        let result = f(&mut self.motion);
        self.look();
        result
    }
}

pub struct Rig {
    pub access: Recorder,
    pub feed: StepFeed,
    pub queue: Box<StepQueue>,
    pub latch: Latch,
    pub now: Ticks,
    pub edges: Vec<Edge>,
    pub events: Vec<(u64, StepEvent)>,
    pub counts: PerActuator<i32>,
    /// Position of X when the feed last ran, mm at 80 steps/mm.
    pub before: f64,
    forward: u8,
}

/// A cartesian printer: 80 steps/mm, Z 400, extruder 400.
pub fn printer() -> MotionConfig {
    let motor = |steps| Some(ActuatorConfig::new(steps));
    MotionConfig {
        kinematics: Kinematics::Cartesian,
        actuators: PerActuator([motor(80.0), motor(80.0), motor(400.0), motor(400.0), None, None]),
        limits: Limits {
            axis_speed: [Some(MmPerSecond(500.0)), Some(MmPerSecond(500.0)), Some(MmPerSecond(20.0))],
            actuator_rate: PerActuator([MmPerSecond(500.0); 6]),
            acceleration: MmPerSecond2(3_000.0),
            ..Limits::DEFAULT
        },
        queue_size: 32,
        queue_delay: Ticks::from_micros(100_000),
        filters: crate::FilterConfig::NONE,
    }
}

/// X, Y, Z, E.
pub fn at(x: f64, y: f64, z: f64, e: f64) -> PerAxis<f64> {
    PerAxis([x, y, z, e, 0.0, 0.0])
}

impl Rig {
    pub fn new(config: MotionConfig) -> Self {
        let mut motion = Box::new(Motion::new());
        motion.configure(config).expect("a valid configuration");
        Self {
            access: Recorder::new(motion),
            feed: StepFeed::default(),
            queue: Box::new(StepQueue::new()),
            latch: Latch::new(),
            // Close to the wrap of the 32-bit clock, so that every longer test crosses it.
            now: Ticks(u64::from(u32::MAX) - 100_000),
            edges: Vec::new(),
            events: Vec::new(),
            counts: PerActuator([0; 6]),
            before: 0.0,
            forward: 0,
        }
    }

    /// Creates a machine as a board has it: the feed runs on demand.
    pub fn on_demand(config: MotionConfig) -> Self {
        Self { feed: StepFeed::new(FeedSchedule::OnDemand, || {}), ..Self::new(config) }
    }

    pub fn motion(&mut self) -> &mut Motion {
        &mut self.access.motion
    }

    /// The feed runs, then the interrupt plays what falls due until the next run.
    pub fn tick(&mut self) {
        self.before = f64::from(self.counts[Actuator::Alpha]) / 80.0;
        self.feed.run(self.now, &mut self.access, &self.queue, &self.latch);
        self.now = self.now.plus(self.feed.wait(self.now));
        self.play_until(self.now);
    }

    pub fn play_until(&mut self, end: Ticks) {
        while let Some(event) = self.queue.front() {
            let ahead = event.at.wrapping_sub(end.0 as u32) as i32;
            if ahead > 0 {
                break;
            }
            let at = end.0.saturating_add_signed(i64::from(ahead));
            self.forward = (self.forward | event.turning_forward()) & !event.turning_backward();
            for actuator in Actuator::ALL {
                if event.stepping() & actuator.bit() != 0 {
                    let sign = if self.forward & actuator.bit() != 0 { 1 } else { -1 };
                    self.counts[actuator] += sign;
                    self.edges.push(Edge { at, actuator, sign, count: self.counts[actuator] });
                }
            }
            self.events.push((at, event));
            self.queue.advance();
        }
    }

    /// Submits a move, letting time pass while the queue is full.
    pub fn submit(&mut self, request: &Move) {
        for _ in 0..1_000_000 {
            match self.motion().submit(request) {
                Ok(()) => return self.motion().plan(),
                Err(Refusal::Full) => self.tick(),
                Err(refusal) => panic!("{request:?} refused: {refusal}"),
            }
        }
        panic!("the queue never drains");
    }

    /// Runs until the machine is idle.
    pub fn finish(&mut self) {
        self.motion().flush();
        for _ in 0..4_000_000 {
            self.tick();
            if self.motion().is_idle() {
                return;
            }
        }
        panic!("never idle: {:?}", self.motion().state());
    }
}

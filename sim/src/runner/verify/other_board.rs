//! Another board's step edges against the plan of the same job.
//!
//! A motion begins when its bytes have arrived and the executor has seen the one before end, so the time
//! of its beginning is the board's own business; the rest is not. For each motion from rest, the moment of
//! its beginning is measured once, from its first steps; every step is then compared with the oracle
//! shifted by that. The measure is a median: no single wrong edge moves it. A delay that all steps of a
//! motion share, such as the entry of the step interrupt, is thereby taken out.

use motion::oracle::{self, Ideal};
use units::{Actuator, Direction, PerActuator, StepCount};

use super::plan::{Plan, PlannedMotion};
use super::step::Step;
use crate::output::StepError;
use crate::trace::StepEdge;

/// Number of steps from which the beginning of a motion is measured.
const MEASURED: usize = 31;

/// Distance of an edge, nanoseconds, that in a motion that ends at a switch is taken for a brake that began
/// a segment sooner or later than planned, before it is taken for an error.
const DOUBT_NS: f64 = 5_000.0;

/// Place at which a board departed from the plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mismatch {
    /// Number of the motion, counted from 1.
    pub motion: usize,
    /// Description of the departure.
    pub reason: String,
    /// Another plan of the same search may fit; this plan may be right all the same.
    pub is_doubt: bool,
}

/// Meaning of an edge that is far off in a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InSearches {
    /// Another plan should be tried.
    Doubt,
    /// The edge is wrong by that much.
    Count,
}

impl Plan {
    /// Compares these edges, which another board made of the same job.
    ///
    /// # Errors
    /// The first place where the board did something else than what was planned, or what reading the edges
    /// says.
    pub fn compare(
        &self,
        edges: impl Iterator<Item = Result<StepEdge, String>>,
        in_searches: InSearches,
    ) -> Result<StepError, Mismatch> {
        let mut edges = edges;
        let mut error = oracle::StepError::default();
        let (mut motion, mut searches) = (0, 0);
        for planned in self.motions() {
            motion += 1;
            let mut follower = Follower::new(planned, motion);
            let mut of_motion = oracle::StepError::default();
            let mismatch = |reason, is_doubt| Mismatch { motion, reason, is_doubt };
            follower.follow(&mut edges, &mut of_motion).map_err(|reason| mismatch(reason, false))?;
            let is_search = planned.searches > std::mem::replace(&mut searches, planned.searches);
            if is_search && in_searches == InSearches::Doubt && of_motion.max > DOUBT_NS {
                let reason = format!("an edge of motion {motion} is {:.0} ns from where it belongs", of_motion.max);
                return Err(mismatch(reason, true));
            }
            error.merge(&of_motion);
        }
        let reason = match edges.next() {
            None => return Ok(error.into()),
            Some(Err(reason)) => reason,
            Some(Ok(edge)) => format!(
                "the board's {} steps at {:.6} s although all planned motion is done",
                edge.actuator.name(),
                edge.time_ns as f64 * 1e-9
            ),
        };
        Err(Mismatch { motion: motion + 1, reason, is_doubt: false })
    }
}

/// Follower of a board through a motion.
struct Follower<'a> {
    motion: &'a PlannedMotion,
    /// Number of the motion, counted from 1.
    number: usize,
    ideal: Ideal,
    counts: PerActuator<StepCount>,
    /// Steps that each motor has yet to make, slaves included, and all together.
    left: PerActuator<u64>,
    expected: u64,
    /// Delay of the board's beginning behind the plan, nanoseconds.
    offset: f64,
}

impl<'a> Follower<'a> {
    fn new(motion: &'a PlannedMotion, number: usize) -> Self {
        let of_master = |actuator: Actuator| Actuator::ALL[master(motion, actuator) as usize];
        let left = PerActuator(Actuator::ALL.map(|actuator| motion.steps[of_master(actuator)]));
        let counts = PerActuator(Actuator::ALL.map(|actuator| motion.counts[of_master(actuator)]));
        Self { motion, number, ideal: motion.ideal(), counts, left, expected: left.0.iter().sum(), offset: 0.0 }
    }

    /// Follows all steps of the motion.
    fn follow(
        &mut self,
        edges: &mut impl Iterator<Item = Result<StepEdge, String>>,
        error: &mut oracle::StepError,
    ) -> Result<(), String> {
        let mut first = Vec::new();
        while self.expected > 0 && first.len() < MEASURED {
            first.push(self.step(&edges.next().ok_or_else(|| self.missing())??)?);
        }
        self.measure_beginning(&first);
        for step in &first {
            error.add(self.error(step)?);
        }
        while self.expected > 0 {
            let step = self.step(&edges.next().ok_or_else(|| self.missing())??)?;
            error.add(self.error(&step)?);
        }
        Ok(())
    }

    fn planned_at(&self) -> f64 {
        self.motion.start * 1e-9
    }

    fn missing(&self) -> String {
        let (number, expected) = (self.number, self.expected);
        format!(
            "the board's steps end {expected} steps before motion {number} does (planned at {:.3} s)",
            self.planned_at()
        )
    }

    /// Takes the edge as the next step of its motor.
    fn step(&mut self, edge: &StepEdge) -> Result<Step, String> {
        let actuator = edge.actuator;
        if self.left[actuator] == 0 {
            return Err(format!(
                "{} at {:.6} s makes a step more than motion {} has for it (planned at {:.3} s): the board moves otherwise than planned",
                actuator.name(),
                edge.time_ns as f64 * 1e-9,
                self.number,
                self.planned_at()
            ));
        }
        self.left[actuator] -= 1;
        self.expected -= 1;
        let sign = match edge.direction {
            Direction::Forward => 1,
            Direction::Backward => -1,
        };
        self.counts[actuator] += sign;
        Ok(Step {
            actuator: master(self.motion, actuator),
            at: edge.time_ns as f64,
            count: self.counts[actuator],
            sign,
        })
    }

    /// Measures from the first steps the time at which the board began.
    fn measure_beginning(&mut self, first: &[Step]) {
        let mut offsets: Vec<f64> = first
            .iter()
            .filter_map(|step| {
                let same = |planned: &&Step| {
                    (planned.actuator, planned.count, planned.sign) == (step.actuator, step.count, step.sign)
                };
                let planned = self.motion.first.iter().find(same)?;
                let crossing = self.ideal.crossing(step.actuator, planned.at, step.count, step.sign)?;
                Some(step.at - crossing)
            })
            .collect();
        offsets.sort_by(f64::total_cmp);
        // Without a measurement nothing fits, and the first comparison says so.
        self.offset = offsets.get(offsets.len().saturating_sub(1) / 2).copied().unwrap_or(0.0);
    }

    fn error(&self, step: &Step) -> Result<f64, String> {
        let at = step.at - self.offset;
        self.ideal.edge_error(step.actuator, at, step.count, step.sign).ok_or_else(|| {
            format!(
                "{} steps {} at {:.6} s, more than a millisecond from where it belongs in motion {} (planned at {:.3} s): the board moves otherwise than planned",
                step.actuator.name(),
                if step.sign > 0 { "forward" } else { "backward" },
                step.at * 1e-9,
                self.number,
                self.planned_at()
            )
        })
    }
}

/// Returns the motor whose steps this motor makes.
fn master(motion: &PlannedMotion, actuator: Actuator) -> Actuator {
    motion.config.actuators[actuator].and_then(|motor| motor.slaved_to).unwrap_or(actuator)
}

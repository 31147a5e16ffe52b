//! The ideal motion of a job, recorded from a native run: pieces of trajectory, and the number of steps
//! that belong to them.

use std::sync::Arc;

use motion::oracle::{Ideal, Warp};
use motion::trajectory::{Piece, TakenBack};
use motion::{FilterConfig, MotionConfig};
use units::{PerActuator, StepCount};

use super::step::Step;

/// Number of first steps remembered of each motion, to find out when another board began it.
pub const FIRST_STEPS: usize = 64;

/// Motion of a job from one rest to the next.
#[derive(Clone, Debug)]
pub struct PlannedMotion {
    /// Configuration at that time: commands may change it at rest.
    pub config: MotionConfig,
    /// Compensation between program and motors.
    warp: Option<Arc<Warp>>,
    pieces: Vec<(Piece, FilterConfig)>,
    /// Times at which trajectory was taken back: after so many pieces.
    taken_back: Vec<(usize, TakenBack)>,
    /// Beginning of the first piece, nanoseconds from boot.
    pub start: f64,
    /// Positions of the motors before the first step.
    pub counts: PerActuator<StepCount>,
    /// Steps of each motor; those of slaves are their masters'.
    pub steps: PerActuator<u64>,
    /// First steps in order of time.
    pub first: Vec<Step>,
    /// Number of searches for a switch that had begun when the motion ended.
    pub searches: usize,
}

impl PlannedMotion {
    fn new((config, warp): (MotionConfig, Option<Arc<Warp>>), piece: &Piece) -> Self {
        Self {
            config,
            warp,
            pieces: Vec::new(),
            taken_back: Vec::new(),
            start: piece.start.to_num::<f64>() * f64::from(units::TICK_NANOSECONDS),
            counts: PerActuator::default(),
            steps: PerActuator::default(),
            first: Vec::new(),
            searches: 0,
        }
    }

    /// Returns the pieces of trajectory, before any filter, in order, without those that were taken back.
    pub fn pieces(&self) -> impl Iterator<Item = &Piece> {
        let is_left = |index: usize, piece: &Piece| {
            !self.taken_back.iter().any(|(count, taken)| index < *count && piece.start >= taken.from)
        };
        self.pieces
            .iter()
            .enumerate()
            .filter(move |(index, (piece, _))| is_left(*index, piece))
            .map(|(_, (piece, _))| piece)
    }

    /// Returns the filters that were in force at the motion's beginning.
    #[must_use]
    pub fn filters(&self) -> FilterConfig {
        self.pieces.first().map_or(FilterConfig::NONE, |(_, filters)| *filters)
    }

    /// Returns the ideal trajectory.
    #[must_use]
    pub fn ideal(&self) -> Ideal {
        self.ideal_through(None)
    }

    /// Returns the trajectory with these filters all along, or with those that were in force.
    #[must_use]
    pub fn ideal_through(&self, other: Option<FilterConfig>) -> Ideal {
        let mut ideal = Ideal::new(self.config);
        ideal.set_warp(self.warp.clone());
        let mut taken_back = self.taken_back.iter().peekable();
        for (index, (piece, filters)) in self.pieces.iter().enumerate() {
            while let Some((_, taken)) = taken_back.next_if(|(count, _)| *count <= index) {
                ideal.take_back(taken);
            }
            ideal.set_filters(other.unwrap_or(*filters));
            ideal.push(piece);
        }
        taken_back.for_each(|(_, taken)| ideal.take_back(taken));
        ideal
    }
}

/// Motion of a job in order.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    motions: Vec<PlannedMotion>,
    searches: usize,
}

impl Plan {
    /// Creates an empty plan.
    pub(super) const fn new() -> Self {
        Self { motions: Vec::new(), searches: 0 }
    }

    /// Returns those motions that have steps.
    pub fn motions(&self) -> impl Iterator<Item = &PlannedMotion> {
        self.motions.iter().filter(|motion| !motion.first.is_empty())
    }

    /// Notes that a search for a switch begins.
    pub(super) const fn search_begins(&mut self) {
        self.searches += 1;
    }

    /// Adds the next piece; with a machine, it begins a motion.
    pub(super) fn push(
        &mut self,
        begins: Option<(MotionConfig, Option<Arc<Warp>>)>,
        piece: &Piece,
        filters: FilterConfig,
    ) {
        self.motions.extend(begins.map(|machine| PlannedMotion::new(machine, piece)));
        if let Some(motion) = self.motions.last_mut() {
            motion.pieces.push((*piece, filters));
            motion.searches = self.searches;
        }
    }

    /// Replaces trajectory that was taken back by later pieces.
    pub(super) fn take_back(&mut self, taken: &TakenBack) {
        if let Some(motion) = self.motions.last_mut() {
            motion.taken_back.push((motion.pieces.len(), *taken));
        }
    }

    /// Takes the next step; `before`: the motors' positions before it.
    pub(super) fn take(&mut self, step: &Step, before: &PerActuator<StepCount>) {
        // The feed works ahead of the motors: the newest motion need not have begun to move.
        let Some(motion) = self.motions.iter_mut().rev().find(|motion| motion.start <= step.at) else { return };
        if motion.first.is_empty() {
            motion.counts = *before;
        }
        if motion.first.len() < FIRST_STEPS {
            motion.first.push(*step);
        }
        motion.steps[step.actuator] += 1;
    }
}

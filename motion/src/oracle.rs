//! The reference for step times: slow, obvious, in `f64`, sharing no arithmetic with the fast path.
//!
//! The reference takes the ideal trajectory as pieces (constant jerk along a path, from
//! [`crate::Motion::last_piece`]) and gives the ideal position of a motor at any time, and the distance in
//! time by which an edge is from the ideal crossing of its half step. Input shaping and pressure advance
//! follow their definitions, from the table of pulses on. The plan itself (limits, junctions) is not checked
//! here but by the planner's laws.

use std::{sync::Arc, vec::Vec};

mod compensation;
mod kinematics;
mod path;
mod version;

pub use compensation::Warp;
use units::{Actuator, PerAxis};

use crate::{
    FilterConfig, MotionConfig, PressureAdvance,
    path::Curve,
    trajectory::{Piece, TakenBack, TickTime},
};
use version::{LONGEST_LOOK_BACK_NS, Timed, Version};

/// Positions closer than this to a crossing, in steps, count as on it: four times the rounding of a knot. A
/// motor that creeps slower than a step a second, or that turns right on a crossing, has no better defined
/// time.
pub const ON_CROSSING_STEPS: f64 = 2.5e-7;

/// The ideal trajectory of all motors, filters included.
#[derive(Clone, Debug)]
pub struct Ideal {
    config: MotionConfig,
    /// Filters of the pieces to come.
    filters: FilterConfig,
    /// Compensation between the program and the motors from the next piece on.
    warp: Option<Arc<Warp>>,
    /// Versions of the trajectory: the first plan, and another after each time that trajectory was taken
    /// back. Never empty.
    versions: Vec<Version>,
}

/// Upper ends of the bins of [`StepError::bins`], ns.
pub const BIN_ENDS_NS: [f64; 11] = [1.0, 2.0, 3.0, 4.0, 5.0, 10.0, 20.0, 50.0, 100.0, 250.0, 1000.0];

/// Time errors of the edges of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepError {
    /// Number of edges compared.
    pub edges: u64,
    /// Greatest error of an edge, ns.
    pub max: f64,
    /// Sum of squares, ns^2.
    sum_of_squares: f64,
    /// Number of edges that were off by less than each of [`BIN_ENDS_NS`] and no less than the one before;
    /// the last bin counts the rest.
    pub bins: [u64; BIN_ENDS_NS.len() + 1],
}

impl StepError {
    /// Adds one edge's error in ns.
    pub fn add(&mut self, error: f64) {
        self.edges += 1;
        self.max = self.max.max(error);
        self.sum_of_squares += error * error;
        self.bins[BIN_ENDS_NS.partition_point(|end| *end <= error)] += 1;
    }

    /// Adds the errors counted elsewhere.
    pub fn merge(&mut self, other: &Self) {
        self.edges += other.edges;
        self.max = self.max.max(other.max);
        self.sum_of_squares += other.sum_of_squares;
        self.bins.iter_mut().zip(other.bins).for_each(|(bin, more)| *bin += more);
    }

    /// Root of the mean square, ns.
    #[must_use]
    pub fn rms(&self) -> f64 {
        if self.edges == 0 { 0.0 } else { (self.sum_of_squares / self.edges as f64).sqrt() }
    }
}

impl Ideal {
    /// Creates a reference without any motion yet.
    #[must_use]
    pub fn new(config: MotionConfig) -> Self {
        Self { config, filters: config.filters, warp: None, versions: std::vec![Version::first()] }
    }

    /// Changes the machine at rest: steps per millimetre, geometry.
    pub fn configure(&mut self, config: MotionConfig) {
        self.config = config;
    }

    /// The filters in force from the next piece on ([`crate::Motion::filters_in_force`]); at first those of
    /// the configuration.
    pub fn set_filters(&mut self, filters: FilterConfig) {
        self.filters = filters;
    }

    /// The compensation in force from the next piece on: it changes at rest only.
    pub fn set_warp(&mut self, warp: Option<Arc<Warp>>) {
        self.warp = warp;
    }

    /// Adds a piece. A piece that begins before the last one ends replaces the rest of it (a hold, a stop, an
    /// override).
    pub fn push(&mut self, piece: &Piece) {
        let start = nanoseconds(piece.start);
        let Some(version) = self.versions.last_mut() else { return };
        let same = version.pieces.last().filter(|last| last.piece.path.curve == piece.path.curve);
        let table = match (same, &piece.path.curve) {
            (Some(last), _) => last.table.clone(),
            (None, Curve::Spline(spline)) => Some(Arc::new(path::Table::new(spline))),
            _ => None,
        };
        version.pieces.push(Timed { start, piece: *piece, filters: self.filters, warp: self.warp.clone(), table });
    }

    /// Trajectory was taken back ([`crate::Motion::last_taken_back`]): the next pieces replace it. Of several
    /// times that were missed, the one that went back farthest counts.
    pub fn take_back(&mut self, taken: &TakenBack) {
        let (from, out) = (nanoseconds(taken.from), nanoseconds(taken.out));
        let Some(last) = self.versions.last_mut() else { return };
        if last.from == out {
            // Nothing was put out since the last time.
            last.cut(from);
            return;
        }
        let next = last.followed_by(from, out);
        self.versions.push(next);
    }

    /// Forgets pieces that have no influence after `at` (ns) any more.
    pub fn forget_before(&mut self, at: f64) {
        let at = at - LONGEST_LOOK_BACK_NS;
        let over = self.versions.iter().skip(1).take_while(|next| next.from < at).count();
        self.versions.drain(..over);
        self.versions.iter_mut().for_each(|version| version.forget_before(at));
    }

    /// Returns the machine's ideal position and velocity at `at` ns. `None` before any piece is known.
    #[must_use]
    pub fn machine(&self, at: f64) -> Option<(PerAxis<f64>, PerAxis<f64>)> {
        self.machine_by(self.number_at(at), at)
    }

    /// The version of the trajectory that is put out at `at` ns.
    fn number_at(&self, at: f64) -> usize {
        self.versions.partition_point(|version| version.from <= at).saturating_sub(1)
    }

    fn version_at(&self, at: f64) -> Option<&Version> {
        self.versions.get(self.number_at(at))
    }

    /// Returns the times at which trajectory was taken back, ns, and the jumps of the output there.
    #[cfg(test)]
    pub(crate) fn jumps(&self) -> Vec<(f64, PerAxis<f64>, PerAxis<f64>)> {
        let jump = |number: usize| {
            let at = self.versions[number].from;
            let ((place, speed), (place_was, speed_was)) =
                (self.machine_by(number, at)?, self.machine_by(number - 1, at)?);
            let less = |of: PerAxis<f64>, was: PerAxis<f64>| PerAxis(core::array::from_fn(|n| of.0[n] - was.0[n]));
            Some((at, less(place, place_was), less(speed, speed_was)))
        };
        (1..self.versions.len()).filter_map(jump).collect()
    }

    /// Returns position and velocity by the plan of this number.
    fn machine_by(&self, number: usize, at: f64) -> Option<(PerAxis<f64>, PerAxis<f64>)> {
        let version = self.versions.get(number)?;
        let filters = version.pieces.get(version.index(at))?.filters;
        let latency = filters.latency();
        if latency == 0.0 {
            return version.planned(at);
        }
        let (mut position, mut velocity) = version.planned(at - latency * 1e9)?;
        for (axis, shaper) in units::Axis::PRIMARY.into_iter().zip(filters.shapers) {
            let Some(pulses) = shaper.map(|shaper| shaper.pulses()) else { continue };
            (position[axis], velocity[axis]) = (0.0, 0.0);
            for pulse in pulses.as_slice() {
                let delay = latency + pulse.time - pulses.shift();
                let (there, speed) = version.planned(at - delay * 1e9)?;
                position[axis] += pulse.amplitude * there[axis];
                velocity[axis] += pulse.amplitude * speed[axis];
            }
        }
        for (index, advance) in filters.advance.into_iter().enumerate() {
            let (axis, Some(advance)) = (3 + index, advance) else { continue };
            if advance.factor > 0.0 {
                (position.0[axis], velocity.0[axis]) = self.extruder(number, axis, advance, latency, at)?;
            }
        }
        Some((position, velocity))
    }

    /// An extruder's position and speed by the plan of this number. The extruder goes over from the plan
    /// before, over one latency, by the cubic that begins with the difference in place and speed and ends
    /// without.
    fn extruder(
        &self,
        number: usize,
        axis: usize,
        advance: PressureAdvance,
        latency: f64,
        at: f64,
    ) -> Option<(f64, f64)> {
        let version = self.versions.get(number)?;
        let (place, speed) = version.averaged(axis, advance, at - latency * 1e9)?;
        let seconds = (at - version.from) * 1e-9;
        if number == 0 || seconds >= latency {
            return Some((place, speed));
        }
        let (place_was, speed_was) = self.extruder(number - 1, axis, advance, latency, version.from)?;
        let (place_is, speed_is) = version.averaged(axis, advance, version.from - latency * 1e9)?;
        let (ahead, faster) = (place_was - place_is, speed_was - speed_is);
        // a + b t + c t^2 + d t^3, and its slope, both zero after the latency.
        let c = -(3.0 * ahead + 2.0 * faster * latency) / latency.powi(2);
        let d = (2.0 * ahead + faster * latency) / latency.powi(3);
        let left = ahead + faster * seconds + c * seconds.powi(2) + d * seconds.powi(3);
        let slope = faster + 2.0 * c * seconds + 3.0 * d * seconds.powi(2);
        Some((place + left, speed + slope))
    }

    fn motor(&self, actuator: Actuator, axes: &PerAxis<f64>, at: f64) -> f64 {
        let version = self.version_at(at);
        let warp =
            version.and_then(|version| version.pieces.get(version.index(at))).and_then(|timed| timed.warp.as_deref());
        let axes = warp.map_or(axes.0, |warp| warp.motors(&axes.0));
        let mm = kinematics::motor(&self.config.kinematics, actuator, &axes);
        mm * self.config.actuators[actuator].map_or(0.0, |motor| motor.steps_per_mm)
    }

    /// Ideal position of a motor in steps at `at` ns. The position of a motor that turns round and round is
    /// given within a turn.
    #[must_use]
    pub fn steps(&self, actuator: Actuator, at: f64) -> Option<f64> {
        self.machine(at).map(|(position, _)| self.motor(actuator, &position, at))
    }

    /// Returns the steps as [`Self::steps`] does, in the turn nearest to `near` steps.
    fn steps_near(&self, actuator: Actuator, at: f64, near: f64) -> Option<f64> {
        let steps = self.steps(actuator, at)?;
        let turn = match self.config.kinematics.turn_of(actuator) {
            Some(degrees) => degrees * self.config.actuators[actuator].map_or(0.0, |motor| motor.steps_per_mm),
            None => return Some(steps),
        };
        Some(steps + ((near - steps) / turn).round() * turn)
    }

    /// Ideal speed of a motor in steps per second at `at` ns: how far it gets in 2 us.
    #[must_use]
    pub fn rate(&self, actuator: Actuator, at: f64) -> Option<f64> {
        let (before, after) = (self.steps(actuator, at - 1e3)?, self.steps(actuator, at + 1e3)?);
        let after = if (after - before).abs() > 1e5 { before } else { after };
        Some((after - before) / 2e-6)
    }

    /// Distance in ns from an edge at `at` ns, after which the motor stands on `count` having stepped by
    /// `sign`, to the ideal crossing of that half step. `None` when there is no such crossing within a
    /// millisecond.
    #[must_use]
    pub fn edge_error(&self, actuator: Actuator, at: f64, count: i32, sign: i32) -> Option<f64> {
        self.crossing(actuator, at, count, sign).map(|crossing| (crossing - at).abs())
    }

    /// Returns the time of the ideal crossing of that half step, the one nearest to `at` as far as that is
    /// defined.
    #[must_use]
    pub fn crossing(&self, actuator: Actuator, at: f64, count: i32, sign: i32) -> Option<f64> {
        let threshold = f64::from(count) - 0.5 * f64::from(sign);
        let beyond =
            |t: f64| self.steps_near(actuator, t, threshold).map(|steps| (steps - threshold) * f64::from(sign));
        if beyond(at)?.abs() <= ON_CROSSING_STEPS {
            return Some(at);
        }
        let mut window = 1.0;
        while window < 1e6 {
            let (mut before, mut after) = (at - window, at + window);
            if beyond(before)? < 0.0 && beyond(after)? >= 0.0 {
                // A millisecond halved thirty times is a femtosecond.
                for _ in 0..30 {
                    let middle = before + (after - before) / 2.0;
                    if beyond(middle)? < 0.0 {
                        before = middle;
                    } else {
                        after = middle;
                    }
                }
                return Some(after);
            }
            // A turn right at the crossing: near enough is there, crossing there is none.
            for near in [before, after] {
                if beyond(near)?.abs() <= ON_CROSSING_STEPS {
                    return Some(near);
                }
            }
            window *= 1.5;
        }
        // A turn so close behind the crossing that no window of these ends between the two.
        let near = |nanoseconds: &f64| beyond(at + nanoseconds).is_some_and(|off| off.abs() <= 4.0 * ON_CROSSING_STEPS);
        (0..4_000).map(|half| f64::from(half) * 0.5 - 1e3).filter(near).map(f64::abs).reduce(f64::min)
    }
}

/// Converts ticks to nanoseconds from boot.
fn nanoseconds(time: TickTime) -> f64 {
    time.to_num::<f64>() * f64::from(units::TICK_NANOSECONDS)
}

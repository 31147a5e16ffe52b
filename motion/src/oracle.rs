//! The reference for step times: slow, obvious, in `f64`, sharing no arithmetic with the fast path.
//!
//! It takes the ideal trajectory as pieces (constant jerk along a path, from [`crate::Motion::last_piece`]) and
//! answers where a motor ideally is at any time, and how far in time an edge is from the ideal crossing of its
//! half step. Input shaping and pressure advance it does by their definitions, from the table of pulses on. What it does not
//! check is the plan itself (limits, junctions); the planner's laws do.

use std::{sync::Arc, vec::Vec};

mod arms;
mod bed;
mod ways;

pub use bed::Warp;
use units::{Actuator, PerAxis};

use crate::{FilterConfig, MotionConfig, PressureAdvance, path::Curve, trajectory::Piece};

/// Positions closer than this to a crossing, in steps, count as on it: four times the rounding of a knot. A motor that
/// creeps slower than a step a second, or that turns right on a crossing, has no better defined time.
pub const ON_CROSSING_STEPS: f64 = 2.5e-7;

/// No filter looks back farther than this.
const LONGEST_LOOK_BACK_NS: f64 = 1e9;

/// The ideal trajectory of all motors, filters included.
#[derive(Clone, Debug)]
pub struct Ideal {
    config: MotionConfig,
    /// Filters of the pieces to come.
    filters: FilterConfig,
    /// What lies between the program and the motors from the next piece on.
    warp: Option<Arc<Warp>>,
    pieces: Vec<Timed>,
}

#[derive(Clone, Debug)]
struct Timed {
    /// Nanoseconds from boot.
    start: f64,
    piece: Piece,
    /// Those that were in force when it came: they hold until the next piece. They only change where the motors rest.
    filters: FilterConfig,
    warp: Option<Arc<Warp>>,
    /// Of its spline, if it has one.
    table: Option<Arc<ways::Table>>,
}

/// Where the bins of [`StepError::bins`] end, ns.
pub const BIN_ENDS_NS: [f64; 11] = [1.0, 2.0, 3.0, 4.0, 5.0, 10.0, 20.0, 50.0, 100.0, 250.0, 1000.0];

/// How far the edges of a run are from ideal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepError {
    /// Edges compared.
    pub edges: u64,
    /// Greatest distance, ns.
    pub max: f64,
    /// Sum of squares, ns^2.
    sum_of_squares: f64,
    /// How many edges were off by less than each of [`BIN_ENDS_NS`] and no less than the one before; last, by more.
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

    /// Root of the mean square, ns.
    #[must_use]
    pub fn rms(&self) -> f64 {
        if self.edges == 0 { 0.0 } else { (self.sum_of_squares / self.edges as f64).sqrt() }
    }
}

impl Ideal {
    /// No motion yet.
    #[must_use]
    pub const fn new(config: MotionConfig) -> Self {
        Self { config, filters: config.filters, warp: None, pieces: Vec::new() }
    }

    /// The machine has changed, at rest: steps per millimetre, geometry.
    pub fn configure(&mut self, config: MotionConfig) {
        self.config = config;
    }

    /// The filters in force from the next piece on ([`crate::Motion::filters_in_force`]); at first those of the configuration.
    pub fn set_filters(&mut self, filters: FilterConfig) {
        self.filters = filters;
    }

    /// The compensation in force from the next piece on: it changes at rest only.
    pub fn set_warp(&mut self, warp: Option<Arc<Warp>>) {
        self.warp = warp;
    }

    /// Adds a piece. One that begins before the last one ends replaces the rest of it (a hold, a stop, an override).
    pub fn push(&mut self, piece: &Piece) {
        let start = piece.start.to_num::<f64>() * f64::from(units::TICK_NANOSECONDS);
        let same = self.pieces.last().filter(|last| last.piece.path.curve == piece.path.curve);
        let table = match (same, &piece.path.curve) {
            (Some(last), _) => last.table.clone(),
            (None, Curve::Spline(spline)) => Some(Arc::new(ways::Table::new(spline))),
            _ => None,
        };
        self.pieces.push(Timed { start, piece: *piece, filters: self.filters, warp: self.warp.clone(), table });
    }

    /// Forgets pieces that have no influence after `at` (ns) any more.
    pub fn forget_before(&mut self, at: f64) {
        let keep = self.index(at - LONGEST_LOOK_BACK_NS).saturating_sub(1);
        self.pieces.drain(..keep);
    }

    fn index(&self, at: f64) -> usize {
        self.pieces.partition_point(|timed| timed.start <= at).saturating_sub(1)
    }

    /// Where the machine ideally is, and its velocity, at `at` ns. `None` before any piece is known.
    #[must_use]
    pub fn machine(&self, at: f64) -> Option<(PerAxis<f64>, PerAxis<f64>)> {
        let filters = self.pieces.get(self.index(at))?.filters;
        let latency = filters.latency();
        if latency == 0.0 {
            return self.planned(at);
        }
        let (mut position, mut velocity) = self.planned(at - latency * 1e9)?;
        for (axis, shaper) in units::Axis::PRIMARY.into_iter().zip(filters.shapers) {
            let Some(pulses) = shaper.map(|shaper| shaper.pulses()) else { continue };
            (position[axis], velocity[axis]) = (0.0, 0.0);
            for pulse in pulses.as_slice() {
                let delay = latency + pulse.time - pulses.shift();
                let (there, speed) = self.planned(at - delay * 1e9)?;
                position[axis] += pulse.amplitude * there[axis];
                velocity[axis] += pulse.amplitude * speed[axis];
            }
        }
        for (index, advance) in filters.advance.into_iter().enumerate() {
            let (axis, Some(advance)) = (3 + index, advance) else { continue };
            if advance.factor > 0.0 {
                (position.0[axis], velocity.0[axis]) = self.averaged(axis, advance, at - latency * 1e9)?;
            }
        }
        Some((position, velocity))
    }

    /// An extruder's advanced position and speed, averaged with a triangular weight around `at` ns: numerically, from the
    /// definition. Between the ends of pieces the integrand is of degree four at most, for which three Gauss points are exact.
    fn averaged(&self, axis: usize, advance: PressureAdvance, at: f64) -> Option<(f64, f64)> {
        let half = advance.smooth_time / 2.0 * 1e9;
        let (from, to) = (at - half, at + half);
        let mut cuts = std::vec![from, at, to];
        for timed in &self.pieces[self.index(from)..=self.index(to)] {
            cuts.extend([timed.start, timed.start + timed.piece.duration * 1e9]);
        }
        cuts.retain(|cut| (from..=to).contains(cut));
        cuts.sort_by(f64::total_cmp);
        let near = self.planned(at)?.0.0[axis];
        let (mut place, mut speed) = (0.0, 0.0);
        for cut in cuts.windows(2) {
            let (middle, reach) = ((cut[0] + cut[1]) / 2.0, (cut[1] - cut[0]) / 2.0);
            for (node, weight) in [(-0.6_f64.sqrt(), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6_f64.sqrt(), 5.0 / 9.0)] {
                let x = middle + node * reach;
                let share = weight * reach * (self.advanced(axis, advance.factor, x)? - near) / (half * half);
                place += share * (half - (at - x).abs());
                speed += share * (x - at).signum();
            }
        }
        Some((near + place, speed * 1e9))
    }

    /// Position plus K times speed, where X or Y move and filament is pushed.
    fn advanced(&self, axis: usize, factor: f64, at: f64) -> Option<f64> {
        let (position, velocity) = self.planned(at)?;
        let pushes = velocity.0[axis] > 0.0 && (velocity.0[0] != 0.0 || velocity.0[1] != 0.0);
        Some(position.0[axis] + if pushes { factor * velocity.0[axis] } else { 0.0 })
    }

    /// The trajectory before the filters.
    fn planned(&self, at: f64) -> Option<(PerAxis<f64>, PerAxis<f64>)> {
        let Timed { start, piece, table, .. } = self.pieces.get(self.index(at))?;
        let seconds = (at - start) * 1e-9;
        let resting = seconds > piece.duration || seconds < 0.0;
        let t = seconds.clamp(0.0, piece.duration);
        let way = piece.speed * t + piece.acceleration * t.powi(2) / 2.0 + piece.jerk * t.powi(3) / 6.0;
        let rate = piece.speed + piece.acceleration * t + piece.jerk * t.powi(2) / 2.0;
        let speed = if resting { 0.0 } else { rate };
        let (position, mut velocity) = ways::place(&piece.path, table.as_deref(), piece.base + way);
        for axis in units::Axis::ALL {
            velocity[axis] *= speed;
        }
        Some((position, velocity))
    }

    fn motor(&self, actuator: Actuator, axes: &PerAxis<f64>, at: f64) -> f64 {
        let warp = self.pieces.get(self.index(at)).and_then(|timed| timed.warp.as_deref());
        let axes = warp.map_or(axes.0, |warp| warp.motors(&axes.0));
        let mm = arms::motor(&self.config.kinematics, actuator, &axes);
        mm * self.config.actuators[actuator].map_or(0.0, |motor| motor.steps_per_mm)
    }

    /// Ideal position of a motor in steps at `at` ns. One that turns round and round is given within a turn.
    #[must_use]
    pub fn steps(&self, actuator: Actuator, at: f64) -> Option<f64> {
        self.machine(at).map(|(position, _)| self.motor(actuator, &position, at))
    }

    /// As [`Self::steps`], in the turn nearest to `near` steps.
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

    /// Distance in ns from an edge at `at` ns, after which the motor stands on `count` having stepped by `sign`, to the
    /// ideal crossing of that half step. `None` when there is no such crossing within a millisecond.
    #[must_use]
    pub fn edge_error(&self, actuator: Actuator, at: f64, count: i32, sign: i32) -> Option<f64> {
        self.crossing(actuator, at, count, sign).map(|crossing| (crossing - at).abs())
    }

    /// When the ideal crossing of that half step is, as near `at` as can be said.
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

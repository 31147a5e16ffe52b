//! The limits of a move that follow from its direction.
//!
//! All limits of a block are found here, once, when it is submitted: [`Envelope`] holds the greatest path
//! speed and acceleration that no axis and no motor exceeds.

use core::f64::consts::SQRT_2;

use units::{Actuator, Axis, MmPerSecond2, PerActuator, PerAxis};

use super::block::Block;
use crate::{config::Limits, kinematics::Strain, least, moves::Move, square_root};

/// Changes smaller than this (mm or degrees) do not count as movement of an axis or motor.
pub(crate) const SMALLEST: f64 = 0.000_1;

/// Shortest time in which the acceleration reaches its limit, seconds; stands in where no jerk limits an
/// axis.
const SHORTEST_RISE: f64 = 0.000_5;

/// Direction and limits of a move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Envelope {
    /// Length of the path, mm.
    pub length: f64,
    /// Greatest path speed, mm/s.
    pub speed_limit: f64,
    /// Path acceleration, mm/s^2.
    pub acceleration: f64,
    /// Unit direction of X Y Z at the beginning; `None` when only auxiliary axes move.
    pub primary: Option<[f64; 3]>,
    /// Bend of X Y Z at the beginning ([`crate::path::Curve::bend`]).
    pub bend: [f64; 3],
    /// Path jerk, mm/s^3; zero where profiles are trapezoids.
    pub jerk: f64,
    /// Clearance, mm, as in [`Block`].
    pub clearance: f64,
}

fn root_of_squares(parts: &[f64]) -> f64 {
    square_root(parts.iter().map(|part| part * part).sum())
}

impl Envelope {
    /// Returns the limits of a move by `delta` that turns the motors by `motors` (mm each). `None` when
    /// nothing moves enough to count.
    #[inline]
    pub fn new(delta: &PerAxis<f64>, motors: &PerActuator<f64>, limits: &Limits) -> Option<Self> {
        let moves = |part: &f64| libm::fabs(*part) >= SMALLEST;
        let [x, y, z, ..] = delta.0;
        let cartesian = [x, y, z];
        if cartesian.iter().any(moves) {
            let length = root_of_squares(&cartesian);
            let unit = cartesian.map(|part| part / length);
            let mut envelope = Self {
                length,
                speed_limit: f64::INFINITY,
                acceleration: limits.acceleration.get(),
                primary: Some(unit),
                bend: [0.0; 3],
                jerk: 0.0,
                clearance: f64::INFINITY,
            };
            envelope.limit_cartesian(&unit, limits);
            for actuator in Actuator::ALL {
                envelope.limit_rate(actuator, motors, limits);
                // Extruders and other auxiliary motors never slow the acceleration of a combined move.
                if (actuator as usize) < Axis::PRIMARY.len() {
                    envelope.limit_acceleration(actuator, motors, limits);
                }
            }
            return Some(envelope);
        }
        // With two motors for the same axes (coreXY), one of them may just move enough to count although no
        // axis does; such a move is none of A, B or C.
        let auxiliary = |actuator: &Actuator| *actuator as usize >= Axis::PRIMARY.len();
        let mut moving = Actuator::ALL.into_iter().filter(|motor| auxiliary(motor) && moves(&motors[*motor]));
        let first = moving.next()?;
        let alone = moving.next().is_none();
        Some(Self::auxiliary(first, alone, motors, limits))
    }

    /// Returns the limits of a move of A, B or C alone. A motor alone uses its own acceleration outright,
    /// even above the default.
    fn auxiliary(first: Actuator, alone: bool, motors: &PerActuator<f64>, limits: &Limits) -> Self {
        let mut envelope = Self {
            length: root_of_squares(&motors.0),
            speed_limit: f64::INFINITY,
            acceleration: limits.acceleration.get(),
            primary: None,
            bend: [0.0; 3],
            jerk: 0.0,
            clearance: f64::INFINITY,
        };
        for actuator in Actuator::ALL {
            envelope.limit_rate(actuator, motors, limits);
            if !alone {
                envelope.limit_acceleration(actuator, motors, limits);
            }
        }
        if let (true, Some(own)) = (alone, limits.actuator_acceleration[first]) {
            envelope.acceleration = own.get();
        }
        envelope
    }

    /// Lowers the speed to what axes and path allow in this direction.
    pub fn limit_cartesian(&mut self, unit: &[f64; 3], limits: &Limits) {
        for (part, limit) in unit.iter().zip(limits.axis_speed) {
            if let (Some(limit), true) = (limit, *part != 0.0) {
                self.speed_limit = least(self.speed_limit, limit.get() / libm::fabs(*part));
            }
        }
        if let Some(limit) = limits.max_speed {
            self.speed_limit = least(self.speed_limit, limit.get());
        }
    }

    /// Lowers the speed to what a motor allows that moves this far along the block.
    pub fn limit_rate(&mut self, actuator: Actuator, motors: &PerActuator<f64>, limits: &Limits) {
        let share = libm::fabs(motors[actuator]) / self.length;
        if share > 0.0 {
            self.speed_limit = least(self.speed_limit, limits.actuator_rate[actuator].get() / share);
        }
    }

    /// Lowers the acceleration to what a motor allows that moves this far along the block.
    pub fn limit_acceleration(&mut self, actuator: Actuator, motors: &PerActuator<f64>, limits: &Limits) {
        let share = libm::fabs(motors[actuator]) / self.length;
        if let (Some(own), true) = (limits.actuator_acceleration[actuator], share > 0.0) {
            self.acceleration = least(self.acceleration, own.get() / share);
        }
    }

    /// Limits a move whose motors do not run straight. The acceleration of a motor is its way's slope times
    /// the path's acceleration plus its bend times the speed squared: the bend may take half of what the
    /// motor can do, the slope gets what is left.
    pub fn limit_strain(&mut self, strain: &Strain, limits: &Limits) {
        self.clearance = strain.clearance;
        let own = |actuator: Actuator| limits.actuator_acceleration[actuator].map(MmPerSecond2::get);
        for actuator in Actuator::ALL {
            if let (Some(own), true) = (own(actuator), strain.bend[actuator] > 0.0) {
                self.speed_limit = least(self.speed_limit, square_root(0.5 * own / strain.bend[actuator]));
            }
        }
        let speed_sq = self.speed_limit * self.speed_limit;
        for actuator in Actuator::ALL {
            if let (Some(own), true) = (own(actuator), strain.bend[actuator] > 0.0) {
                let left = own - strain.bend[actuator] * speed_sq;
                if strain.slope[actuator] * self.acceleration > left {
                    self.acceleration = left / strain.slope[actuator];
                }
            }
        }
    }

    /// The block of this move, its corner not yet known.
    pub fn block(&self, request: &Move) -> Block {
        Block {
            target: request.target,
            length: self.length,
            acceleration: self.acceleration,
            jerk: self.jerk,
            speed_limit: self.speed_limit,
            requested: request.feed_rate.get(),
            clearance: self.clearance,
            power: request.power,
            mode: request.mode,
            curved: !request.curve.is_line(),
            tag: request.tag,
            part: request.part,
            ..Block::EMPTY
        }
    }

    /// Sets the jerk of a straight move, if any is configured.
    pub(crate) fn limit_straight_jerk(&mut self, limits: &Limits) {
        if !limits.has_jerk() {
            return;
        }
        let mut jerk = limits.jerk.map_or(f64::INFINITY, |jerk| jerk.get());
        let shares = self.primary.unwrap_or_default();
        for (part, limit) in shares.iter().zip(limits.axis_jerk) {
            if let (Some(limit), true) = (limit, *part != 0.0) {
                jerk = least(jerk, limit.get() / libm::fabs(*part));
            }
        }
        self.limit_jerk(jerk, &shares, limits);
    }

    /// Sets the jerk. Acceleration and jerk are rounded down to steps of a fourth root of two, so that they
    /// stay the same from chord to chord of a curve.
    ///
    /// `shares` is how much of a millimetre of path each of X Y Z moves at most.
    pub(crate) fn limit_jerk(&mut self, jerk: f64, shares: &[f64; 3], limits: &Limits) {
        let mut unit = limits.jerk.map_or(f64::INFINITY, |jerk| jerk.get());
        for (part, limit) in shares.iter().zip(limits.axis_jerk) {
            if let (Some(limit), true) = (limit, *part != 0.0) {
                unit = least(unit, limit.get());
            }
        }
        self.acceleration = rounded_down(self.acceleration, limits.acceleration.get());
        let fastest = self.acceleration / SHORTEST_RISE;
        self.jerk = if jerk < fastest { rounded_down(jerk, unit) } else { fastest };
    }
}

/// The greatest `unit * 2^(n/4)` that is not above `value`.
fn rounded_down(value: f64, unit: f64) -> f64 {
    let n = libm::floor(4.0 * libm::log2(value / unit) + 1e-9);
    least(unit * power_of_two(n), value)
}

/// `2^(quarters/4)` of a whole number of quarters, rounded as [`libm::exp2`] does it, which has a table of
/// 4 kB for any exponent.
fn power_of_two(quarters: f64) -> f64 {
    /// 2 to the power of no, one, two and three quarters.
    const ROOTS: [f64; 4] = [1.0, 1.189_207_115_002_721, SQRT_2, 1.681_792_830_507_429];
    let whole = libm::floor(0.25 * quarters);
    let root = ROOTS.get((quarters - 4.0 * whole) as usize);
    libm::ldexp(root.copied().unwrap_or(1.0), whole as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use units::{MmPerSecond, MmPerSecond2};

    fn limits() -> Limits {
        Limits {
            axis_speed: [Some(MmPerSecond(100.0)), None, Some(MmPerSecond(5.0))],
            actuator_rate: PerActuator([MmPerSecond(200.0); units::MAX_ACTUATORS]),
            acceleration: MmPerSecond2(1_000.0),
            ..Limits::DEFAULT
        }
    }

    fn envelope(delta: [f64; 6], motors: [f64; 6], limits: &Limits) -> Envelope {
        Envelope::new(&PerAxis(delta), &PerActuator(motors), limits).expect("it moves")
    }

    #[test]
    fn the_slowest_axis_sets_the_path_speed() {
        let diagonal = [3.0, 4.0, 0.0, 0.0, 0.0, 0.0];
        assert!((envelope(diagonal, diagonal, &limits()).speed_limit - 100.0 / 0.6).abs() < 1e-9);
        let with_z = [3.0, 0.0, 4.0, 0.0, 0.0, 0.0];
        assert!((envelope(with_z, with_z, &limits()).speed_limit - 5.0 / 0.8).abs() < 1e-9);
        let capped = Limits { max_speed: Some(MmPerSecond(50.0)), ..limits() };
        assert_eq!(envelope(diagonal, diagonal, &capped).speed_limit, 50.0);
    }

    #[test]
    fn motors_that_work_together_limit_speed_and_acceleration_by_their_own_share() {
        let mut limits = limits();
        limits.actuator_acceleration[Actuator::Alpha] = Some(MmPerSecond2(700.0));
        // A corexy diagonal: alpha makes both axes' way.
        let envelope = envelope([0.0, 5.0, 0.0, 0.0, 0.0, 0.0], [10.0, 0.0, 0.0, 0.0, 0.0, 0.0], &limits);
        assert_eq!((envelope.speed_limit, envelope.acceleration), (100.0, 350.0));
    }

    #[test]
    fn an_extruder_limits_the_rate_of_a_combined_move_but_not_its_acceleration() {
        let mut limits = limits();
        limits.actuator_rate[Actuator::Delta] = MmPerSecond(10.0);
        limits.actuator_acceleration[Actuator::Delta] = Some(MmPerSecond2(1.0));
        let delta = [0.0, 10.0, 0.0, 2.0, 0.0, 0.0];
        let envelope = envelope(delta, delta, &limits);
        assert_eq!((envelope.speed_limit, envelope.acceleration, envelope.length), (50.0, 1_000.0, 10.0));
    }

    #[test]
    fn a_lone_extruder_uses_its_own_acceleration_even_above_the_default() {
        let mut limits = limits();
        limits.actuator_acceleration[Actuator::Delta] = Some(MmPerSecond2(5_000.0));
        let alone = [0.0, 0.0, 0.0, -2.0, 0.0, 0.0];
        let envelope_alone = envelope(alone, alone, &limits);
        assert_eq!((envelope_alone.acceleration, envelope_alone.length, envelope_alone.primary), (5_000.0, 2.0, None));
        let two = [0.0, 0.0, 0.0, 3.0, 4.0, 0.0];
        limits.actuator_acceleration[Actuator::Epsilon] = Some(MmPerSecond2(400.0));
        assert_eq!(envelope(two, two, &limits).acceleration, 500.0, "together each limits by its share");
    }

    #[test]
    fn what_hardly_moves_does_not_count() {
        let tiny = [0.000_05, 0.0, 0.0, -0.000_09, 0.0, 0.0];
        assert!(Envelope::new(&PerAxis(tiny), &PerActuator(tiny), &limits()).is_none());
    }

    #[test]
    fn quarters_of_a_power_of_two_are_those_of_the_library() {
        for quarters in -4000..4000 {
            let quarters = f64::from(quarters);
            assert_eq!(power_of_two(quarters), libm::exp2(0.25 * quarters), "{quarters}");
        }
        for beyond in [-1e9, 1e9, f64::NEG_INFINITY, f64::INFINITY] {
            assert_eq!(power_of_two(beyond), libm::exp2(0.25 * beyond), "{beyond}");
        }
    }

    #[test]
    fn the_bend_of_a_motor_takes_half_of_its_acceleration_and_the_slope_the_rest() {
        let mut limits = limits();
        limits.actuator_acceleration[Actuator::Alpha] = Some(MmPerSecond2(600.0));
        let still = PerActuator([0.0; units::MAX_ACTUATORS]);
        let mut strain = Strain { slope: still, bend: still, clearance: 7.0 };
        (strain.slope[Actuator::Alpha], strain.bend[Actuator::Alpha]) = (2.0, 0.03);
        let x = [10.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let mut fast = envelope(x, x, &Limits { axis_speed: [None; 3], ..limits });
        fast.limit_strain(&strain, &limits);
        assert!((fast.speed_limit - 100.0).abs() < 1e-9, "0.03 v^2 is half of 600");
        assert!((fast.acceleration - 150.0).abs() < 1e-9, "a slope of 2 takes the other half");
        assert_eq!(fast.clearance, 7.0);
    }
}

//! Limits met by a move that asks for more than it is given.

use core::fmt;

use motion::path::{Curve, Path};
use motion::{Block, Limits, MotionConfig};
use units::{Actuator, Axis, MmPerSecond, PerActuator, PerAxis};

/// Number of places looked at, beside the end, on a path along which motors do not run straight.
const PLACES: u32 = 8;
/// Distance of the look ahead from a place, as a share of the path.
const AHEAD: f64 = 1e-4;
/// Greatest ratio of allowed to given value at which a move has met a limit; less may lie between two places.
const NEAR: f64 = 1.1;

/// A limit of speed or acceleration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// Speed of the X, Y or Z component.
    AxisSpeed(Axis),
    /// Speed along the path.
    PathSpeed,
    /// Rate of a motor.
    MotorRate(Actuator),
    /// Flow of filament, mm3/s.
    Flow,
    /// Acceleration that a bend of the path takes, or that arms take on a straight one.
    Bend,
    /// Acceleration of a motor of X, Y or Z.
    MotorAcceleration(Actuator),
}

impl Limit {
    /// Number of limits there are.
    pub const COUNT: usize = 15;

    /// All limits in their order.
    pub const ALL: [Self; Self::COUNT] = [
        Self::AxisSpeed(Axis::X),
        Self::AxisSpeed(Axis::Y),
        Self::AxisSpeed(Axis::Z),
        Self::PathSpeed,
        Self::MotorRate(Actuator::Alpha),
        Self::MotorRate(Actuator::Beta),
        Self::MotorRate(Actuator::Gamma),
        Self::MotorRate(Actuator::Delta),
        Self::MotorRate(Actuator::Epsilon),
        Self::MotorRate(Actuator::Zeta),
        Self::Flow,
        Self::Bend,
        Self::MotorAcceleration(Actuator::Alpha),
        Self::MotorAcceleration(Actuator::Beta),
        Self::MotorAcceleration(Actuator::Gamma),
    ];

    /// Returns the limit's place in [`Self::ALL`].
    #[must_use]
    pub const fn index(self) -> usize {
        match self {
            Self::AxisSpeed(axis) => axis as usize,
            Self::PathSpeed => 3,
            Self::MotorRate(motor) => 4 + motor as usize,
            Self::Flow => 10,
            Self::Bend => 11,
            Self::MotorAcceleration(motor) => 12 + motor as usize,
        }
    }
}

/// Writes the limit as the configuration calls it.
impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AxisSpeed(axis) => write!(f, "{}_axis_max_speed", axis.letter().to_ascii_lowercase()),
            Self::PathSpeed => f.write_str("max_speed"),
            Self::MotorRate(motor) => write!(f, "{}.max_rate", motor.name()),
            Self::Flow => f.write_str("flow (M203 V)"),
            Self::Bend => f.write_str("acceleration in bends"),
            Self::MotorAcceleration(motor) => write!(f, "{}.acceleration", motor.name()),
        }
    }
}

/// Limit that a move is above.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    pub limit: Limit,
    /// Value asked of the axis or motor, and the most allowed: mm/s, or mm/s2.
    pub asked: f64,
    pub most: f64,
    /// Speed or acceleration of the path that the limit allows.
    pub allows: f64,
}

/// Greatest demand of a move on axes and motors for each mm of its path.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Demand {
    axes: [f64; 3],
    motors: PerActuator<f64>,
}

impl Demand {
    /// Returns the demand of a block that begins there, along this curve.
    pub fn of(config: &MotionConfig, from: &PerAxis<f64>, block: &Block, curve: Curve) -> Self {
        let path = Path::new(*from, &block.target, block.length, curve);
        let mut demand = Self::default();
        if curve.is_line() && config.kinematics.is_linear() {
            demand.between(config, [from, &block.target], block.length);
            return demand;
        }
        let ahead = AHEAD * block.length;
        for place in 0..=PLACES {
            let s = (block.length - ahead) * f64::from(place) / f64::from(PLACES);
            demand.between(config, [&path.point(s), &path.point(s + ahead)], ahead);
        }
        demand
    }

    /// Raises the demand to that between two points so many mm apart.
    fn between(&mut self, config: &MotionConfig, [from, to]: [&PerAxis<f64>; 2], length: f64) {
        let [here, there] = [from, to].map(|place| config.kinematics.actuators(place));
        for (most, axis) in self.axes.iter_mut().zip(Axis::PRIMARY) {
            *most = most.max(libm::fabs(to[axis] - from[axis]) / length);
        }
        for motor in Actuator::ALL {
            self.motors[motor] = self.motors[motor].max(libm::fabs(there[motor] - here[motor]) / length);
        }
    }

    /// Returns the limits of speed that a move along this path at `asked` mm/s is above.
    pub fn speeds(&self, limits: &Limits, asked: f64) -> impl Iterator<Item = Met> {
        let axes = Axis::PRIMARY.into_iter().zip(limits.axis_speed).zip(self.axes);
        let axes = axes.map(|((axis, most), share)| (Limit::AxisSpeed(axis), most.map(MmPerSecond::get), share));
        let moves = self.axes.iter().any(|share| *share > 0.0);
        let path = (Limit::PathSpeed, limits.max_speed.map(MmPerSecond::get), if moves { 1.0 } else { 0.0 });
        let (rates, shares) = (limits.actuator_rate, self.motors);
        let motors = Actuator::ALL.into_iter();
        let motors = motors.map(move |motor| (Limit::MotorRate(motor), Some(rates[motor].get()), shares[motor]));
        axes.chain([path]).chain(motors).filter_map(move |(limit, most, share)| met(limit, most?, share, asked))
    }

    /// Returns the limits of acceleration that a move with `asked` mm/s2 is above.
    pub fn accelerations(&self, limits: &Limits, asked: f64) -> impl Iterator<Item = Met> {
        let (own, shares) = (limits.actuator_acceleration, self.motors);
        let motors = Actuator::ALL.into_iter().take(Axis::PRIMARY.len());
        motors.filter_map(move |motor| met(Limit::MotorAcceleration(motor), own[motor]?.get(), shares[motor], asked))
    }
}

fn met(limit: Limit, most: f64, share: f64, asked: f64) -> Option<Met> {
    let own = share * asked;
    (own > most * 1.000_001).then(|| Met { limit, asked: own, most, allows: most / share })
}

/// Returns the limit that a move given no more than this has met: the first of those that allow least, or
/// else its bend.
pub(super) fn strictest(met: impl Iterator<Item = Met>, given: f64) -> Limit {
    let least = met.reduce(|least, met| if met.allows < least.allows { met } else { least });
    least.filter(|least| least.allows <= given * NEAR).map_or(Limit::Bend, |least| least.limit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_limit_has_its_place() {
        for (place, limit) in Limit::ALL.into_iter().enumerate() {
            assert_eq!(limit.index(), place, "{limit}");
        }
    }
}

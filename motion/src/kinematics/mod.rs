//! Kinematics: where each motor must be for the machine to be at a point, and back.
//!
//! An enum rather than a trait object: the set is closed, the call is in the path of every knot, and a copy
//! of it fits a configuration. Each family has a file of its own. Axes and motors that a family does not use
//! go through one to one: A B C drive delta, epsilon and zeta.
//!
//! Everything downstream asks only these questions, so an arm solution is added here and nowhere else: the
//! motors' positions at a point, their velocities there, the point for given motors, and what [`line`] says
//! of straight moves.
//!
//! Outside the reachable space positions and velocities are those of the nearest posture, continuous and
//! finite: no rounding can make a motor jump. `Kinematics::check_line` sees to it that such places are
//! never commanded.

mod deltesian;
mod line;
mod linear;
mod linear_delta;
mod morgan;
mod parameters;
mod polar;
mod rotary_delta;
mod space;
mod spheres;
#[cfg(test)]
pub(crate) mod tests;
mod winch;

pub(crate) use line::Strain;
pub use linear::{CoreXz, Generic};
pub use linear_delta::LinearDelta;
pub use parameters::Parameters;
pub use units::{Deltesian, LinearDeltaGeometry, Morgan, RotaryDelta};
pub use winch::{MOST_ANCHORS, Winch};

use units::{Actuator, Axis, AxisSet, PerActuator, PerAxis};

use space::{Axes, LEAST_CLEARANCE, Motors};

/// Mapping from the machine's position to the motors' positions (mm at the motor, or degrees).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Kinematics {
    /// Each motor drives one axis.
    #[default]
    Cartesian,
    /// Two motors move X and Y together through one belt: alpha X+Y, beta X-Y (corexy, hbot).
    CoreXy,
    /// Two motors move X and Z together, geared: alpha and beta; gamma is Y.
    CoreXz(CoreXz),
    /// Alpha X-Y, beta Y.
    HybridCoreXy,
    /// Alpha X-Z, beta Y, gamma Z.
    HybridCoreXz,
    /// Alpha X, beta Z; there is no Y.
    Lathe,
    /// Any combination of X, Y and Z for each of three motors.
    Generic(Generic),
    /// Three vertical towers (linear delta).
    LinearDelta(LinearDelta),
    /// Three shoulders (rotary delta).
    RotaryDelta(RotaryDelta),
    /// Two links on a tower.
    Morgan(Morgan),
    /// Two towers and a bed.
    Deltesian(Deltesian),
    /// A turning bed (polar).
    Polar,
    /// Ropes on winches (cable robot).
    Winch(Winch),
}

impl Kinematics {
    /// The name in configurations.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Cartesian => "cartesian",
            Self::CoreXy => "corexy",
            Self::CoreXz(_) => "corexz",
            Self::HybridCoreXy => "hybrid_corexy",
            Self::HybridCoreXz => "hybrid_corexz",
            Self::Lathe => "lathe",
            Self::Generic(_) => "generic_cartesian",
            Self::LinearDelta(_) => "linear_delta",
            Self::RotaryDelta(_) => "rotary_delta",
            Self::Morgan(_) => "morgan",
            Self::Deltesian(_) => "deltesian",
            Self::Polar => "polar",
            Self::Winch(_) => "winch",
        }
    }

    /// Motor positions in mm (degrees) for a machine position.
    #[must_use]
    pub fn actuators(&self, point: &PerAxis<f64>) -> PerActuator<f64> {
        let [x, y, z, a, b, c] = point.0;
        let axes = [x, y, z];
        let [alpha, beta, gamma] = match self {
            Self::Cartesian => axes,
            Self::LinearDelta(delta) => delta.motors(axes),
            Self::RotaryDelta(delta) => rotary_delta::motors(delta, axes),
            Self::Morgan(arm) => morgan::motors(arm, axes),
            Self::Deltesian(towers) => deltesian::motors(towers, axes),
            Self::Polar => polar::motors(axes),
            Self::Winch(ropes) => {
                let mut motors = point.0;
                ropes.motors(axes, &mut motors);
                return PerActuator(motors);
            }
            _ => self.linear(axes),
        };
        PerActuator([alpha, beta, gamma, a, b, c])
    }

    /// Motor velocities in mm/s (degrees/s) where the machine is at `point` and moves with `velocity`.
    #[must_use]
    pub fn velocities(&self, point: &PerAxis<f64>, velocity: &PerAxis<f64>) -> PerActuator<f64> {
        let ([x, y, z, ..], [vx, vy, vz, a, b, c]) = (point.0, velocity.0);
        let (axes, speed) = ([x, y, z], [vx, vy, vz]);
        let [alpha, beta, gamma] = match self {
            Self::Cartesian => speed,
            Self::LinearDelta(delta) => delta.velocities(axes, speed),
            Self::RotaryDelta(delta) => rotary_delta::velocities(delta, axes, speed),
            Self::Morgan(arm) => morgan::velocities(arm, axes, speed),
            Self::Deltesian(towers) => deltesian::velocities(towers, axes, speed),
            Self::Polar => polar::velocities(axes, speed),
            Self::Winch(ropes) => {
                let mut motors = velocity.0;
                ropes.velocities(axes, speed, &mut motors);
                return PerActuator(motors);
            }
            _ => self.linear(speed),
        };
        PerActuator([alpha, beta, gamma, a, b, c])
    }

    /// Machine position for motor positions in mm (degrees).
    #[must_use]
    pub fn point(&self, actuators: &PerActuator<f64>) -> PerAxis<f64> {
        let [alpha, beta, gamma, a, b, c] = actuators.0;
        let motors = [alpha, beta, gamma];
        let [x, y, z] = match self {
            Self::Cartesian => motors,
            Self::CoreXy => [(alpha + beta) * 0.5, (alpha - beta) * 0.5, gamma],
            Self::CoreXz(gearing) => gearing.axes(motors),
            Self::HybridCoreXy => [alpha + beta, beta, gamma],
            Self::HybridCoreXz => [alpha + gamma, beta, gamma],
            Self::Lathe => [alpha, 0.0, beta],
            Self::Generic(map) => map.axes(motors),
            Self::LinearDelta(delta) => delta.axes(motors),
            Self::RotaryDelta(delta) => rotary_delta::axes(delta, motors),
            Self::Morgan(arm) => morgan::axes(arm, motors),
            Self::Deltesian(towers) => deltesian::axes(towers, motors),
            Self::Polar => polar::axes(motors),
            Self::Winch(ropes) => ropes.axes(&actuators.0),
        };
        // A motor that winds a rope drives no auxiliary axis.
        let own = |index: usize, value: f64| if self.path_motors() & (1 << index) == 0 { value } else { 0.0 };
        PerAxis([x, y, z, own(3, a), own(4, b), own(5, c)])
    }

    fn linear(&self, [x, y, z]: Axes) -> Motors {
        match self {
            Self::CoreXy => [x + y, x - y, z],
            Self::CoreXz(gearing) => gearing.motors([x, y, z]),
            Self::HybridCoreXy => [x - y, y, z],
            Self::HybridCoreXz => [x - z, y, z],
            Self::Lathe => [x, z, 0.0],
            Self::Generic(map) => map.motors([x, y, z]),
            _ => [x, y, z],
        }
    }

    /// Returns whether straight moves are straight for every motor.
    #[must_use]
    pub const fn is_linear(&self) -> bool {
        !matches!(
            self,
            Self::LinearDelta(_)
                | Self::RotaryDelta(_)
                | Self::Morgan(_)
                | Self::Deltesian(_)
                | Self::Polar
                | Self::Winch(_)
        )
    }

    /// Motors that X, Y and Z turn, one bit each.
    const fn path_motors(&self) -> u8 {
        match self {
            Self::Winch(ropes) => ropes.mask(),
            _ => 0b111,
        }
    }

    /// Motors that must stand still for `axis` to stand still, one bit each: what an end switch of that axis
    /// stops. Zero for an axis that the machine does not have.
    #[must_use]
    pub fn motors_of(&self, axis: Axis) -> u8 {
        let index = axis as usize;
        let own = 1 << index;
        if !axis.is_primary() {
            return own & !self.path_motors();
        }
        let (alpha, beta, gamma) = (Actuator::Alpha.bit(), Actuator::Beta.bit(), Actuator::Gamma.bit());
        match (self, axis) {
            (Self::CoreXy | Self::Deltesian(_) | Self::Morgan(_) | Self::Polar, Axis::X) => alpha | beta,
            (Self::CoreXy | Self::Morgan(_) | Self::Polar, Axis::Y) => alpha | beta,
            (Self::CoreXz(_), Axis::X | Axis::Z) | (Self::Deltesian(_), Axis::Z) => alpha | beta,
            (Self::CoreXz(_) | Self::Deltesian(_), _) => gamma,
            (Self::HybridCoreXy, Axis::Y) => alpha | beta,
            (Self::HybridCoreXz, Axis::Z) => alpha | gamma,
            (Self::Lathe, Axis::Y) => 0,
            (Self::Lathe, Axis::Z) => beta,
            (Self::Generic(map), _) => map.motors_of(index),
            (Self::LinearDelta(_) | Self::RotaryDelta(_) | Self::Winch(_), _) => self.path_motors(),
            _ => own,
        }
    }

    /// The axes whose places are not known any more once this motor has been turned by hand.
    #[must_use]
    pub fn axes_of(&self, motor: Actuator) -> AxisSet {
        if !self.is_linear() && self.path_motors() & motor.bit() != 0 {
            return AxisSet::PRIMARY;
        }
        let still = PerActuator::default();
        let mut turned = still;
        turned[motor] = 1.0;
        let (from, to) = (self.point(&still), self.point(&turned));
        AxisSet::collect(Axis::ALL.into_iter().filter(|axis| from[*axis] != to[*axis]))
    }

    /// A whole turn of a motor whose positions repeat, degrees: of two equal postures the nearer one is
    /// meant.
    #[must_use]
    pub const fn turn_of(&self, actuator: Actuator) -> Option<f64> {
        match (self, actuator) {
            (Self::Polar, Actuator::Beta) | (Self::Morgan(_), Actuator::Alpha | Actuator::Beta) => Some(360.0),
            _ => None,
        }
    }

    /// Distance in mm to the nearest place where a motor's position is no smooth function of the tool's. A
    /// path well within that distance is nearly straight, so the distance bounds the slices of the
    /// trajectory. Infinite for linear kinematics.
    #[must_use]
    pub fn clearance(&self, point: &PerAxis<f64>) -> f64 {
        let [x, y, z, ..] = point.0;
        let axes = [x, y, z];
        match self {
            Self::LinearDelta(delta) => delta.clearance(axes),
            Self::RotaryDelta(delta) => rotary_delta::clearance(delta, axes),
            Self::Morgan(arm) => morgan::clearance(arm, axes),
            Self::Deltesian(towers) => deltesian::clearance(towers, axes),
            Self::Polar => polar::clearance(axes),
            Self::Winch(ropes) => ropes.clearance(axes),
            _ => f64::INFINITY,
        }
    }

    /// Returns whether the machine can be at this point.
    #[must_use]
    pub fn reaches(&self, point: &PerAxis<f64>) -> bool {
        let [x, y, z, ..] = point.0;
        let axes = [x, y, z];
        let is_allowed = match self {
            Self::RotaryDelta(delta) => rotary_delta::is_within_angles(delta, axes),
            Self::Morgan(arm) => morgan::is_within_limits(arm, axes),
            _ => true,
        };
        // A NaN compares false, so it is refused.
        is_allowed && self.clearance(point) >= LEAST_CLEARANCE
    }

    /// Whether the geometry is that of a machine: its middle can be reached, nothing divides by zero.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        match self {
            Self::CoreXz(gearing) => libm::fabs(gearing.x) > 1e-6 && libm::fabs(gearing.z) > 1e-6,
            Self::LinearDelta(delta) => delta.is_sound(),
            Self::RotaryDelta(delta) => rotary_delta::is_sound(delta),
            Self::Morgan(arm) => morgan::is_sound(arm),
            Self::Deltesian(towers) => deltesian::is_sound(towers),
            _ => true,
        }
    }
}

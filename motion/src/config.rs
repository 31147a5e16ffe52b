//! The motion configuration, already typed, and the checks that only this crate can make.

use units::{Actuator, Axis, AxisSet, Mm, MmPerSecond, MmPerSecond2, MmPerSecond3, PerActuator, STEP_CLOCK_HZ, Ticks};

use crate::{
    filters::{
        FilterConfig,
        advance::{MAX_FACTOR, SMOOTH_TIME_RANGE},
        shaper::FREQUENCY_RANGE,
    },
    kinematics::Kinematics,
    least,
};

/// Greatest number of blocks in the look-ahead queue: at 0.2 mm a block and 100 mm/s, half a second of
/// look-ahead.
pub const MOST_BLOCKS: usize = 256;

/// Configuration that is fixed while the machine moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionConfig {
    /// Mapping from machine space to motors.
    pub kinematics: Kinematics,
    /// The motors that exist. `None`: not fitted; its axis cannot be commanded.
    pub actuators: PerActuator<Option<ActuatorConfig>>,
    /// Limits in force at the start; [`crate::Motion::set_limits`] changes them at any time.
    pub limits: Limits,
    /// Look-ahead depth in blocks (`planner_queue_size`), 2 to [`MOST_BLOCKS`].
    pub queue_size: usize,
    /// Time that a queue that is not full waits for more moves before it runs (`queue_delay_time_ms`).
    pub queue_delay: Ticks,
    /// Input shaping and pressure advance.
    pub filters: FilterConfig,
}

/// Configuration of one motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActuatorConfig {
    /// (Micro)steps for one millimetre at the motor, or one degree. Greater than zero; a reversed motor is
    /// the pin's matter.
    pub steps_per_mm: f64,
    /// The motor copies every step of this one and is not an axis of its own.
    pub slaved_to: Option<Actuator>,
    /// Ticks by which a direction change precedes the next step, and follows the last one.
    pub direction_setup: u32,
    /// Least distance in ticks between two steps of this motor (pulse plus pause; edge to edge with
    /// double-edge stepping).
    pub step_interval: u32,
}

impl ActuatorConfig {
    /// A motor with its own axis on a driver of the TMC2590 kind, with room to spare over its STEP/DIR
    /// timing: the direction settles 100 ns before the step, edges are at least 100 ns apart.
    #[must_use]
    pub const fn new(steps_per_mm: f64) -> Self {
        Self { steps_per_mm, slaved_to: None, direction_setup: 20, step_interval: 20 }
    }
}

/// Speed, acceleration and corner limits. A change holds for moves submitted after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Limit of the X, Y and Z component of any move (`x_axis_max_speed`, M203). `None`: no limit.
    pub axis_speed: [Option<MmPerSecond>; 3],
    /// Limit of the path speed of moves of X Y Z (`max_speed`, M203 P). `None`: no limit.
    pub max_speed: Option<MmPerSecond>,
    /// Top speed of each motor (`max_rate`, M203.1).
    pub actuator_rate: PerActuator<MmPerSecond>,
    /// Acceleration of a move (`default_acceleration`, M204 S).
    pub acceleration: MmPerSecond2,
    /// Acceleration of each motor, where it has its own limit (`acceleration`, M204 X..).
    pub actuator_acceleration: PerActuator<Option<MmPerSecond2>>,
    /// Jerk of a move along its path (`jerk`), mm/s^3. `None` here and in `axis_jerk`: speed profiles are
    /// trapezoids.
    pub jerk: Option<MmPerSecond3>,
    /// Jerk of the X, Y and Z component of any move (`x_axis_max_jerk`), mm/s^3.
    pub axis_jerk: [Option<MmPerSecond3>; 3],
    /// Speed kept through a right angle at `acceleration`; takes the place of both junction deviations.
    pub square_corner_velocity: Option<MmPerSecond>,
    /// Share of the way between two slow places that is left for cruising, 0 to 0.95; trapezoids only.
    pub cruise_ratio: f64,
    /// Junction deviation: greatest distance of a corner from its virtual arc; sets the speed kept through
    /// corners.
    pub junction_deviation: Mm,
    /// Junction deviation of moves of Z alone. `None`: as `junction_deviation`.
    pub z_junction_deviation: Option<Mm>,
    /// Speed at the start, the end and the sharpest corners of moves (`minimum_planner_speed`).
    pub minimum_speed: MmPerSecond,
}

impl Limits {
    /// The defaults of the settings reference.
    pub const DEFAULT: Self = Self {
        axis_speed: [
            Some(MmPerSecond::from_per_minute(60_000.0)),
            Some(MmPerSecond::from_per_minute(60_000.0)),
            Some(MmPerSecond::from_per_minute(300.0)),
        ],
        max_speed: None,
        actuator_rate: PerActuator([MmPerSecond::from_per_minute(30_000.0); units::MAX_ACTUATORS]),
        acceleration: MmPerSecond2(100.0),
        actuator_acceleration: PerActuator([None; units::MAX_ACTUATORS]),
        jerk: None,
        axis_jerk: [None; 3],
        square_corner_velocity: None,
        cruise_ratio: 0.0,
        junction_deviation: Mm(0.05),
        z_junction_deviation: None,
        minimum_speed: MmPerSecond(0.0),
    };
}

impl Default for Limits {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Mistake in a [`MotionConfig`] or [`Limits`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum ConfigError {
    /// Something still moves or is queued.
    Busy,
    /// The kinematics' geometry is none that a machine can have.
    Geometry,
    /// `steps_per_mm` must be a finite number above zero.
    StepsPerMm(Actuator),
    /// `max_rate` must be a finite number above zero.
    ActuatorRate(Actuator),
    /// `max_rate` times `steps_per_mm` comes faster than the driver's `step_interval` allows.
    StepRate(Actuator),
    /// An actuator's acceleration must be a finite number above zero.
    ActuatorAcceleration(Actuator),
    /// A motor is slaved to itself, to one that is not fitted, or to one that is a slave too.
    Slave(Actuator),
    /// The default acceleration must be a finite number above zero.
    Acceleration,
    /// An axis speed limit must be a finite number above zero.
    AxisSpeed(Axis),
    /// A jerk must be a finite number above zero.
    Jerk,
    /// The square corner velocity must be a finite number above zero.
    SquareCornerVelocity,
    /// The minimum cruise ratio must lie between 0 and 0.95, and be zero with jerk.
    CruiseRatio,
    /// `max_speed` must be a finite number above zero.
    MaxSpeed,
    /// A junction deviation must be a finite number, not negative.
    JunctionDeviation,
    /// The minimum planner speed must be a finite number, not negative.
    MinimumSpeed,
    /// `planner_queue_size` must lie between 2 and [`MOST_BLOCKS`].
    QueueSize,
    /// A shaper's frequency or damping ratio is out of range.
    Shaper(Axis),
    /// A pressure advance or its smoothing time is out of range; the axis is the extruder's.
    PressureAdvance(Axis),
    /// A laser's duties, delays or power curve are out of range or out of order.
    Laser,
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Busy => f.write_str("the machine is moving"),
            Self::Geometry => f.write_str("the geometry of the arm_solution fits no machine: check its lengths"),
            Self::StepsPerMm(a) => write!(f, "{}.steps_per_mm must be above zero", a.name()),
            Self::ActuatorRate(a) => write!(f, "{}.max_rate must be above zero", a.name()),
            Self::StepRate(a) => write!(f, "{}.max_rate needs steps faster than its driver takes them", a.name()),
            Self::ActuatorAcceleration(a) => write!(f, "{}.acceleration must be above zero", a.name()),
            Self::Slave(a) => write!(f, "{}.slaved_to must name another motor that is not a slave", a.name()),
            Self::Acceleration => f.write_str("default_acceleration must be above zero"),
            Self::AxisSpeed(axis) => write!(f, "the speed limit of axis {} must be above zero", axis.letter()),
            Self::Jerk => f.write_str("a jerk must be above zero"),
            Self::SquareCornerVelocity => f.write_str("square_corner_velocity must be above zero"),
            Self::CruiseRatio => f.write_str("minimum_cruise_ratio must be 0 to 0.95, and 0 where a jerk is set"),
            Self::MaxSpeed => f.write_str("max_speed must be above zero"),
            Self::JunctionDeviation => f.write_str("junction_deviation must not be negative"),
            Self::MinimumSpeed => f.write_str("minimum_planner_speed must not be negative"),
            Self::Shaper(axis) => write!(
                f,
                "the input shaper of {} needs a frequency from {} to {} Hz and a damping ratio within its formulas",
                axis.letter(),
                FREQUENCY_RANGE.0,
                FREQUENCY_RANGE.1
            ),
            Self::PressureAdvance(axis) => write!(
                f,
                "the pressure advance of {} must be 0 to {} s and its smooth time {} to {} s",
                axis.letter(),
                MAX_FACTOR,
                SMOOTH_TIME_RANGE.0,
                SMOOTH_TIME_RANGE.1
            ),
            Self::Laser => f.write_str(
                "the laser needs duties from 0 to 1, a power curve that rises in both, and delays of 0 to 20 ms",
            ),
            Self::QueueSize => write!(f, "planner_queue_size must lie between 2 and {}", MOST_BLOCKS),
        }
    }
}

fn positive(value: f64) -> bool {
    value.is_finite() && value > 0.0
}

impl MotionConfig {
    /// Checks everything, in the order of [`ConfigError`].
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self) -> Result<(), ConfigError> {
        for actuator in Actuator::ALL {
            self.check_actuator(actuator)?;
        }
        self.limits.check()?;
        if !self.kinematics.is_sound() {
            return Err(ConfigError::Geometry);
        }
        if !(2..=MOST_BLOCKS).contains(&self.queue_size) {
            return Err(ConfigError::QueueSize);
        }
        self.check_filters()
    }

    /// Scale of a motor that has an axis of its own; zero for one that is absent or a slave.
    pub(crate) fn steps_per_mm(&self, actuator: Actuator) -> f64 {
        match self.actuators[actuator] {
            Some(fitted) if fitted.slaved_to.is_none() => fitted.steps_per_mm,
            _ => 0.0,
        }
    }

    /// Axes that no motor moves, or not with all the motors that they need.
    pub(crate) fn orphans(&self) -> AxisSet {
        AxisSet::collect(Axis::ALL.into_iter().filter(|axis| {
            let motors = self.kinematics.motors_of(*axis);
            let mut needed = Actuator::ALL.into_iter().filter(|actuator| motors & actuator.bit() != 0);
            motors == 0 || needed.any(|actuator| self.steps_per_mm(actuator) <= 0.0)
        }))
    }

    fn check_filters(&self) -> Result<(), ConfigError> {
        let [x, y, z, a, b, c] = Axis::ALL;
        for (axis, shaper) in [x, y, z].into_iter().zip(self.filters.shapers) {
            if shaper.is_some_and(|shaper| !shaper.is_valid()) {
                return Err(ConfigError::Shaper(axis));
            }
        }
        for (axis, advance) in [a, b, c].into_iter().zip(self.filters.advance) {
            if advance.is_some_and(|advance| !advance.is_valid()) {
                return Err(ConfigError::PressureAdvance(axis));
            }
        }
        Ok(())
    }

    fn check_actuator(&self, actuator: Actuator) -> Result<(), ConfigError> {
        let Some(config) = self.actuators[actuator] else { return Ok(()) };
        if !positive(config.steps_per_mm) {
            return Err(ConfigError::StepsPerMm(actuator));
        }
        if let Some(master) = config.slaved_to {
            let own_axis = self.actuators[master].is_some_and(|master| master.slaved_to.is_none());
            return if own_axis && master != actuator { Ok(()) } else { Err(ConfigError::Slave(actuator)) };
        }
        let steps_per_second = self.limits.actuator_rate[actuator].get() * config.steps_per_mm;
        if steps_per_second * f64::from(config.step_interval) > f64::from(STEP_CLOCK_HZ) {
            return Err(ConfigError::StepRate(actuator));
        }
        Ok(())
    }
}

impl Limits {
    /// Returns whether speed profiles are limited in jerk.
    #[must_use]
    pub fn has_jerk(&self) -> bool {
        self.jerk.is_some() || self.axis_jerk.iter().any(Option::is_some)
    }

    /// The jerk limits of the path, X, Y and Z; infinite where there is none.
    pub(crate) fn jerks(&self) -> [f64; 4] {
        let [x, y, z] = self.axis_jerk;
        [self.jerk, x, y, z].map(|jerk| jerk.map_or(f64::INFINITY, |jerk| jerk.get()))
    }

    /// Path on which any move comes to rest from `speed` mm/s, mm; motors' own accelerations aside.
    #[must_use]
    pub fn braking_length(&self, speed: f64) -> f64 {
        let acceleration = self.acceleration.get();
        let jerks = self.jerk.iter().chain(self.axis_jerk.iter().flatten());
        let jerk = jerks.map(|jerk| jerk.get()).fold(f64::INFINITY, least);
        0.5 * speed * (speed / acceleration + acceleration / jerk)
    }

    /// Checks every one of the limits.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self) -> Result<(), ConfigError> {
        for actuator in Actuator::ALL {
            if !positive(self.actuator_rate[actuator].get()) {
                return Err(ConfigError::ActuatorRate(actuator));
            }
            if self.actuator_acceleration[actuator].is_some_and(|own| !positive(own.get())) {
                return Err(ConfigError::ActuatorAcceleration(actuator));
            }
        }
        if !positive(self.acceleration.get()) {
            return Err(ConfigError::Acceleration);
        }
        for (axis, limit) in Axis::PRIMARY.into_iter().zip(self.axis_speed) {
            if limit.is_some_and(|limit| !positive(limit.get())) {
                return Err(ConfigError::AxisSpeed(axis));
            }
        }
        if self.max_speed.is_some_and(|limit| !positive(limit.get())) {
            return Err(ConfigError::MaxSpeed);
        }
        if self.jerk.iter().chain(self.axis_jerk.iter().flatten()).any(|jerk| !positive(jerk.get())) {
            return Err(ConfigError::Jerk);
        }
        if self.square_corner_velocity.is_some_and(|speed| !positive(speed.get())) {
            return Err(ConfigError::SquareCornerVelocity);
        }
        if !(0.0..=0.95).contains(&self.cruise_ratio) || (self.has_jerk() && self.cruise_ratio > 0.0) {
            return Err(ConfigError::CruiseRatio);
        }
        let z_deviation = self.z_junction_deviation.unwrap_or_default().get();
        for deviation in [self.junction_deviation.get(), z_deviation] {
            if !(deviation.is_finite() && deviation >= 0.0) {
                return Err(ConfigError::JunctionDeviation);
            }
        }
        if !(self.minimum_speed.get().is_finite() && self.minimum_speed.get() >= 0.0) {
            return Err(ConfigError::MinimumSpeed);
        }
        Ok(())
    }
}

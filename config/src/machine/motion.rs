//! Path and speed: `[motion control]`, `[planner]`, `[conveyor]`.

use super::Arms;
use units::{Actuator, Axis, AxisSet, Micros, Mm, MmPerSecond, MmPerSecond2, MmPerSecond3};

/// Kinematics: relation of actuators to Cartesian axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ArmSolution {
    /// Cartesian: one motor per axis.
    #[default]
    Cartesian,
    /// CoreXY: alpha = X + Y, beta = X - Y (`hbot`, `corexy`).
    CoreXy,
    /// CoreXZ: alpha and beta share X and Z, gamma carries Y.
    CoreXz,
    /// Linear delta with three vertical towers.
    LinearDelta,
    /// Rotary delta with three shoulder motors.
    RotaryDelta,
    /// SCARA with a two-link arm.
    Morgan,
    /// Hybrid CoreXY: alpha = X - Y.
    HybridCoreXy,
    /// Hybrid CoreXZ: alpha = X - Z.
    HybridCoreXz,
    /// Deltesian: two vertical towers, a bed in Y.
    Deltesian,
    /// Polar, with a turning bed.
    Polar,
    /// Winches that pull ropes.
    Winch,
    /// Any linear combination of the axes.
    Generic,
    /// Lathe: alpha is X, beta is Z.
    Lathe,
}

impl ArmSolution {
    /// Returns the axes that a motor moves; `None` where a motor's place depends on all of them.
    #[must_use]
    pub const fn axes_of(self, motor: Actuator) -> Option<AxisSet> {
        const fn both(one: Axis, other: Axis) -> AxisSet {
            AxisSet::of(one).with(other)
        }
        Some(match (self, motor) {
            (_, Actuator::Delta) => AxisSet::of(Axis::A),
            (_, Actuator::Epsilon) => AxisSet::of(Axis::B),
            (_, Actuator::Zeta) => AxisSet::of(Axis::C),
            (Self::Cartesian, Actuator::Beta) => AxisSet::of(Axis::Y),
            (Self::CoreXy, Actuator::Alpha | Actuator::Beta) => both(Axis::X, Axis::Y),
            (Self::CoreXz, Actuator::Alpha | Actuator::Beta) => both(Axis::X, Axis::Z),
            (Self::CoreXz, Actuator::Gamma) => AxisSet::of(Axis::Y),
            (Self::Cartesian, Actuator::Alpha) => AxisSet::of(Axis::X),
            (Self::Cartesian | Self::CoreXy, Actuator::Gamma) => AxisSet::of(Axis::Z),
            _ => return None,
        })
    }
}

/// Section `[motion control]`: path and kinematics.
#[derive(Clone, Copy, Debug, Default)]
pub struct MotionControl {
    /// Feed rate of G1, G2 and G3 until an F word.
    pub default_feed_rate: MmPerSecond,
    /// Feed rate of G0 until an F word.
    pub default_seek_rate: MmPerSecond,
    /// Whether F always sets the G1 rate; G0 keeps its own.
    pub compliant_seek_rate: bool,
    /// Longest segment of a straight move; none: not cut.
    pub mm_per_line_segment: Option<Mm>,
    /// Segments per second of motion; none: not cut by time.
    pub segments_per_second: Option<f64>,
    /// Least chord length of arcs; none: by error.
    pub mm_per_arc_segment: Option<Mm>,
    /// Largest distance between chord and arc; with neither limit, arcs are not cut.
    pub mm_max_arc_error: Option<Mm>,
    /// Small-angle rotations between exact arc points (Velvet computes every arc point exactly).
    pub arc_correction: u16,
    /// Speed limit of X, Y and Z; none: no limit.
    pub axis_max_speed: [Option<MmPerSecond>; 3],
    /// Limit of the path speed; none: no limit.
    pub max_speed: Option<MmPerSecond>,
    /// Acceleration where an actuator has none of its own.
    pub default_acceleration: MmPerSecond2,
    /// Whether moves that name neither X nor Y are cut into segments.
    pub segment_z_moves: bool,
    /// Whether M500 saves work offsets.
    pub save_wcs: bool,
    /// Whether M500 saves the G92 offset.
    pub save_g92: bool,
    /// G92 offset at boot, X Y Z in mm.
    pub set_g92: Option<[f64; 3]>,
    /// Whether G30 moves to the stored position (with `grbl_mode`).
    pub nist_g30: bool,
    /// Whether moves are refused until homed.
    pub must_be_homed: bool,
    /// Kinematics of the machine.
    pub arm_solution: ArmSolution,
    /// Geometry of the kinematics.
    pub arms: Arms,
}

/// Sections `[planner]` and `[conveyor]`.
#[derive(Clone, Copy, Debug, Default)]
pub struct PlannerConfig {
    /// Junction deviation: corner rounding distance.
    pub junction_deviation: Mm,
    /// Junction deviation for moves of Z alone; none: as above.
    pub z_junction_deviation: Option<Mm>,
    /// Slowest speed at start, end and corners.
    pub minimum_planner_speed: MmPerSecond,
    /// Number of look-ahead blocks.
    pub queue_size: u16,
    /// Time for which an idle queue may collect blocks before motion starts.
    pub queue_delay: Micros,
    /// Speed kept through a right angle, in place of the deviation; none: the deviation counts.
    pub square_corner_velocity: Option<MmPerSecond>,
    /// Share of each run up and down that is left for cruising.
    pub minimum_cruise_ratio: f64,
    /// Jerk limit along the path; none here and for every axis: trapezoidal speed profiles.
    pub jerk: Option<MmPerSecond3>,
    /// Jerk limits of X, Y and Z.
    pub axis_jerk: [Option<MmPerSecond3>; 3],
}

/// Kind of input shaper, `[input shaper]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs, reason = "these are the shapers' names")]
pub enum InputShaper {
    Zv,
    #[default]
    Mzv,
    Zvd,
    Ei,
    TwoHumpEi,
    ThreeHumpEi,
}

impl InputShaper {
    /// Greatest damping ratio that the shaper's formulas hold for.
    #[must_use]
    pub const fn max_damping(self) -> f64 {
        match self {
            Self::Zv | Self::Mzv | Self::Zvd => 0.99,
            Self::Ei => 0.4,
            Self::TwoHumpEi => 0.3,
            Self::ThreeHumpEi => 0.2,
        }
    }
}

/// The input shaper of one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InputShaperConfig {
    /// Kind of the shaper.
    pub shaper: InputShaper,
    /// Resonance frequency in hertz; none: the axis is not shaped.
    pub frequency_hz: Option<f64>,
    /// Damping ratio of the resonance.
    pub damping_ratio: f64,
}

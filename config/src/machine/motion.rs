//! Path and speed: `[motion control]`, `[planner]`, `[conveyor]`.

use super::Arms;
use units::{Actuator, Axis, AxisSet, Micros, Mm, MmPerSecond, MmPerSecond2, MmPerSecond3};

/// How actuators relate to Cartesian axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ArmSolution {
    /// One motor per axis.
    #[default]
    Cartesian,
    /// alpha = X + Y, beta = X - Y (`hbot`, `corexy`).
    CoreXy,
    /// alpha and beta share X and Z, gamma carries Y.
    CoreXz,
    /// Three vertical towers.
    LinearDelta,
    /// Three shoulder motors.
    RotaryDelta,
    /// Two-link arm.
    Morgan,
    /// alpha = X - Y.
    HybridCoreXy,
    /// alpha = X - Z.
    HybridCoreXz,
    /// Two vertical towers, a bed in Y.
    Deltesian,
    /// A turning bed.
    Polar,
    /// Ropes.
    Winch,
    /// Any linear combination.
    Generic,
    /// alpha is X, beta is Z.
    Lathe,
}

impl ArmSolution {
    /// The axes that a motor moves. `None` where a motor's place is that of all of them.
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

/// `[motion control]`
#[derive(Clone, Copy, Debug, Default)]
pub struct MotionControl {
    /// G1 G2 G3 until an F word.
    pub default_feed_rate: MmPerSecond,
    /// G0 until an F word.
    pub default_seek_rate: MmPerSecond,
    /// F always sets the G1 rate; G0 keeps its own.
    pub compliant_seek_rate: bool,
    /// Longest piece a line is cut into; none: not cut.
    pub mm_per_line_segment: Option<Mm>,
    /// Pieces per second of motion; none: not cut by time.
    pub segments_per_second: Option<f64>,
    /// Least chord length of arcs; none: by error.
    pub mm_per_arc_segment: Option<Mm>,
    /// Largest distance between chord and arc; with neither, arcs stay arcs.
    pub mm_max_arc_error: Option<Mm>,
    /// Small-angle rotations between exact arc points (Velvet computes every arc point exactly).
    pub arc_correction: u16,
    /// Speed limit of X, Y and Z; none: no limit.
    pub axis_max_speed: [Option<MmPerSecond>; 3],
    /// Limit of the path speed; none: no limit.
    pub max_speed: Option<MmPerSecond>,
    /// Acceleration where an actuator has none of its own.
    pub default_acceleration: MmPerSecond2,
    /// Cut moves that name neither X nor Y.
    pub segment_z_moves: bool,
    /// M500 saves work offsets.
    pub save_wcs: bool,
    /// M500 saves G92.
    pub save_g92: bool,
    /// G92 offset at boot, X Y Z in mm.
    pub set_g92: Option<[f64; 3]>,
    /// G30 moves to the stored position (with `grbl_mode`).
    pub nist_g30: bool,
    /// Refuse moves until homed.
    pub must_be_homed: bool,
    /// Kinematics.
    pub arm_solution: ArmSolution,
    /// Their geometry.
    pub arms: Arms,
}

/// `[planner]` and `[conveyor]`
#[derive(Clone, Copy, Debug, Default)]
pub struct PlannerConfig {
    /// Corner rounding distance.
    pub junction_deviation: Mm,
    /// The same for moves of Z alone; none: as above.
    pub z_junction_deviation: Option<Mm>,
    /// Slowest speed at start, end and corners.
    pub minimum_planner_speed: MmPerSecond,
    /// Look-ahead blocks.
    pub queue_size: u16,
    /// How long an idle queue may collect blocks before motion starts.
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

/// Which input shaper, `[input shaper]`.
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
    /// Which one.
    pub shaper: InputShaper,
    /// Resonance frequency in hertz; none: the axis is not shaped.
    pub frequency_hz: Option<f64>,
    /// Damping ratio of the resonance.
    pub damping_ratio: f64,
}

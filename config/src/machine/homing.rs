//! Homing and probing settings: `[endstops]`, `[soft endstop]` and `[zprobe]`.

use super::{Command, Name};
use crate::pin::Pin;
use heapless::Vec;
use units::{Amps, Axis, AxisSet, Micros, Mm, MmPerSecond};

/// Direction in which an axis moves to find its endstop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HomingDirection {
    /// The endstop is not used for homing.
    #[default]
    None,
    /// Towards the negative end of travel.
    ToMin,
    /// Towards the positive end of travel.
    ToMax,
}

/// Settings of one endstop switch.
#[derive(Clone, Debug, Default)]
pub struct EndstopConfig {
    /// Name of the endstop in the file.
    pub name: Name,
    /// Whether the endstop is in use.
    pub enable: bool,
    /// Input, logically high when hit.
    pub pin: Option<Pin>,
    /// Axis of the endstop (for a slaved motor's own switch: A, B or C).
    pub axis: Option<Axis>,
    /// Direction of the homing move.
    pub homing_direction: HomingDirection,
    /// Coordinate of the axis at the switch.
    pub homing_position: Mm,
    /// Longest distance of a homing move.
    pub max_travel: Mm,
    /// Speed of the first approach.
    pub fast_rate: MmPerSecond,
    /// Speed of the back-off and the second approach.
    pub slow_rate: MmPerSecond,
    /// Distance of the back-off after a hit.
    pub retract: Mm,
    /// Whether a hit while moving halts the machine.
    pub limit_enable: bool,
    /// Settings for the motor's phase at the hit.
    pub phase: EndstopPhaseConfig,
    /// Settings of sensorless homing, without a switch.
    pub stall: EndstopStallConfig,
}

/// Sensorless homing: the motor's stall marks the end of the axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EndstopStallConfig {
    /// Whether `pin` is the stallGuard output of the motor's driver.
    pub homing: bool,
    /// Peak coil current while homing; none: the motor's own.
    pub current: Option<Amps>,
    /// `SGT`, -64 to 63: lower is more sensitive; or `SGTHRS` of a TMC2209 and TMC2226, 0 to 255: higher is
    /// more sensitive.
    pub threshold: i16,
}

impl EndstopStallConfig {
    /// Full steps at constant speed that pass before a StallGuard reading counts: two periods of its filter.
    pub const SETTLING_FULL_STEPS: f64 = 8.0;
    /// Additional full steps between the first place at which a stall can be seen and the end of the axis, so
    /// that one is told from the other.
    pub const APART_FULL_STEPS: f64 = 8.0;
    /// Greatest lag of the motors behind the plan, seconds: steps written ahead, and time between two looks.
    pub const SETTLING_S: f64 = 0.0025;

    /// Returns the distance from its end at which an axis must start to detect the stall there: mm, from
    /// mm/s, mm/s^2, mm/s^3.
    #[must_use]
    pub fn run_up(rate: f64, acceleration: f64, jerk: Option<f64>, full_steps_per_mm: f64) -> f64 {
        // With a jerk limit the acceleration rises and falls; where it has no time to, this is an upper
        // bound.
        let seconds = rate / acceleration + jerk.map_or(0.0, |jerk| acceleration / jerk);
        let full_steps = Self::SETTLING_FULL_STEPS + Self::APART_FULL_STEPS;
        rate * seconds / 2.0 + full_steps / full_steps_per_mm + rate * Self::SETTLING_S
    }
}

/// Check of the motor's phase, within its electrical cycle of four full steps, when its axis hits the switch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EndstopPhaseConfig {
    /// Whether every homing checks the phase.
    pub check: bool,
    /// Expected phase, 1/256 full steps, 0 to below 1024; none: as the first homing finds it.
    pub calibrated: Option<f64>,
    /// Allowed deviation from the expected phase, mm either way; none: a full step.
    pub tolerance: Option<Mm>,
    /// Whether the homing position is moved, by half a full step at most, so that zero is at a full step.
    pub align_zero: bool,
    /// Whether a deviation beyond the tolerance is an alarm instead of a warning.
    pub halts: bool,
}

/// Settings under `[endstops] common`.
#[derive(Clone, Debug, Default)]
pub struct HomingConfig {
    /// Time a switch must stay active.
    pub debounce: Micros,
    /// Axes one after another in this order; empty: XY together, then Z, then A B C.
    pub order: Vec<Axis, 6>,
    /// Whether Z homes before X and Y.
    pub z_first: bool,
    /// Whether each axis homes alone, stopping both X and Y motors. Follows `arm_solution` unless the file
    /// says otherwise.
    pub corexy: bool,
    /// Whether one Z move homes all three towers. Follows `arm_solution` unless the file says otherwise.
    pub delta: bool,
    /// Whether a rotary delta homes by angles. Follows `arm_solution` unless the file says otherwise.
    pub rotary_delta: bool,
    /// Whether homing moves are in actuator space.
    pub scara: bool,
    /// Whether homing ends with a move to machine X0 Y0.
    pub move_to_origin: bool,
    /// Height by which Z rises before X and Y home.
    pub lift: Mm,
    /// Machine X and Y where Z homes; `None`: at the current position.
    pub safe_z: [Option<Mm>; 2],
    /// Number of slow approaches that must agree.
    pub samples: u8,
    /// Greatest spread of the slow approaches' results.
    pub tolerance: Mm,
    /// Additional rounds when the slow approaches disagree.
    pub retries: u8,
    /// G-code line that runs instead of G28 without axes; empty: none.
    pub gcode: Command,
    /// Trims of the first three actuators.
    pub trim: [Mm; 3],
}

impl HomingConfig {
    /// Returns whether homing these axes ends over the origin: only with both X and Y, as an axis that is not
    /// homed stays in place. A rotary delta stays where its arms meet their switches.
    #[must_use]
    pub fn ends_over_origin(&self, homed: AxisSet) -> bool {
        self.move_to_origin && !self.rotary_delta && homed.has(Axis::X) && homed.has(Axis::Y)
    }
}

/// Section `[soft endstop]`: travel limits.
#[derive(Clone, Copy, Debug, Default)]
pub struct SoftEndstops {
    /// Whether moves are checked against the travel.
    pub enable: bool,
    /// Whether a move out of the travel halts the machine. Follows the dialect unless the file says
    /// otherwise.
    pub halt: bool,
    /// Least machine position of X, Y and Z, where written.
    pub least: [Option<Mm>; 3],
    /// Greatest machine position of X, Y and Z, where written.
    pub most: [Option<Mm>; 3],
}

/// Section `[zprobe]`: the probe.
#[derive(Clone, Copy, Debug, Default)]
pub struct ProbeConfig {
    /// Whether there is a probe.
    pub enable: bool,
    /// Input, logically high when triggered.
    pub pin: Option<Pin>,
    /// Search speed of a probing move.
    pub slow_rate: MmPerSecond,
    /// Travel speed between probed points.
    pub fast_rate: MmPerSecond,
    /// Speed of the lift after a touch.
    pub return_rate: MmPerSecond,
    /// Clearance height between touches.
    pub height: Mm,
    /// Longest distance of a probing move.
    pub max_travel: Mm,
    /// Whether the probe moves towards +Z.
    pub reverse_z: bool,
    /// Pause before each probing move.
    pub dwell: Micros,
    /// Time the probe must stay triggered.
    pub debounce: Micros,
    /// Position of the probe relative to the nozzle, mm.
    pub offsets: [f64; 3],
    /// Input that is logically high while the probe is deployed.
    pub deployed_pin: Option<Pin>,
    /// Whether the contact of a stowed probe reads triggered.
    pub stowed_reads_triggered: bool,
    /// Repeated touches of one place.
    pub samples: SamplesConfig,
}

/// Repeated touches of one place: `[zprobe]` `samples` and related settings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SamplesConfig {
    /// Number of touches per place.
    pub count: u8,
    /// Whether the median of the touches counts, not their mean.
    pub median: bool,
    /// Greatest spread of the touches; 0: not checked.
    pub tolerance: Mm,
    /// Additional rounds of touches when their spread exceeds `tolerance`.
    pub retries: u8,
    /// Lift of the probe between touches.
    pub retract: Mm,
}

impl ProbeConfig {
    /// Returns the default speed of the lift after a touch.
    #[must_use]
    pub fn usual_return_rate(&self) -> MmPerSecond {
        let twice = self.slow_rate * 2.0;
        if twice < self.fast_rate { twice } else { self.fast_rate }
    }
}

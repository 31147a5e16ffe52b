//! `[endstops]`, `[soft endstop]` and `[zprobe]`.

use super::{Command, Name};
use crate::pin::Pin;
use heapless::Vec;
use units::{Amps, Axis, AxisSet, Micros, Mm, MmPerSecond};

/// Which way an axis moves to find its endstop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HomingDirection {
    /// Not used for homing.
    #[default]
    None,
    /// Towards the negative end.
    ToMin,
    /// Towards the positive end.
    ToMax,
}

/// One endstop switch.
#[derive(Clone, Debug, Default)]
pub struct EndstopConfig {
    /// Its name.
    pub name: Name,
    /// Whether it exists.
    pub enable: bool,
    /// Input, logically high when hit.
    pub pin: Option<Pin>,
    /// The axis it belongs to (for a slaved motor's own switch: A, B or C).
    pub axis: Option<Axis>,
    /// Homing.
    pub homing_direction: HomingDirection,
    /// Coordinate of the axis at the switch.
    pub homing_position: Mm,
    /// Longest homing move.
    pub max_travel: Mm,
    /// First approach.
    pub fast_rate: MmPerSecond,
    /// Back-off and second approach.
    pub slow_rate: MmPerSecond,
    /// Back-off distance.
    pub retract: Mm,
    /// A hit while moving halts.
    pub limit_enable: bool,
    /// What the motor's phase at the hit is good for.
    pub phase: EndstopPhaseConfig,
    /// Homing without a switch.
    pub stall: EndstopStallConfig,
}

/// The end of an axis found by its motor's stall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EndstopStallConfig {
    /// `pin` is the stallGuard output of the motor's driver.
    pub homing: bool,
    /// Peak coil current meanwhile; none: the motor's own.
    pub current: Option<Amps>,
    /// `SGT`, -64 to 63: lower is more sensitive; `SGTHRS` of a TMC2209 and TMC2226, 0 to 255: higher is.
    pub threshold: i16,
}

impl EndstopStallConfig {
    /// So many full steps at constant speed are let pass before a reading counts: two of the filter's.
    pub const SETTLING_FULL_STEPS: f64 = 8.0;
    /// So many more are between the first place at which a stall can be seen and the end, so that one is told
    /// from the other.
    pub const APART_FULL_STEPS: f64 = 8.0;
    /// So much later than the plan the motors are: what is written ahead, and between two looks, seconds.
    pub const SETTLING_S: f64 = 0.0025;

    /// How far off an axis must come from to see the stall at its end: mm, from mm/s, mm/s^2, mm/s^3.
    #[must_use]
    pub fn run_up(rate: f64, acceleration: f64, jerk: Option<f64>, full_steps_per_mm: f64) -> f64 {
        // With jerk the acceleration rises and falls; where it has no time to, this is more than it takes.
        let seconds = rate / acceleration + jerk.map_or(0.0, |jerk| acceleration / jerk);
        let full_steps = Self::SETTLING_FULL_STEPS + Self::APART_FULL_STEPS;
        rate * seconds / 2.0 + full_steps / full_steps_per_mm + rate * Self::SETTLING_S
    }
}

/// The motor's place in its electrical cycle of four full steps, when its axis hits the switch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EndstopPhaseConfig {
    /// It is looked at in every homing.
    pub check: bool,
    /// Where it should be, 1/256 full steps, 0 to below 1024; none: where the first homing finds it.
    pub calibrated: Option<f64>,
    /// How far from there it may be, mm either way; none: a full step.
    pub tolerance: Option<Mm>,
    /// The homing position is moved by half a full step at most, so that zero is at a full step.
    pub align_zero: bool,
    /// More than the tolerance is an alarm, and not a warning alone.
    pub halts: bool,
}

/// `[endstops]` `common.*`
#[derive(Clone, Debug, Default)]
pub struct HomingConfig {
    /// Time a switch must stay active.
    pub debounce: Micros,
    /// Axes one after another in this order; empty: XY together, then Z, then A B C.
    pub order: Vec<Axis, 6>,
    /// Z before X and Y.
    pub z_first: bool,
    /// Each axis alone, stopping both X and Y motors. Follows `arm_solution` unless the file says otherwise.
    pub corexy: bool,
    /// All three towers with one Z move. Follows `arm_solution` unless the file says otherwise.
    pub delta: bool,
    /// Rotary delta, by angles. Follows `arm_solution` unless the file says otherwise.
    pub rotary_delta: bool,
    /// In actuator space.
    pub scara: bool,
    /// Move to machine X0 Y0 afterwards.
    pub move_to_origin: bool,
    /// Z rises so far before X and Y home.
    pub lift: Mm,
    /// Where Z homes, machine X and Y; `None`: wherever the tool is.
    pub safe_z: [Option<Mm>; 2],
    /// Slow approaches that must agree.
    pub samples: u8,
    /// How far they may lie apart.
    pub tolerance: Mm,
    /// Rounds that are added where they do not.
    pub retries: u8,
    /// The line that G28 without axes runs instead; empty: none.
    pub gcode: Command,
    /// Trims of the first three actuators.
    pub trim: [Mm; 3],
}

impl HomingConfig {
    /// Whether homing these axes ends over the origin: not when X or Y stays where somebody has put it. A
    /// rotary delta stays where its arms meet their switches.
    #[must_use]
    pub fn ends_over_origin(&self, homed: AxisSet) -> bool {
        self.move_to_origin && !self.rotary_delta && homed.has(Axis::X) && homed.has(Axis::Y)
    }
}

/// `[soft endstop]`
#[derive(Clone, Copy, Debug, Default)]
pub struct SoftEndstops {
    /// Moves are held against the travel.
    pub enable: bool,
    /// A move out of the travel halts. Follows the dialect unless the file says otherwise.
    pub halt: bool,
    /// The least machine position of X, Y and Z, where the file says one.
    pub least: [Option<Mm>; 3],
    /// The greatest one.
    pub most: [Option<Mm>; 3],
}

/// `[zprobe]`
#[derive(Clone, Copy, Debug, Default)]
pub struct ProbeConfig {
    /// Whether there is one.
    pub enable: bool,
    /// Input, logically high when triggered.
    pub pin: Option<Pin>,
    /// Search.
    pub slow_rate: MmPerSecond,
    /// Travel between points.
    pub fast_rate: MmPerSecond,
    /// Lift after a touch.
    pub return_rate: MmPerSecond,
    /// Clearance between touches.
    pub height: Mm,
    /// Longest probing move.
    pub max_travel: Mm,
    /// Probe towards +Z.
    pub reverse_z: bool,
    /// Pause before each probing move.
    pub dwell: Micros,
    /// Time the probe must stay triggered.
    pub debounce: Micros,
    /// Where it is, seen from the nozzle, mm.
    pub offsets: [f64; 3],
    /// Input that is logically high while the probe is out.
    pub deployed_pin: Option<Pin>,
    /// Put away, its contact reads triggered.
    pub stowed_reads_triggered: bool,
    /// How the bed is touched at a place.
    pub samples: SamplesConfig,
}

/// Several touches of one place: `[zprobe]` `samples` and what follows it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SamplesConfig {
    /// How many.
    pub count: u8,
    /// Their middle one counts, not their mean.
    pub median: bool,
    /// How far apart they may lie; 0: not looked at.
    pub tolerance: Mm,
    /// How often they are made again when they lie further apart.
    pub retries: u8,
    /// How far the probe rises between them.
    pub retract: Mm,
}

impl ProbeConfig {
    /// The speed of the lift where none is asked for.
    #[must_use]
    pub fn usual_return_rate(&self) -> MmPerSecond {
        let twice = self.slow_rate * 2.0;
        if twice < self.fast_rate { twice } else { self.fast_rate }
    }
}

//! State of the machine at a moment, as values: for pages and displays, which would else have to read it
//! out of the answers to commands.

use config::{Name, TemperatureConfig};
use heapless::Vec;
use program::{Spindle, State};
use units::{Axis, AxisSet, Celsius, MAX_HEATERS, MmPerSecond, PerAxis};

use crate::bed::MeshName;
use crate::paths::Path;

/// Most fans that are shown: one for each that the configuration may describe.
pub const MAX_SHOWN_FANS: usize = config::MAX_FANS;

/// Coordinate systems that are shown: G54 to G59.
pub const SHOWN_SYSTEMS: usize = 6;

/// Room for the names of a laser's interlocks: as much as the setting has, and a comma.
const INTERLOCK_BYTES: usize = 97;

/// The machine at a moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// State of the machine.
    pub state: State,
    /// Whether a job is suspended, to be come back to.
    pub is_suspended: bool,
    /// Position in machine coordinates, mm: of the motors while they move, else of the last move's end.
    pub position: PerAxis<f64>,
    /// The same in the coordinate system in force, mm.
    pub work: PerAxis<f64>,
    /// Least and greatest places of the axes, mm; infinite where an axis does not end.
    pub ends: [PerAxis<f64>; 2],
    /// Coordinate system in force: 0 is G54.
    pub system: u8,
    /// Offsets of G54 to G59, X Y Z in mm.
    pub systems: [[f64; 3]; SHOWN_SYSTEMS],
    /// Shift of everything (M290), X Y Z in mm.
    pub shift: [f64; 3],
    /// Whether coordinates of X, Y and Z, and lengths of filament, are absolute.
    pub absolute: [bool; 2],
    /// Factor of filament (M221); 1 is as written.
    pub flow_factor: f64,
    /// Speed along the path.
    pub speed: MmPerSecond,
    /// Feed rate in force.
    pub feed_rate: MmPerSecond,
    /// Operator's factor of feed rates, with the program's (M220); 1 is as written.
    pub feed_factor: f64,
    /// Operator's factor of rapids.
    pub rapid_factor: f64,
    /// Axes that are homed.
    pub homed: AxisSet,
    /// Heaters and sensors, in the configuration's order.
    pub heaters: Vec<HeaterShown, MAX_HEATERS>,
    /// Fans, in the configuration's order.
    pub fans: Vec<FanShown, MAX_SHOWN_FANS>,
    /// The job: played or paused, else the last one.
    pub job: Option<JobShown>,
    /// Greatest speed along the path, mm/s, none where only axes and motors have one; and acceleration,
    /// mm/s^2.
    pub most: (Option<f64>, f64),
    /// Switches at the ends of axes.
    pub limits: Vec<LimitShown, { config::MAX_ENDSTOPS }>,
    /// The probe, where there is one.
    pub probe: Option<ProbeShown>,
    /// Number of the tool in the spindle, 0 without one, and its length in mm; none where tools are
    /// extruders.
    pub tool: Option<(u32, f64)>,
    /// The spindle, where an output turns one.
    pub spindle: Option<SpindleShown>,
    /// The laser, where there is one.
    pub laser: Option<LaserShown>,
    /// Whether flood and mist are on; none where no output is coolant's.
    pub coolant: Option<[bool; 2]>,
    /// The mesh that levels the machine, while one does.
    pub mesh: Option<MeshShown>,
    /// Number of the list of macros, which viewers are given apart: it changes when they are read anew.
    pub macros: u32,
}

/// Mesh of the bed, but for its heights, which viewers are given apart: they are many, and seldom change.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeshShown {
    /// Name of the file that it is saved in; empty: it is not.
    pub name: MeshName,
    /// Least and greatest place of its points, X and Y in mm.
    pub ends: [[f64; 2]; 2],
    /// Points along X and along Y.
    pub count: [u8; 2],
    /// Number that changes with the heights; not 0.
    pub number: u32,
}

/// Switch at an end of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LimitShown {
    /// Axis that it is on.
    pub axis: Axis,
    /// End of the axis: least, greatest, or not said.
    pub end: Option<bool>,
    /// Whether it is pressed.
    pub is_pressed: bool,
}

/// State of the probe.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProbeShown {
    /// Whether it touches.
    pub touches: bool,
    /// Machine coordinates of the last contact, X Y Z in mm.
    pub last: Option<[f64; 3]>,
}

/// State of the spindle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpindleShown {
    /// Direction of its turning.
    pub direction: Spindle,
    /// Speed that the program asks for (S).
    pub asked: f32,
    /// Speed that the output is set to, by the operator's factor as well: what it turns with is not measured.
    pub set: f32,
    /// Greatest speed; 0 where the configuration does not say it.
    pub most: f32,
    /// Operator's factor; 1 is as programmed.
    pub factor: f32,
}

/// State of the laser.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LaserShown {
    /// Power that comes out now, a share of full power.
    pub power: f32,
    /// Code in force: M3 is clockwise, M4 counterclockwise.
    pub mode: Spindle,
    /// Whether the beam is that of a test at rest (`fire`).
    pub is_test: bool,
    /// Whether it shows the place during a jog.
    pub is_framing: bool,
    /// Names of interlocks that are open, each with a comma behind.
    pub open: heapless::String<INTERLOCK_BYTES>,
}

/// A heater, or a sensor without one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeaterShown {
    /// Name in the configuration.
    pub name: Name,
    /// Letter of replies: `T`, `B`.
    pub designator: heapless::String<8>,
    /// Temperature; none while the sensor does not give one.
    pub reading: Option<Celsius>,
    /// Target; 0 is off.
    pub target: Celsius,
    /// Share of full power, 0 to 1.
    pub power: f32,
    /// Highest target that the configuration allows.
    pub max: Celsius,
    /// Whether there is a heater, and not a sensor alone.
    pub heats: bool,
}

impl HeaterShown {
    /// Returns a heater of the configuration, cold.
    #[must_use]
    pub fn named(heater: &TemperatureConfig) -> Self {
        Self {
            name: heater.name.clone(),
            designator: heater.designator.clone(),
            max: heater.max_temp,
            heats: heater.heater_pin.is_some(),
            ..Self::default()
        }
    }
}

/// Power and speed of a fan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FanShown {
    /// Name in the configuration.
    pub name: Name,
    /// Share of full power, 0 to 1.
    pub power: f32,
    /// Revolutions per minute, where they are counted.
    pub rpm: Option<f32>,
}

/// How a job has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobEnd {
    /// With its last line.
    Complete,
    /// By somebody who ended it.
    Cancelled,
    /// The job was dropped by a halt.
    Halted,
}

/// The file that is played, or was played last.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JobShown {
    /// Path of the file.
    pub path: Path,
    /// Size of the file, bytes.
    pub size: u32,
    /// Bytes of lines that are made, or read while nothing moves.
    pub done: u32,
    /// Number of the line that is made.
    pub line: u32,
    /// Time since the job began, seconds.
    pub elapsed_s: u32,
    /// Time left by the planner, or by the slicer's statement, seconds.
    pub left_s: Option<f32>,
    /// Whether the job is paused.
    pub is_paused: bool,
    /// Whether the job waits for a temperature.
    pub is_heating: bool,
    /// Layer, from 1; 0 before the first.
    pub layer: u32,
    /// Number of layers, once the file has said it.
    pub layers: Option<u32>,
    /// Filament that extruders have pushed since the job began, mm.
    pub filament: f32,
    /// How it has ended; none while it goes on.
    pub end: Option<JobEnd>,
}

//! State of the machine at a moment, as values: for pages and displays, which would else have to read it
//! out of the answers to commands.

use config::{Name, TemperatureConfig};
use heapless::Vec;
use program::State;
use units::{AxisSet, Celsius, MAX_HEATERS, MmPerSecond, PerAxis};

use crate::paths::Path;

/// Most fans that are shown: one for each that the configuration may describe.
pub const MAX_SHOWN_FANS: usize = config::MAX_FANS;

/// Coordinate systems that are shown: G54 to G59.
pub const SHOWN_SYSTEMS: usize = 6;

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
    /// The job, played or paused.
    pub job: Option<JobShown>,
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
}

impl HeaterShown {
    /// Returns a heater of the configuration, cold.
    #[must_use]
    pub fn named(heater: &TemperatureConfig) -> Self {
        Self { name: heater.name.clone(), designator: heater.designator.clone(), ..Self::default() }
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

/// The file that is played.
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
}

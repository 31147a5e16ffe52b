//! What the interpreter is told about the machine once, when it starts.

use heapless::Vec;
use units::{Axis, Celsius, MmPerSecond, SwitchId, ToolId};

use crate::claims::Claims;
use crate::tools::MAX_TOOLS;

/// The machine as the interpreter sees it.
#[derive(Clone, Debug, Default)]
pub struct Setup {
    /// Rate of G1 until an F word.
    pub feed_rate: MmPerSecond,
    /// Rate of G0 until it is changed.
    pub seek_rate: MmPerSecond,
    /// F always sets the rate of G1, also on a line of G0.
    pub compliant_seek_rate: bool,
    /// G92 offset at the start, X Y Z in mm.
    pub g92: [f64; 3],
    /// The extruders.
    pub tools: Vec<ToolSettings, MAX_TOOLS>,
    /// The temperature controls, in the description's order.
    pub heaters: Vec<HeaterSetup, { units::MAX_HEATERS }>,
    /// Codes that heaters and switches listen to.
    pub claims: Claims,
    /// Offsets of coordinate systems and the park position outlast a power cycle as parameters do.
    pub keeps_offsets: bool,
    /// Switches that codes name by a number.
    pub io: Vec<IoSetup, MOST_IO>,
    /// Nothing is carried out: programs are only looked at.
    pub is_preview: bool,
    /// What the spindle can do.
    pub spindle: SpindleSetup,
    /// Canned cycles.
    pub cycles: CycleSetup,
    /// In GRBL's dialect G30 parks at the second park position (`nist_G30`).
    pub g30_parks: bool,
}

/// Switches at most.
const MOST_IO: usize = 16;

/// A switch that M62 to M68 name by a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IoSetup {
    /// Its number.
    pub number: u8,
    /// The switch.
    pub switch: SwitchId,
    /// What it is.
    pub kind: IoKind,
}

/// What a switch with a number is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IoKind {
    /// An output that is on or off.
    Digital,
    /// An output that takes a value.
    Analog,
    /// An input.
    Input,
}

/// What the spindle can do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SpindleSetup {
    /// It says where it is: moves follow it, and it can be turned to an angle.
    pub has_encoder: bool,
    /// Its speed follows the radius (G96).
    pub has_speed_control: bool,
}

/// What the machine's description says of canned cycles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CycleSetup {
    /// They are switched off.
    pub is_off: bool,
    /// P is in milliseconds, not in seconds.
    pub dwell_in_ms: bool,
}

/// A temperature control, as codes address it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeaterSetup {
    /// Its number.
    pub id: ToolId,
    /// What targets 1 and 2 stand for.
    pub presets: [Celsius; 2],
}

/// What can be said of an extruder at run time.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolSettings {
    /// Its number.
    pub id: ToolId,
    /// The axis that its motor is.
    pub axis: Axis,
    /// X Y Z of its nozzle, seen from tool 0, mm.
    pub offset: [f64; 3],
    /// Diameter of the filament, mm, where E counts in mm3.
    pub filament_diameter: Option<f64>,
    /// G10 pulls back by this, mm.
    pub retract_length: f64,
    /// How fast.
    pub retract_rate: MmPerSecond,
    /// G11 pushes this much more than G10 pulled, mm.
    pub recover_length: f64,
    /// How fast.
    pub recover_rate: MmPerSecond,
    /// G10 then lifts Z by this, mm.
    pub z_lift: f64,
    /// How fast.
    pub z_lift_rate: MmPerSecond,
    /// The greatest flow of G1 where E counts in mm3, mm3/s (M203 V).
    pub flow_limit: Option<f64>,
    /// An error in the configuration keeps it off.
    pub is_off: bool,
}

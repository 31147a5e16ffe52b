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
    /// Switches whose codes give the width of pulses, or an angle.
    pub pulses: Vec<PulseSetup, MOST_IO>,
    /// Switches that codes name by a number.
    pub io: Vec<IoSetup, MOST_IO>,
    /// Strips of lights, in the description's order.
    pub strips: Vec<StripSetup, MOST_STRIPS>,
    /// Nothing is carried out: programs are only looked at.
    pub is_preview: bool,
    /// What the spindle can do.
    pub spindle: SpindleSetup,
    /// Canned cycles.
    pub cycles: CycleSetup,
    /// In GRBL's dialect G30 parks at the second park position (`nist_G30`).
    pub g30_parks: bool,
}

impl Setup {
    /// What S asks of a switch: percent of one on a timer.
    pub(crate) fn value_of_s(&self, switch: SwitchId, s: f32) -> f32 {
        let pulses = self.pulses.iter().find(|pulses| pulses.switch == switch);
        pulses.map_or(s, |pulses| pulses.percent_of_s(s))
    }
}

/// Switches at most.
const MOST_IO: usize = 16;

/// Strips of lights at most.
const MOST_STRIPS: usize = 4;

/// A strip of lights, as M150 addresses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StripSetup {
    /// Its number.
    pub number: u8,
    /// Lights that it has.
    pub lights: u16,
}

/// A switch on a timer: what its pulses are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PulseSetup {
    /// The switch.
    pub switch: SwitchId,
    /// Percent of the timer's period that a microsecond is.
    pub percent_per_us: f32,
    /// What angles mean, where it turns a servo.
    pub servo: Option<ServoSetup>,
}

/// A servo: pulses from the least to the widest turn it from 0 to the greatest angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoSetup {
    /// The greatest angle, degrees.
    pub max_angle: f32,
    /// Width of its pulses at angle 0 and at the greatest, microseconds.
    pub pulse_us: [f32; 2],
}

impl PulseSetup {
    /// Percent that S asks for: an angle of a servo, or the width of its pulses where that is more than any
    /// angle; of every other output S is percent.
    #[must_use]
    pub fn percent_of_s(&self, s: f32) -> f32 {
        let Some(ServoSetup { max_angle, pulse_us: [least, most] }) = self.servo else { return s };
        let width = if s <= max_angle { least + (most - least) * s.max(0.0) / max_angle } else { s };
        self.percent_per_us * width.clamp(least, most)
    }

    /// Percent that a width of pulses is, in microseconds.
    #[must_use]
    pub fn percent_of_width(&self, us: f32) -> f32 {
        let us = self.servo.map_or(us, |servo| us.clamp(servo.pulse_us[0], servo.pulse_us[1]));
        (self.percent_per_us * us).clamp(0.0, 100.0)
    }
}

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

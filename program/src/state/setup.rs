//! Facts about the machine that the interpreter gets at start-up.

use heapless::Vec;
use units::{Celsius, MmPerSecond, PowerLaw, SwitchId, ToolId};

pub use units::{CycleSetup, ServoSetup, ToolSettings};

use crate::state::auxiliary::Spindle;
use crate::state::claims::Claims;
use crate::state::modal::Modal;
use crate::state::tools::MAX_TOOLS;

/// Machine configuration as the interpreter sees it.
#[derive(Clone, Debug, Default)]
pub struct Setup {
    /// Feed rate of G1 before the first F word.
    pub feed_rate: MmPerSecond,
    /// Rapid rate of G0 until a code changes it.
    pub seek_rate: MmPerSecond,
    /// Whether F always sets the rate of G1, even on a line of G0.
    pub compliant_seek_rate: bool,
    /// G92 offset at the start, X Y Z in mm.
    pub g92: [f64; 3],
    /// Extruders and their settings.
    pub tools: Vec<ToolSettings, MAX_TOOLS>,
    /// Temperature controls, in the configuration's order.
    pub heaters: Vec<HeaterSetup, { units::MAX_HEATERS }>,
    /// Codes that heaters and switches listen to.
    pub claims: Claims,
    /// Whether coordinate systems and park positions are persistent, as parameters are.
    pub keeps_offsets: bool,
    /// Switches whose codes give the width of pulses, or an angle.
    pub pulses: Vec<PulseSetup, MOST_IO>,
    /// Switches that codes address by number.
    pub io: Vec<IoSetup, MOST_IO>,
    /// Strips of lights, in the configuration's order.
    pub strips: Vec<StripSetup, MOST_STRIPS>,
    /// Whether programs are only checked, without carrying anything out.
    pub is_preview: bool,
    /// Capabilities of the spindle.
    pub spindle: SpindleSetup,
    /// Laser; `None` without one, and S and M3 to M5 are the spindle's alone.
    pub laser: Option<LaserSetup>,
    /// Settings of canned cycles.
    pub cycles: CycleSetup,
    /// Whether G30 parks at the second park position in GRBL's dialect (`nist_G30`).
    pub g30_parks: bool,
}

impl Setup {
    /// Returns the value of a switch for S; an output on a timer takes percent.
    pub(crate) fn value_of_s(&self, switch: SwitchId, s: f32) -> f32 {
        let pulses = self.pulses.iter().find(|pulses| pulses.switch == switch);
        pulses.map_or(s, |pulses| pulses.percent_of_s(s))
    }

    /// Returns the S of moves in these modes, and how a laser's power depends on the speed: S counts for a
    /// laser only between M3 or M4 and M5, in laser mode.
    #[inline]
    pub(crate) fn power_of_moves(&self, modal: &Modal) -> (f32, PowerLaw) {
        let (Some(laser), spindle) = (self.laser, modal.auxiliary.spindle) else { return (modal.power, PowerLaw::Off) };
        if !laser.is_laser_mode || spindle == Spindle::Stopped {
            return (0.0, PowerLaw::Off);
        }
        let follows = laser.always_by_speed || spindle == Spindle::CounterClockwise;
        (modal.power, if follows { PowerLaw::BySpeed } else { PowerLaw::Constant })
    }
}

/// Greatest number of switches.
const MOST_IO: usize = 16;

/// Greatest number of strips of lights.
const MOST_STRIPS: usize = 4;

/// Strip of lights, as M150 addresses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StripSetup {
    /// Number of the strip.
    pub number: u8,
    /// Number of lights in the strip.
    pub lights: u16,
}

/// Pulse settings of a switch on a timer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PulseSetup {
    /// Switch with these pulses.
    pub switch: SwitchId,
    /// Percent of the timer's period in a microsecond.
    pub percent_per_us: f32,
    /// Meaning of angles, if the switch turns a servo.
    pub servo: Option<ServoSetup>,
}

impl PulseSetup {
    /// Returns the percent for S: an angle of a servo, or a pulse width if S exceeds every angle; S of every
    /// other output is percent.
    #[must_use]
    pub fn percent_of_s(&self, s: f32) -> f32 {
        let Some(ServoSetup { max_angle, pulse_us: [least, most] }) = self.servo else { return s };
        let width = if s <= max_angle { least + (most - least) * s.max(0.0) / max_angle } else { s };
        self.percent_per_us * units::within(width, least, most)
    }

    /// Returns the percent for a pulse width in microseconds.
    #[must_use]
    pub fn percent_of_width(&self, us: f32) -> f32 {
        let us = self.servo.map_or(us, |servo| units::within(us, servo.pulse_us[0], servo.pulse_us[1]));
        units::within(self.percent_per_us * us, 0.0, 100.0)
    }
}

/// Switch that M62 to M68 address by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IoSetup {
    /// Number that codes use.
    pub number: u8,
    /// Switch of that number.
    pub switch: SwitchId,
    /// Kind of the switch.
    pub kind: IoKind,
}

/// Kind of a numbered switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IoKind {
    /// Output that is on or off.
    Digital,
    /// Output that takes a value.
    Analog,
    /// Input that codes read.
    Input,
}

/// Capabilities of the spindle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SpindleSetup {
    /// Whether an encoder reports the angle, for synchronised moves and for orienting.
    pub has_encoder: bool,
    /// Whether spindle speed can follow the radius (G96).
    pub has_speed_control: bool,
}

/// Laser, as codes use it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaserSetup {
    /// Laser mode (`$32`): moves have power. Otherwise they have none, and S is the power at rest.
    pub is_laser_mode: bool,
    /// Whether M3's power follows the speed along the path, as M4's always does.
    pub always_by_speed: bool,
    /// S until the program sets it.
    pub default_s: f32,
}

/// Temperature control, as codes address it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeaterSetup {
    /// Tool number of the heater.
    pub id: ToolId,
    /// Temperatures that targets 1 and 2 stand for.
    pub presets: [Celsius; 2],
}

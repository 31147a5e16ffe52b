//! Section `[fan]`: fans on outputs of `[switch]`, and the control of their speed.

use super::{MachineConfig, Name};
use crate::pin::Pin;
use heapless::String;
use units::{Celsius, Micros};

/// Quantity that controls a fan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FanFollows {
    /// Codes of the fan's switch.
    #[default]
    Codes,
    /// Heaters: the fan runs while one of them heats or is warm.
    Heaters,
    /// Motors and heaters: the fan runs while one of them is on, and for `linger` afterwards.
    Electronics,
    /// Temperature that the fan holds.
    Temperature,
}

/// Response to a fan that has stopped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StoppedFan {
    /// Every console gets a message.
    #[default]
    Tell,
    /// The machine halts at once.
    Halt,
}

/// Drive of a fan: shares of full power, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FanDriveConfig {
    /// Requested power below which the fan is off.
    pub off_below: f32,
    /// Least power of a running fan.
    pub min_power: f32,
    /// Greatest power of the fan.
    pub max_power: f32,
    /// Duration of the kick start at `max_power`.
    pub kick_start: Micros,
    /// Least increase in power that gets a kick start; a start from standstill always does.
    pub kick_start_step: f32,
}

/// Control law of a fan that holds a temperature.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FanControl {
    /// Whether PID control is used instead of on/off.
    pub pid: bool,
    /// Proportional gain: share of full power per degree too warm.
    pub p: f32,
    /// Integral gain: share of full power per degree-second.
    pub i: f32,
    /// Derivative gain: share of full power per degree a second.
    pub d: f32,
}

/// The tachometer of a fan.
#[derive(Clone, Copy, Debug, Default)]
pub struct TachometerConfig {
    /// Input of the tachometer.
    pub pin: Option<Pin>,
    /// Pulses per turn of the fan.
    pub pulses_per_turn: f32,
    /// Speed below which a driven fan counts as stopped, turns a minute; 0: never.
    pub min_rpm: f32,
    /// Time below `min_rpm` before the fan counts as stopped.
    pub stopped_after: Micros,
    /// Response to a stopped fan.
    pub when_stopped: StoppedFan,
}

/// A fan, named like the switch that drives it.
#[derive(Clone, Debug, Default)]
pub struct FanConfig {
    /// Name of the fan and its switch.
    pub name: Name,
    /// Whether the fan is in use.
    pub enable: bool,
    /// Quantity that controls the fan.
    pub follows: FanFollows,
    /// Names of the watched temperature controls, as written.
    pub sensors: String<72>,
    /// Places of the watched temperature controls, one bit each; set once all controls have places.
    pub watched: u8,
    /// Temperature that controls the fan.
    pub temperature: Celsius,
    /// Half width of the dead band around `temperature`.
    pub hysteresis: Celsius,
    /// Share of full power of the running fan.
    pub speed: f32,
    /// Share of full power while lingering, and the least while holding a temperature.
    pub idle_speed: f32,
    /// Time for which the fan runs on.
    pub linger: Micros,
    /// Control law for holding a temperature.
    pub control: FanControl,
    /// Drive limits and kick start.
    pub drive: FanDriveConfig,
    /// Tachometer that monitors the fan.
    pub tachometer: TachometerConfig,
}

impl FanConfig {
    /// Returns the names of the watched temperature controls.
    pub fn sensor_names(&self) -> impl Iterator<Item = &str> {
        self.sensors.split(',').map(str::trim).filter(|name| !name.is_empty())
    }

    /// Returns whether the fan watches the temperature control at this place.
    #[must_use]
    pub const fn watches(&self, place: usize) -> bool {
        place < 8 && self.watched & 1 << place != 0
    }
}

const _: () = assert!(super::MAX_TEMPERATURES <= 8, "a fan's temperature controls are bits of a byte");

impl MachineConfig {
    /// Returns the fan of a switch, when something else than the switch's codes controls the fan.
    #[must_use]
    pub fn automatic_fan(&self, switch: &str) -> Option<&FanConfig> {
        self.fans.iter().find(|fan| fan.enable && fan.name == switch && fan.follows != FanFollows::Codes)
    }
}

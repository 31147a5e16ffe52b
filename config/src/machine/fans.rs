//! `[fan]`: what an output of `[switch]` drives is a fan, and what that fan follows.

use super::{MachineConfig, Name};
use crate::pin::Pin;
use heapless::String;
use units::{Celsius, Micros};

/// What a fan follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FanFollows {
    /// The codes of its switch.
    #[default]
    Codes,
    /// Heaters: it runs while one of them heats or is warm.
    Heaters,
    /// Motors and heaters: it runs while one of them is on, and a while longer.
    Electronics,
    /// A temperature, which it is to keep.
    Temperature,
}

/// What happens when a fan does not turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StoppedFan {
    /// Every console is told.
    #[default]
    Tell,
    /// The machine halts.
    Halt,
}

/// How a fan is driven: shares of full power, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FanDriveConfig {
    /// Asked for less, it is off.
    pub off_below: f32,
    /// It is never given less, unless it is off.
    pub min_power: f32,
    /// It is never given more.
    pub max_power: f32,
    /// How long it has all of that first, when it is to run faster.
    pub kick_start: Micros,
    /// By how much faster; from standstill always.
    pub kick_start_step: f32,
}

/// How a fan keeps a temperature.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FanControl {
    /// With a PID law; else on and off.
    pub pid: bool,
    /// Share of full power for each degree too warm.
    pub p: f32,
    /// The same for each degree and second.
    pub i: f32,
    /// The same for each degree a second.
    pub d: f32,
}

/// The tachometer of a fan.
#[derive(Clone, Copy, Debug, Default)]
pub struct TachometerConfig {
    /// Its input.
    pub pin: Option<Pin>,
    /// Pulses of a turn.
    pub pulses_per_turn: f32,
    /// Turning slower than this while it is driven, turns a minute, it counts as stopped; 0: never.
    pub min_rpm: f32,
    /// For how long.
    pub stopped_after: Micros,
    /// What happens then.
    pub when_stopped: StoppedFan,
}

/// A fan. It has the name of the switch that drives it.
#[derive(Clone, Debug, Default)]
pub struct FanConfig {
    /// That name.
    pub name: Name,
    /// Whether it exists.
    pub enable: bool,
    /// What it follows.
    pub follows: FanFollows,
    /// Names of temperature controls, as written.
    pub sensors: String<72>,
    /// The same by their places, one bit each, once all have one.
    pub watched: u8,
    /// The temperature that it follows.
    pub temperature: Celsius,
    /// Half the width around it in which nothing changes.
    pub hysteresis: Celsius,
    /// Share of full power at which it runs.
    pub speed: f32,
    /// The same while it lingers, and the least with which it keeps a temperature.
    pub idle_speed: f32,
    /// How long it lingers.
    pub linger: Micros,
    /// How it keeps a temperature.
    pub control: FanControl,
    /// How it is driven.
    pub drive: FanDriveConfig,
    /// How its turning is known.
    pub tachometer: TachometerConfig,
}

impl FanConfig {
    /// The names of the temperature controls.
    pub fn sensor_names(&self) -> impl Iterator<Item = &str> {
        self.sensors.split(',').map(str::trim).filter(|name| !name.is_empty())
    }

    /// Whether it watches the temperature control at this place.
    #[must_use]
    pub const fn watches(&self, place: usize) -> bool {
        place < 8 && self.watched & 1 << place != 0
    }
}

const _: () = assert!(super::MAX_TEMPERATURES <= 8, "a fan's temperature controls are bits of a byte");

impl MachineConfig {
    /// The fan that a switch drives, when it follows something else than the switch's codes.
    #[must_use]
    pub fn automatic_fan(&self, switch: &str) -> Option<&FanConfig> {
        self.fans.iter().find(|fan| fan.enable && fan.name == switch && fan.follows != FanFollows::Codes)
    }
}

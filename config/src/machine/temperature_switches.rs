//! `[temperature switch]`: switches that follow a temperature.

use super::{Name, TemperatureConfig};
use units::{Celsius, Micros};

/// When such a rule operates its switch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Trigger {
    /// On when it becomes hot, off when it becomes cold.
    #[default]
    Level,
    /// On when it becomes hot.
    Rising,
    /// Off when it becomes cold.
    Falling,
}

/// A rule that operates an output switch by the hottest of some temperature controls.
#[derive(Clone, Debug, Default)]
pub struct TemperatureSwitchConfig {
    /// Its name.
    pub name: Name,
    /// Whether it exists.
    pub enable: bool,
    /// Designator of the temperature controls to watch: its first letter counts.
    pub designator: Name,
    /// Name of the switch.
    pub switch: Name,
    /// On and off change places.
    pub inverted: bool,
    /// When the switch is operated.
    pub trigger: Trigger,
    /// M-code that arms and disarms it; none: it is always armed.
    pub arm_mcode: Option<u16>,
    /// Armed at boot, where an M-code arms it.
    pub start_armed: bool,
    /// From here on it is hot.
    pub threshold: Celsius,
    /// Time between two looks while it is cold.
    pub heatup_poll: Micros,
    /// Time between two looks while it is hot.
    pub cooldown_poll: Micros,
}

impl TemperatureSwitchConfig {
    /// Whether it watches this temperature control.
    #[must_use]
    pub fn watches(&self, control: &TemperatureConfig) -> bool {
        let letter = self.designator.chars().next();
        letter.is_some() && control.designator.chars().next() == letter
    }
}

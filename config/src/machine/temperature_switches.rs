//! Section `[temperature switch]`: switches controlled by a temperature.

use super::{Name, TemperatureConfig};
use units::{Celsius, Micros};

/// Temperature change that operates the switch of a rule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Trigger {
    /// On when hot, off when cold again.
    #[default]
    Level,
    /// On when the control becomes hot, never off.
    Rising,
    /// Off when the control becomes cold, never on.
    Falling,
}

/// A rule that operates an output switch by the hottest of some temperature controls.
#[derive(Clone, Debug, Default)]
pub struct TemperatureSwitchConfig {
    /// Name of the rule in the file.
    pub name: Name,
    /// Whether the rule is in use.
    pub enable: bool,
    /// Designator of the watched temperature controls; its first letter counts.
    pub designator: Name,
    /// Name of the operated switch.
    pub switch: Name,
    /// Whether on and off change places.
    pub inverted: bool,
    /// Temperature change that operates the switch.
    pub trigger: Trigger,
    /// M-code that arms and disarms the rule; none: always armed.
    pub arm_mcode: Option<u16>,
    /// Whether a rule with `arm_mcode` is armed at boot.
    pub start_armed: bool,
    /// Temperature from which on the control counts as hot.
    pub threshold: Celsius,
    /// Time between two readings while cold.
    pub heatup_poll: Micros,
    /// Time between two readings while hot.
    pub cooldown_poll: Micros,
}

impl TemperatureSwitchConfig {
    /// Returns whether the rule watches this temperature control.
    #[must_use]
    pub fn watches(&self, control: &TemperatureConfig) -> bool {
        let letter = self.designator.chars().next();
        letter.is_some() && control.designator.chars().next() == letter
    }
}

//! Section `[temperature switch]`: switches controlled by a temperature.

use super::heat::TemperatureConfig;
use crate::names::Name;
use crate::setting::build::{bool, integer, number, text, word};
use crate::setting::declare::{settings, words};
use units::{Celsius, Micros};

/// Greatest number of rules in `[temperature switch]`.
pub const MAX_TEMPERATURE_SWITCHES: usize = 8;

words! {
    /// Temperature change that operates the switch of a rule.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Trigger {
        /// On when hot, off when cold again.
        #[default]
        Level = "level",
        /// On when the control becomes hot, never off.
        Rising = "rising",
        /// Off when the control becomes cold, never on.
        Falling = "falling",
    }
}

settings! {
    /// Rules that operate an output of [switch] by a temperature: a fan, a pump, a power supply that goes off
    /// when all is cold. Fans of hot ends and cabinets have more in [fan].
    #[derive(Clone, Debug, Default)]
    pub struct TemperatureSwitchConfig {
        /// Name of the rule in the file.
        name: Name;
        /// There is such a rule.
        enable: bool = bool("false").v1("temperatureswitch.<name>.enable");
        /// First letter of the designators of the temperature controls to watch; the hottest counts.
        designator: Name = text("", 8)
            .v1("temperatureswitch.<name>.designator") => |v: &str| Name::try_from(v).unwrap_or_default();
        /// Name of the output switch to operate.
        switch: Name = text("", 24)
            .v1("temperatureswitch.<name>.switch") => |v: &str| Name::try_from(v).unwrap_or_default();
        /// Off where it would be on, and the other way round.
        inverted: bool = bool("false").v1("temperatureswitch.<name>.inverted");
        /// level switches on when it becomes hot and off when it becomes cold; rising only on, falling only
        /// off.
        trigger: Trigger = word("level", Trigger::WORDS).v1("temperatureswitch.<name>.trigger");
        /// M-code that arms it (S1), or disarms it (S0); rising and falling act once, then it must be armed
        /// anew. 0: always armed.
        arm_mcode: Option<u16> = integer("0", &(0, 65_535))
            .v1("temperatureswitch.<name>.arm_mcode") => |v: i64| u16::try_from(v).ok().filter(|code| *code > 0);
        /// Armed at boot, where arm_mcode is not 0.
        start_armed: bool = bool("false");
        /// From here on it is hot, below it is cold.
        "threshold_temp" threshold: Celsius = number("50", &(-273.0, 2_000.0))
            .unit("C").klipper("[heater_fan <name>] heater_temp").v1("temperatureswitch.<name>.threshold_temp");
        /// Time between two looks while it is cold.
        heatup_poll: Micros = integer("15", &(0, 86_400)).unit("s").v1("temperatureswitch.<name>.heatup_poll");
        /// Time between two looks while it is hot.
        cooldown_poll: Micros = integer("60", &(0, 86_400))
            .unit("s").v1("temperatureswitch.<name>.cooldown_poll")
           ;
    }
}

impl TemperatureSwitchConfig {
    /// Returns whether the rule watches this temperature control.
    #[must_use]
    pub fn watches(&self, control: &TemperatureConfig) -> bool {
        let letter = self.designator.chars().next();
        letter.is_some() && control.designator.chars().next() == letter
    }
}

//! `[temperature switch]`.

use super::build::{bool, integer, new_name, number, text, word};
use super::{CannotCreate, Docs, Form, Instances, Section, Words};
use crate::machine::{MAX_TEMPERATURE_SWITCHES, Name, TemperatureSwitchConfig, Trigger};
use units::{Celsius, Micros};

/// `|rule, value| ...` on the rule at the instance's place.
macro_rules! rule {
    (|$rule:ident, $value:ident| $body:expr) => {
        |c, i, $value| {
            if let Some($rule) = c.temperature_switches.get_mut(i) {
                $body;
            }
        }
    };
}

/// Converts whole seconds to microseconds.
const fn seconds(seconds: i64) -> Micros {
    Micros::from_seconds(seconds as u64)
}

pub const TEMPERATURE_SWITCH: Section = Section {
    name: "temperature switch",
    store: None,
    docs: Docs::new(
        "Rules that operate an output of [switch] by a temperature: a fan, a pump, a power supply that goes off \
              when all is cold. Fans of hot ends and cabinets have more in [fan].",
    ),
    form: Form::Named(Instances {
        noun: "temperature switch",
        find: |c, name| c.temperature_switches.iter().position(|rule| rule.name == name),
        create: |c, name| {
            let rule = TemperatureSwitchConfig { name: new_name(name)?, ..TemperatureSwitchConfig::default() };
            c.temperature_switches.push(rule).map_err(|_| CannotCreate::Full(MAX_TEMPERATURE_SWITCHES))?;
            Ok(c.temperature_switches.len() - 1)
        },
        name: |c, i| c.temperature_switches.get(i).map_or("", |rule| rule.name.as_str()),
        is_live: |c, i| c.temperature_switches.get(i).is_some_and(|rule| rule.enable),
    }),
    settings: &[
        bool("enable", "false", rule!(|r, v| r.enable = v), "There is such a rule.")
            .v1("temperatureswitch.<name>.enable"),
        text(
            "designator",
            "",
            8,
            rule!(|r, v| r.designator = Name::try_from(v).unwrap_or_default()),
            "First letter of the designators of the temperature controls to watch; the hottest counts.",
        )
        .v1("temperatureswitch.<name>.designator"),
        text(
            "switch",
            "",
            24,
            rule!(|r, v| r.switch = Name::try_from(v).unwrap_or_default()),
            "Name of the output switch to operate.",
        )
        .v1("temperatureswitch.<name>.switch"),
        bool("inverted", "false", rule!(|r, v| r.inverted = v), "Off where it would be on, and the other way round.")
            .v1("temperatureswitch.<name>.inverted"),
        word(
            "trigger",
            "level",
            &Words(&["level", "rising", "falling"]),
            rule!(|r, v| r.trigger = match v {
                1 => Trigger::Rising,
                2 => Trigger::Falling,
                _ => Trigger::Level,
            }),
            "level switches on when it becomes hot and off when it becomes cold; rising only on, falling only off.",
        )
        .v1("temperatureswitch.<name>.trigger"),
        integer(
            "arm_mcode",
            "0",
            &(0, 65_535),
            rule!(|r, v| r.arm_mcode = u16::try_from(v).ok().filter(|code| *code > 0)),
            "M-code that arms it (S1), or disarms it (S0); rising and falling act once, then it must be armed anew. \
             0: always armed.",
        )
        .v1("temperatureswitch.<name>.arm_mcode"),
        bool("start_armed", "false", rule!(|r, v| r.start_armed = v), "Armed at boot, where arm_mcode is not 0."),
        number(
            "threshold_temp",
            "50",
            &(-273.0, 2_000.0),
            rule!(|r, v| r.threshold = Celsius(v as f32)),
            "From here on it is hot, below it is cold.",
        )
        .unit("C")
        .klipper("[heater_fan <name>] heater_temp")
        .v1("temperatureswitch.<name>.threshold_temp"),
        integer(
            "heatup_poll",
            "15",
            &(0, 86_400),
            rule!(|r, v| r.heatup_poll = seconds(v)),
            "Time between two looks while it is cold.",
        )
        .unit("s")
        .v1("temperatureswitch.<name>.heatup_poll"),
        integer(
            "cooldown_poll",
            "60",
            &(0, 86_400),
            rule!(|r, v| r.cooldown_poll = seconds(v)),
            "Time between two looks while it is hot.",
        )
        .unit("s")
        .v1("temperatureswitch.<name>.cooldown_poll"),
    ],
};

//! Rows of the section `[fan]`.

use super::build::{NOT_NEGATIVE, bool, new_name, number, pin, text, word};
use super::{CannotCreate, Docs, Form, Instances, PinRole, Section, Words};
use crate::machine::{FanConfig, FanFollows, MAX_FANS, StoppedFan};
use crate::pin::PinName;
use units::{Celsius, Micros};

/// `|fan, value| ...` on the fan at the instance's place.
macro_rules! fan {
    (|$fan:ident, $value:ident| $body:expr) => {
        |c, i, $value| {
            if let Some($fan) = c.fans.get_mut(i) {
                $body;
            }
        }
    };
}

const PERCENT: &(f64, f64) = &(0.0, 100.0);

/// A share from percent.
const fn share(percent: f64) -> f32 {
    (percent / 100.0) as f32
}

const fn time(seconds: f64) -> Micros {
    Micros((seconds * 1e6) as u64)
}

pub const FAN: Section = Section {
    name: "fan",
    store: None,
    docs: Docs::new("Fans: each has the name of the [switch] that drives it. It can follow heaters, motors or a temperature by \
              itself, be helped to start, and be watched by its tachometer."),
    form: Form::Named(Instances {
        noun: "fan",
        find: |c, name| c.fans.iter().position(|fan| fan.name == name),
        create: |c, name| {
            let fan = FanConfig { name: new_name(name)?, ..FanConfig::default() };
            c.fans.push(fan).map_err(|_| CannotCreate::Full(MAX_FANS))?;
            Ok(c.fans.len() - 1)
        },
        name: |c, i| c.fans.get(i).map_or("", |fan| fan.name.as_str()),
        is_live: |c, i| c.fans.get(i).is_some_and(|fan| fan.enable),
    }),
    settings: &[
        bool("enable", "false", fan!(|f, v| f.enable = v), "The switch of this name drives a fan.").velvet(),
        word(
            "follows",
            "codes",
            &Words(&["codes", "heaters", "electronics", "temperature"]),
            fan!(|f, v| f.follows = match v {
                1 => FanFollows::Heaters,
                2 => FanFollows::Electronics,
                3 => FanFollows::Temperature,
                _ => FanFollows::Codes,
            }),
            "codes: those of the switch. heaters: on while one of its sensors' heaters heats or is at `temperature`, as \
             for a hot end. electronics: on while motors have current or a heater is on, and `linger` longer. \
             temperature: it keeps its sensor at `temperature`.",
        )
        .velvet(),
        text(
            "sensors",
            "",
            72,
            fan!(|f, v| f.sensors = heapless::String::try_from(v).unwrap_or_default()),
            "Names of the temperature controls that it watches, commas between. electronics: every heater without any; \
             temperature: one.",
        )
        .klipper("[heater_fan <name>] heater")
        .velvet(),
        number(
            "temperature",
            "50",
            &(0.0, 2_000.0),
            fan!(|f, v| f.temperature = Celsius(v as f32)),
            "heaters: warm from here on. temperature: what it keeps.",
        )
        .unit("C")
        .klipper("[heater_fan <name>] heater_temp")
        .velvet(),
        number(
            "hysteresis",
            "2",
            &(0.0, 100.0),
            fan!(|f, v| f.hysteresis = Celsius(v as f32)),
            "It goes on or off when `temperature` is passed by so much.",
        )
        .unit("C")
        .klipper("[temperature_fan <name>] max_delta")
        .velvet(),
        number("speed", "100", PERCENT, fan!(|f, v| f.speed = share(v)), "Power with which it runs by itself.")
            .unit("%")
            .klipper("[heater_fan <name>] fan_speed")
            .velvet(),
        number(
            "idle_speed",
            "0",
            PERCENT,
            fan!(|f, v| f.idle_speed = share(v)),
            "electronics: power while it lingers. temperature: the least, so that it never stands.",
        )
        .derived("speed, where it follows electronics; else 0")
        .unit("%")
        .klipper("[controller_fan <name>] idle_speed")
        .velvet(),
        number(
            "linger",
            "30",
            &(0.0, 86_400.0),
            fan!(|f, v| f.linger = time(v)),
            "electronics: how long it runs on when motors and heaters are off.",
        )
        .unit("s")
        .klipper("[controller_fan <name>] idle_timeout")
        .velvet(),
        word(
            "control",
            "bang-bang",
            &Words(&["bang-bang", "pid"]),
            fan!(|f, v| f.control.pid = v == 1),
            "temperature: full on and off, or as much as it takes.",
        )
        .klipper("[temperature_fan <name>] control")
        .velvet(),
        number("p_factor", "10", NOT_NEGATIVE, fan!(|f, v| f.control.p = share(v)), "pid: power for each degree too warm.")
            .unit("%/C")
            .klipper("[temperature_fan <name>] pid_Kp")
            .velvet(),
        number("i_factor", "0.2", NOT_NEGATIVE, fan!(|f, v| f.control.i = share(v)), "pid: for each degree and second.")
            .unit("%/(C s)")
            .klipper("[temperature_fan <name>] pid_Ki")
            .velvet(),
        number("d_factor", "0", NOT_NEGATIVE, fan!(|f, v| f.control.d = share(v)), "pid: for each degree a second.")
            .unit("% s/C")
            .klipper("[temperature_fan <name>] pid_Kd")
            .velvet(),
        number(
            "off_below",
            "0",
            PERCENT,
            fan!(|f, v| f.drive.off_below = share(v)),
            "Asked for less than this, it is off: most fans hum and do not turn with less than 20 %.",
        )
        .unit("%")
        .klipper("[fan] off_below")
        .velvet(),
        number(
            "min_power",
            "0",
            PERCENT,
            fan!(|f, v| f.drive.min_power = share(v)),
            "It is given no less, unless it is off.",
        )
        .unit("%")
        .velvet(),
        number("max_power", "100", PERCENT, fan!(|f, v| f.drive.max_power = share(v)), "It is given no more.")
            .unit("%")
            .klipper("[fan] max_power")
            .velvet(),
        number(
            "kick_start_time",
            "0",
            &(0.0, 10.0),
            fan!(|f, v| f.drive.kick_start = time(v)),
            "From standstill it has max_power for so long first, so that it starts at any speed.",
        )
        .unit("s")
        .klipper("[fan] kick_start_time")
        .velvet(),
        number(
            "kick_start_step",
            "50",
            PERCENT,
            fan!(|f, v| f.drive.kick_start_step = share(v)),
            "The same where it is to run so much faster than it does.",
        )
        .unit("%")
        .velvet(),
        pin(
            "tachometer_pin",
            "nc",
            PinRole::Input,
            fan!(|f, v| f.tachometer.pin = v.and_then(PinName::digital)),
            "Input of its tachometer. Any input will do: it is looked at 2,000 times a second, so that up to 800 pulses a \
             second count.",
        )
        .klipper("[fan] tachometer_pin")
        .velvet(),
        number(
            "pulses_per_turn",
            "2",
            &(0.1, 100.0),
            fan!(|f, v| f.tachometer.pulses_per_turn = v as f32),
            "Pulses that the tachometer gives in a turn.",
        )
        .klipper("[fan] tachometer_ppr")
        .velvet(),
        number(
            "min_rpm",
            "100",
            &(0.0, 100_000.0),
            fan!(|f, v| f.tachometer.min_rpm = v as f32),
            "Slower than this while it is driven, it counts as stopped. 0: that is not watched.",
        )
        .unit("1/min")
        .velvet(),
        number(
            "stopped_after",
            "5",
            &(1.0, 600.0),
            fan!(|f, v| f.tachometer.stopped_after = time(v)),
            "When it has been so slow for so long.",
        )
        .unit("s")
        .velvet(),
        word(
            "when_stopped",
            "tell",
            &Words(&["tell", "halt"]),
            fan!(|f, v| f.tachometer.when_stopped = if v == 1 { StoppedFan::Halt } else { StoppedFan::Tell }),
            "A fan that has stopped is told on every console, or halts the machine.",
        )
        .velvet(),
    ],
};

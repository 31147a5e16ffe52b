//! Section `[fan]`: fans on outputs of `[switch]`, and the control of their speed.

use crate::names::Name;
use crate::pin::Pin;
use crate::setting::build::{NOT_NEGATIVE, bool, number, pin, text, word};
use crate::setting::declare::{settings, words};
use crate::setting::{PinRole, Words};
use heapless::String;
use units::{Celsius, Micros};

/// Greatest number of fans.
pub const MAX_FANS: usize = 8;

words! {
    /// Quantity that controls a fan.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum FanFollows {
        /// Codes of the fan's switch.
        #[default]
        Codes = "codes",
        /// Heaters: the fan runs while one of them heats or is warm.
        Heaters = "heaters",
        /// Motors and heaters: the fan runs while one of them is on, and for `linger` afterwards.
        Electronics = "electronics",
        /// Temperature that the fan holds.
        Temperature = "temperature",
    }
}

words! {
    /// Response to a fan that has stopped.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum StoppedFan {
        /// Every console gets a message.
        #[default]
        Tell = "tell",
        /// The machine halts at once.
        Halt = "halt",
    }
}

settings! {
    /// Drive of a fan: shares of full power, 0 to 1.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct FanDriveConfig {
        /// Asked for less than this, it is off: most fans hum and do not turn with less than 20 %.
        off_below: f32 = number("0", PERCENT).unit("%").klipper("[fan] off_below").velvet() => share;
        /// It is given no less, unless it is off.
        min_power: f32 = number("0", PERCENT).unit("%").velvet() => share;
        /// It is given no more.
        max_power: f32 = number("100", PERCENT).unit("%").klipper("[fan] max_power").velvet() => share;
        /// From standstill it has max_power for so long first, so that it starts at any speed.
        "kick_start_time" kick_start: Micros = number("0", &(0.0, 10.0))
            .unit("s").klipper("[fan] kick_start_time").velvet();
        /// The same where it is to run so much faster than it does.
        kick_start_step: f32 = number("50", PERCENT).unit("%").velvet() => share;
    }
}

settings! {
    /// Control law of a fan that holds a temperature.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct FanControl {
        /// temperature: full on and off, or as much as it takes.
        "control" pid: bool = word("bang-bang", &Words(&["bang-bang", "pid"]))
            .klipper("[temperature_fan <name>] control").velvet();
        /// pid: power for each degree too warm.
        "p_factor" p: f32 = number("10", NOT_NEGATIVE)
            .unit("%/C").klipper("[temperature_fan <name>] pid_Kp").velvet() => share;
        /// pid: for each degree and second.
        "i_factor" i: f32 = number("0.2", NOT_NEGATIVE)
            .unit("%/(C s)").klipper("[temperature_fan <name>] pid_Ki").velvet() => share;
        /// pid: for each degree a second.
        "d_factor" d: f32 = number("0", NOT_NEGATIVE)
            .unit("% s/C").klipper("[temperature_fan <name>] pid_Kd").velvet() => share;
    }
}

settings! {
    /// The tachometer of a fan.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct TachometerConfig {
        /// Input of its tachometer. Any input will do: it is looked at 2,000 times a second, so that up to
        /// 800 pulses a second count.
        "tachometer_pin" pin: Option<Pin> = pin("nc", PinRole::Input).klipper("[fan] tachometer_pin").velvet();
        /// Pulses that the tachometer gives in a turn.
        pulses_per_turn: f32 = number("2", &(0.1, 100.0)).klipper("[fan] tachometer_ppr").velvet();
        /// Slower than this while it is driven, it counts as stopped. 0: that is not watched.
        min_rpm: f32 = number("100", &(0.0, 100_000.0)).unit("1/min").velvet();
        /// When it has been so slow for so long.
        stopped_after: Micros = number("5", &(1.0, 600.0)).unit("s").velvet();
        /// A fan that has stopped is told on every console, or halts the machine.
        when_stopped: StoppedFan = word("tell", StoppedFan::WORDS).velvet();
    }
}

settings! {
    /// Fans: each has the name of the [switch] that drives it. It can follow heaters, motors or a temperature
    /// by itself, be helped to start, and be watched by its tachometer.
    #[derive(Clone, Debug, Default)]
    pub struct FanConfig {
        /// Name of the fan and its switch.
        name: Name;
        /// The switch of this name drives a fan.
        enable: bool = bool("false").velvet();
        /// codes: those of the switch. heaters: on while one of its sensors' heaters heats or is at
        /// `temperature`, as for a hot end. electronics: on while motors have current or a heater is on, and
        /// `linger` longer. temperature: it keeps its sensor at `temperature`.
        follows: FanFollows = word("codes", FanFollows::WORDS).velvet();
        /// Names of the temperature controls that it watches, commas between. electronics: every heater
        /// without any; temperature: one.
        sensors: String<72> = text("", 72).klipper("[heater_fan <name>] heater").velvet();
        /// heaters: warm from here on. temperature: what it keeps.
        temperature: Celsius = number("50", &(0.0, 2_000.0))
            .unit("C").klipper("[heater_fan <name>] heater_temp").velvet();
        /// It goes on or off when `temperature` is passed by so much.
        hysteresis: Celsius = number("2", &(0.0, 100.0))
            .unit("C").klipper("[temperature_fan <name>] max_delta").velvet();
        /// Power with which it runs by itself.
        speed: f32 = number("100", PERCENT).unit("%").klipper("[heater_fan <name>] fan_speed").velvet() => share;
        /// electronics: power while it lingers. temperature: the least, so that it never stands.
        idle_speed: f32 = number("0", PERCENT)
            .derived("speed, where it follows electronics; else 0").unit("%")
            .klipper("[controller_fan <name>] idle_speed").velvet() => share;
        /// electronics: how long it runs on when motors and heaters are off.
        linger: Micros = number("30", &(0.0, 86_400.0))
            .unit("s").klipper("[controller_fan <name>] idle_timeout").velvet();
        /// Control law for holding a temperature.
        control: FanControl;
        /// Drive limits and kick start.
        drive: FanDriveConfig;
        /// Tachometer that monitors the fan.
        tachometer: TachometerConfig;
        /// Places of the watched temperature controls, one bit each; set once all controls have places.
        watched: u8;
    }
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

const _: () = assert!(super::heat::MAX_TEMPERATURES <= 8, "a fan's temperature controls are bits of a byte");

const PERCENT: &(f64, f64) = &(0.0, 100.0);

/// A share from percent.
const fn share(percent: f64) -> f32 {
    (percent / 100.0) as f32
}

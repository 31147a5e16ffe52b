//! `[temperature control]`: sensor, heater, control and safety.

use super::{Name, SpiSensorConfig, ToolId};
use crate::pin::{Pin, ThermistorInput};
use heapless::String;
use units::{Celsius, Duty, HeaterId, Micros, Ohms, Volts};

/// Kind of sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum SensorKind {
    #[default]
    Thermistor,
    Pt100,
    Pt1000,
    Ad849x,
    Voltage,
    Max,
    Min,
    Mean,
    Difference,
    Chip,
    Max31855,
    Max31856,
    Max31865,
}

impl SensorKind {
    /// In the order of [`Self::WORDS`].
    pub const ALL: [Self; 13] = [
        Self::Thermistor,
        Self::Pt100,
        Self::Pt1000,
        Self::Ad849x,
        Self::Voltage,
        Self::Max,
        Self::Min,
        Self::Mean,
        Self::Difference,
        Self::Chip,
        Self::Max31855,
        Self::Max31856,
        Self::Max31865,
    ];
    /// What the file calls them.
    pub const WORDS: [&'static str; 13] = {
        let mut words = [""; 13];
        let mut at = 0;
        while at < words.len() {
            words[at] = Self::ALL[at].word();
            at += 1;
        }
        words
    };

    /// What the file calls it.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Thermistor => "thermistor",
            Self::Pt100 => "pt100",
            Self::Pt1000 => "pt1000",
            Self::Ad849x => "ad849x",
            Self::Voltage => "voltage",
            Self::Max => "max",
            Self::Min => "min",
            Self::Mean => "mean",
            Self::Difference => "difference",
            Self::Chip => "chip",
            Self::Max31855 => "max31855",
            Self::Max31856 => "max31856",
            Self::Max31865 => "max31865",
        }
    }

    /// It is read by the converter, at `thermistor_pin`.
    #[must_use]
    pub const fn is_analog(self) -> bool {
        matches!(self, Self::Thermistor | Self::Pt100 | Self::Pt1000 | Self::Ad849x | Self::Voltage)
    }

    /// It is read by a converter chip of its own, on an SPI bus.
    #[must_use]
    pub const fn is_on_spi(self) -> bool {
        matches!(self, Self::Max31855 | Self::Max31856 | Self::Max31865)
    }

    /// It measures nothing itself: it combines others.
    #[must_use]
    pub const fn is_combined(self) -> bool {
        matches!(self, Self::Max | Self::Min | Self::Mean | Self::Difference)
    }
}

/// Most points of a sensor's curve of voltages.
pub const MAX_VOLTAGE_POINTS: usize = 6;

/// A thermistor and its divider. Which rule applies, strongest first: `rt_curve`, `coefficients`, `table`,
/// `beta`.
#[derive(Clone, Copy, Debug, Default)]
pub struct ThermistorConfig {
    /// Analogue input.
    pub input: Option<ThermistorInput>,
    /// A built-in table entry by its name; the reader has checked that the name is known.
    pub table: Option<&'static str>,
    /// Look the name up only among the beta entries.
    pub use_beta_table: bool,
    /// Beta constant, kelvin.
    pub beta_k: f64,
    /// Resistance at `t0`.
    pub r0: Ohms,
    /// Temperature of `r0`.
    pub t0: Celsius,
    /// Resistor in parallel with the thermistor; zero for none.
    pub r1: Ohms,
    /// Pull-up resistor.
    pub r2: Ohms,
    /// Steinhart-Hart coefficients c1 c2 c3.
    pub coefficients: Option<[f64; 3]>,
    /// Three points of (temperature C, resistance ohm).
    pub rt_curve: Option<[(f64, f64); 3]>,
}

/// Where a temperature comes from.
#[derive(Clone, Copy, Debug, Default)]
pub struct SensorConfig {
    /// What it is.
    pub kind: SensorKind,
    /// When it is a thermistor; its input and its divider serve every other analogue sensor too.
    pub thermistor: ThermistorConfig,
    /// Output of a thermocouple amplifier at 0 C.
    pub amplifier_offset: Volts,
    /// Points of (temperature C, volts), as many as are written.
    pub voltage_points: [Option<[f64; 2]>; MAX_VOLTAGE_POINTS],
    /// The temperature controls that it combines, in the order that is written.
    pub parts: [Option<HeaterId>; units::MAX_HEATERS],
    /// Time constant of the filter between sensor and control, s; 0: none.
    pub filter_s: f32,
    /// When a converter chip reads it.
    pub spi: SpiSensorConfig,
    /// Sampling and control rate.
    pub readings_per_second: u16,
}

/// PID gains in Smoothieware's units: duty steps (of 255) per degree, per degree-second, and duty-seconds per
/// degree.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pid {
    /// Proportional.
    pub p: f32,
    /// Integral, per second.
    pub i: f32,
    /// Derivative, seconds.
    pub d: f32,
    /// Limit of the integral term, duty steps.
    pub i_max: f32,
    /// Time constant of the derivative's filter, s; 0: none.
    pub d_filter_s: f32,
    /// Proportional on measurement.
    pub on_measurement: bool,
    /// At a limit of the output the integral does not move towards it.
    pub windup: bool,
}

/// What is known of a heater: control by a model of it.
#[derive(Clone, Debug, Default)]
pub struct ThermalModel {
    /// Of the heater at full output, W.
    pub power_w: f32,
    /// Heat capacity of what it heats, J/K; 0: not known.
    pub capacity: f32,
    /// Loss to still air, W/K.
    pub loss: f32,
    /// More with the fan full on, W/K.
    pub fan_loss: f32,
    /// Dead time and lag of the sensor, s; 0: not known.
    pub late_s: f32,
    /// What filament takes, J/(mm3 K).
    pub filament_heat: f32,
    /// Name of the switch of the fan that blows at it; empty: none.
    pub fan_name: Name,
    /// The same by its place in the list of switches.
    pub fan: Option<u8>,
}

/// How the heater follows the target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ControlLaw {
    /// PID by [`Pid`].
    Pid,
    /// By [`ThermalModel`].
    Model,
    /// On below, off above the target by this much.
    BangBang {
        /// Half width of the dead band.
        hysteresis: Celsius,
    },
}

/// Runaway detection.
#[derive(Clone, Copy, Debug, Default)]
pub struct Runaway {
    /// Allowed deviation once the target was reached; none: not checked.
    pub range: Option<Celsius>,
    /// Time allowed to heat up; none: not checked.
    pub heating_timeout: Option<Micros>,
    /// Time allowed to cool down; none: as if cooling were instant.
    pub cooling_timeout: Option<Micros>,
    /// How close counts as reached.
    pub error_range: Celsius,
}

/// How a heater must answer to being driven.
#[derive(Clone, Copy, Debug, Default)]
pub struct Verify {
    /// Below its target by more than this it must warm.
    pub band: Celsius,
    /// By this much...
    pub gain: Celsius,
    /// ...with full output for so long; none: not checked.
    pub gain_time: Option<Micros>,
    /// Degrees below the band times seconds that are allowed once it was at its target; 0: any.
    pub max_error: f32,
    /// Largest rise of the reading in a second; 0: any.
    pub max_rise: Celsius,
    /// Largest fall of the reading in a second; 0: any.
    pub max_fall: Celsius,
    /// Longest time at full output; none: for ever.
    pub full_power_timeout: Option<Micros>,
    /// Longest time at one target; none: for ever.
    pub hold_timeout: Option<Micros>,
}

/// When M109 and its like have waited long enough.
#[derive(Clone, Copy, Debug, Default)]
pub struct TemperatureWait {
    /// So near below the target counts as reached.
    pub window: Celsius,
    /// It must be there for so long.
    pub dwell: Micros,
    /// The wait ends with an error after so long; 0: never.
    pub timeout: Micros,
}

/// One temperature controller, or a sensor when it has no heater.
#[derive(Clone, Debug, Default)]
pub struct TemperatureConfig {
    /// Its name.
    pub name: Name,
    /// Whether it exists.
    pub enable: bool,
    /// Address in tool changes and M-codes; 250 and above are always active.
    pub tool_id: ToolId,
    /// Label in reports: T, B.
    pub designator: String<8>,
    /// Sensor.
    pub sensor: SensorConfig,
    /// Names of what a combined sensor is made of.
    pub combines: String<96>,
    /// Heater output; none: read only.
    pub heater_pin: Option<Pin>,
    /// Ceiling of the output.
    pub max_pwm: Duty,
    /// It is on once in so long; 0: as often as can be.
    pub cycle: Micros,
    /// Gains.
    pub pid: Pid,
    /// Control by a model instead of PID.
    pub by_model: bool,
    /// What the model needs to know.
    pub model: ThermalModel,
    /// On/off control instead of PID.
    pub bang_bang: bool,
    /// Half width of the on/off dead band.
    pub hysteresis: Celsius,
    /// Lowest believable reading while heating.
    pub min_temp: Celsius,
    /// Highest allowed target and reading.
    pub max_temp: Celsius,
    /// Runaway detection.
    pub runaway: Runaway,
    /// How it must answer.
    pub verify: Verify,
    /// When a wait for it is over.
    pub wait: TemperatureWait,
    /// M-code that sets the target.
    pub set_m_code: u16,
    /// M-code that sets the target and waits.
    pub set_and_wait_m_code: u16,
    /// M-code that reports.
    pub get_m_code: u16,
    /// Meaning of S1 and S2; zero: off.
    pub presets: [Celsius; 2],
    /// Presets with names, as they are written.
    pub preset_names: String<96>,
}

impl TemperatureConfig {
    /// Names of what a combined sensor is made of.
    pub fn part_names(&self) -> impl Iterator<Item = &str> {
        self.combines.split([',', ' ', '\t']).filter(|name| !name.is_empty())
    }

    /// Presets with names; none where no temperature follows.
    pub fn named_presets(&self) -> impl Iterator<Item = (&str, Option<Celsius>)> {
        self.preset_names.split(',').map(str::trim).filter(|preset| !preset.is_empty()).map(|preset| {
            let (name, celsius) = preset.split_once([' ', '\t']).unwrap_or((preset, ""));
            (name, celsius.trim().parse().ok().filter(|celsius: &f32| *celsius > 0.0).map(Celsius))
        })
    }

    /// The temperature of a preset.
    #[must_use]
    pub fn preset(&self, name: &str) -> Option<Celsius> {
        let mut presets = self.named_presets();
        presets.find(|(preset, _)| preset.eq_ignore_ascii_case(name)).and_then(|(_, celsius)| celsius)
    }

    /// The control law chosen.
    #[must_use]
    pub const fn control(&self) -> ControlLaw {
        match (self.bang_bang, self.by_model) {
            (true, _) => ControlLaw::BangBang { hysteresis: self.hysteresis },
            (false, true) => ControlLaw::Model,
            (false, false) => ControlLaw::Pid,
        }
    }

    /// It melts filament: its number is that of a tool, not of a bed or a chamber.
    #[must_use]
    pub fn is_hot_end(&self) -> bool {
        self.heater_pin.is_some() && self.tool_id < ToolId::FIRST_BED
    }
}

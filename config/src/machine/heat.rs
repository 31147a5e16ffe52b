//! `[temperature control]`: sensor, heater, control and safety.

use super::{Name, SpiSensorConfig, ToolId};
use crate::pin::{Pin, ThermistorInput};
use heapless::String;
use units::{Celsius, Duty, HeaterId, Micros, Ohms, Volts};

/// Kind of temperature sensor.
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
    /// All kinds, in the order of [`Self::WORDS`].
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
    /// Words for the kinds in the file, in the order of [`Self::ALL`].
    pub const WORDS: [&'static str; 13] = {
        let mut words = [""; 13];
        let mut at = 0;
        while at < words.len() {
            words[at] = Self::ALL[at].word();
            at += 1;
        }
        words
    };

    /// Returns the word for this kind in the file.
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

    /// Returns whether the board's analogue converter reads the sensor, at `thermistor_pin`.
    #[must_use]
    pub const fn is_analog(self) -> bool {
        matches!(self, Self::Thermistor | Self::Pt100 | Self::Pt1000 | Self::Ad849x | Self::Voltage)
    }

    /// Returns whether a converter chip on an SPI bus reads the sensor.
    #[must_use]
    pub const fn is_on_spi(self) -> bool {
        matches!(self, Self::Max31855 | Self::Max31856 | Self::Max31865)
    }

    /// Returns whether the temperature is combined from other controls instead of measured.
    #[must_use]
    pub const fn is_combined(self) -> bool {
        matches!(self, Self::Max | Self::Min | Self::Mean | Self::Difference)
    }
}

/// Most points of a sensor's curve of voltages.
pub const MAX_VOLTAGE_POINTS: usize = 6;

/// A thermistor and its divider. Where several conversions are given, the first of `rt_curve`,
/// `coefficients`, `table` and `beta` applies.
#[derive(Clone, Copy, Debug, Default)]
pub struct ThermistorConfig {
    /// Analogue input of the sensor.
    pub input: Option<ThermistorInput>,
    /// A built-in table entry by its name; the reader has checked that the name is known.
    pub table: Option<&'static str>,
    /// Whether `table` is looked up only among the beta entries.
    pub use_beta_table: bool,
    /// Beta constant of the thermistor, kelvin.
    pub beta_k: f64,
    /// Thermistor resistance at `t0`, ohm.
    pub r0: Ohms,
    /// Temperature at which `r0` holds.
    pub t0: Celsius,
    /// Resistor in parallel with the thermistor, ohm; zero for none.
    pub r1: Ohms,
    /// Pull-up resistor of the divider, ohm.
    pub r2: Ohms,
    /// Steinhart-Hart coefficients c1 c2 c3.
    pub coefficients: Option<[f64; 3]>,
    /// Three points of (temperature C, resistance ohm).
    pub rt_curve: Option<[(f64, f64); 3]>,
}

/// The temperature sensor of a control.
#[derive(Clone, Copy, Debug, Default)]
pub struct SensorConfig {
    /// Kind of the sensor.
    pub kind: SensorKind,
    /// Thermistor data; input and divider serve every other analogue sensor too.
    pub thermistor: ThermistorConfig,
    /// Output of a thermocouple amplifier at 0 C.
    pub amplifier_offset: Volts,
    /// Points of the voltage curve, (temperature C, volts), as many as are written.
    pub voltage_points: [Option<[f64; 2]>; MAX_VOLTAGE_POINTS],
    /// Temperature controls that a combined sensor is made of, in the order written.
    pub parts: [Option<HeaterId>; units::MAX_HEATERS],
    /// Time constant of the filter between sensor and control, s; 0: none.
    pub filter_s: f32,
    /// Settings of the converter chip, for a sensor on an SPI bus.
    pub spi: SpiSensorConfig,
    /// Sampling and control rate.
    pub readings_per_second: u16,
}

/// PID gains in Smoothieware's units: duty steps (of 255) per degree, per degree-second, and duty-seconds per
/// degree.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pid {
    /// Proportional gain, duty steps per degree.
    pub p: f32,
    /// Integral gain, duty steps per degree-second.
    pub i: f32,
    /// Derivative gain, duty-seconds per degree.
    pub d: f32,
    /// Limit of the integral term, duty steps.
    pub i_max: f32,
    /// Time constant of the derivative's filter, s; 0: none.
    pub d_filter_s: f32,
    /// Whether the proportional term follows the measurement instead of the error.
    pub on_measurement: bool,
    /// Whether the integral stops moving towards a limit that the output has reached.
    pub windup: bool,
}

/// Thermal model of a heater, for model-based control.
#[derive(Clone, Debug, Default)]
pub struct ThermalModel {
    /// Power of the heater at full output, W.
    pub power_w: f32,
    /// Heat capacity of the heated part, J/K; 0: not known.
    pub capacity: f32,
    /// Heat loss to still air, W/K.
    pub loss: f32,
    /// Additional heat loss with the fan full on, W/K.
    pub fan_loss: f32,
    /// Dead time and lag of the sensor, s; 0: not known.
    pub late_s: f32,
    /// Heat that filament carries away, J/(mm3 K).
    pub filament_heat: f32,
    /// Name of the switch of the fan that blows at the heated part; empty: none.
    pub fan_name: Name,
    /// Place of the switch `fan_name` in the list of switches.
    pub fan: Option<u8>,
}

/// Control law by which a heater follows its target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ControlLaw {
    /// PID control with the gains of [`Pid`].
    Pid,
    /// Model-based control with [`ThermalModel`].
    Model,
    /// On/off control: on below the target, off above.
    BangBang {
        /// Half width of the dead band.
        hysteresis: Celsius,
    },
}

/// Settings of the runaway detection.
#[derive(Clone, Copy, Debug, Default)]
pub struct Runaway {
    /// Allowed deviation once the target was reached; none: not checked.
    pub range: Option<Celsius>,
    /// Time allowed to heat up; none: not checked.
    pub heating_timeout: Option<Micros>,
    /// Time allowed to cool down; none: as if cooling were instant.
    pub cooling_timeout: Option<Micros>,
    /// Deviation from the target that still counts as reached.
    pub error_range: Celsius,
}

/// Heater verification: the response to power that a working heater must show.
#[derive(Clone, Copy, Debug, Default)]
pub struct Verify {
    /// Distance below the target beyond which the reading must rise.
    pub band: Celsius,
    /// Rise that is required within `gain_time` at full output.
    pub gain: Celsius,
    /// Time at full output within which the reading must rise by `gain`; none: not checked.
    pub gain_time: Option<Micros>,
    /// Degrees below the band times seconds that are allowed once the target was reached; 0: any.
    pub max_error: f32,
    /// Largest rise of the reading, degrees per second; 0: any.
    pub max_rise: Celsius,
    /// Largest fall of the reading, degrees per second; 0: any.
    pub max_fall: Celsius,
    /// Longest time at full output; none: for ever.
    pub full_power_timeout: Option<Micros>,
    /// Longest time at one target; none: for ever.
    pub hold_timeout: Option<Micros>,
}

/// Conditions that end the wait of M109 and similar codes.
#[derive(Clone, Copy, Debug, Default)]
pub struct TemperatureWait {
    /// Distance below the target that counts as reached.
    pub window: Celsius,
    /// Time for which the reading must stay within the window.
    pub dwell: Micros,
    /// Time after which the wait ends with an error; 0: never.
    pub timeout: Micros,
}

/// A temperature control, or only a sensor when there is no heater.
#[derive(Clone, Debug, Default)]
pub struct TemperatureConfig {
    /// Name of the control in the file.
    pub name: Name,
    /// Whether the control is in use.
    pub enable: bool,
    /// Address in tool changes and M-codes; controls numbered 250 and above are always active.
    pub tool_id: ToolId,
    /// Label in reports: T, B.
    pub designator: String<8>,
    /// Sensor that measures the temperature.
    pub sensor: SensorConfig,
    /// Names of the controls that a combined sensor is made of.
    pub combines: String<96>,
    /// Heater output; none: read only.
    pub heater_pin: Option<Pin>,
    /// Ceiling of the output's duty cycle.
    pub max_pwm: Duty,
    /// Period of the output, with one pulse in each; 0: as fast as possible.
    pub cycle: Micros,
    /// Gains of the PID control.
    pub pid: Pid,
    /// Whether a thermal model controls instead of PID.
    pub by_model: bool,
    /// Parameters of the thermal model.
    pub model: ThermalModel,
    /// Whether on/off control is used instead of PID.
    pub bang_bang: bool,
    /// Half width of the on/off dead band.
    pub hysteresis: Celsius,
    /// Lowest believable reading while heating.
    pub min_temp: Celsius,
    /// Highest allowed target and reading.
    pub max_temp: Celsius,
    /// Settings of the runaway detection.
    pub runaway: Runaway,
    /// Limits of the heater verification.
    pub verify: Verify,
    /// Conditions that end a wait for the target.
    pub wait: TemperatureWait,
    /// M-code that sets the target.
    pub set_m_code: u16,
    /// M-code that sets the target and waits.
    pub set_and_wait_m_code: u16,
    /// M-code that reports the temperature.
    pub get_m_code: u16,
    /// Meaning of S1 and S2; zero: off.
    pub presets: [Celsius; 2],
    /// Named presets, as written in the file.
    pub preset_names: String<96>,
}

impl TemperatureConfig {
    /// Returns the names of the controls that a combined sensor is made of.
    pub fn part_names(&self) -> impl Iterator<Item = &str> {
        self.combines.split([',', ' ', '\t']).filter(|name| !name.is_empty())
    }

    /// Returns the named presets; the temperature is `None` where none is written.
    pub fn named_presets(&self) -> impl Iterator<Item = (&str, Option<Celsius>)> {
        self.preset_names.split(',').map(str::trim).filter(|preset| !preset.is_empty()).map(|preset| {
            let (name, celsius) = preset.split_once([' ', '\t']).unwrap_or((preset, ""));
            (name, celsius.trim().parse().ok().filter(|celsius: &f32| *celsius > 0.0).map(Celsius))
        })
    }

    /// Returns the temperature of a named preset.
    #[must_use]
    pub fn preset(&self, name: &str) -> Option<Celsius> {
        let mut presets = self.named_presets();
        presets.find(|(preset, _)| preset.eq_ignore_ascii_case(name)).and_then(|(_, celsius)| celsius)
    }

    /// Returns the control law chosen.
    #[must_use]
    pub const fn control(&self) -> ControlLaw {
        match (self.bang_bang, self.by_model) {
            (true, _) => ControlLaw::BangBang { hysteresis: self.hysteresis },
            (false, true) => ControlLaw::Model,
            (false, false) => ControlLaw::Pid,
        }
    }

    /// Returns whether the heater melts filament: its `tool_id` is a tool's, not a bed's or a chamber's.
    #[must_use]
    pub fn is_hot_end(&self) -> bool {
        self.heater_pin.is_some() && self.tool_id < ToolId::FIRST_BED
    }
}

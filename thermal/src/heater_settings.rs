//! Settings of a temperature controller, and their conversion from the configuration.

use config::{LawSettings, TemperatureConfig};
use units::{Celsius, Duty, Micros, ToolId};

use crate::safety::{CourseLimits, ReadingLimits, ResponseLimits, SafetyLimits, TimeLimits};
use crate::sensor::Sensor;

/// Settings of a single temperature controller.
#[derive(Clone, Debug, PartialEq)]
pub struct HeaterSettings {
    /// Whether a heater output exists; false for a sensor that only reads.
    pub heats: bool,
    /// Law of the sensor.
    pub sensor: Sensor,
    /// Settings of the control law.
    pub law: LawSettings,
    /// Ceiling of the output.
    pub max_duty: Duty,
    /// Period in which the output is on once; 0: as often as can be.
    pub cycle: Micros,
    /// Lowest believable reading while heating.
    pub min: Celsius,
    /// Highest target and highest believable reading while heating.
    pub max: Celsius,
    /// Largest rise and fall of its reading in a second while heating; 0: any.
    pub change_per_s: [f32; 2],
    /// Limits on the response to being driven.
    pub response: ResponseLimits,
    /// Limits on the course of the temperature.
    pub course: CourseLimits,
    /// Limits on the time for which the heater may be driven.
    pub time: TimeLimits,
    /// Time between two samples.
    pub period: Micros,
    /// Time constant of the filter between sensor and control, s; 0: none.
    pub filter_s: f32,
    /// The switch of the fan that blows at the heater, by its place in the configuration's list.
    pub fan: Option<u8>,
    /// The tool whose filament the heater melts.
    pub melts_for: Option<ToolId>,
}

impl From<&TemperatureConfig> for HeaterSettings {
    fn from(config: &TemperatureConfig) -> Self {
        Self {
            heats: config.heater_pin.is_some(),
            sensor: Sensor::from(&config.sensor),
            law: config.law(),
            max_duty: config.max_pwm,
            cycle: config.cycle,
            min: config.min_temp,
            max: config.max_temp,
            change_per_s: [config.verify.max_rise, config.verify.max_fall].map(|celsius| celsius.0),
            response: ResponseLimits {
                band: config.verify.band,
                gain: config.verify.gain,
                within: config.verify.gain_time.unwrap_or_default(),
                sinking: config.verify.max_error,
            },
            time: TimeLimits {
                full: config.verify.full_power_timeout.unwrap_or_default(),
                hold: config.verify.hold_timeout.unwrap_or_default(),
            },
            course: CourseLimits {
                range: config.runaway.range.unwrap_or_default(),
                heating_timeout: config.runaway.heating_timeout.unwrap_or_default(),
                cooling_timeout: config.runaway.cooling_timeout.unwrap_or_default(),
                reached_within: config.runaway.error_range,
            },
            period: Micros(1_000_000 / u64::from(config.sensor.readings_per_second.max(1))),
            filter_s: config.sensor.filter_s,
            fan: config.fan,
            melts_for: config.is_hot_end().then_some(config.tool_id),
        }
    }
}

impl HeaterSettings {
    /// Returns the limits that heat safety checks.
    #[must_use]
    pub fn safety_limits(&self) -> SafetyLimits {
        let [rise_per_s, fall_per_s] = self.change_per_s;
        SafetyLimits {
            heats: self.heats,
            full_share: f32::from(self.max_duty.0) / f32::from(Duty::FULL.0),
            reading: ReadingLimits { min: self.min, max: self.max, rise_per_s, fall_per_s },
            response: self.response,
            course: self.course,
            time: self.time,
        }
    }
}

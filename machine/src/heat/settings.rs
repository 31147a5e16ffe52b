//! What a temperature controller is told once, and how the configuration says it.

use config::{ControlLaw, TemperatureConfig};
use units::{Celsius, Duty, Micros};

use super::law::PidGains;
use super::sensor::Sensor;
use crate::heat_safety::{CourseLimits, ReadingLimits, ResponseLimits, SafetyLimits, TimeLimits};

/// Settings of a control law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LawSettings {
    /// PID.
    Pid(PidGains),
    /// On and off.
    BangBang {
        /// Half width of the dead band.
        hysteresis: Celsius,
    },
}

/// Settings of one temperature controller.
#[derive(Clone, Debug, PartialEq)]
pub struct HeaterSettings {
    /// Has a heater output; false for a sensor that only reads.
    pub heats: bool,
    /// Sensor.
    pub sensor: Sensor,
    /// Control law.
    pub law: LawSettings,
    /// Output ceiling.
    pub max_duty: Duty,
    /// Lowest believable reading while heating.
    pub min: Celsius,
    /// Highest target and highest believable reading while heating.
    pub max: Celsius,
    /// Largest rise and fall of its reading in a second while heating; 0: any.
    pub change_per_s: [f32; 2],
    /// How it must answer to being driven.
    pub response: ResponseLimits,
    /// Limits on the course of the temperature.
    pub course: CourseLimits,
    /// How long it may be driven.
    pub time: TimeLimits,
    /// Time between samples.
    pub period: Micros,
    /// Time constant of the filter between sensor and control, s; 0: none.
    pub filter_s: f32,
}

impl From<&TemperatureConfig> for HeaterSettings {
    fn from(config: &TemperatureConfig) -> Self {
        Self {
            heats: config.heater_pin.is_some(),
            sensor: Sensor::from(&config.sensor),
            law: law(config),
            max_duty: config.max_pwm,
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
        }
    }
}

impl HeaterSettings {
    /// What heat safety allows it.
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

fn law(config: &TemperatureConfig) -> LawSettings {
    match config.control() {
        ControlLaw::BangBang { hysteresis } => LawSettings::BangBang { hysteresis },
        ControlLaw::Pid => LawSettings::Pid(PidGains {
            p: config.pid.p,
            i: config.pid.i,
            d: config.pid.d,
            i_max: config.pid.i_max,
            on_measurement: config.pid.on_measurement,
            conditional_integral: config.pid.windup,
        }),
    }
}

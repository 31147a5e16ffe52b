//! Heaters and sensors: a mistake here burns.

use super::Checks;
use crate::machine::{SensorKind, TemperatureConfig};

const SECTION: &str = "temperature control";
const WRITTEN_SENSOR: [&str; 4] = ["thermistor", "beta", "coefficients", "rt_curve"];

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    for (place, heater) in config.temperatures.iter().enumerate().filter(|(_, heater)| heater.enable) {
        sensor(checks, place, heater);
        if heater.heater_pin.is_some() {
            safety(checks, place, heater);
        }
        let earlier = config.temperatures.iter().enumerate().take(place).filter(|(_, other)| other.enable);
        for (other_place, other) in earlier {
            if other.tool_id == heater.tool_id {
                let reason = format_args!("'{}' has tool_id {} as well", other.name, heater.tool_id);
                checks.error_of_both(
                    (SECTION, place, "tool_id"),
                    other_place,
                    reason,
                    format_args!("give each its own"),
                );
            }
            if other.designator == heater.designator {
                let reason = format_args!("'{}' has the designator {} as well", other.name, heater.designator);
                checks.warn((SECTION, place, "designator"), reason, format_args!("give each its own"));
            }
        }
    }
}

fn sensor(checks: &mut Checks<'_, '_>, place: usize, heater: &TemperatureConfig) {
    let heats = if heater.heater_pin.is_some() {
        "a heater without a sensor cannot be controlled"
    } else {
        "it measures nothing"
    };
    match heater.sensor.kind {
        SensorKind::Thermistor => {
            if heater.sensor.thermistor.input.is_none() {
                let reason = format_args!("there is no thermistor_pin: {heats}");
                checks.error(
                    (SECTION, place, "thermistor_pin"),
                    reason,
                    format_args!("write ADC1_1 (connector T1) to ADC1_3 (T3)"),
                );
            }
            let path = |key| crate::ledger::Path::named(SECTION, place, key);
            let is_described =
                WRITTEN_SENSOR.iter().any(|key| path(key).is_some_and(|path| checks.ledger.span(path).is_some()));
            if !is_described {
                let reason = format_args!("no thermistor is named, so beta 4066 at 100 kOhm is assumed");
                checks.warn(
                    (SECTION, place, "thermistor"),
                    reason,
                    format_args!("write thermistor = Semitec, or another"),
                );
            }
        }
        SensorKind::Max31855 => {
            for (key, is_there) in [
                ("spi_channel", heater.sensor.spi_channel.is_some()),
                ("spi_select_pin", heater.sensor.spi_select_pin.is_some()),
            ] {
                if !is_there {
                    let reason = format_args!("a MAX31855 needs its {key}: {heats}");
                    checks.error((SECTION, place, key), reason, format_args!("write one"));
                }
            }
        }
    }
}

fn safety(checks: &mut Checks<'_, '_>, place: usize, heater: &TemperatureConfig) {
    if heater.min_temp >= heater.max_temp {
        let reason = format_args!("max_temp {} is not above min_temp {}", heater.max_temp, heater.min_temp);
        checks.error((SECTION, place, "max_temp"), reason, format_args!("write the heater's real limits"));
    }
    if heater.runaway.heating_timeout.is_none() && heater.runaway.range.is_none() {
        let reason = format_args!("all runaway checks are off: a loose sensor or a stuck heater goes unnoticed");
        checks.warn((SECTION, place, "runaway_heating_timeout"), reason, format_args!("delete the line to use 300 s"));
    }
    for (preset, key) in heater.presets.into_iter().zip(["preset1", "preset2"]) {
        if preset > heater.max_temp {
            let reason = format_args!("{preset} is above max_temp {}", heater.max_temp);
            checks.error((SECTION, place, key), reason, format_args!("write less than max_temp"));
        }
    }
    if heater.max_pwm.0 == 0 {
        let reason = format_args!("0 means the heater never heats");
        checks.warn((SECTION, place, "max_pwm"), reason, format_args!("write 1 to 255, or heater_pin = nc"));
    }
}

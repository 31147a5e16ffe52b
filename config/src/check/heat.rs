//! Heaters and sensors: a mistake here burns.

use super::findings::Checks;
use crate::machine::{SensorKind, TemperatureConfig};

const SECTION: &str = "temperature control";
const WRITTEN_SENSOR: [&str; 4] = ["thermistor", "beta", "coefficients", "rt_curve"];

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    for (place, heater) in config.temperatures.iter().enumerate().filter(|(_, heater)| heater.enable) {
        sensor(checks, place, heater);
        if heater.heater_pin.is_some() {
            safety(checks, place, heater);
            model(checks, place, heater);
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
    let kind = heater.sensor.kind;
    if kind.is_analog() && heater.sensor.thermistor.input.is_none() {
        let reason = format_args!("there is no thermistor_pin: {heats}");
        checks.error(
            (SECTION, place, "thermistor_pin"),
            reason,
            format_args!("write ADC1_1 (connector T1) to ADC1_3 (T3)"),
        );
    }
    if kind != SensorKind::Voltage && heater.sensor.voltage_points[0].is_some() {
        let reason = format_args!("a sensor of the kind {} has no such curve", kind.word());
        checks.error((SECTION, place, "voltage_curve"), reason, format_args!("write sensor = voltage, or delete it"));
    }
    match kind {
        SensorKind::Thermistor => {
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
        SensorKind::Pt100 | SensorKind::Pt1000 | SensorKind::Ad849x => {}
        // Checked in the module `combined_sensors`.
        SensorKind::Max | SensorKind::Min | SensorKind::Mean | SensorKind::Difference => {}
        SensorKind::Chip if heater.heater_pin.is_some() => {
            let reason = format_args!("the microcontroller's own temperature says nothing of a heater");
            checks.error(
                (SECTION, place, "sensor"),
                reason,
                format_args!("write the heater's sensor, or heater_pin = nc"),
            );
        }
        SensorKind::Chip => {}
        SensorKind::Voltage => {
            if let Some(reason) = flaw(&heater.sensor.voltage_points) {
                let fix = format_args!("write two points or more, as in 0,0.5, 300,2.5 (temperature,voltage)");
                checks.error((SECTION, place, "voltage_curve"), format_args!("{reason}: {heats}"), fix);
            }
        }
        // Checked in the module `spi_sensors`.
        SensorKind::Max31855 | SensorKind::Max31856 | SensorKind::Max31865 => {}
    }
}

/// Returns the flaw of a voltage curve, if any.
fn flaw(points: &[Option<[f64; 2]>]) -> Option<&'static str> {
    let points = || points.iter().flatten();
    if points().count() < 2 {
        return Some("one point makes no curve");
    }
    if points().any(|[_, volts]| !(0.0..=3.3).contains(volts)) {
        return Some("the input reads 0 to 3.3 V only");
    }
    let (mut rises, mut falls) = (false, false);
    for (nth, [celsius, volts]) in points().enumerate() {
        for [other_celsius, other_volts] in points().take(nth) {
            if (volts - other_volts).abs() < 1e-6 {
                return Some("two points have the same voltage");
            }
            let slope = (celsius - other_celsius) * (volts - other_volts);
            (rises, falls) = (rises || slope >= 0.0, falls || slope <= 0.0);
        }
    }
    (rises && falls).then_some("temperature must rise with voltage all the way, or fall all the way")
}

/// Checks that control by a model has a complete model.
fn model(checks: &mut Checks<'_, '_>, place: usize, heater: &TemperatureConfig) {
    let model = &heater.model;
    let switches = &checks.config.switches;
    let is_fan = |name: &str| switches.iter().any(|switch| switch.enable && !switch.is_input() && switch.name == name);
    if !heater.fan_name.is_empty() && !is_fan(&heater.fan_name) {
        let reason = format_args!("there is no [switch] {} that is enabled and has an output", heater.fan_name);
        checks.error((SECTION, place, "fan"), reason, format_args!("write the name of the part fan's switch"));
    }
    if !heater.by_model {
        return;
    }
    if heater.bang_bang {
        let reason = format_args!("bang_bang = true is another control");
        checks.error((SECTION, place, "control"), reason, format_args!("write one of them"));
    }
    for (key, figure) in [("model_capacity", model.capacity), ("model_late", model.late_s)] {
        if figure <= 0.0 {
            let reason = format_args!("control = model needs it");
            let fix = format_args!("write control = pid, let M306 find it and M500 keep it, or write what M307 says");
            checks.error((SECTION, place, key), reason, fix);
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
            let reason =
                format_args!("{preset} is above max_temp {}: it is refused when a code asks for it", heater.max_temp);
            checks.warn((SECTION, place, key), reason, format_args!("write less than max_temp"));
        }
    }
    for (name, celsius) in heater.named_presets() {
        let at = (SECTION, place, "presets");
        match celsius {
            None => {
                let reason = format_args!("no temperature follows {name}");
                checks.error(at, reason, format_args!("write as in pla 205, petg 235"));
            }
            Some(celsius) if celsius > heater.max_temp => {
                let reason = format_args!(
                    "{name}: {celsius} is above max_temp {}: it is refused when a code asks for it",
                    heater.max_temp
                );
                checks.warn(at, reason, format_args!("write less than max_temp"));
            }
            Some(_) => {}
        }
    }
    if heater.max_pwm.0 == 0 {
        let reason = format_args!("0 means the heater never heats");
        checks.warn((SECTION, place, "max_pwm"), reason, format_args!("write 1 to 255, or heater_pin = nc"));
    }
}

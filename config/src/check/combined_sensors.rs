//! Checks of combined sensors: their parts exist and form no circle.

use super::findings::Checks;
use crate::machine::{MachineConfig, SensorKind, TemperatureConfig};
use heapless::{String, Vec};

const SECTION: &str = "temperature control";
const MOST: usize = units::MAX_HEATERS;

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    for (place, heater) in config.temperatures.iter().enumerate().filter(|(_, heater)| heater.enable) {
        let kind = heater.sensor.kind;
        if kind.is_combined() {
            combined(checks, place, heater);
        } else if !heater.combines.is_empty() {
            let reason = format_args!("a sensor of the kind {} measures by itself", kind.word());
            let fix = format_args!("write sensor = max, min, mean or difference, or delete it");
            checks.error((SECTION, place, "sensors"), reason, fix);
        }
    }
}

fn combined(checks: &mut Checks<'_, '_>, place: usize, heater: &TemperatureConfig) {
    let config = checks.config;
    let at = (SECTION, place, "sensors");
    let (kind, count) = (heater.sensor.kind, heater.part_names().count());
    if kind == SensorKind::Difference && heater.heater_pin.is_some() {
        let reason = format_args!("a difference is no temperature to heat to");
        checks.error((SECTION, place, "sensor"), reason, format_args!("write max, min or mean, or heater_pin = nc"));
    }
    if !(2..=MOST).contains(&count) || (kind == SensorKind::Difference && count != 2) {
        let wanted = if kind == SensorKind::Difference { "two" } else { "two or more" };
        let reason = format_args!("{} is of {wanted} sensors, and here are {count}", kind.word());
        checks.error(at, reason, format_args!("write the names of other temperature controls, commas between"));
    }
    for (nth, name) in heater.part_names().enumerate() {
        if config.temperatures.iter().all(|other| !other.enable || other.name != name) {
            let reason = format_args!("there is no [temperature control] {name}");
            checks.error(at, reason, format_args!("write the names of some that are enabled"));
        }
        if heater.part_names().take(nth).any(|earlier| earlier == name) {
            let reason = format_args!("{name} is there twice");
            checks.error(at, reason, format_args!("write each once"));
        }
    }
    let mut way = Vec::new();
    if leads_back(config, place, place, &mut way) {
        let mut names: String<256> = String::new();
        for step in &way {
            let name = config.temperatures.get(*step).map_or("", |step| step.name.as_str());
            // As many names as there can be fit.
            let _ = names.push_str(name).and_then(|()| names.push_str(" is made of "));
        }
        let reason = format_args!("a circle: {names}{}", heater.name);
        checks.error(at, reason, format_args!("leave one of them out"));
    }
}

/// Whether the sensor at `from` is made of that at `to`, and over which: the `way`, `from` first.
fn leads_back(config: &MachineConfig, from: usize, to: usize, way: &mut Vec<usize, MOST>) -> bool {
    if way.contains(&from) || way.push(from).is_err() {
        return false;
    }
    let Some(heater) = config.temperatures.get(from).filter(|heater| heater.sensor.kind.is_combined()) else {
        way.pop();
        return false;
    };
    for name in heater.part_names() {
        let part = config.temperatures.iter().position(|other| other.enable && other.name == name);
        if part.is_some_and(|part| part == to || leads_back(config, part, to, way)) {
            return true;
        }
    }
    way.pop();
    false
}

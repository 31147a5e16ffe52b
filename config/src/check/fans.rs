//! Checks of `[fan]`: its switch, watched controls and limits.

use super::findings::Checks;
use crate::ledger::Path;
use crate::machine::{FanConfig, FanFollows, OutputKind};

const SECTION: &str = "fan";

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    for (place, fan) in config.fans.iter().enumerate().filter(|(_, fan)| fan.enable) {
        switch(checks, place, fan);
        sensors(checks, place, fan);
        drive(checks, place, fan);
        tachometer(checks, place, fan);
    }
}

/// Checks that the switch of the same name can drive the fan.
fn switch(checks: &mut Checks<'_, '_>, place: usize, fan: &FanConfig) {
    let config = checks.config;
    let at = (SECTION, place, "enable");
    let Some(switch) = config.switches.iter().find(|switch| switch.enable && switch.name == fan.name) else {
        let reason = format_args!("there is no [switch] {} that would drive it", fan.name);
        checks.error(at, reason, format_args!("give the fan the name of its switch"));
        return;
    };
    if switch.is_input() {
        checks.error(at, format_args!("[switch] {} is an input", fan.name), format_args!("delete its input_pin"));
    }
    if switch.output_kind == OutputKind::Digital && fan.control.pid && fan.follows == FanFollows::Temperature {
        let reason = format_args!("[switch] {} is on or off, and pid asks for what lies between", fan.name);
        checks.error((SECTION, place, "control"), reason, format_args!("write output_type = sigmadeltapwm, or hwpwm"));
    }
    if fan.follows == FanFollows::Codes {
        return;
    }
    let has_codes = switch.input_on_command.is_some() || switch.input_off_command.is_some();
    let ruled = config.temperature_switches.iter().find(|rule| rule.enable && rule.switch == fan.name);
    let follows = (SECTION, place, "follows");
    if has_codes || switch.io_number.is_some() {
        let reason = format_args!("codes switch [switch] {}, and the fan runs by itself", fan.name);
        let fix = format_args!("delete the switch's codes and its io_number, or write follows = codes");
        checks.error(follows, reason, fix);
    } else if let Some(rule) = ruled {
        let reason = format_args!("[temperature switch] {} operates the same switch", rule.name);
        checks.error(follows, reason, format_args!("delete one of them"));
    }
}

fn sensors(checks: &mut Checks<'_, '_>, place: usize, fan: &FanConfig) {
    let config = checks.config;
    let at = (SECTION, place, "sensors");
    let count = fan.sensor_names().count();
    let wanted = match fan.follows {
        FanFollows::Heaters if count == 0 => Some("the fan has no heater to follow"),
        FanFollows::Temperature if count != 1 => Some("a temperature is of one sensor"),
        FanFollows::Codes if count > 0 => Some("a fan that follows codes watches nothing"),
        _ => None,
    };
    if let Some(reason) = wanted {
        let fix = match fan.follows {
            FanFollows::Codes => "delete it, or write what it follows",
            _ => "write the name of a [temperature control]",
        };
        checks.error(at, format_args!("{reason}"), format_args!("{fix}"));
    }
    for name in fan.sensor_names() {
        let Some(control) = config.temperatures.iter().find(|control| control.enable && control.name == name) else {
            let reason = format_args!("there is no [temperature control] {name}");
            checks.error(at, reason, format_args!("write the names of some that are enabled"));
            continue;
        };
        if fan.follows == FanFollows::Electronics && control.heater_pin.is_none() {
            let reason = format_args!("{name} has no heater that could be on");
            checks.error(at, reason, format_args!("leave it out"));
        }
    }
}

fn drive(checks: &mut Checks<'_, '_>, place: usize, fan: &FanConfig) {
    let drive = &fan.drive;
    if drive.max_power <= 0.0 {
        let reason = format_args!("the fan would never run");
        checks.error((SECTION, place, "max_power"), reason, format_args!("write more than 0"));
    } else if drive.min_power > drive.max_power {
        let reason = format_args!("it is more than max_power");
        checks.error((SECTION, place, "min_power"), reason, format_args!("write no more than max_power"));
    }
    let stands = fan.speed <= 0.0 || fan.speed < drive.off_below;
    if fan.follows != FanFollows::Codes && stands {
        let reason = format_args!("with this speed the fan is off");
        checks.error((SECTION, place, "speed"), reason, format_args!("write more than 0, and at least off_below"));
    }
}

fn tachometer(checks: &mut Checks<'_, '_>, place: usize, fan: &FanConfig) {
    let written = |key| Path::named(SECTION, place, key).is_some_and(|path| checks.ledger.span(path).is_some());
    let lost = ["pulses_per_turn", "min_rpm", "stopped_after", "when_stopped"].into_iter().find(|key| written(key));
    if let Some(key) = lost.filter(|_| fan.tachometer.pin.is_none()) {
        let reason = format_args!("without a tachometer nobody knows whether the fan turns");
        checks.error((SECTION, place, key), reason, format_args!("write tachometer_pin, or delete it"));
    }
}

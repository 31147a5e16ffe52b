//! Checks of `[temperature switch]`: each rule watches a control, and its switch exists.

use super::findings::Checks;
use crate::machine::{TemperatureSwitchConfig, Trigger};

const SECTION: &str = "temperature switch";

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    for (place, rule) in config.temperature_switches.iter().enumerate().filter(|(_, rule)| rule.enable) {
        watched(checks, place, rule);
        operated(checks, place, rule);
        if rule.start_armed && rule.arm_mcode.is_none() {
            let reason = format_args!("no M-code arms it, so it is always armed");
            checks.warn((SECTION, place, "start_armed"), reason, format_args!("write arm_mcode, or delete it"));
        }
    }
}

fn watched(checks: &mut Checks<'_, '_>, place: usize, rule: &TemperatureSwitchConfig) {
    let config = checks.config;
    let at = (SECTION, place, "designator");
    if config.temperatures.iter().any(|control| control.enable && rule.watches(control)) {
        return;
    }
    let fix = format_args!("write the designator of one, as T or B");
    if rule.designator.is_empty() {
        checks.error(at, format_args!("it does not say which temperature controls to watch"), fix);
    } else {
        let reason = format_args!("no [temperature control] has a designator that begins like '{}'", rule.designator);
        checks.error(at, reason, fix);
    }
}

fn operated(checks: &mut Checks<'_, '_>, place: usize, rule: &TemperatureSwitchConfig) {
    let config = checks.config;
    let at = (SECTION, place, "switch");
    let fix = format_args!("write the name of an enabled [switch] with an output_pin");
    match config.switches.iter().find(|switch| switch.enable && switch.name == rule.switch) {
        None if rule.switch.is_empty() => {
            checks.error(at, format_args!("it does not say which switch to operate"), fix);
        }
        None => checks.error(at, format_args!("there is no [switch] {}", rule.switch), fix),
        Some(switch) if switch.is_input() => {
            checks.error(at, format_args!("[switch] {} is an input", rule.switch), fix);
        }
        Some(_) => {}
    }
    let contends = |other: &&TemperatureSwitchConfig| {
        other.enable && other.switch == rule.switch && other.trigger == Trigger::Level
    };
    let other = config.temperature_switches.iter().take(place).find(contends);
    if let Some(other) = other.filter(|_| rule.trigger == Trigger::Level) {
        let reason = format_args!("'{}' operates the same switch: what it does depends on who looks last", other.name);
        let fix = format_args!("watch both with one rule, or give one of them trigger = rising or falling");
        checks.warn(at, reason, fix);
    }
}

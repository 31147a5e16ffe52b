//! Checks of `[led strip]`: outputs, number of lights, and other users of the timer.

use super::findings::Checks;
use crate::machine::{LedStripConfig, MOST_LIGHTS};
use crate::pin::OutputPin;
use units::ColourOrder;

const SECTION: &str = "led strip";

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    let mut lights = 0;
    for (place, strip) in config.led_strips.iter().enumerate().filter(|(_, strip)| strip.enable) {
        if strip.is_of_switches() {
            switches(checks, place, strip);
        } else {
            chain(checks, place, strip);
        }
        same_number(checks, place, strip);
        lights += strip.lights();
        if lights > MOST_LIGHTS {
            let reason = format_args!("with this strip there are {lights} lights, and {MOST_LIGHTS} at most can be");
            checks.error((SECTION, place, "chain_count"), reason, format_args!("shorten a strip"));
        }
    }
}

fn chain(checks: &mut Checks<'_, '_>, place: usize, strip: &LedStripConfig) {
    let config = checks.config;
    let Some(pin) = strip.pin else {
        let reason = format_args!("the strip has no pin");
        let fix = format_args!("write PWM1_1 to PWM2_4, or the switches that are its colours");
        checks.error((SECTION, place, "pin"), reason, fix);
        return;
    };
    if strip.order.is_none() {
        let reason = format_args!("red, green and blue must each be in it once, white at most once");
        checks.error((SECTION, place, "color_order"), reason, format_args!("write GRB, or GRBW"));
    }
    let has_white = strip.order.unwrap_or(ColourOrder::GRB).bytes_each() == 4;
    if strip.initial.white > 0 && !has_white {
        let reason = format_args!("its chips have no white");
        checks.error(
            (SECTION, place, "initial_white"),
            reason,
            format_args!("write color_order with a W, or delete it"),
        );
    }
    let on_timer = config.switches.iter().find(|switch| {
        let timer = match switch.output_pin {
            Some(OutputPin::Pwm(output)) => output.timer,
            _ => 0,
        };
        switch.enable && !switch.is_input() && timer == pin.timer
    });
    if let Some(switch) = on_timer {
        let reason = format_args!(
            "the timer of PWM{} sends to strips at their rate, and [switch] {} is on it",
            pin.timer, switch.name
        );
        checks.error((SECTION, place, "pin"), reason, format_args!("use a pin of the other timer for one of them"));
    }
}

/// Checks a light made of switches: each is an output of its own, and no other section operates it.
fn switches(checks: &mut Checks<'_, '_>, place: usize, strip: &LedStripConfig) {
    let config = checks.config;
    if strip.pin.is_some() {
        let reason = format_args!("its colours are switches, so there is nothing for a pin to do");
        checks.error((SECTION, place, "pin"), reason, format_args!("delete it, or the switches"));
    }
    for (key, name) in ["red_switch", "green_switch", "blue_switch", "white_switch"].into_iter().zip(&strip.switches) {
        if name.is_empty() {
            continue;
        }
        let at = (SECTION, place, key);
        let fix = format_args!("write the name of an enabled [switch] with an output_pin");
        let Some(switch) = config.switches.iter().find(|switch| switch.enable && switch.name == *name) else {
            checks.error(at, format_args!("there is no [switch] {name}"), fix);
            continue;
        };
        let has_codes = switch.input_on_command.is_some() || switch.input_off_command.is_some();
        let other = config.strip_of_switch(name).filter(|other| other.name != strip.name);
        if switch.is_input() {
            checks.error(at, format_args!("[switch] {name} is an input"), fix);
        } else if has_codes || switch.io_number.is_some() {
            let reason = format_args!("codes switch [switch] {name}, and the strip does");
            checks.error(at, reason, format_args!("delete the switch's codes and its io_number"));
        } else if config.automatic_fan(name).is_some() {
            checks.error(at, format_args!("[switch] {name} is a fan that runs by itself"), fix);
        } else if let Some(rule) = config.temperature_switches.iter().find(|rule| rule.enable && rule.switch == *name) {
            let reason = format_args!("[temperature switch] {} operates the same switch", rule.name);
            checks.error(at, reason, format_args!("delete one of them"));
        } else if let Some(other) = other {
            let reason = format_args!("'{}' has the same switch", other.name);
            checks.error(at, reason, format_args!("delete one of them"));
        }
    }
}

/// Numbers count only where the file gives them: the others get what is free.
fn same_number(checks: &mut Checks<'_, '_>, place: usize, strip: &LedStripConfig) {
    let config = checks.config;
    let is_same = |other: &&LedStripConfig| other.enable && other.number == strip.number;
    if let Some(other) = config.led_strips.iter().take(place).find(is_same) {
        let reason = format_args!("'{}' has the same number", other.name);
        checks.error((SECTION, place, "number"), reason, format_args!("write another one"));
    }
}

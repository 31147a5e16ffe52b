//! Checks of switches and their outputs.

use super::findings::Checks;
use crate::ledger::Path;
use crate::machine::{OutputKind, SwitchConfig};
use crate::pin::OutputPin;

const SWITCH: &str = "switch";

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    for (place, switch) in config.switches.iter().enumerate().filter(|(_, switch)| switch.enable) {
        same_number(checks, place, switch);
        let has_lines = !switch.output_on_command.is_empty() || !switch.output_off_command.is_empty();
        if switch.is_input() {
            input(checks, place, switch);
        } else if has_lines && switch.output_pin.is_none() {
            let reason = format_args!("the input has no pin");
            checks.error((SWITCH, place, "input_pin"), reason, format_args!("write its pin, or enable = false"));
        } else {
            output(checks, place, switch);
            for other in config.switches.iter().take(place).filter(|other| other.enable && !other.is_input()) {
                if switch.input_on_command.is_some() && other.input_on_command == switch.input_on_command {
                    let reason = format_args!("'{}' turns on with the same code", other.name);
                    checks.warn(
                        (SWITCH, place, "input_on_command"),
                        reason,
                        format_args!("add a subcode, as in M106.1"),
                    );
                }
            }
        }
    }
}

/// Checks that no two inputs, and no two outputs, have the same number.
fn same_number(checks: &mut Checks<'_, '_>, place: usize, switch: &SwitchConfig) {
    let config = checks.config;
    let is_same = |other: &&SwitchConfig| {
        other.enable && other.is_input() == switch.is_input() && other.io_number == switch.io_number
    };
    let other = config.switches.iter().take(place).find(is_same).filter(|_| switch.io_number.is_some());
    if let Some(other) = other {
        let reason = format_args!("'{}' has the same number", other.name);
        checks.error((SWITCH, place, "io_number"), reason, format_args!("write another one"));
    }
}

fn input(checks: &mut Checks<'_, '_>, place: usize, switch: &SwitchConfig) {
    let is_silent = switch.output_on_command.is_empty() && switch.output_off_command.is_empty();
    let is_interlock = checks.config.laser.interlock_names().any(|name| switch.name == name);
    if is_silent && switch.io_number.is_none() && !is_interlock {
        let reason = format_args!("the input does nothing");
        checks.error((SWITCH, place, "output_on_command"), reason, format_args!("write the line it executes"));
    }
}

/// Returns whether another section operates the switch.
fn is_automatic(checks: &Checks<'_, '_>, switch: &SwitchConfig) -> bool {
    let ruled = checks.config.temperature_switches.iter().any(|rule| rule.enable && rule.switch == switch.name);
    let config = checks.config;
    let is_air = config.laser.enable && config.laser.air_switch == switch.name;
    ruled || is_air || config.automatic_fan(&switch.name).is_some() || config.strip_of_switch(&switch.name).is_some()
}

fn output(checks: &mut Checks<'_, '_>, place: usize, switch: &SwitchConfig) {
    let is_written = |checks: &Checks<'_, '_>, key| {
        Path::named(SWITCH, place, key).is_some_and(|path| checks.ledger.span(path).is_some())
    };
    if !is_written(checks, "output_type") {
        let reason = format_args!("the switch does not say how its output is driven");
        checks.error((SWITCH, place, "output_type"), reason, format_args!("write digital, sigmadeltapwm or hwpwm"));
    }
    let is_named =
        switch.input_on_command.is_some() || switch.input_off_command.is_some() || switch.io_number.is_some();
    if !is_named && !is_automatic(checks, switch) {
        let reason = format_args!("no code turns the switch on or off");
        checks.error((SWITCH, place, "input_on_command"), reason, format_args!("write a code, as in M106"));
    }
    match (switch.output_pin, switch.output_kind) {
        (None, _) => {
            let reason = format_args!("the switch has neither an output_pin nor an input_pin");
            checks.error((SWITCH, place, "output_pin"), reason, format_args!("write one of them"));
        }
        (Some(OutputPin::Digital(_)), OutputKind::HardwarePwm) => {
            let reason = format_args!("hwpwm needs a timer channel");
            checks.error((SWITCH, place, "output_pin"), reason, format_args!("write PWM1_1 to PWM2_4"));
        }
        (Some(OutputPin::Pwm(_)), OutputKind::Digital | OutputKind::SigmaDelta) => {
            let reason = format_args!("a timer channel needs output_type = hwpwm");
            checks.error((SWITCH, place, "output_type"), reason, format_args!("write hwpwm, or another pin"));
        }
        (Some(OutputPin::Pwm(pwm)), OutputKind::HardwarePwm) => {
            let timer = usize::from(pwm.timer).saturating_sub(1);
            let sends = checks.config.timer_sends(pwm.timer);
            if !sends && checks.config.pwm_frequency_hz.get(timer).is_none_or(Option::is_none) {
                let reason = format_args!("the timer of PWM{} is not set up", pwm.timer);
                checks.error((SWITCH, place, "output_pin"), reason, format_args!("add the section [pwm{}]", pwm.timer));
            }
        }
        (Some(OutputPin::Digital(_)), _) => {}
    }
    servo(checks, place, switch);
    spindle(checks, place, switch);
    if switch.output_kind == OutputKind::HardwarePwm && switch.startup_value > 100.0 {
        let reason = format_args!("{} is more than 100 percent", switch.startup_value);
        checks.error((SWITCH, place, "startup_value"), reason, format_args!("write 0 to 100"));
    }
}

/// Reports contradictions in the settings of a spindle.
fn spindle(checks: &mut Checks<'_, '_>, place: usize, switch: &SwitchConfig) {
    if switch.input_reverse_command.is_some() && switch.input_on_command.is_none() {
        let reason = format_args!("no code turns it the first way");
        checks.error((SWITCH, place, "input_reverse_command"), reason, format_args!("write input_on_command = M3"));
    }
    if switch.min_rpm > switch.max_rpm {
        let reason = format_args!("it is more than max_rpm = {}", switch.max_rpm);
        checks.error((SWITCH, place, "min_rpm"), reason, format_args!("write less, or a greater max_rpm"));
    }
    if switch.max_rpm > 0.0 && (switch.output_kind == OutputKind::Digital || switch.servo.max_angle > 0.0) {
        let reason = format_args!("S is no speed of an output that is digital, or a servo's");
        checks.error((SWITCH, place, "max_rpm"), reason, format_args!("leave it out, or write output_type = hwpwm"));
    }
}

/// Checks that a servo's pulses fit the period of the timer.
fn servo(checks: &mut Checks<'_, '_>, place: usize, switch: &SwitchConfig) {
    let [least, most] = switch.servo.pulse_us;
    if switch.servo.max_angle <= 0.0 {
        return;
    }
    let at = (SWITCH, place, "servo_max_angle");
    let Some(OutputPin::Pwm(pwm)) = switch.output_pin else {
        let reason = format_args!("only a timer gives pulses that are exact enough for a servo");
        checks.error(at, reason, format_args!("write output_type = hwpwm and a pin of PWM1_1 to PWM2_4"));
        return;
    };
    if most <= least {
        let reason = format_args!("it is no more than servo_min_us");
        checks.error((SWITCH, place, "servo_max_us"), reason, format_args!("write more"));
    }
    let timer = usize::from(pwm.timer).saturating_sub(1);
    let hertz = checks.config.pwm_frequency_hz.get(timer).copied().flatten();
    if let Some(hertz) = hertz.filter(|hertz| *hertz as f32 * most >= 1e6) {
        let reason = format_args!("pulses of {most} us do not fit into the period of {hertz} Hz");
        checks.error(at, reason, format_args!("write frequency = 50 in [pwm{}]", pwm.timer));
    }
}

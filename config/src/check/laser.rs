//! Checks of `[laser]`: its timer, its powers, and the switches that it names.

use super::findings::Checks;
use crate::ledger::Path;
use crate::machine::MAX_INTERLOCKS;
use crate::pin::{OutputPin, PwmOutput};

const SECTION: &str = "laser";
/// Fastest rate of a laser's timer, Hz.
const MOST_HZ: u32 = 50_000;

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    if !config.laser.enable {
        return;
    }
    match config.laser.pwm_pin {
        Some(pin) => timer(checks, pin),
        None => {
            let reason = format_args!("the laser has no pin");
            checks.error((SECTION, 0, "pwm_pin"), reason, format_args!("write PWM1_1 to PWM2_4"));
        }
    }
    powers(checks);
    power_table(checks);
    interlocks(checks);
    air(checks);
}

/// The laser restarts its timer's period with each change, so that nothing else can be on that timer.
fn timer(checks: &mut Checks<'_, '_>, pin: PwmOutput) {
    let config = checks.config;
    let at = (SECTION, 0, "pwm_pin");
    let fix = format_args!("use a pin of the other timer for one of them");
    let switch = config.switches.iter().find(|switch| {
        let is_on_timer = matches!(switch.output_pin, Some(OutputPin::Pwm(output)) if output.timer == pin.timer);
        switch.enable && !switch.is_input() && is_on_timer
    });
    if let Some(switch) = switch {
        let reason =
            format_args!("the timer of PWM{} serves the laser alone, and [switch] {} is on it", pin.timer, switch.name);
        checks.error(at, reason, fix);
    }
    let is_on_timer = |strip: &&crate::LedStripConfig| strip.enable && strip.pin.is_some_and(|p| p.timer == pin.timer);
    if let Some(strip) = config.led_strips.iter().find(is_on_timer) {
        let reason = format_args!(
            "the timer of PWM{} serves the laser alone, and [led strip] {} is on it",
            pin.timer, strip.name
        );
        checks.error(at, reason, fix);
    }
    let own = Path::named(SECTION, 0, "pwm_frequency").is_some_and(|path| checks.ledger.span(path).is_some());
    let of_timer = config.pwm_frequency_hz.get(usize::from(pin.timer).saturating_sub(1)).copied().flatten();
    let at = (SECTION, 0, "pwm_frequency");
    match of_timer {
        Some(hertz) if own && hertz != config.laser.frequency_hz => {
            let reason = format_args!("[pwm{}] has frequency = {hertz} for the same timer", pin.timer);
            checks.error(at, reason, format_args!("delete one of them"));
        }
        Some(hertz) if hertz > MOST_HZ => {
            let reason = format_args!("{hertz} Hz of [pwm{}] is too fast for a laser", pin.timer);
            checks.error(at, reason, format_args!("write {MOST_HZ} or less"));
        }
        _ => {}
    }
}

fn powers(checks: &mut Checks<'_, '_>) {
    let laser = &checks.config.laser;
    if laser.maximum_power <= laser.minimum_power {
        let reason = format_args!("it leaves nothing above minimum_power = {}", laser.minimum_power);
        checks.error((SECTION, 0, "maximum_power"), reason, format_args!("write more, 1 at most"));
    }
    if laser.default_power > laser.maximum_s_value {
        let reason = format_args!("it is more than maximum_s_value = {}", laser.maximum_s_value);
        checks.error((SECTION, 0, "default_power"), reason, format_args!("write it in units of S"));
    }
}

fn power_table(checks: &mut Checks<'_, '_>) {
    let table = &checks.config.laser.power_table;
    let at = (SECTION, 0, "power_table");
    let fix = format_args!("write duty and power of each point from 0 to 1, ascending: 0.1,0 0.5,0.3 1,1");
    if table.len() == 1 {
        checks.error(at, format_args!("one point is no table"), fix);
    } else if let Some([duty, power]) = table.iter().find(|point| point.iter().any(|v| !(0.0..=1.0).contains(v))) {
        checks.error(at, format_args!("{duty},{power} is not within 0 to 1"), fix);
    } else if let Some([[duty, power], _]) =
        table.array_windows().find(|[low, high]| high.iter().zip(low).any(|(high, low)| high <= low))
    {
        checks.error(at, format_args!("the point behind {duty},{power} does not ascend in both"), fix);
    }
}

fn interlocks(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    let at = (SECTION, 0, "interlock_switches");
    for name in config.laser.interlock_names() {
        let switch = config.switches.iter().find(|switch| switch.enable && switch.name == name);
        if !switch.is_some_and(crate::SwitchConfig::is_input) {
            let fix = format_args!("write the name of an enabled [switch] with an input_pin");
            checks.error(at, format_args!("there is no input [switch] {name}"), fix);
        }
    }
    let count = config.laser.interlock_names().count();
    if count > MAX_INTERLOCKS {
        let reason = format_args!("these are {count} interlocks");
        checks.error(at, reason, format_args!("name {MAX_INTERLOCKS} at most, and wire the others in series"));
    }
}

fn air(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    let name = &config.laser.air_switch;
    if name.is_empty() {
        return;
    }
    let switch = config.switches.iter().find(|switch| switch.enable && switch.name == *name);
    if switch.is_none_or(crate::SwitchConfig::is_input) {
        let fix = format_args!("write the name of an enabled [switch] with an output_pin");
        checks.error((SECTION, 0, "air_switch"), format_args!("there is no output [switch] {name}"), fix);
    }
}

//! Fans: those that codes set, and those that follow heaters, motors or a temperature.

use super::super::account::{Class, Verdict};
use super::super::migration::{Migration, text};
use super::super::wiring::Role;
use super::table::{Change, NUMBER, Rule, apply};
use super::{heat, outputs, sensors};

const FAN: &str = "fan";
const MOST: usize = 8;
/// Time that Klipper gives a fan full power when it starts, where the file does not say one, s.
const KICK_START: &str = "0.1";

const COMMON: &[(&str, Rule)] = &[
    ("max_power", Rule::To(FAN, "max_power", Change::Times(100.0))),
    ("off_below", Rule::To(FAN, "off_below", Change::Times(100.0))),
    ("kick_start_time", Rule::To(FAN, "kick_start_time", NUMBER)),
    ("tachometer_ppr", Rule::To(FAN, "pulses_per_turn", NUMBER)),
    ("tachometer_poll_interval", Rule::Needless("the input is looked at 2,000 times a second")),
    ("hardware_pwm", Rule::Needless("MOSFETs of the board have no timer")),
    ("shutdown_speed", Rule::Only("0", "in a halt the MOSFETs lose their power", "[switch] halt_set_to")),
    ("enable_pin", Rule::Refused("a fan has one output", "a [switch] of its own")),
];

/// Makes the output and the fan of a section; `name` is the instance of both.
fn fan(m: &mut Migration<'_>, section: usize, name: &str) -> bool {
    if m.entries.iter().filter(|entry| (entry.section, &*entry.key) == (FAN, "enable")).count() >= MOST {
        let why = "Velvet has eight fans";
        m.ask(format!("[{}]: {why}; it is left out", m.section(section).name));
        m.judge_rest(section, &Verdict::refused(why, "[switch]"));
        return false;
    }
    if !outputs::load(m, section, "pin", name, "fan") {
        return false;
    }
    m.write((FAN, name, "enable"), "true", format!("of [{}]", m.section(section).name));
    outputs::cycle(m, section, name);
    if let Some((place, pin)) = m.place(section, "tachometer_pin", Role::Input, "tachometer") {
        let written = format!("{}^{}", place.pin, if pin.is_inverted { "!" } else { "" });
        m.put(section, "tachometer_pin", (FAN, name, "tachometer_pin"), written);
    }
    apply(m, section, name, COMMON);
    if m.section(section).get("kick_start_time").is_none() {
        m.put(section, "kick_start_time", (FAN, name, "kick_start_time"), KICK_START);
    }
    m.judge_section(section, Verdict::new(Class::Converted, "an output of [switch], and [fan]"));
    true
}

/// Converts `[fan]`, which M106 and M107 set.
pub fn part(m: &mut Migration<'_>, section: usize) {
    if fan(m, section, FAN) {
        m.write(("switch", FAN, "input_on_command"), "M106", "");
        m.write(("switch", FAN, "input_off_command"), "M107", "");
    }
}

/// Converts `[fan_generic NAME]`, which SET_FAN_SPEED sets.
pub fn generic(m: &mut Migration<'_>, section: usize) {
    let name = m.fresh(&["switch", "fan"], &m.section(section).label());
    if fan(m, section, &name) {
        outputs::number_it(m, &name);
    }
}

/// Converts `[heater_fan NAME]`.
pub fn of_heater(m: &mut Migration<'_>, section: usize) {
    let name = m.fresh(&["switch", "fan"], &m.section(section).label());
    if !fan(m, section, &name) {
        return;
    }
    m.write((FAN, &name, "follows"), "heaters", "");
    follow(m, section, &name, "extruder");
    let warm = m.number(section, "heater_temp").unwrap_or(50.0);
    m.put(section, "heater_temp", (FAN, &name, "temperature"), text(warm));
    apply(m, section, &name, &[("fan_speed", Rule::To(FAN, "speed", Change::Times(100.0)))]);
}

/// Writes the temperature controls that a fan watches.
fn follow(m: &mut Migration<'_>, section: usize, name: &str, default: &str) {
    let wanted = m.section(section).get("heater").unwrap_or(default).to_owned();
    let mut known = Vec::new();
    for heater in wanted.split([',', '\n']).map(str::trim).filter(|heater| !heater.is_empty()) {
        match m.heaters.get(heater) {
            Some(heater) => known.push(heater.clone()),
            None => m.ask(format!("fan {name}: there is no heater {heater} to follow")),
        }
    }
    match known.is_empty() {
        true => {
            // A fan that cools something hot has to run where nobody tells it when.
            m.write((FAN, name, "follows"), "codes", "nothing to follow was converted");
            m.write(("switch", name, "startup_state"), "true", "always on: nothing to follow was converted");
            outputs::number_it(m, name);
            m.refuse(section, "heater", "no heater of this name was converted: it always runs", "[fan] sensors");
        }
        false => m.put(section, "heater", (FAN, name, "sensors"), known.join(",")),
    }
}

/// Converts `[controller_fan NAME]`.
pub fn of_controller(m: &mut Migration<'_>, section: usize) {
    let name = m.fresh(&["switch", "fan"], &m.section(section).label());
    if !fan(m, section, &name) {
        return;
    }
    m.write((FAN, &name, "follows"), "electronics", "");
    follow(m, section, &name, "extruder");
    let rows: &[(&str, Rule)] = &[
        ("fan_speed", Rule::To(FAN, "speed", Change::Times(100.0))),
        ("idle_speed", Rule::To(FAN, "idle_speed", Change::Times(100.0))),
        ("idle_timeout", Rule::To(FAN, "linger", NUMBER)),
        ("stepper", Rule::Needless("any motor that has current counts")),
    ];
    apply(m, section, &name, rows);
}

/// Converts `[temperature_fan NAME]`: a sensor, an output and what keeps the temperature.
pub fn of_temperature(m: &mut Migration<'_>, section: usize) {
    let kind = m.section(section).get("sensor_type").unwrap_or("").to_owned();
    if kind == "temperature_host" {
        return m.judge_rest(section, &Verdict::needless("there is no host computer to cool"));
    }
    if !sensors::is_known(m, &kind) {
        let why = format!("Velvet has no sensor of the kind {kind}");
        return m.judge_rest(section, &Verdict::refused(why, "[fan] follows = electronics"));
    }
    let name = m.fresh(&["switch", "fan", "temperature control"], &m.section(section).label());
    if !heat::heater(m, section, &name, Role::Load) {
        return;
    }
    m.write(("temperature control", &name, "heater_pin"), "nc", "a sensor only");
    if !fan(m, section, &name) {
        return;
    }
    m.write((FAN, &name, "follows"), "temperature", "");
    m.write((FAN, &name, "sensors"), name.clone(), "its own sensor");
    let rows: &[(&str, Rule)] = &[
        ("target_temp", Rule::To(FAN, "temperature", NUMBER)),
        ("max_delta", Rule::To(FAN, "hysteresis", NUMBER)),
        ("max_speed", Rule::To(FAN, "speed", Change::Times(100.0))),
        ("min_speed", Rule::To(FAN, "idle_speed", Change::Times(100.0))),
        // Klipper's gains are of 255, Velvet's of 100.
        ("pid_kp", Rule::To(FAN, "p_factor", Change::Times(100.0 / 255.0))),
        ("pid_ki", Rule::To(FAN, "i_factor", Change::Times(100.0 / 255.0))),
        ("pid_kd", Rule::To(FAN, "d_factor", Change::Times(100.0 / 255.0))),
        ("pid_deriv_time", Rule::Refused("the derivative has a filter of its own", "[fan] d_factor")),
    ];
    apply(m, section, &name, rows);
    match m.section(section).get("control") {
        Some("watermark") => m.put(section, "control", (FAN, &name, "control"), "bang-bang"),
        Some("pid") => m.put(section, "control", (FAN, &name, "control"), "pid"),
        _ => {}
    }
}

//! Heaters and temperature sensors.

use super::super::account::{Class, Verdict};
use super::super::migration::{Migration, text};
use super::super::wiring::Role;
use super::sensors;
use super::table::{Change, NUMBER, Rule, apply};

/// Kind of a sensor that combines others.
const COMBINED: &str = "temperature_combined";
/// Longest time of a check of a heater, s.
const LONGEST_CHECK: f64 = 86_400.0;
const TEMPERATURE: &str = "temperature control";
/// Temperature controls beside the board's own.
const MOST: usize = 7;
/// Longest period of a heater's pulses that is as often as can be, s.
const FAST: f64 = 0.2;

const HEATER: &[(&str, Rule)] = &[
    ("max_power", Rule::To(TEMPERATURE, "max_pwm", Change::Whole(255.0))),
    ("pid_kp", Rule::To(TEMPERATURE, "p_factor", NUMBER)),
    ("pid_ki", Rule::To(TEMPERATURE, "i_factor", NUMBER)),
    ("pid_kd", Rule::To(TEMPERATURE, "d_factor", NUMBER)),
    ("max_delta", Rule::To(TEMPERATURE, "hysteresis", NUMBER)),
    ("min_temp", Rule::To(TEMPERATURE, "min_temp", NUMBER)),
    ("max_temp", Rule::To(TEMPERATURE, "max_temp", NUMBER)),
    ("smooth_time", Rule::Refused("readings are not smoothed over a time", "[temperature control] sensor_filter")),
    ("pid_integral_max", Rule::To(TEMPERATURE, "i_max", Change::Whole(255.0))),
    ("gcode_id", Rule::Needless("M105 says every temperature by its designator")),
];

/// Converts a heater; `name` is its instance in the new file, with pins of its own by default where the board
/// knows the name. Returns whether there was room for it.
pub fn heater(m: &mut Migration<'_>, section: usize, name: &str, role: Role) -> bool {
    let of = m.section(section);
    if is_full(m, section) {
        return false;
    }
    m.heaters.insert(of.name.clone(), name.to_owned());
    m.heaters.insert(of.label(), name.to_owned());
    m.write((TEMPERATURE, name, "enable"), "true", format!("of [{}]", of.name));
    if of.get("heater_pin").is_some()
        && let Some((place, pin)) = m.place(section, "heater_pin", role, "heater")
    {
        // An output of the board that is active low stays so; the old board's polarity is its own.
        let _ = pin;
        m.put(section, "heater_pin", (TEMPERATURE, name, "heater_pin"), place.pin);
    }
    control(m, section, name);
    cycle(m, section, name);
    sensors::sensor(m, section, name);
    apply(m, section, name, HEATER);
    identify(m, name);
    if m.written((TEMPERATURE, name, "enable")) == Some("false") {
        m.heaters.retain(|_, known| known != name);
    }
    true
}

/// Returns whether there is room for no further temperature control; then the section is left out.
fn is_full(m: &mut Migration<'_>, section: usize) -> bool {
    let count = m.entries.iter().filter(|entry| (entry.section, &*entry.key) == (TEMPERATURE, "enable")).count();
    if count >= MOST {
        let why = "Velvet has eight temperature controls, the board's own among them";
        m.ask(format!("[{}]: {why}; it is left out", m.section(section).name));
        m.judge_rest(section, &Verdict::refused(why, "[temperature control]"));
    }
    count >= MOST
}

fn control(m: &mut Migration<'_>, section: usize, name: &str) {
    match m.section(section).get("control") {
        Some("watermark") => m.put(section, "control", (TEMPERATURE, name, "bang_bang"), "true"),
        Some("pid") => m.put(section, "control", (TEMPERATURE, name, "control"), "pid"),
        Some(_) => m.refuse(section, "control", "Velvet has no such control", "pid, or bang_bang = true"),
        None => {}
    }
}

fn cycle(m: &mut Migration<'_>, section: usize, name: &str) {
    match m.number(section, "pwm_cycle_time") {
        Some(seconds) if seconds >= FAST => {
            m.put(section, "pwm_cycle_time", (TEMPERATURE, name, "cycle_time"), text(seconds));
        }
        _ => m.needless(section, "pwm_cycle_time", "the output is switched as often as can be"),
    }
}

/// Writes designator and number of what the board has no name for.
fn identify(m: &mut Migration<'_>, name: &str) {
    if name == "chamber" {
        m.write((TEMPERATURE, name, "designator"), "C", "as hosts call it");
    } else if !matches!(name, "hotend" | "hotend2" | "bed" | "board") {
        let letters: String = name.chars().take(8).collect();
        m.write((TEMPERATURE, name, "designator"), letters, "in reports");
        m.write((TEMPERATURE, name, "tool_id"), "255", "none of a tool");
    }
}

/// Converts `[heater_bed]`.
pub fn bed(m: &mut Migration<'_>, section: usize) {
    heater(m, section, "bed", Role::Bed);
}

/// Converts `[heater_generic NAME]`.
pub fn generic(m: &mut Migration<'_>, section: usize) {
    let name = m.fresh(&["temperature control", "switch"], &m.section(section).label());
    heater(m, section, &name, Role::Load);
}

/// Converts `[temperature_sensor NAME]`.
pub fn sensor(m: &mut Migration<'_>, section: usize) {
    let name = m.fresh(&["temperature control", "switch"], &m.section(section).label());
    let kind = m.section(section).get("sensor_type").unwrap_or("");
    if kind == "temperature_host" {
        let why = "there is no host computer";
        return m.judge_rest(section, &Verdict::needless(why));
    }
    if kind == COMBINED {
        return;
    }
    if !sensors::is_known(m, kind) {
        let why = format!("Velvet has no sensor of the kind {kind}");
        return m.judge_rest(section, &Verdict::refused(why, "[temperature control] sensor"));
    }
    if heater(m, section, &name, Role::Load) {
        m.write((TEMPERATURE, &name, "heater_pin"), "nc", "a sensor only");
    }
}

/// Converts a sensor that combines others, when these have been converted.
pub fn combined(m: &mut Migration<'_>, section: usize) {
    let of = m.section(section);
    if of.get("sensor_type") != Some(COMBINED) {
        return;
    }
    let method = of.get("combination_method").unwrap_or("").to_lowercase();
    let list = of.get("sensor_list").unwrap_or("").split([',', '\n']).map(str::trim).filter(|name| !name.is_empty());
    let parts: Option<Vec<String>> = list.map(|name| m.heaters.get(name).cloned()).collect();
    let (Some(parts), "min" | "max" | "mean") = (parts.filter(|parts| !parts.is_empty()), method.as_str()) else {
        let why = "not all of the sensors that it combines were converted";
        return m.judge_rest(section, &Verdict::refused(why, "[temperature control] sensor = max, min, mean"));
    };
    if is_full(m, section) {
        return;
    }
    let name = m.fresh(&[TEMPERATURE, "switch"], &of.label());
    m.write((TEMPERATURE, &name, "enable"), "true", format!("of [{}]", of.name));
    m.put(section, "combination_method", (TEMPERATURE, &name, "sensor"), method);
    m.put(section, "sensor_list", (TEMPERATURE, &name, "sensors"), parts.join(","));
    m.merged(section, "sensor_type", "the sensors are combined", "");
    m.refuse(
        section,
        "maximum_deviation",
        "how far they may lie apart is not looked at",
        "[temperature control] sensors",
    );
    apply(m, section, &name, HEATER);
    identify(m, &name);
}

/// Converts `[verify_heater HEATER]`.
pub fn verify(m: &mut Migration<'_>, section: usize) {
    let label = m.section(section).label();
    let Some(name) = m.heaters.get(&label).cloned() else {
        let why = format!("there is no heater {label}");
        return m.judge_rest(section, &Verdict::refused(why, "[temperature control] verify_gain_time"));
    };
    let rows: &[(&str, Rule)] = &[
        ("hysteresis", Rule::To(TEMPERATURE, "verify_band", NUMBER)),
        ("heating_gain", Rule::To(TEMPERATURE, "verify_gain", NUMBER)),
        ("check_gain_time", Rule::To(TEMPERATURE, "verify_gain_time", Change::Whole(1.0))),
        ("max_error", Rule::To(TEMPERATURE, "verify_max_error", NUMBER)),
    ];
    if let Some(seconds) = m.number(section, "check_gain_time").filter(|seconds| *seconds > LONGEST_CHECK) {
        let why = format!("{seconds} s switch the check off, which 0 does");
        m.put_for(section, "check_gain_time", (TEMPERATURE, &name, "verify_gain_time"), "0", &why);
        m.ask(format!("{name}: [verify_heater {label}] switches the check of its heater off: is that meant?"));
    }
    apply(m, section, &name, rows);
    m.judge_section(section, Verdict::new(Class::Converted, "heat safety of the same rules"));
}

//! Functions of the machine: resonance, retraction, arcs, filament, homing, what stays in printer.cfg.

use super::super::account::{Class, Verdict};
use super::super::migration::{KEPT, Migration, instance, text};
use super::super::source::{numbers, truth};
use super::super::wiring::Role;
use super::table::{Change, NUMBER, Rule, apply, template};

/// Rule of templates that a sensor of the filament's width runs in Klipper.
const NO_TEMPLATE: Rule = Rule::Refused("the filament detector has one", "[filament detector] runout_gcode");

/// Shapers that Velvet has, by Klipper's names.
const SHAPERS: [&str; 6] = ["zv", "mzv", "zvd", "ei", "2hump_ei", "3hump_ei"];

/// Converts `[input_shaper]`.
pub fn shaper(m: &mut Migration<'_>, section: usize) {
    for axis in ["x", "y", "z"] {
        let [freq, damping, kind] =
            ["shaper_freq", "damping_ratio", "shaper_type"].map(|option| format!("{option}_{axis}"));
        m.scaled(section, &freq, ("input shaper", "", &freq), 1.0);
        m.scaled(section, &damping, ("input shaper", "", &damping), 1.0);
        let own = m.section(section).get(&kind).is_some();
        let option = if own { kind.as_str() } else { "shaper_type" };
        let Some(name) = m.section(section).get(option).map(str::to_lowercase) else { continue };
        let is_shaped = m.section(section).get(&freq).is_some();
        match SHAPERS.contains(&name.as_str()) {
            true if own || is_shaped => m.put(section, option, ("input shaper", "", &kind), name),
            true => {}
            false => m.refuse(section, option, "Velvet has no such shaper", "[input shaper] shaper_type_x"),
        }
    }
    m.merged(section, "shaper_type", "of every axis that is shaped", "");
    m.judge_section(section, Verdict::new(Class::Converted, "[input shaper]"));
}

/// Converts `[firmware_retraction]`, for every extruder.
pub fn retraction(m: &mut Migration<'_>, section: usize) {
    let tools: Vec<String> = (m.entries.iter())
        .filter(|entry| entry.section == "extruder" && entry.key == "tool_id")
        .map(|entry| entry.instance.clone())
        .collect();
    let rows: &[(&str, &str, &str)] = &[
        ("retract_length", "retract_length", "0"),
        ("retract_speed", "retract_feedrate", "20"),
        ("unretract_extra_length", "retract_recover_length", "0"),
        ("unretract_speed", "retract_recover_feedrate", "10"),
    ];
    for tool in &tools {
        for (option, key, default) in rows {
            let value = m.number(section, option).map_or_else(|| (*default).to_owned(), text);
            m.put(section, option, ("extruder", tool, key), value);
        }
    }
    let verdict = match tools.is_empty() {
        true => Verdict::refused("there is no extruder", "[extruder] retract_length"),
        false => Verdict::new(Class::Converted, "G10 and G11"),
    };
    m.judge_rest(section, &verdict);
}

/// Converts `[safe_z_home]`.
pub fn safe_z(m: &mut Migration<'_>, section: usize) {
    let by_probe = m.find("stepper_z").and_then(|z| m.pin(z, "endstop_pin")).is_some_and(|pin| pin.is_virtual());
    if by_probe {
        let reason = "goes into the line that homes Z by the probe";
        for option in ["home_xy_position", "speed", "z_hop", "z_hop_speed"] {
            m.merged(section, option, reason, "");
        }
    }
    if let Some([x, y]) = m.section(section).get("home_xy_position").and_then(numbers).as_deref()
        && !by_probe
    {
        m.put(section, "home_xy_position", ("endstops", "common", "safe_z_x"), text(*x));
        m.put(section, "home_xy_position", ("endstops", "common", "safe_z_y"), text(*y));
    }
    let rows: &[(&str, Rule)] = &[
        ("home_xy_position", Rule::Refused("these are no two numbers", "[endstops] safe_z_x")),
        ("z_hop", Rule::To("endstops", "home_lift", NUMBER)),
        ("speed", Rule::Refused("the tool goes there at fast_rate", "[endstops] fast_rate")),
        ("z_hop_speed", Rule::Refused("Z rises at fast_rate", "[endstops] fast_rate")),
        ("move_to_previous", Rule::Only("false", "it stays where Z homed", "[endstops] home_gcode")),
    ];
    apply(m, section, "common", rows);
    m.judge_section(section, Verdict::new(Class::Converted, "where Z homes"));
}

/// Converts `[endstop_phase STEPPER]`.
pub fn phase(m: &mut Migration<'_>, section: usize) {
    let label = m.section(section).label();
    let axis = label.trim_start_matches("stepper_").to_lowercase();
    let name = ["min", "max"].map(|end| format!("{end}{axis}"));
    let found = name.into_iter().find(|name| m.written(("endstops", name, "pin")).is_some());
    let Some(name) = found else {
        let why = "[endstop_phase] names no axis with a switch";
        return m.judge_rest(section, &Verdict::refused(why, "[endstops] phase_check"));
    };
    m.write(("endstops", &name, "phase_check"), "true", format!("of [endstop_phase {label}]"));
    m.write(("endstops", &name, "phase_fault"), "halt", "as Klipper does");
    let rows: &[(&str, Rule)] = &[
        ("endstop_accuracy", Rule::To("endstops", "phase_tolerance", Change::Times(0.5))),
        ("endstop_align_zero", Rule::To("endstops", "phase_align_zero", Change::Truth)),
        ("trigger_phase", Rule::Refused("another driver counts phases from another place", "M875.1, M500")),
    ];
    apply(m, section, &name, rows);
    m.judge_section(section, Verdict::new(Class::Converted, "M875"));
}

/// Converts `[filament_switch_sensor NAME]` and `[filament_motion_sensor NAME]`; there is one detector.
pub fn filament(m: &mut Migration<'_>, section: usize) {
    const DETECTOR: &str = "filament detector";
    let is_motion = m.section(section).kind() == "filament_motion_sensor";
    let key = if is_motion { "encoder_pin" } else { "detector_pin" };
    if m.written((DETECTOR, "", key)).is_some() {
        let why = "Velvet has one filament detector of each kind";
        return m.judge_rest(section, &Verdict::refused(why, "[filament detector]"));
    }
    if let Some((place, pin)) = m.place(section, "switch_pin", Role::Input, "filament sensor") {
        m.write((DETECTOR, "", "enable"), "true", format!("of [{}]", m.section(section).name));
        // Klipper's pin is high where there is filament, Velvet's where there is none.
        let mark = if is_motion || pin.is_inverted { "" } else { "!" };
        m.put(section, "switch_pin", (DETECTOR, "", key), format!("{}^{mark}", place.pin));
    }
    if let Some(length) = m.number(section, "detection_length").filter(|length| *length > 0.0) {
        m.put(section, "detection_length", (DETECTOR, "", "pulses_per_mm"), text(1.0 / length));
    }
    template(m, section, "runout_gcode", (DETECTOR, "", "runout_gcode"));
    if !is_motion {
        template(m, section, "insert_gcode", (DETECTOR, "", "insert_gcode"));
    }
    let rows: &[(&str, Rule)] = &[
        ("pause_on_runout", Rule::To(DETECTOR, "suspends", Change::Truth)),
        ("runout_gcode", Rule::Refused("the detector has this line already", "[filament detector] runout_gcode")),
        ("insert_gcode", Rule::Refused("a wheel does not tell when filament is put in", "[filament detector]")),
        ("event_delay", Rule::Needless("a job is suspended once, and contacts may bounce")),
        ("pause_delay", Rule::Needless("a job is suspended once")),
        ("debounce_delay", Rule::Needless("contacts may bounce")),
        ("extruder", Rule::Needless("every extruder that turns counts")),
    ];
    apply(m, section, "", rows);
    m.judge_section(section, Verdict::new(Class::Converted, "[filament detector]"));
}

/// Converts `[hall_filament_width_sensor]` and `[tsl1401cl_filament_width_sensor]`.
pub fn width(m: &mut Migration<'_>, section: usize) {
    const WIDTH: &str = "filament width sensor";
    let is_hall = m.section(section).kind() == "hall_filament_width_sensor";
    for (option, key) in [("adc1", "adc_pin"), ("adc2", "second_adc_pin"), ("pin", "adc_pin")] {
        if let Some((place, _)) = m.place(section, option, Role::Thermistor, "filament width sensor") {
            m.put(section, option, (WIDTH, "", key), place.pin);
        }
    }
    let is_on = m.section(section).get("enable").and_then(truth).unwrap_or(!is_hall);
    m.put(section, "enable", (WIDTH, "", "enable"), is_on.to_string());
    let rows: &[(&str, Rule)] = &[
        ("cal_dia1", Rule::To(WIDTH, "first_diameter", NUMBER)),
        ("cal_dia2", Rule::To(WIDTH, "second_diameter", NUMBER)),
        ("raw_dia1", Rule::To(WIDTH, "first_raw", NUMBER)),
        ("raw_dia2", Rule::To(WIDTH, "second_raw", NUMBER)),
        ("default_nominal_filament_diameter", Rule::To(WIDTH, "nominal_diameter", NUMBER)),
        ("max_difference", Rule::To(WIDTH, "max_difference", NUMBER)),
        ("measurement_delay", Rule::To(WIDTH, "measurement_delay", NUMBER)),
        ("min_diameter", Rule::To(WIDTH, "min_diameter", NUMBER)),
        ("max_diameter", Rule::To(WIDTH, "max_diameter", NUMBER)),
        ("use_current_dia_while_delay", Rule::To(WIDTH, "measured_at_once", Change::Truth)),
        ("logging", Rule::To(WIDTH, "log", Change::Truth)),
        ("measurement_interval", Rule::Needless("every piece is measured")),
        ("pause_on_runout", Rule::Needless("min_diameter suspends")),
        ("runout_gcode", NO_TEMPLATE),
        ("insert_gcode", NO_TEMPLATE),
        ("event_delay", Rule::Needless("a job is suspended once")),
        ("pause_delay", Rule::Needless("a job is suspended once")),
    ];
    apply(m, section, "", rows);
    m.judge_section(section, Verdict::new(Class::Converted, "[filament width sensor]"));
}

/// Converts `[skew_correction NAME]`, the lengths that a profile keeps.
pub fn skew(m: &mut Migration<'_>, section: usize) {
    let is_profile = !m.section(section).label().is_empty();
    for plane in ["xy", "xz", "yz"] {
        let option = format!("{plane}_skew");
        if let (true, Some(angle)) = (is_profile, m.number(section, &option)) {
            m.put(section, &option, ("skew correction", "", plane), text(angle));
        }
    }
    m.judge_rest(section, &Verdict::new(Class::Converted, "[skew correction]"));
}

/// Keeps `[homing_override]`, whose moves were written for another machine.
pub fn homing(m: &mut Migration<'_>, section: usize) {
    m.ask("[homing_override] stands for G28: try it with a hand at the kill button".to_owned());
    kept(m, section);
}

/// Keeps a whole section in printer.cfg.
pub fn kept(m: &mut Migration<'_>, section: usize) {
    m.judge_rest(section, &Verdict::kept(KEPT));
}

/// Keeps `[save_variables]`; the variables themselves are a file beside the computer's printer.cfg.
pub fn variables(m: &mut Migration<'_>, section: usize) {
    let file = m.section(section).get("filename").unwrap_or("").to_owned();
    m.ask(format!("[save_variables]: copy {file} to the card beside printer.cfg, or its variables begin anew"));
    kept(m, section);
}

/// Gives verdicts on `[multi_pin NAME]`: an output has one pin.
pub fn several(m: &mut Migration<'_>, section: usize) {
    let name = instance(&m.section(section).label());
    let why = "an output has one pin: join the loads at one MOSFET, or make a switch of each";
    m.ask(format!("[multi_pin {name}]: {why}"));
    m.judge_rest(section, &Verdict::refused(why, "[switch]"));
}

//! `[extruder]` and its kin: a motor, a heater, pressure advance.

use super::super::account::{Class, Verdict};
use super::super::migration::{Migration, text};
use super::super::wiring::Role;
use super::motors::{drive, is_on_board, step_rate};
use super::table::{NUMBER, Rule, apply};
use super::{heat, machine};

/// Heaters of tools, with the pins that the board has for them.
const HEATERS: [&str; 3] = ["hotend", "hotend2", "hotend3"];
/// Temperature below which Klipper does not extrude, where the file does not say one, C.
const LEAST_TEMPERATURE: &str = "170";
/// Filament that a move alone may feed in Klipper, where the file does not say it, mm.
const LONGEST_ALONE: &str = "50";
const EXTRUDER: &str = "extruder";

const ROWS: &[(&str, Rule)] = &[
    ("pressure_advance", Rule::To(EXTRUDER, "pressure_advance", NUMBER)),
    ("pressure_advance_smooth_time", Rule::To(EXTRUDER, "pressure_advance_smooth_time", NUMBER)),
    ("max_extrude_cross_section", Rule::Refused("how thick a line is extruded is not looked at", "[player] preflight")),
    ("instantaneous_corner_velocity", Rule::Refused("no limit of the filament's own at corners", "[planner]")),
];

/// Converts the section of a tool.
pub fn extruder(m: &mut Migration<'_>, section: usize) {
    let of = m.section(section);
    let tool: usize = of.name.trim_start_matches(EXTRUDER).parse().unwrap_or(0);
    let (Some(heater), Some(motor)) = (HEATERS.get(tool).copied(), m.motors.get(&of.name).copied()) else {
        let why = match of.get("step_pin") {
            Some(_) => "Velvet turns three extruders at most, by delta, epsilon and zeta",
            None => "an extruder without a motor of its own",
        };
        return m.judge_rest(section, &Verdict::refused(why, "[extruder]"));
    };
    m.write((EXTRUDER, heater, "enable"), "true", format!("of [{}]", of.name));
    m.write((EXTRUDER, heater, "tool_id"), tool.to_string(), format!("T{tool}, turned by motor {motor}"));
    drive(m, section, motor);
    limits(m, section, motor);
    if is_on_board(motor) {
        m.wiring.reserve("PG9");
    }
    let has_heater = m.section(section).get("heater_pin").is_some();
    if m.section(section).get("shared_heater").is_some() {
        shared(m, section);
    } else if has_heater && heat::heater(m, section, heater, Role::Hotend) {
        least_temperature(m, section, heater);
    }
    let longest = m.number(section, "max_extrude_only_distance").map_or_else(|| LONGEST_ALONE.to_owned(), text);
    m.put(section, "max_extrude_only_distance", (EXTRUDER, heater, "max_extrude_only_distance"), longest);
    apply(m, section, heater, ROWS);
    filament(m, section);
    if tool > 0 {
        m.write((EXTRUDER, heater, "x_offset"), "0", "mm; in Klipper macros shift the tool");
    }
    m.judge_section(section, Verdict::new(Class::Converted, "a motor, a heater and an extruder"));
}

fn shared(m: &mut Migration<'_>, section: usize) {
    let why = "Velvet's extruders have a heater each";
    m.refuse(section, "shared_heater", why, "[temperature control] tool_id");
}

fn least_temperature(m: &mut Migration<'_>, section: usize, heater: &str) {
    let value = m.number(section, "min_extrude_temp").map_or_else(|| LEAST_TEMPERATURE.to_owned(), text);
    m.put(section, "min_extrude_temp", (EXTRUDER, heater, "min_extrude_temp"), value);
}

/// Writes the limits of an extruder's motor, as Klipper works them out for moves of filament alone.
fn limits(m: &mut Migration<'_>, section: usize, motor: &'static str) {
    let printer = m.source.section("printer");
    let of_printer = |option: &str| printer.and_then(|printer| printer.number(option));
    let (speed, accel) = (of_printer("max_velocity"), of_printer("max_accel"));
    let nozzle = m.section(section).number("nozzle_diameter");
    let filament = m.section(section).number("filament_diameter");
    let ratio = match (nozzle, filament) {
        (Some(nozzle), Some(filament)) if filament > 0.0 => {
            let cross = m.section(section).number("max_extrude_cross_section").unwrap_or(4.0 * nozzle * nozzle);
            Some(cross / (std::f64::consts::PI * (filament / 2.0).powi(2)))
        }
        _ => None,
    };
    let work = |limit: Option<f64>| limit.zip(ratio).map(|(limit, ratio)| (limit * ratio * 1000.0).round() / 1000.0);
    let wanted = m.number(section, "max_extrude_only_velocity").or_else(|| work(speed));
    if let Some(rate) = wanted {
        m.put(section, "max_extrude_only_velocity", ("actuator", motor, "max_rate"), text(rate * 60.0));
        step_rate(m, motor, rate);
    }
    if let Some(accel) = m.number(section, "max_extrude_only_accel").or_else(|| work(accel)) {
        m.put(section, "max_extrude_only_accel", ("actuator", motor, "acceleration"), text(accel));
    }
}

/// Gives verdicts on the thickness of nozzle and filament.
fn filament(m: &mut Migration<'_>, section: usize) {
    let of = m.section(section);
    let is_used = of.get("max_extrude_only_velocity").is_none() || of.get("max_extrude_only_accel").is_none();
    for option in ["nozzle_diameter", "filament_diameter"] {
        match is_used {
            true => {
                m.merged(section, option, "goes into the motor's max_rate and acceleration; E stays millimetres", "")
            }
            false => m.needless(section, option, "E is millimetres of filament, and its limits are written"),
        }
    }
}

/// Returns the number of a tool's section, if it is one.
pub fn is_extruder(name: &str) -> bool {
    name.strip_prefix(EXTRUDER).is_some_and(|rest| rest.chars().all(|c| c.is_ascii_digit()))
        || name == machine::extruder(0)
}

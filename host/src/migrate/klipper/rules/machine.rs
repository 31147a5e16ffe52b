//! `[printer]`: kinematics, speeds; and which motor of the Prime turns for which section.

use super::super::account::Verdict;
use super::super::migration::{Migration, text};
use super::generic;
use super::table::{NUMBER, Rule, apply};

/// Kinematics: Klipper's name, Velvet's name, the sections whose motors are alpha, beta, gamma.
const KINEMATICS: &[(&str, &str, [&str; 3])] = &[
    ("cartesian", "cartesian", ["stepper_x", "stepper_y", "stepper_z"]),
    ("corexy", "corexy", ["stepper_x", "stepper_y", "stepper_z"]),
    ("corexz", "corexz", ["stepper_x", "stepper_z", "stepper_y"]),
    ("hybrid_corexy", "hybrid_corexy", ["stepper_x", "stepper_y", "stepper_z"]),
    ("hybrid_corexz", "hybrid_corexz", ["stepper_x", "stepper_y", "stepper_z"]),
    ("delta", "linear_delta", ["stepper_a", "stepper_b", "stepper_c"]),
    ("rotary_delta", "rotary_delta", ["stepper_a", "stepper_b", "stepper_c"]),
    ("deltesian", "deltesian", ["stepper_left", "stepper_right", "stepper_y"]),
    ("polar", "polar", ["stepper_arm", "stepper_bed", "stepper_z"]),
    ("winch", "winch", ["stepper_a", "stepper_b", "stepper_c"]),
    // Its motors have names of their own here.
    (GENERIC, GENERIC, ["", "", ""]),
];
const GENERIC: &str = "generic_cartesian";
/// Motors without one axis of their own.
const SPARE: [&str; 3] = ["delta", "epsilon", "zeta"];
/// Klipper's speed through a right angle, mm/s, where the file does not say one.
const CORNER_SPEED: &str = "5";
/// Klipper's share of a short move that is cruised, where the file does not say one.
const CRUISE_RATIO: &str = "0.5";

/// Finds a motor of the Prime for each section with a motor: axes, then extruders, then further motors.
pub fn plan(m: &mut Migration<'_>) {
    let kinematics = kinematics(m).unwrap_or_default();
    if kinematics == GENERIC {
        generic::plan(m);
    } else if let Some((_, _, sections)) = KINEMATICS.iter().find(|(name, ..)| *name == kinematics) {
        for (section, motor) in sections.iter().zip(["alpha", "beta", "gamma"]) {
            m.motors.insert((*section).to_owned(), motor);
        }
    }
    let mut spare = SPARE.to_vec();
    if kinematics == "winch" {
        for (letter, motor) in ["d", "e", "f"].iter().zip(SPARE) {
            let section = format!("stepper_{letter}");
            if m.find(&section).is_some() {
                m.motors.insert(section, motor);
                spare.retain(|other| *other != motor);
            }
        }
    }
    for (tool, motor) in SPARE.into_iter().enumerate() {
        let section = extruder(tool);
        let has_motor = m.source.section(&section).is_some_and(|of| of.get("step_pin").is_some());
        if has_motor && spare.contains(&motor) {
            m.motors.insert(section, motor);
            spare.retain(|other| *other != motor);
        }
    }
    for section in &m.source.sections {
        if master(m, &section.name).is_some() && !spare.is_empty() {
            m.motors.insert(section.name.clone(), spare.remove(0));
        }
    }
}

/// Returns the section of a tool's extruder.
pub fn extruder(tool: usize) -> String {
    if tool == 0 { "extruder".to_owned() } else { format!("extruder{tool}") }
}

/// Returns the kinematics of `[printer]`, lower case.
pub fn kinematics(m: &Migration<'_>) -> Option<String> {
    Some(m.source.section("printer")?.get("kinematics")?.trim().to_lowercase())
}

/// Returns the motor that a further one of its axis copies: gamma of `stepper_z1`.
pub fn master(m: &Migration<'_>, section: &str) -> Option<&'static str> {
    if let Some(motor) = m.slaves.get(section) {
        return Some(motor);
    }
    let axis = section.strip_prefix("stepper_")?.trim_end_matches(|c: char| c.is_ascii_digit());
    let first = format!("stepper_{axis}");
    let motor = m.motors.get(&first).copied().filter(|motor| !SPARE.contains(motor))?;
    (first != section && first.len() < section.len()).then_some(motor)
}

/// Converts `[printer]`.
pub fn printer(m: &mut Migration<'_>, section: usize) {
    let name = kinematics(m).unwrap_or_default();
    match KINEMATICS.iter().find(|(known, ..)| *known == name) {
        Some((_, solution, _)) => m.put(section, "kinematics", ("motion control", "", "arm_solution"), *solution),
        None if name == "none" => m.needless(section, "kinematics", "without a motor no kinematics are needed"),
        None => {
            let why = format!("Velvet cannot work out {name} from this file");
            m.judge(section, "kinematics", Verdict::refused(why, "[motion control] arm_solution, and [actuator]"));
            m.ask("the kinematics: write [motion control] arm_solution and the motors by hand (docs/motion.md)");
        }
    }
    speeds(m, section, &name);
    if name == "corexz" {
        m.write(("corexz", "", "x_reduction"), "1", "Klipper has no reduction");
        m.write(("corexz", "", "z_reduction"), "1", "Klipper has no reduction");
    }
    let rows: &[(&str, Rule)] = &[
        ("square_corner_velocity", Rule::To("planner", "square_corner_velocity", NUMBER)),
        ("minimum_cruise_ratio", Rule::To("planner", "minimum_cruise_ratio", NUMBER)),
        ("delta_radius", Rule::To("linear delta", "arm_radius", NUMBER)),
        ("minimum_z_position", Rule::To("soft endstop", "z_min", NUMBER)),
        ("print_radius", Rule::Needless("what the arms cannot reach is refused where a move is read")),
        ("shoulder_height", Rule::To("rotary delta", "delta_z_offset", NUMBER)),
        ("buffer_time_low", Rule::Needless("there is no line between planning and steps")),
        ("buffer_time_high", Rule::Needless("there is no line between planning and steps")),
        ("buffer_time_start", Rule::Needless("there is no line between planning and steps")),
        ("move_flush_time", Rule::Needless("there is no line between planning and steps")),
    ];
    apply(m, section, "", rows);
    if name == "delta" && m.section(section).get("minimum_z_position").is_none() {
        m.put(section, "minimum_z_position", ("soft endstop", "", "z_min"), "0");
    }
    for (option, key, value) in [
        ("square_corner_velocity", "square_corner_velocity", CORNER_SPEED),
        ("minimum_cruise_ratio", "minimum_cruise_ratio", CRUISE_RATIO),
    ] {
        if m.section(section).get(option).is_none() && m.written(("planner", "", key)).is_none() {
            m.put(section, option, ("planner", "", key), value);
        }
    }
}

fn speeds(m: &mut Migration<'_>, section: usize, kinematics: &str) {
    let Some(speed) = m.number(section, "max_velocity") else { return };
    m.put_for(section, "max_velocity", ("motion control", "", "max_speed"), text(speed * 60.0), "mm/s to mm/min");
    for axis in ["x_axis_max_speed", "y_axis_max_speed"] {
        m.write(("motion control", "", axis), "0", "max_speed limits it");
    }
    let speed_z = m.number(section, "max_z_velocity").unwrap_or(speed);
    m.put(section, "max_z_velocity", ("motion control", "", "z_axis_max_speed"), text(speed_z * 60.0));
    let accel = m.number(section, "max_accel");
    if let Some(accel) = accel {
        m.put(section, "max_accel", ("motion control", "", "default_acceleration"), text(accel));
    }
    if let (Some(accel), Some(slower)) = (accel, m.number(section, "max_accel_to_decel")) {
        let ratio = (1.0 - slower / accel).clamp(0.0, 0.95);
        m.put(section, "max_accel_to_decel", ("planner", "", "minimum_cruise_ratio"), text(ratio));
    }
    let z_is_alone = !matches!(kinematics, "delta" | "rotary_delta" | "deltesian" | "corexz" | "winch");
    if let Some(accel_z) = m.number(section, "max_z_accel") {
        if z_is_alone && m.motors.values().any(|motor| *motor == "gamma") {
            m.put(section, "max_z_accel", ("actuator", "gamma", "acceleration"), text(accel_z));
        } else {
            let why = "Velvet limits motors, and here no motor moves Z alone";
            m.refuse(section, "max_z_accel", why, "[actuator] alpha.acceleration and the others");
        }
    }
}

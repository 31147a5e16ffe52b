//! Values of options as Klipper has them in `printer.configfile.settings`: numbers, truth values, lists, by
//! the look of their text, and those that count where an option is not written.

use core::fmt::Write as _;

use crate::store::Scratch;

/// Value of an option.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// A truth value, `True` or `False`.
    Bool(bool),
    /// A whole number, as Python's int.
    Int(i64),
    /// A number with a fraction, as Python's float.
    Float(f64),
    /// A list of numbers: the text has become a literal of them.
    List,
    /// A text, as it is.
    Text,
}

/// Options that Klipper reads as whole numbers.
const WHOLE: [&str; 14] = [
    "microsteps",
    "full_steps_per_rotation",
    "samples",
    "samples_tolerance_retries",
    "probe_count",
    "retries",
    "round_probe_count",
    "interpolate",
    "sgthrs",
    "driver_sgthrs",
    "algorithm",
    "chain_count",
    "tachometer_ppr",
    "max_retries",
];

/// Values that count where an option is not written: end of the section's name and key, and the value.
const DEFAULTS: [(&str, &str, &str); 43] = [
    ("idle_timeout", "timeout", "600"),
    ("extruder", "min_extrude_temp", "170"),
    ("extruder", "max_extrude_only_distance", "50"),
    ("extruder", "pressure_advance", "0"),
    ("extruder", "pressure_advance_smooth_time", "0.04"),
    ("printer", "square_corner_velocity", "5"),
    ("printer", "minimum_cruise_ratio", "0.5"),
    ("stepper", "homing_speed", "5"),
    ("stepper", "homing_retract_dist", "5"),
    ("stepper", "homing_retract_speed", "5"),
    ("stepper", "position_min", "0"),
    ("fan", "max_power", "1"),
    ("fan", "off_below", "0"),
    ("fan", "kick_start_time", "0.1"),
    ("safe_z_home", "z_hop", "0"),
    ("safe_z_home", "z_hop_speed", "15"),
    ("safe_z_home", "speed", "50"),
    ("safe_z_home", "move_to_previous", "False"),
    ("filament_switch_sensor", "pause_on_runout", "True"),
    ("pause_resume", "recover_velocity", "50"),
    ("probe", "x_offset", "0"),
    ("probe", "y_offset", "0"),
    ("probe", "speed", "5"),
    ("probe", "samples", "1"),
    ("probe", "lift_speed", "5"),
    ("probe", "sample_retract_dist", "2"),
    ("probe", "samples_tolerance", "0.1"),
    ("probe", "samples_tolerance_retries", "0"),
    ("bed_mesh", "speed", "50"),
    ("bed_mesh", "horizontal_move_z", "5"),
    ("bed_mesh", "algorithm", "lagrange"),
    ("bed_mesh", "probe_count", "3,3"),
    ("bed_mesh", "fade_start", "1"),
    ("bed_mesh", "fade_end", "0"),
    ("z_tilt", "speed", "50"),
    ("z_tilt", "horizontal_move_z", "5"),
    ("z_tilt", "retries", "0"),
    ("z_tilt", "retry_tolerance", "0"),
    ("firmware_retraction", "retract_length", "0"),
    ("firmware_retraction", "retract_speed", "20"),
    ("firmware_retraction", "unretract_extra_length", "0"),
    ("firmware_retraction", "unretract_speed", "10"),
    ("force_move", "enable_force_move", "False"),
];

/// Returns the value that counts where an option is not written.
#[must_use]
pub fn default_of(section: &str, key: &str) -> Option<&'static str> {
    defaults_of(section).find(|(option, _)| *option == key).map(|(_, value)| value)
}

/// Returns options of a section that count where they are not written, and their values.
pub fn defaults_of(section: &str) -> impl Iterator<Item = (&'static str, &'static str)> {
    let kind = match section.split(' ').next().unwrap_or(section) {
        kind if kind.starts_with("stepper_") => "stepper",
        kind if kind.starts_with("extruder") => "extruder",
        "bltouch" | "smart_effector" => "probe",
        "quad_gantry_level" => "z_tilt",
        "fan_generic" | "heater_fan" | "controller_fan" => "fan",
        "filament_motion_sensor" => "filament_switch_sensor",
        kind => kind,
    };
    DEFAULTS.into_iter().filter(move |(of, _, _)| *of == kind).map(|(_, option, value)| (option, value))
}

/// Returns the option of the same section that stands in where this one is not written.
#[must_use]
pub fn stand_in(key: &str) -> Option<&'static str> {
    Some(match key {
        "lift_speed" => "speed",
        "homing_retract_speed" => "homing_speed",
        "max_z_velocity" => "max_velocity",
        "max_z_accel" => "max_accel",
        _ => return None,
    })
}

/// Reads the text of an option as what it looks like.
pub fn read(key: &str, text: &mut Scratch) -> Setting {
    let (Some(written), false) = (text.text(), key.starts_with("variable_") || key.ends_with("gcode")) else {
        return Setting::Text;
    };
    for (word, is) in [("true", true), ("false", false), ("yes", true), ("no", false), ("on", true), ("off", false)] {
        if written.eq_ignore_ascii_case(word) {
            return Setting::Bool(is);
        }
    }
    let is_whole = WHOLE.contains(&key);
    if is_whole && let Ok(number) = written.parse() {
        return Setting::Int(number);
    }
    if let Some(number) = number(written) {
        return Setting::Float(number);
    }
    if !written.contains(',') || written.split(',').any(|part| number(part.trim()).is_none()) {
        return Setting::Text;
    }
    let mut list = Scratch::new();
    let begin = if is_whole { '[' } else { '(' };
    for (place, part) in written.split(',').map(str::trim).enumerate() {
        let point = if is_whole || part.contains(['.', 'e', 'E']) { "" } else { ".0" };
        // A text that does not fit is seen by its length.
        let _ = write!(list, "{}{part}{point}", if place == 0 { begin } else { ',' });
    }
    list.push(if is_whole { b']' } else { b')' });
    text.fill(list.bytes().iter().copied());
    Setting::List
}

/// Reads a number that Python's `float` would read, but for words.
fn number(text: &str) -> Option<f64> {
    text.starts_with(|first: char| first.is_ascii_digit() || matches!(first, '-' | '+' | '.'))
        .then(|| gcode::read_f64(text))
        .flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_of(key: &str, text: &str) -> (Setting, std::string::String) {
        let mut scratch = Scratch::new();
        scratch.fill(text.bytes());
        let setting = read(key, &mut scratch);
        (setting, scratch.text().unwrap_or_default().into())
    }

    #[test]
    fn options_are_what_they_look_like() {
        assert_eq!(read_of("position_max", "250").0, Setting::Float(250.0));
        assert_eq!(read_of("microsteps", "16").0, Setting::Int(16));
        assert_eq!(read_of("enable_force_move", "True").0, Setting::Bool(true));
        assert_eq!(read_of("variable_speed", "20").0, Setting::Text);
        assert_eq!(read_of("step_pin", "PA4").0, Setting::Text);
        assert_eq!(read_of("mesh_min", "10, 5.5"), (Setting::List, "(10.0,5.5)".into()));
        assert_eq!(read_of("probe_count", "5,5"), (Setting::List, "[5,5]".into()));
    }

    #[test]
    fn what_is_not_written_has_klippers_value() {
        assert_eq!(default_of("stepper_x", "homing_speed"), Some("5"));
        assert_eq!(default_of("extruder1", "min_extrude_temp"), Some("170"));
        assert_eq!(default_of("idle_timeout", "timeout"), Some("600"));
        assert_eq!(default_of("printer", "max_accel"), None);
        assert_eq!(default_of("bltouch", "sample_retract_dist"), Some("2"));
        assert_eq!(default_of("quad_gantry_level", "retries"), Some("0"));
        assert_eq!(default_of("filament_motion_sensor wheel", "pause_on_runout"), Some("True"));
        assert_eq!(default_of("fan_generic aux", "max_power"), Some("1"));
        assert_eq!([stand_in("lift_speed"), stand_in("speed")], [Some("speed"), None]);
    }
}

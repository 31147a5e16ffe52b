//! Rules for each kind of section of a printer.cfg. Their order matters where one uses the results of
//! another.

mod drivers;
mod endstops;
mod extruder;
mod fans;
mod features;
mod generic;
mod geometry;
mod heat;
mod leveling;
mod machine;
mod motors;
mod outputs;
mod probe;
mod sensors;
mod table;

use super::account::{Class, Verdict};
use super::migration::Migration;
use super::sections;

type Rule = fn(&mut Migration<'_>, usize);

/// Kinds of sections in the order in which they choose their places on the board, and what converts them.
const RULES: &[(&str, Rule)] = &[
    ("printer", machine::printer),
    ("extruder", extruder::extruder),
    ("stepper", motors::stepper),
    ("carriage", generic::carriage),
    ("heater_bed", heat::bed),
    ("heater_generic", heat::generic),
    ("temperature_sensor", heat::sensor),
    ("temperature_sensor", heat::combined),
    ("verify_heater", heat::verify),
    ("thermistor", sensors::description),
    ("adc_temperature", sensors::description),
    ("fan", fans::part),
    ("heater_fan", fans::of_heater),
    ("controller_fan", fans::of_controller),
    ("temperature_fan", fans::of_temperature),
    ("fan_generic", fans::generic),
    ("output_pin", outputs::pin),
    ("pwm_tool", outputs::pin),
    ("pwm_cycle_time", outputs::pin),
    ("servo", outputs::servo),
    ("led", outputs::led),
    ("neopixel", outputs::strip),
    ("multi_pin", features::several),
    ("tmc2130", drivers::driver),
    ("tmc2208", drivers::driver),
    ("tmc2209", drivers::driver),
    ("tmc2240", drivers::driver),
    ("tmc2660", drivers::driver),
    ("tmc5160", drivers::driver),
    ("probe", probe::probe),
    ("smart_effector", probe::probe),
    ("bltouch", probe::bltouch),
    ("safe_z_home", features::safe_z),
    ("endstop_phase", features::phase),
    ("bed_mesh", leveling::mesh),
    ("bed_tilt", leveling::tilt),
    ("screws_tilt_adjust", leveling::screws),
    ("bed_screws", leveling::screws),
    ("z_tilt", leveling::z_motors),
    ("quad_gantry_level", leveling::z_motors),
    ("delta_calibrate", leveling::delta),
    ("axis_twist_compensation", leveling::twist),
    ("z_thermal_adjust", leveling::thermal),
    ("skew_correction", features::skew),
    ("input_shaper", features::shaper),
    ("firmware_retraction", features::retraction),
    ("filament_switch_sensor", features::filament),
    ("filament_motion_sensor", features::filament),
    ("hall_filament_width_sensor", features::width),
    ("tsl1401cl_filament_width_sensor", features::width),
    ("gcode_button", outputs::button),
    ("dual_carriage", motors::extra),
    ("extruder_stepper", motors::extra),
    ("manual_stepper", motors::extra),
    ("gcode_macro", features::kept),
    ("delayed_gcode", features::kept),
    ("homing_override", features::homing),
    ("idle_timeout", features::kept),
    ("save_variables", features::variables),
];

/// Converts all sections, and gives every section and option its verdict.
pub fn apply(m: &mut Migration<'_>) {
    machine::plan(m);
    for (kind, rule) in RULES {
        for section in 0..m.source.sections.len() {
            if kind_of(&m.section(section).name) == *kind {
                rule(m, section);
            }
        }
    }
    endstops::finish(m);
    drivers::finish(m);
    board(m);
    for section in 0..m.source.sections.len() {
        rest(m, section);
    }
}

/// Returns the kind by which a section's rule is found.
fn kind_of(name: &str) -> &str {
    let first = name.split_whitespace().next().unwrap_or("");
    if first.starts_with("stepper_") {
        "stepper"
    } else if extruder::is_extruder(name) {
        "extruder"
    } else {
        first
    }
}

/// Writes what the Prime has and no other board's file can say.
fn board(m: &mut Migration<'_>) {
    m.write(("temperature control", "board", "enable"), "true", "the board's own thermistor, for reports");
    m.write(("temperature control", "board", "thermistor"), "EPCOS100K", "");
    if config::schema::section("macros").is_some() {
        let name = m.source.files.first().and_then(|path| path.file_name());
        let name = name.map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        m.write(("macros", "", "file"), name, "its macros are read on the board");
    }
}

/// Gives verdicts on what no rule has judged.
fn rest(m: &mut Migration<'_>, section: usize) {
    let name = m.section(section).name.clone();
    let has_rule = RULES.iter().any(|(kind, _)| *kind == kind_of(&name));
    let verdict = match sections::find(&name) {
        Some(row) if has_rule => {
            m.judge_section(section, Verdict::new(Class::Converted, row.why));
            Verdict::refused("Velvet has nothing that this sets", row.nearest)
        }
        Some(row) => row.verdict(),
        None => sections::unknown(&name),
    };
    m.judge_rest(section, &verdict);
}

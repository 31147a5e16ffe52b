//! Every section of Klipper's reference, and what becomes of it; sections that others have added to Klipper.

use super::account::{Class, Verdict};

/// What becomes of a section as a rule; its options may have verdicts of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    Converted,
    /// Stays in printer.cfg, which the board reads.
    Kept,
    Needless,
    Refused,
}

/// Edition of Klipper's reference that has a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edition {
    Both,
    /// Only the English one.
    English,
}

/// Row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// As the reference heads it; `<name>` stands for a name.
    pub name: &'static str,
    pub edition: Edition,
    pub fate: Fate,
    pub why: &'static str,
    /// The nearest thing in Velvet.
    pub nearest: &'static str,
}

const fn row(name: &'static str, fate: Fate, why: &'static str, nearest: &'static str) -> Row {
    Row { name, edition: Edition::Both, fate, why, nearest }
}

const fn english(name: &'static str, fate: Fate, why: &'static str, nearest: &'static str) -> Row {
    Row { name, edition: Edition::English, fate, why, nearest }
}

impl Row {
    /// Returns the verdict on what no rule has judged.
    pub fn verdict(&self) -> Verdict {
        match self.fate {
            Fate::Converted => Verdict::new(Class::Converted, self.why),
            Fate::Kept => Verdict::kept(super::migration::KEPT),
            Fate::Needless => Verdict::needless(self.why),
            Fate::Refused => Verdict::refused(self.why, self.nearest),
        }
    }

    /// Returns the kind of the row's sections.
    fn kind(&self) -> &'static str {
        self.name.split_once(' ').map_or(self.name, |(kind, _)| kind)
    }
}

use Fate::{Converted, Kept, Needless, Refused};

/// Sections of Klipper's reference in its order.
pub const SECTIONS: &[Row] = &[
    row("mcu", Needless, "the board makes the steps itself: there is no line between", "[network], USB"),
    row("printer", Converted, "kinematics, speeds and accelerations", "[motion control], [planner]"),
    row("stepper_<name>", Converted, "a motor, its switch and its travel", "[actuator], [endstops], [soft endstop]"),
    row(
        "stepper_y / stepper_z / stepper_b / stepper_c",
        Converted,
        "as the first of its kind",
        "[actuator], [endstops]",
    ),
    row("delta_calibrate", Converted, "how a delta is calibrated", "[delta calibration strategy]"),
    row("stepper_bed", Converted, "the motor of a polar bed", "[actuator] beta"),
    english("stepper_right", Converted, "the second tower of a deltesian", "[actuator] beta, [deltesian]"),
    row("stepper_arm", Converted, "the radius of a polar machine", "[actuator] alpha"),
    english("carriage <name>", Converted, "the switch and the travel of an axis", "[endstops], [soft endstop]"),
    english("stepper <name>", Converted, "a motor and what it moves", "[generic cartesian], [actuator]"),
    english("extra_carriage <name>", Refused, "a second switch of an axis is that of a slave", "[endstops] axis = A"),
    row("extruder", Converted, "a motor, a heater and an extruder", "[extruder], [actuator], [temperature control]"),
    row("heater_bed", Converted, "the heater of the bed", "[temperature control] bed"),
    row("bed_mesh", Converted, "a grid of heights", "[cartesian grid leveling strategy], [bed mesh]"),
    row("bed_tilt", Converted, "three points make a plane", "[three point leveling strategy]"),
    row("bed_screws", Converted, "screws by paper", "[bed screws]"),
    row("screws_tilt_adjust", Converted, "screws by the probe, G35", "[bed screws]"),
    row("z_tilt", Converted, "G34", "[z alignment]"),
    row("quad_gantry_level", Converted, "G34", "[z alignment] twist = true"),
    english("z_thermal_adjust", Converted, "Z follows the frame", "[z thermal adjust]"),
    row("safe_z_home", Converted, "where Z homes", "[endstops] safe_z_x, home_lift"),
    row("homing_override", Kept, "its template stands for G28", "[macros] file, [endstops] home_z_gcode"),
    row("endstop_phase <stepper>", Converted, "homing by the motor's phase", "[endstops] phase_check"),
    row("gcode_macro <name>", Kept, "its template runs on the board", "[macros] file"),
    row("delayed_gcode <name>", Kept, "its template runs on the board", "[macros] file"),
    row("save_variables", Kept, "variables of macros", "[macros] file"),
    row("idle_timeout", Kept, "its template runs on the board", "[macros] file"),
    row("virtual_sdcard", Needless, "the board plays files of its own card", "[player]"),
    row("sdcard_loop", Refused, "a file is played once", "O words (docs/programming.md)"),
    row("force_move", Kept, "FORCE_MOVE is allowed by it on the board", "test acc MOTOR"),
    row("pause_resume", Needless, "suspend and resume are always there", "M600, suspend, resume"),
    row("firmware_retraction", Converted, "G10 and G11", "[extruder] retract_length"),
    row("gcode_arcs", Needless, "G2 and G3 are always there, and exact", "[motion control] mm_per_arc_segment"),
    row("respond", Needless, "M118 and RESPOND are always there", "M118"),
    english("exclude_object", Needless, "objects can always be left out", "M486, EXCLUDE_OBJECT"),
    row("input_shaper", Converted, "shapers of X, Y and Z", "[input shaper]"),
    row(
        "adxl345 [<name>]",
        Refused,
        "Velvet reads no accelerometer",
        "[input shaper], a tower with a changing frequency",
    ),
    english("icm20948 [<name>]", Refused, "Velvet reads no accelerometer", "[input shaper]"),
    english("lis2dw [<name>]", Refused, "Velvet reads no accelerometer", "[input shaper]"),
    english("lis3dh [<name>]", Refused, "Velvet reads no accelerometer", "[input shaper]"),
    english("mpu9250 [<name>]", Refused, "Velvet reads no accelerometer", "[input shaper]"),
    row("resonance_tester", Refused, "resonances are not measured", "[input shaper]"),
    row("board_pins <name>", Needless, "pins are given by their role on the Prime", "the list of wires in the report"),
    row("include <file>", Converted, "read at its place", "one config.ini"),
    row(
        "duplicate_pin_override",
        Needless,
        "pins are given by their role on the Prime",
        "the list of wires in the report",
    ),
    row("probe", Converted, "the board's probe", "[zprobe]"),
    row("bltouch", Converted, "a probe that a servo's output puts out", "[zprobe] deploy_gcode, [switch]"),
    english("smart_effector", Converted, "a probe", "[zprobe]"),
    english("probe_eddy_current <name>", Refused, "Velvet has no probe that measures distance", "[zprobe]"),
    english("axis_twist_compensation", Converted, "M851.1 P4 measures it", "[axis twist compensation]"),
    row("stepper_<axis><N>", Converted, "a motor that copies another", "[actuator] slaved_to"),
    row("extruder<N>", Converted, "a further tool", "[extruder] tool_id"),
    row("dual_carriage", Refused, "one carriage on each axis", "nothing"),
    english("dual_carriage <name>", Refused, "one carriage on each axis", "nothing"),
    row("extruder_stepper <name>", Refused, "no motor follows an extruder", "nothing"),
    row(
        "manual_stepper <name>",
        Refused,
        "a motor without an axis is the axis A, B or C",
        "[actuator] delta, epsilon, zeta",
    ),
    row("verify_heater <heater>", Converted, "heat safety of the same rules", "[temperature control] verify_gain_time"),
    row("homing_heaters", Refused, "heaters stay as they are while an axis homes", "M104 in home_gcode"),
    row("thermistor <name>", Converted, "goes into what names it", "[temperature control] rt_curve, beta"),
    row("adc_temperature <name>", Converted, "goes into what names it", "[temperature control] voltage_curve"),
    row("heater_generic <name>", Converted, "a further heater", "[temperature control]"),
    row("temperature_sensor <name>", Converted, "a sensor without a heater", "[temperature control] heater_pin = nc"),
    english("temperature_probe <name>", Refused, "a probe's drift is not reckoned with", "[z thermal adjust]"),
    row("(sensor) common thermistors", Converted, "by their curve or beta", "[temperature control] rt_curve, beta"),
    row(
        "(sensor) temperature amplifiers",
        Converted,
        "AD8494 to AD8497; others by a curve",
        "[temperature control] sensor = ad849x, voltage",
    ),
    row("(sensor) PT1000", Converted, "straight on the input", "[temperature control] sensor = pt1000"),
    row(
        "(sensor) MAX31855 family",
        Converted,
        "on SPI; a MAX6675 is refused",
        "[temperature control] sensor = max31856",
    ),
    row("(sensor) BME280 family", Refused, "Velvet has no sensor on I2C", "[temperature control] sensor"),
    english("(sensor) AHT10", Refused, "Velvet has no sensor on I2C", "[temperature control] sensor"),
    row("(sensor) HTU21D family", Refused, "Velvet has no sensor on I2C", "[temperature control] sensor"),
    english("(sensor) SHT3X", Refused, "Velvet has no sensor on I2C", "[temperature control] sensor"),
    row("(sensor) LM75", Refused, "Velvet has no sensor on I2C", "[temperature control] sensor"),
    row("(sensor) temperature_mcu", Converted, "the board's microcontroller", "[temperature control] sensor = chip"),
    row("(sensor) temperature_host", Needless, "there is no host computer", "[temperature control] sensor = chip"),
    row("(sensor) DS18B20", Refused, "Velvet has no sensor on one wire", "[temperature control] sensor"),
    english(
        "(sensor) temperature_combined",
        Converted,
        "of sensors that were converted",
        "[temperature control] sensor = max, mean",
    ),
    row("fan", Converted, "M106 and M107", "[switch], [fan]"),
    row("heater_fan <name>", Converted, "follows heaters", "[fan] follows = heaters"),
    row("controller_fan <name>", Converted, "follows motors and heaters", "[fan] follows = electronics"),
    row("temperature_fan <name>", Converted, "keeps a temperature", "[fan] follows = temperature"),
    row("fan_generic <name>", Converted, "SET_FAN_SPEED", "[switch], [fan]"),
    english("led <name>", Converted, "a switch for each colour", "[led strip] red_switch"),
    row("neopixel <name>", Converted, "a strip on a timer's pin", "[led strip]"),
    row("dotstar <name>", Refused, "lights with a clock line", "[led strip]"),
    row("pca9533 <name>", Refused, "Velvet has no lights on I2C", "[led strip]"),
    english("pca9632 <name>", Refused, "Velvet has no lights on I2C", "[led strip]"),
    row("servo <name>", Converted, "an output on a timer", "[switch] servo_max_angle"),
    row("gcode_button <name>", Converted, "a button; RUN_TEMPLATE carries out its templates", "[button box]"),
    row("output_pin <name>", Converted, "SET_PIN", "[switch]"),
    english("pwm_tool <name>", Converted, "an output with PWM", "[switch], [laser]"),
    english("pwm_cycle_time <name>", Converted, "an output with PWM", "[switch] cycle_time"),
    row("static_digital_output <name>", Refused, "nobody can tell what hangs on these pins", "[switch] startup_state"),
    row("multi_pin <name>", Refused, "an output has one pin", "[switch]"),
    row(
        "tmc2130 <stepper>",
        Converted,
        "the board's driver, or one outside it",
        "[tmc2590], [tmc2660], [current control], [tmc2130]",
    ),
    row(
        "tmc2208 <stepper>",
        Converted,
        "the board's driver, or one outside it",
        "[tmc2590], [tmc2660], [current control], [tmc2208]",
    ),
    row(
        "tmc2209 <stepper>",
        Converted,
        "the board's driver, or one outside it",
        "[tmc2590], [tmc2660], [current control], [tmc2209]",
    ),
    row("tmc2660 <stepper>", Converted, "the board's driver", "[tmc2590], [tmc2660], [current control]"),
    english(
        "tmc2240 <stepper>",
        Converted,
        "the board's driver, or one outside it",
        "[tmc2590], [tmc2660], [current control], [tmc2240]",
    ),
    row(
        "tmc5160 <stepper>",
        Converted,
        "the board's driver, or one outside it",
        "[tmc2590], [tmc2660], [current control], [tmc5160]",
    ),
    row("ad5206 <name>", Needless, "the board's drivers have no potentiometers", "[current control]"),
    row("mcp4451 <name>", Needless, "the board's drivers have no potentiometers", "[current control]"),
    row("mcp4728 <name>", Needless, "the board's drivers have no potentiometers", "[current control]"),
    row("mcp4018 <name>", Needless, "the board's drivers have no potentiometers", "[current control]"),
    row("display", Refused, "Velvet drives no display yet", "the page in a browser (docs/page.md)"),
    row("display_data <group> <item>", Refused, "Velvet drives no display yet", "the page in a browser (docs/page.md)"),
    row("display_template <name>", Refused, "Velvet drives no display yet", "the page in a browser (docs/page.md)"),
    row("display_glyph <name>", Refused, "Velvet drives no display yet", "the page in a browser (docs/page.md)"),
    row("display <name>", Refused, "Velvet drives no display yet", "the page in a browser (docs/page.md)"),
    row("menu <path>", Refused, "Velvet drives no display yet", "the page in a browser (docs/page.md)"),
    row("filament_switch_sensor <name>", Converted, "one detector", "[filament detector] detector_pin"),
    row("filament_motion_sensor <name>", Converted, "one detector", "[filament detector] encoder_pin"),
    row("tsl1401cl_filament_width_sensor", Converted, "a voltage that is the diameter", "[filament width sensor]"),
    row("hall_filament_width_sensor", Converted, "one or two Hall sensors", "[filament width sensor]"),
    english("load_cell", Refused, "Velvet has no load cells", "nothing"),
    english("load_cell_probe", Refused, "Velvet has no load cells", "[zprobe]"),
    row("sx1509 <name>", Refused, "Velvet has no pins on I2C", "the headers of the Prime"),
    row("samd_sercom <name>", Needless, "of another microcontroller", "nothing"),
    row("adc_scaled <name>", Needless, "the board measures its own reference", "nothing"),
    english("ads1x1x <name>", Refused, "Velvet has no converter on I2C", "ADC1_4 to ADC1_6"),
    english("(sensor) ads1x1x", Refused, "Velvet has no converter on I2C", "ADC1_4 to ADC1_6"),
    row("replicape", Needless, "another board", "[actuator], [current control]"),
    row("palette2", Refused, "Velvet does not speak to it", "nothing"),
    english("angle <name>", Refused, "Velvet reads no shaft encoder", "[actuator] on_stall"),
    row("mcu <name>", Needless, "all that hung on it hangs on the Prime", "the list of wires in the report"),
    row("skew_correction", Converted, "axes that are not square", "[skew correction]"),
    row("(common) spi", Needless, "the Prime has its own buses", "[temperature control] spi_channel"),
    row("(common) i2c", Refused, "Velvet uses no I2C", "nothing"),
];

/// Sections that Klipper knows but its reference does not head.
const OTHERS: &[Row] = &[
    row("display_status", Needless, "M73 and M117 are always there", "M73, M117"),
    row("dac084S085", Needless, "the board's drivers have no potentiometers", "[current control]"),
    row("static_pwm_clock", Needless, "a clock for another board's drivers", "nothing"),
    row("gcode_arcs", Needless, "G2 and G3 are always there, and exact", "nothing"),
    row("print_stats", Needless, "always there", "progress"),
    row("query_adc", Needless, "always there", "adc"),
    row("bus_switch", Refused, "Velvet has no such chip", "nothing"),
];

/// Sections that programs beside Klipper have added: beginning of the kind, what it belongs to.
const THIRD_PARTY: &[(&str, &str)] = &[
    ("gcode_shell_command", "runs programs of a Linux computer"),
    ("led_effect", "Klipper LED effect"),
    ("z_calibration", "Klipper automatic Z calibration"),
    ("beacon", "Beacon's scanner"),
    ("scanner", "Cartographer's or IDM's scanner"),
    ("cartographer", "Cartographer's scanner"),
    ("idm", "IDM's scanner"),
    ("shaketune", "Shake&Tune"),
    ("autotune_tmc", "Klipper TMC autotune"),
    ("motor_constants", "Klipper TMC autotune"),
    ("mmu", "Happy Hare"),
    ("ercf", "Enraged Rabbit"),
    ("afc", "AFC's filament changer"),
    ("ratos", "RatOS"),
    ("tool", "Klipper toolchanger"),
    ("toolchanger", "Klipper toolchanger"),
    ("timelapse", "Moonraker's timelapse"),
    ("update_manager", "Moonraker, not Klipper"),
    ("server", "Moonraker, not Klipper"),
    ("authorization", "Moonraker, not Klipper"),
    ("octoprint_compat", "Moonraker, not Klipper"),
    ("power", "Moonraker, not Klipper"),
    ("webcam", "Moonraker or crowsnest, not Klipper"),
    ("cam", "crowsnest, not Klipper"),
    ("crowsnest", "crowsnest, not Klipper"),
    ("nevermore", "Nevermore's filter"),
    ("frame_expansion_compensation", "an older frame compensation"),
    ("gcode_macro_break", "Klipper macro extras"),
    ("danger_options", "Kalico"),
    ("constants", "Kalico"),
    ("dockable_probe", "Kalico"),
    ("prtouch", "Creality's probe"),
    ("fan_feedback", "Creality"),
    ("auto_addr", "Creality"),
    ("filter", "Creality"),
    ("io_remap", "Creality"),
    ("motor_control", "Creality"),
    ("box", "Creality"),
    ("custom_macro", "Creality"),
    ("hx711s", "Creality's load cell"),
    ("dirzctl", "Creality"),
    ("bl24c16f", "Creality"),
    ("belt_mdl", "Creality"),
    ("accel_chip_proxy", "Creality"),
    ("resonance_tester_q", "another maker"),
    ("ktcc", "Klipper tool changer code"),
    ("ktc", "Klipper tool changer code"),
    ("telegram", "a Telegram bot"),
    ("plr", "a power loss recovery of another maker"),
];

/// Returns the row of a section by its name.
pub fn find(name: &str) -> Option<&'static Row> {
    let mut words = name.split_whitespace();
    let kind = words.next()?;
    let has_label = words.next().is_some();
    let plain = kind.trim_end_matches(|c: char| c.is_ascii_digit());
    let kind = match kind {
        _ if kind.starts_with("stepper_") && kind != "stepper_bed" => "stepper_<name>",
        _ if plain == "extruder" && plain != kind => "extruder<N>",
        _ => kind,
    };
    // `[display]` and `[display left]` are two rows: the one that fits better counts.
    let all = || SECTIONS.iter().chain(OTHERS).filter(|row| row.kind() == kind);
    all().find(|row| row.name.contains(' ') == has_label).or_else(|| all().next())
}

/// Returns what a section of none of Klipper's belongs to.
pub fn third_party(name: &str) -> Option<&'static str> {
    let kind = name.split_whitespace().next()?.to_lowercase();
    let fits = |known: &str| kind == known || kind.strip_prefix(known).is_some_and(|rest| rest.starts_with('_'));
    THIRD_PARTY.iter().find(|(known, _)| fits(known)).map(|(_, what)| *what)
}

/// Returns the verdict on a section that Klipper does not have.
pub fn unknown(name: &str) -> Verdict {
    match third_party(name) {
        Some(what) => Verdict::refused(format!("not Klipper's own ({what}): a third-party section"), "nothing"),
        None => Verdict::refused("not in Klipper's reference: a third-party section, or a misspelt name", "nothing"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::fmt::Write as _;

    const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/klipper.md");
    const BEGIN: &str = "| section | becomes | how, or why not | in Velvet |\n";

    fn fate(row: &Row) -> &'static str {
        match row.fate {
            Fate::Converted => "converted",
            Fate::Kept => "kept in printer.cfg",
            Fate::Needless => "needless",
            Fate::Refused => "refused",
        }
    }

    fn table() -> String {
        let mut out = String::from(BEGIN);
        out += "|---|---|---|---|\n";
        for row in SECTIONS {
            let mark = if row.edition == Edition::English { " *" } else { "" };
            let _ = writeln!(out, "| `{}`{mark} | {} | {} | {} |", row.name, fate(row), row.why, row.nearest);
        }
        out
    }

    /// `WRITE_KLIPPER=1` writes it.
    #[test]
    fn the_page_has_the_table_of_sections() {
        let page = std::fs::read_to_string(PAGE).expect("docs/klipper.md");
        let from = page.find(BEGIN).expect("the table's head");
        let rest = &page[from..];
        let to = from + rest.find("\n\n").map_or(rest.len(), |end| end + 1);
        if std::env::var_os("WRITE_KLIPPER").is_some() {
            std::fs::write(PAGE, format!("{}{}{}", &page[..from], table(), &page[to..])).expect("written");
        } else {
            assert_eq!(&page[from..to], table(), "WRITE_KLIPPER=1 cargo test -p host the_page_has writes it");
        }
    }

    #[test]
    fn every_section_of_the_reference_has_one_row() {
        let names: BTreeSet<&str> = SECTIONS.iter().map(|row| row.name).collect();
        assert_eq!((names.len(), SECTIONS.len()), (127, 127));
        assert!(SECTIONS.iter().all(|row| !row.why.is_empty() && !row.nearest.is_empty()));
    }

    #[test]
    fn a_section_is_found_by_its_kind_and_label() {
        for (name, row) in [
            ("stepper_x", "stepper_<name>"),
            ("stepper_z2", "stepper_<name>"),
            ("stepper_bed", "stepper_bed"),
            ("extruder", "extruder"),
            ("extruder1", "extruder<N>"),
            ("extruder_stepper e", "extruder_stepper <name>"),
            ("display", "display"),
            ("display left", "display <name>"),
            ("board_pins", "board_pins <name>"),
            ("mcu", "mcu"),
            ("mcu rpi", "mcu <name>"),
            ("dual_carriage", "dual_carriage"),
            ("dual_carriage u", "dual_carriage <name>"),
            ("adxl345", "adxl345 [<name>]"),
            ("adxl345 hotend", "adxl345 [<name>]"),
        ] {
            assert_eq!(find(name).map(|row| row.name), Some(row), "{name}");
        }
        assert!(find("gcode_shell_command x").is_none());
    }

    #[test]
    fn sections_of_others_are_called_so() {
        for (name, says) in [
            ("gcode_shell_command backup", "Linux"),
            ("mmu_servo", "Happy Hare"),
            ("led_effect panel", "LED effect"),
            ("flux_capacitor", "misspelt"),
        ] {
            let verdict = unknown(name);
            assert!(verdict.reason.contains("third-party") && verdict.reason.contains(says), "{}", verdict.reason);
        }
    }
}

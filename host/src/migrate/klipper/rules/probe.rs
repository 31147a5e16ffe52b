//! Rules of probes: `[probe]`, `[bltouch]` and their kin.

use super::super::account::{Class, Verdict};
use super::super::migration::{Migration, text};
use super::super::source::truth;
use super::outputs;
use super::table::{Change, NUMBER, Rule, apply, template};

const PROBE: &str = "zprobe";
const CONNECTOR: (&str, &str) = ("PB10", "connector probe");
/// Pulses of a BLTouch, us: pin down, pin up, touch switch mode.
const PIN_DOWN: u32 = 650;
const PIN_UP: u32 = 1475;
const TOUCH_MODE: u32 = 1165;
/// Time that the pin of a BLTouch takes, s.
const PIN_TIME: f64 = 0.68;
const STAYS_OUT: &str = "it stays out until a command that probes has ended";

const ROWS: &[(&str, Rule)] = &[
    ("speed", Rule::To(PROBE, "slow_feedrate", NUMBER)),
    ("lift_speed", Rule::To(PROBE, "return_feedrate", NUMBER)),
    ("samples", Rule::To(PROBE, "samples", Change::Whole(1.0))),
    ("samples_result", Rule::To(PROBE, "samples_result", Change::Word)),
    ("samples_tolerance", Rule::To(PROBE, "samples_tolerance", NUMBER)),
    ("samples_tolerance_retries", Rule::To(PROBE, "samples_retries", Change::Whole(1.0))),
    ("sample_retract_dist", Rule::To(PROBE, "samples_retract", NUMBER)),
    ("activate_gcode", Rule::Refused("the pin of the BLTouch has this line", "[zprobe] deploy_gcode")),
    ("deactivate_gcode", Rule::Refused("the pin of the BLTouch has this line", "[zprobe] stow_gcode")),
    ("deactivate_on_each_sample", Rule::Only("false", STAYS_OUT, "[zprobe] stow_gcode")),
    ("stow_on_each_sample", Rule::Only("false", STAYS_OUT, "[zprobe] stow_gcode")),
    ("pin_up_reports_not_triggered", Rule::Refused("it is not asked whether the pin is up", "[zprobe] deployed_pin")),
    ("pin_up_touch_mode_reports_triggered", Rule::Refused("it is not asked", "[zprobe] stowed_reads_triggered")),
    ("set_output_mode", Rule::Refused("the mode in the probe's memory stays as it is", "M280 of its servo output")),
    ("probe_accel", Rule::Refused("Z moves as it does elsewhere", "[actuator] gamma.acceleration")),
    ("recovery_time", Rule::To(PROBE, "dwell_before_probing", NUMBER)),
];

/// Converts `[probe]` and `[smart_effector]`.
pub fn probe(m: &mut Migration<'_>, section: usize) {
    input(m, section, "pin");
    m.refuse(section, "control_pin", "the sensitivity in the effector's memory stays as it is", "nothing");
    common(m, section);
}

/// Converts `[bltouch]`: a servo's output, and the scripts that put its pin out and away.
pub fn bltouch(m: &mut Migration<'_>, section: usize) {
    input(m, section, "sensor_pin");
    let name = "bltouch";
    if outputs::timer(m, section, "control_pin", name, "control of the BLTouch") {
        m.write(("switch", name, "input_on_command"), "M280", "");
        m.write(("switch", name, "servo_max_angle"), "180", "S of M280 is an angle, or above it a width in us");
        m.write(("switch", name, "servo_min_us"), "544", "us");
        m.write(("switch", name, "servo_max_us"), "2400", "us");
        scripts(m, section);
    }
    common(m, section);
}

fn scripts(m: &mut Migration<'_>, section: usize) {
    let seconds = m.number(section, "pin_move_time").unwrap_or(PIN_TIME);
    let wait = text((seconds * 1000.0).round());
    let is_touch = m.section(section).get("probe_with_touch_mode").and_then(truth) == Some(true);
    let down = match is_touch {
        true => format!("M280 S{PIN_DOWN} G4 P{wait} M280 S{TOUCH_MODE} G4 P100"),
        false => format!("M280 S{PIN_DOWN} G4 P{wait}"),
    };
    m.put(section, "pin_move_time", (PROBE, "", "deploy_gcode"), down.clone());
    m.put(section, "pin_move_time", (PROBE, "", "stow_gcode"), format!("M280 S{PIN_UP} G4 P{wait}"));
    let becomes = format!("[zprobe] deploy_gcode = {down}");
    m.merged(section, "probe_with_touch_mode", "", &becomes);
}

/// Writes the lines for templates around each touch, once for all touches of a command.
fn templates(m: &mut Migration<'_>, section: usize) {
    const LINES: [(&str, &str); 2] = [("activate_gcode", "deploy_gcode"), ("deactivate_gcode", "stow_gcode")];
    let written = LINES.map(|(option, key)| template(m, section, option, (PROBE, "", key)));
    if written.contains(&true) {
        for ((_, key), _) in LINES.into_iter().zip(written).filter(|(_, is_written)| !is_written) {
            m.write((PROBE, "", key), "G4 P0", "deploy_gcode and stow_gcode come together");
        }
    }
}

fn input(m: &mut Migration<'_>, section: usize, option: &str) {
    let Some(pin) = m.pin(section, option) else { return };
    let old = m.section(section).get(option).unwrap_or("").to_owned();
    if pin.is_virtual() {
        return m.refuse(section, option, "a probe of its own wants an input", "[zprobe] probe_pin");
    }
    let (connector, label) = CONNECTOR;
    let written = format!("{connector}^{}", if pin.is_inverted { "!" } else { "" });
    m.put(section, option, (PROBE, "", "probe_pin"), written);
    m.wiring.note("probe", &old, connector, label, "");
    m.wiring.reserve(connector);
}

fn common(m: &mut Migration<'_>, section: usize) {
    if m.written((PROBE, "", "probe_pin")).is_none() {
        return m.judge_rest(section, &Verdict::refused("a probe wants an input", "[zprobe] probe_pin"));
    }
    m.write((PROBE, "", "enable"), "true", format!("of [{}]", m.section(section).name));
    let offsets = ["x_offset", "y_offset", "z_offset"];
    let values = offsets.map(|option| m.number(section, option).unwrap_or(0.0));
    let value = values.map(text).join(",");
    let first = offsets.into_iter().find(|option| m.section(section).get(option).is_some());
    m.put(section, first.unwrap_or("z_offset"), (PROBE, "", "probe_offsets"), value.clone());
    let becomes = format!("[zprobe] probe_offsets = {value}");
    for option in offsets.into_iter().filter(|option| Some(*option) != first) {
        m.merged(section, option, "", &becomes);
    }
    if m.written((PROBE, "", "deploy_gcode")).is_none() {
        templates(m, section);
    }
    apply(m, section, "", ROWS);
    for (option, key, value) in [("speed", "slow_feedrate", "5"), ("samples_tolerance_retries", "samples_retries", "0")]
    {
        if m.section(section).get(option).is_none() {
            m.put(section, option, (PROBE, "", key), value);
        }
    }
    m.judge_section(section, Verdict::new(Class::Converted, "the board's probe"));
}

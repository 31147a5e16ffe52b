//! Outputs, servos, lights, buttons.

use super::super::account::{Class, Verdict};
use super::super::migration::{Migration, instance, text};
use super::super::source::truth;
use super::super::wiring::Role;
use super::table::{Change, NUMBER, Rule, apply, template};

const SWITCH: &str = "switch";
const STRIP: &str = "led strip";
/// Longest period of an output's pulses that is as often as can be, s.
const FAST: f64 = 0.2;

/// Gives an option's pin an output of the board; returns whether there was one.
pub fn load(m: &mut Migration<'_>, section: usize, option: &str, name: &str, what: &str) -> bool {
    let Some((place, _)) = m.place(section, option, Role::Load, what) else {
        let why = "it has no output";
        m.judge_rest(section, &Verdict::refused(why, "[switch] output_pin"));
        return false;
    };
    m.write((SWITCH, name, "enable"), "true", format!("of [{}]", m.section(section).name));
    m.put(section, option, (SWITCH, name, "output_pin"), place.pin);
    m.write((SWITCH, name, "output_type"), "sigmadeltapwm", "");
    true
}

/// Gives an output that no code turns on a number, by which M62 to M68 know it.
pub fn number_it(m: &mut Migration<'_>, name: &str) {
    let known = m.entries.iter().filter(|entry| (entry.section, &*entry.key) == (SWITCH, "io_number")).count();
    m.write((SWITCH, name, "io_number"), known.to_string(), "P of M62 to M68; SET_PIN has its name");
}

/// Writes the period of pulses where it is that of a relay.
pub fn cycle(m: &mut Migration<'_>, section: usize, name: &str) {
    match m.number(section, "cycle_time") {
        Some(seconds) if seconds >= FAST => {
            m.put(section, "cycle_time", (SWITCH, name, "cycle_time"), text(seconds));
        }
        _ => m.needless(section, "cycle_time", "the output is switched as often as can be"),
    }
}

/// Converts `[output_pin NAME]`, `[pwm_tool NAME]` and `[pwm_cycle_time NAME]`.
pub fn pin(m: &mut Migration<'_>, section: usize) {
    let name = m.fresh(&["switch", "led strip", "button box"], &m.section(section).label());
    if !load(m, section, "pin", &name, "output") {
        return;
    }
    number_it(m, &name);
    let is_pwm =
        m.section(section).kind() != "output_pin" || m.section(section).get("pwm").and_then(truth) == Some(true);
    let kind = if is_pwm { "sigmadeltapwm" } else { "digital" };
    m.put(section, "pwm", (SWITCH, &name, "output_type"), kind);
    if is_pwm {
        cycle(m, section, &name);
    } else {
        m.needless(section, "cycle_time", "an output without PWM has no period");
    }
    let scale = m.number(section, "scale").unwrap_or(1.0);
    value(m, section, &name, "value", scale, is_pwm);
    value(m, section, &name, "static_value", scale, is_pwm);
    if let Some(shut) = m.number(section, "shutdown_value") {
        m.put(section, "shutdown_value", (SWITCH, &name, "halt_set_to"), (shut > 0.0).to_string());
    }
    let rows: &[(&str, Rule)] = &[
        ("hardware_pwm", Rule::Needless("MOSFETs of the board have no timer; PWM1 and PWM2 on the headers do")),
        ("scale", Rule::Refused("SET_PIN's VALUE is from 0 to 1", "SET_PIN VALUE=0.5, M106-like codes of 255")),
        ("maximum_mcu_duration", Rule::Needless("no line to a host can break")),
    ];
    if scale == 1.0 {
        m.merged(section, "scale", "Velvet counts from 0 to 1 too", "");
    }
    apply(m, section, &name, rows);
    m.judge_section(section, Verdict::new(Class::Converted, "an output of [switch], which SET_PIN sets"));
}

/// Writes the state at start.
fn value(m: &mut Migration<'_>, section: usize, name: &str, option: &str, scale: f64, is_pwm: bool) {
    let Some(value) = m.number(section, option) else { return };
    let share = if scale > 0.0 { value / scale } else { value };
    m.put(section, option, (SWITCH, name, "startup_state"), (share > 0.0).to_string());
    if is_pwm && share > 0.0 && share < 1.0 {
        m.put(section, option, (SWITCH, name, "startup_value"), text((share * 255.0).round()));
    }
}

/// Converts `[servo NAME]`.
pub fn servo(m: &mut Migration<'_>, section: usize) {
    let name = m.fresh(&["switch", "led strip", "button box"], &m.section(section).label());
    if !timer(m, section, "pin", &name, "servo") {
        return m.judge_rest(section, &Verdict::refused("it has no output", "[switch] output_pin"));
    }
    number_it(m, &name);
    let rows: &[(&str, Rule)] = &[
        ("minimum_pulse_width", Rule::To(SWITCH, "servo_min_us", Change::Times(1e6))),
        ("maximum_pulse_width", Rule::To(SWITCH, "servo_max_us", Change::Times(1e6))),
        (
            "initial_angle",
            Rule::Refused("a servo stands still until it is told where to turn", "[player] on_boot_gcode"),
        ),
        ("initial_pulse_width", Rule::Refused("a servo stands still until it is told", "[player] on_boot_gcode")),
    ];
    let angle = m.number(section, "maximum_servo_angle").unwrap_or(180.0);
    m.put(section, "maximum_servo_angle", (SWITCH, &name, "servo_max_angle"), text(angle));
    apply(m, section, &name, rows);
    m.judge_section(section, Verdict::new(Class::Converted, "an output on a timer"));
}

/// Gives an option's pin a timer's output at 50 Hz; returns whether there was one.
pub fn timer(m: &mut Migration<'_>, section: usize, option: &str, name: &str, what: &str) -> bool {
    let Some((place, _)) = m.place(section, option, Role::Servo, what) else { return false };
    m.write(("pwm1", "", "frequency"), "50", "Hz, for servos");
    m.write((SWITCH, name, "enable"), "true", format!("of [{}]", m.section(section).name));
    m.put(section, option, (SWITCH, name, "output_pin"), place.pin);
    m.write((SWITCH, name, "output_type"), "hwpwm", "");
    true
}

/// Converts `[neopixel NAME]`.
pub fn strip(m: &mut Migration<'_>, section: usize) {
    let name = m.fresh(&["switch", "led strip", "button box"], &m.section(section).label());
    let Some((place, _)) = m.place(section, "pin", Role::Strip, "strip of lights") else {
        return m.judge_rest(section, &Verdict::refused("four strips at most", "[led strip]"));
    };
    m.write((STRIP, &name, "enable"), "true", format!("of [{}]", m.section(section).name));
    m.put(section, "pin", (STRIP, &name, "pin"), place.pin);
    if let Some(order) = m.section(section).get("color_order") {
        let first = order.split(',').next().unwrap_or(order).trim();
        match order.contains(',') {
            true => m.refuse(section, "color_order", "all lights of a strip have one order", "[led strip] color_order"),
            false => m.put(section, "color_order", (STRIP, &name, "color_order"), first.to_uppercase()),
        }
    }
    apply(m, section, &name, &[("chain_count", Rule::To(STRIP, "chain_count", Change::Whole(1.0)))]);
    colours(m, section, &name);
    m.judge_section(section, Verdict::new(Class::Converted, "a strip that SET_LED and M150 set"));
}

fn colours(m: &mut Migration<'_>, section: usize, name: &str) {
    let is_chain = m.section(section).kind() == "neopixel";
    let has_white = m.section(section).get("color_order").is_some_and(|order| order.contains(['w', 'W']));
    if is_chain && !has_white {
        m.needless(section, "initial_white", "its chips have no white");
    }
    let rows: &[(&str, Rule)] = &[
        ("initial_red", Rule::To(STRIP, "initial_red", NUMBER)),
        ("initial_green", Rule::To(STRIP, "initial_green", NUMBER)),
        ("initial_blue", Rule::To(STRIP, "initial_blue", NUMBER)),
        ("initial_white", Rule::To(STRIP, "initial_white", NUMBER)),
    ];
    apply(m, section, name, rows);
}

/// Converts `[led NAME]`: a switch for each colour.
pub fn led(m: &mut Migration<'_>, section: usize) {
    let name = m.fresh(&["switch", "led strip", "button box"], &m.section(section).label());
    m.write((STRIP, &name, "enable"), "true", format!("of [{}]", m.section(section).name));
    for colour in ["red", "green", "blue", "white"] {
        let option = format!("{colour}_pin");
        let of_colour = instance(&format!("{name}_{colour}"));
        let Some((place, _)) = m.place(section, &option, Role::Load, &format!("{colour} light")) else { continue };
        m.write((SWITCH, &of_colour, "enable"), "true", format!("of [{}]", m.section(section).name));
        m.write((SWITCH, &of_colour, "output_pin"), place.pin, "");
        m.write((SWITCH, &of_colour, "output_type"), "sigmadeltapwm", "");
        m.put(section, &option, (STRIP, &name, &format!("{colour}_switch")), of_colour.clone());
    }
    colours(m, section, &name);
    m.needless(section, "cycle_time", "the output is switched as often as can be");
    m.needless(section, "hardware_pwm", "MOSFETs of the board have no timer");
    m.judge_section(section, Verdict::new(Class::Converted, "a light that SET_LED and M150 set"));
}

/// Converts `[gcode_button NAME]`: one line is written, other templates stay in printer.cfg.
pub fn button(m: &mut Migration<'_>, section: usize) {
    let name = m.fresh(&["switch", "led strip", "button box"], &m.section(section).label());
    if m.section(section).get("analog_range").is_some() {
        let why = "a button is on or off: an analog input tells several of them apart";
        return m.judge_rest(section, &Verdict::refused(why, "[button box]"));
    }
    let does_nothing = ["press_gcode", "release_gcode"].iter().all(|option| {
        let script = m.section(section).get(option);
        script.is_none_or(|script| script.trim().is_empty())
    });
    if does_nothing {
        return m.judge_rest(section, &Verdict::needless("the button does nothing"));
    }
    let Some((place, pin)) = m.place(section, "pin", Role::Input, "button") else {
        return m.judge_rest(section, &Verdict::refused("it has no input", "[button box]"));
    };
    let written = format!("{}^{}", place.pin, if pin.is_inverted { "!" } else { "" });
    m.put(section, "pin", ("button box", &name, "pin"), written);
    for (option, key) in [("press_gcode", "press"), ("release_gcode", "release")] {
        template(m, section, option, ("button box", &name, key));
    }
    m.needless(section, "debounce_delay", "contacts may bounce as long as the time between two looks");
    m.judge_section(section, Verdict::new(Class::Converted, "a button of [button box]"));
}

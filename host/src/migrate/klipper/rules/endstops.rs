//! Switches of axes, sensorless homing, and homing by the probe.

use super::super::account::Verdict;
use super::super::migration::{Migration, text};
use super::super::pins::Pin;
use super::super::source::{numbers, truth};
use super::super::wiring::Role;
use super::machine::kinematics;

/// Connectors: axis, towards the least position, towards the greatest.
const CONNECTORS: [(&str, [(&str, &str); 2]); 3] = [
    ("X", [("PD0", "connector X min"), ("PI3", "connector X max")]),
    ("Y", [("PI1", "connector Y min"), ("PA9", "connector Y max")]),
    ("Z", [("PI0", "connector Z min"), ("PH15", "connector Z max")]),
];
/// Way back from a switch that Klipper touches once, mm.
const LEAST_RETRACT: f64 = 2.0;
/// Section whose speeds all towers of a delta home at.
const FIRST_TOWER: &str = "stepper_a";
/// Longest way to a switch, mm: belts without an end have travels of kilometres.
const LONGEST_WAY: f64 = 10_000.0;
/// Length of a line of the configuration.
const LONGEST_LINE: usize = 96;
/// Outputs of the on-board drivers that tell a stall.
const STALLS: [(&str, &str); 3] = [("alpha", "PK4"), ("beta", "PK5"), ("gamma", "PJ15")];

/// Returns the axis that a section's switch homes.
fn axis_of(m: &Migration<'_>, section: usize, motor: &str) -> &'static str {
    match m.section(section).name.as_str() {
        "stepper_x" => "X",
        "stepper_y" => "Y",
        "stepper_z" => "Z",
        _ => match motor {
            "alpha" => "X",
            "beta" => "Y",
            _ => "Z",
        },
    }
}

fn is_delta(m: &Migration<'_>) -> bool {
    matches!(kinematics(m).as_deref(), Some("delta" | "rotary_delta"))
}

/// Returns whether an axis homes towards its greatest position, as Klipper works it out.
fn homes_to_max(m: &Migration<'_>, section: usize) -> bool {
    let of = m.section(section);
    if let Some(is_positive) = of.get("homing_positive_dir").and_then(truth) {
        return is_positive;
    }
    if is_delta(m) {
        return true;
    }
    let low = of.number("position_min").unwrap_or(0.0);
    let (Some(high), Some(stop)) = (of.number("position_max"), of.number("position_endstop")) else { return false };
    stop > low + (high - low) / 4.0
}

/// Converts the switch and the travel of an axis.
pub fn of_axis(m: &mut Migration<'_>, section: usize, motor: &'static str) {
    let axis = axis_of(m, section, motor);
    travel(m, section, axis);
    let Some(pin) = m.pin(section, "endstop_pin") else { return };
    let to_max = homes_to_max(m, section);
    let name = format!("{}{}", if to_max { "max" } else { "min" }, axis.to_lowercase());
    if pin.is_virtual() && (pin.mcu == "probe" || pin.mcu.starts_with("bltouch")) {
        return by_probe(m, section);
    }
    if pin.is_virtual() {
        if !by_stall(m, section, motor, &name) {
            return;
        }
    } else {
        switch(m, section, axis, &pin, &name, to_max);
    }
    m.write(("endstops", &name, "enable"), "true", "");
    m.write(("endstops", &name, "axis"), axis, format!("of [{}]", m.section(section).name));
    homing(m, section, &name, to_max);
}

fn switch(m: &mut Migration<'_>, section: usize, axis: &str, pin: &Pin, name: &str, to_max: bool) {
    let found = CONNECTORS.iter().find(|(letter, _)| *letter == axis);
    let Some((_, ends)) = found else { return };
    let (connector, label) = ends[usize::from(to_max)];
    let who = m.section(section).name.clone();
    let old = m.section(section).get("endstop_pin").unwrap_or("").to_owned();
    // Inputs of the board are held up whatever the old board did.
    let written = format!("{connector}^{}", if pin.is_inverted { "!" } else { "" });
    m.put(section, "endstop_pin", ("endstops", name, "pin"), written);
    m.wiring.reserve(connector);
    let remark = if pin.is_pulled_down { "the board pulls the input up: the sensor has to pull it down" } else { "" };
    m.wiring.note(format!("switch of [{who}]"), &old, connector, label, remark);
}

/// Writes how an axis homes on its switch.
fn homing(m: &mut Migration<'_>, section: usize, name: &str, to_max: bool) {
    let direction = if to_max { "home_to_max" } else { "home_to_min" };
    m.put(section, "homing_positive_dir", ("endstops", name, "homing_direction"), direction);
    if let Some(position) = m.number(section, "position_endstop") {
        m.put(section, "position_endstop", ("endstops", name, "homing_position"), text(position));
        let of = m.section(section);
        let low = of.number("position_min").unwrap_or(0.0);
        let way = match (of.number("position_max"), to_max) {
            (_, true) => position - low,
            (Some(high), false) => high - position,
            (None, false) => 0.0,
        };
        longest_way(m, name, way);
    }
    if is_delta(m) && m.section(section).name != FIRST_TOWER {
        return as_first(m, section, name);
    }
    let fast = m.number(section, "homing_speed").unwrap_or(5.0);
    m.put(section, "homing_speed", ("endstops", name, "fast_rate"), text(fast));
    let retract = m.number(section, "homing_retract_dist").unwrap_or(5.0);
    if m.written(("endstops", name, "stall_homing")).is_some() {
        m.needless(section, "second_homing_speed", "both approaches to a stall are as fast");
        // The second approach has to be at its speed before a stall can be told.
        let least = run_up(m, section, fast);
        m.put(section, "homing_retract_dist", ("endstops", name, "retract"), text(retract.max(least)));
    } else {
        let slow = m.number(section, "second_homing_speed").unwrap_or(fast / 2.0);
        m.put(section, "second_homing_speed", ("endstops", name, "slow_rate"), text(slow));
        retreat(m, section, name, retract);
    }
    m.refuse(section, "homing_retract_speed", "Velvet backs off at slow_rate", "[endstops] slow_rate");
}

/// Writes how far an axis backs off; one that Klipper lets touch once is touched twice.
fn retreat(m: &mut Migration<'_>, section: usize, name: &str, retract: f64) {
    let (way, reason) = match retract > 0.0 {
        true => (retract, ""),
        false => (LEAST_RETRACT, "Velvet approaches a switch twice, the second time slowly"),
    };
    m.put_for(section, "homing_retract_dist", ("endstops", name, "retract"), text(way), reason);
}

/// Writes the longest homing move for a travel.
fn longest_way(m: &mut Migration<'_>, name: &str, way: f64) {
    if way > 0.0 {
        let comment = "mm; half as much again as the travel, as Klipper does";
        // Sums of decimal fractions have a tail of digits that nobody measures.
        let most = (way * 1.5 * 1e3).round() / 1e3;
        m.write(("endstops", name, "max_travel"), text(most.min(LONGEST_WAY)), comment);
    }
}

/// Writes how a further tower homes: with the first, at its speeds.
fn as_first(m: &mut Migration<'_>, section: usize, name: &str) {
    let Some(first) = m.source.section(FIRST_TOWER) else { return };
    let speed = first.number("homing_speed").unwrap_or(5.0);
    let slow = first.number("second_homing_speed").unwrap_or(speed / 2.0);
    let retract = first.number("homing_retract_dist").filter(|way| *way > 0.0);
    let missing = if first.get("homing_retract_dist").is_some() { LEAST_RETRACT } else { 5.0 };
    let retract = retract.unwrap_or(missing);
    let comment = format!("as [{FIRST_TOWER}]: all towers home together");
    for (key, value) in [("fast_rate", speed), ("slow_rate", slow), ("retract", retract)] {
        m.write(("endstops", name, key), text(value), comment.clone());
    }
    if let Some(height) = first.number("position_endstop") {
        longest_way(m, name, height);
    }
    for option in ["homing_speed", "second_homing_speed", "homing_retract_dist", "homing_retract_speed"] {
        m.needless(section, option, "all towers home together, at the speeds of the first");
    }
}

/// Returns the way that a motor needs to be at its speed and tell a stall, mm.
fn run_up(m: &Migration<'_>, section: usize, speed: f64) -> f64 {
    let printer = m.source.section("printer");
    let accel = |option| printer.and_then(|of| of.number(option));
    let is_z = m.section(section).name == "stepper_z";
    let accel = is_z.then(|| accel("max_z_accel")).flatten().or(accel("max_accel")).unwrap_or(1000.0);
    let of = m.section(section);
    let full = of.number("full_steps_per_rotation").unwrap_or(200.0) / of.number("rotation_distance").unwrap_or(40.0);
    let way = config::EndstopStallConfig::run_up(speed, accel, None, full);
    (way * 10.0 + 1.0).ceil() / 10.0
}

/// Writes the ends of an axis' travel; where the file has none, what Klipper takes.
fn travel(m: &mut Migration<'_>, section: usize, axis: &str) {
    if is_delta(m) || kinematics(m).as_deref() == Some("winch") {
        return;
    }
    let keys = [("position_min", "min"), ("position_max", "max")].map(|(option, end)| {
        let key = format!("{}_{end}", axis.to_lowercase());
        (option, key)
    });
    for (option, key) in keys {
        match m.number(section, option) {
            Some(value) => m.put(section, option, ("soft endstop", "", &key), text(value)),
            None if option == "position_min" && m.section(section).get("position_max").is_some() => {
                m.put(section, option, ("soft endstop", "", &key), "0");
            }
            None => {}
        }
    }
}

/// Converts sensorless homing; returns whether it could be.
fn by_stall(m: &mut Migration<'_>, section: usize, motor: &'static str, name: &str) -> bool {
    let output = STALLS.iter().find(|(of, _)| *of == motor).map(|(_, pin)| *pin);
    let is_alone = kinematics(m).as_deref() == Some("cartesian");
    let (Some(pin), true) = (output, is_alone) else {
        let why = "the motor moves more than one axis, so its stall is that of none";
        let rest = Verdict::refused(why, "a switch, in [endstops]");
        for option in ["endstop_pin", "position_endstop", "homing_speed", "homing_retract_dist", "second_homing_speed"]
        {
            m.judge(section, option, rest.clone());
        }
        m.judge(section, "homing_positive_dir", rest);
        m.ask(format!("[{}] homes without a switch: {why}; give it a switch", m.section(section).name));
        return false;
    };
    m.put(section, "endstop_pin", ("endstops", name, "pin"), pin);
    m.write(("endstops", name, "stall_homing"), "true", "homes without a switch");
    m.ask(format!(
        "[endstops] {name}.stall_threshold: find it anew (docs/drivers.md); the old driver's figure has another meaning"
    ));
    true
}

/// Notes that Z homes by the probe: [`finish`] writes the line.
fn by_probe(m: &mut Migration<'_>, section: usize) {
    let probes = ["probe", "bltouch", "smart_effector"];
    if !probes.iter().any(|name| m.find(name).is_some()) {
        m.refuse(section, "endstop_pin", "Velvet has nothing like the probe that Z homes by", "[zprobe], [endstops]");
        m.ask("Z homes by a probe that Velvet does not have: give it a switch in [endstops]");
    }
    m.merged(
        section,
        "endstop_pin",
        "Z homes by the probe: a line does it with G30",
        "[endstops] common.home_gcode, or home_z_gcode with [homing_override]",
    );
    for option in ["homing_speed", "second_homing_speed", "homing_retract_dist"] {
        m.needless(section, option, "the probe searches as [zprobe] says");
    }
    m.needless(section, "position_endstop", "the probe's offset says where Z is");
    m.needless(section, "homing_positive_dir", "the probe searches down");
    m.needless(section, "homing_retract_speed", "[zprobe] says how fast the probe rises");
}

/// Converts the switch of a motor that copies another one.
pub fn of_slave(m: &mut Migration<'_>, section: usize, motor: &'static str) {
    let axis = match motor {
        "delta" => "A",
        "epsilon" => "B",
        _ => "C",
    };
    if m.pin(section, "endstop_pin").is_some_and(|pin| pin.is_virtual()) {
        return m.refuse(section, "endstop_pin", "a motor that copies another homes with it", "G34 (docs/leveling.md)");
    }
    let Some((place, pin)) = m.place(section, "endstop_pin", Role::Input, "switch") else { return };
    let name = format!("own{}", axis.to_lowercase());
    let written = format!("{}^{}", place.pin, if pin.is_inverted { "!" } else { "" });
    m.put(section, "endstop_pin", ("endstops", &name, "pin"), written);
    m.write(("endstops", &name, "enable"), "true", "G28.7 looks at it (docs/leveling.md)");
    m.write(("endstops", &name, "axis"), axis, "a slave's own switch has the letter of its motor");
}

/// Returns the section whose axis homes by the probe.
fn homed_by_probe(m: &Migration<'_>) -> bool {
    let z = m.find("stepper_z").and_then(|section| m.pin(section, "endstop_pin"));
    z.is_some_and(|pin| pin.is_virtual() && pin.mcu == "probe")
}

/// Writes what axes have in common: their order, and how Z homes by the probe.
pub fn finish(m: &mut Migration<'_>) {
    let homes = |axis: &str| m.entries.iter().any(|e| (e.section, &*e.key, &*e.value) == ("endstops", "axis", axis));
    if !is_delta(m) && homes("X") && homes("Y") {
        m.write(("endstops", "common", "homing_order"), "XYZ", "one after another, as Klipper does");
    }
    by_line(m);
}

/// Writes the line that homes Z by the probe, and the place where it does.
fn by_line(m: &mut Migration<'_>) {
    if !homed_by_probe(m) || m.written(("zprobe", "", "enable")).is_none() {
        return;
    }
    let safe = m.source.section("safe_z_home");
    let place = safe.and_then(|safe| numbers(safe.get("home_xy_position")?));
    let speed = safe.and_then(|safe| safe.number("speed")).unwrap_or(50.0) * 60.0;
    let hop = safe.and_then(|safe| safe.number("z_hop")).filter(|hop| *hop > 0.0);
    let hop_speed = safe.and_then(|safe| safe.number("z_hop_speed")).unwrap_or(15.0) * 60.0;
    let height = ["probe", "bltouch"].iter().find_map(|name| m.source.section(name)?.number("z_offset"));
    // With a template that stands for G28 only Z homes by the line: the template moves the others.
    let is_kept = m.find("homing_override").is_some();
    let key = if is_kept { "home_z_gcode" } else { "home_gcode" };
    // Nobody knows how high the tool is, and X and Y must not drag it over the bed.
    let mut line = hop.map_or_else(String::new, |hop| format!("G91 G0 Z{} F{} G90 ", text(hop), text(hop_speed)));
    if is_kept {
        line.clear();
    } else {
        line += "G28 X Y ";
    }
    if let Some([x, y]) = place.as_deref() {
        line += &format!("G53 G0 X{} Y{} F{} ", text(*x), text(*y), text(speed));
    }
    // The tool stays at the contact until the machine knows how high it is there.
    line += "G30 L G28.3 P1";
    let lift = hop.unwrap_or(5.0).max(height.unwrap_or(0.0));
    line += &format!(" G0 Z{}", text(lift));
    if m.written(("zprobe", "", "deploy_gcode")).is_some() {
        line += " M402";
    }
    m.write(("endstops", "common", key), line.replace(' ', "_"), "Z homes by the probe");
    m.write(("cartesian grid leveling strategy", "", "do_home"), "false", format!("{key} homes"));
    if line.len() > LONGEST_LINE {
        m.ask(format!("[endstops] common.{key}: the line is longer than {LONGEST_LINE}: shorten its numbers"));
    }
    m.ask("Z homes by the probe: try G28 with a hand at the kill button, and compare [zprobe] probe_offsets");
}

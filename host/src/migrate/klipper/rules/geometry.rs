//! Options of motors that belong to the geometry of their kinematics.

use super::super::migration::{Migration, text};
use super::machine::kinematics;

/// Angles of a delta's towers, degrees.
const TOWER_ANGLES: [f64; 3] = [210.0, 330.0, 90.0];
const TOWERS: [&str; 3] = ["stepper_a", "stepper_b", "stepper_c"];

/// Converts lengths, angles and anchors of a motor's section.
pub fn stepper(m: &mut Migration<'_>, section: usize, motor: &'static str) {
    match kinematics(m).as_deref() {
        Some("delta") => tower(m, section),
        Some("rotary_delta") => arm(m, section),
        Some("deltesian") => deltesian(m, section, motor),
        Some("winch") => winch(m, section, motor),
        _ => {}
    }
}

fn of_first(m: &Migration<'_>, option: &str) -> Option<f64> {
    m.source.section(TOWERS[0])?.number(option)
}

fn tower(m: &mut Migration<'_>, section: usize) {
    let Some(number) = TOWERS.iter().position(|name| *name == m.section(section).name) else { return };
    let first = of_first(m, "arm_length");
    match (m.number(section, "arm_length"), first) {
        (Some(length), _) if number == 0 => {
            m.put(section, "arm_length", ("linear delta", "", "arm_length"), text(length));
        }
        (Some(length), Some(first)) => {
            let key = format!("delta_arm{}_offset", number + 1);
            m.put(section, "arm_length", ("linear delta", "", &key), text(length - first));
        }
        _ => {}
    }
    if let Some(angle) = m.number(section, "angle") {
        let key = format!("delta_tower{}_angle", number + 1);
        m.put(section, "angle", ("linear delta", "", &key), text(angle - TOWER_ANGLES[number]));
    }
    let (Some(height), Some(first)) = (m.section(section).number("position_endstop"), of_first(m, "position_endstop"))
    else {
        return;
    };
    let motor = ["alpha", "beta", "gamma"][number];
    if number > 0 && height != first {
        let key = format!("{motor}_trim_mm");
        // A switch that sits too low has a trim above zero.
        m.put(section, "position_endstop", ("endstops", "common", &key), text(first - height));
    }
    // The height of the machine stands with the last tower.
    m.write(("endstops", "maxz", "homing_position"), text(first), "mm, the tool with all carriages at the top");
    let top = text(first);
    m.write(("soft endstop", "", "z_max"), top, "the carriages' switches");
}

fn arm(m: &mut Migration<'_>, section: usize) {
    let first = m.section(section).name == TOWERS[0];
    for (option, key) in [("upper_arm_length", "delta_rf"), ("lower_arm_length", "delta_re")] {
        if let Some(length) = m.number(section, option) {
            match first {
                true => m.put(section, option, ("rotary delta", "", key), text(length)),
                false if of_first(m, option) == Some(length) => {
                    m.merged(section, option, "as that of the first arm", "")
                }
                false => m.refuse(section, option, "all arms are as long as the first", "[rotary delta]"),
            }
        }
    }
    if first {
        m.ask("a rotary delta: write [rotary delta] delta_e, delta_f and the offsets by hand (docs/settings.md)");
    }
}

fn deltesian(m: &mut Migration<'_>, section: usize, motor: &str) {
    let side = match motor {
        "alpha" => "left",
        "beta" => "right",
        _ => return,
    };
    for (option, key) in [("arm_length", "arm_length"), ("arm_x_length", "arm_x_length")] {
        let key = format!("{side}_{key}");
        let first = m.source.section("stepper_left").and_then(|left| left.number(option));
        if let Some(length) = m.number(section, option).or(first) {
            m.put(section, option, ("deltesian", "", &key), text(length));
        }
    }
}

fn winch(m: &mut Migration<'_>, section: usize, motor: &str) {
    let anchors = ["anchor_x", "anchor_y", "anchor_z"];
    let places = anchors.map(|option| m.number(section, option));
    let [Some(x), Some(y), Some(z)] = places else { return };
    let value = [x, y, z].map(text).join(",");
    m.put(section, anchors[0], ("winch", "", motor), value.clone());
    for option in anchors.into_iter().skip(1) {
        m.merged(section, option, "", &format!("[winch] {motor} = {value}"));
    }
}

//! The machines of the console target: the samples of the documentation, made small and fast, so that little
//! virtual time shows much.

use config::edit::{Edit, apply};

/// Machine: its name, the sample it comes from, the changed settings (`[section] key = value`).
#[derive(Clone, Copy, Debug)]
pub struct Machine {
    /// Name of the machine in `@machine`.
    pub name: &'static str,
    sample: &'static str,
    changes: &'static [&'static [&'static str]],
}

const CARTESIAN: &str = include_str!("../../../config/samples/cartesian.ini");
const COREXY: &str = include_str!("../../../config/samples/corexy.ini");
const DELTA: &str = include_str!("../../../config/samples/delta.ini");
const MILL: &str = include_str!("../../../config/samples/cnc-mill.ini");

/// Changes for a short way to the switches, and fast motion.
const SMALL: &[&str] = &[
    "[endstops] minx.max_travel = 40",
    "[endstops] miny.max_travel = 50",
    "[endstops] minz.max_travel = 30",
    "[endstops] minx.fast_rate = 80",
    "[endstops] miny.fast_rate = 80",
    "[endstops] minz.fast_rate = 60",
    "[endstops] minz.slow_rate = 10",
    "[actuator] gamma.max_rate = 6000",
    "[actuator] gamma.acceleration = 1500",
    "[motion control] z_axis_max_speed = 6000",
    "[conveyor] queue_delay_time_ms = 5",
];
/// Inputs that a person can press, and a probe.
const INPUTS: &[&str] = &[
    "[kill button] enable = true",
    "[kill button] pin = PB7^",
    "[switch] light.enable = true",
    "[switch] light.input_pin = PJ6^",
    "[switch] light.output_on_command = M106_S255",
    "[switch] light.output_off_command = M107",
    "[zprobe] enable = true",
    "[zprobe] probe_pin = PI2^",
    "[zprobe] slow_feedrate = 20",
    "[zprobe] fast_feedrate = 60",
];
/// Junction deviation of zero: no speed is kept through corners, so accelerations can be told from step
/// times.
const SHARP: &[&str] = &["[planner] junction_deviation = 0"];
/// Settings that bend a path or a speed.
const CORNERS: &[&str] = &[
    "[planner] junction_deviation = 0.05",
    "[planner] jerk = 200000",
    "[input shaper] shaper_type_x = mzv",
    "[input shaper] shaper_freq_x = 40",
    "[extruder] hotend.pressure_advance = 0.05",
    "[zprobe] leveling = cartesian grid",
    "[cartesian grid leveling strategy] x_size = 30",
    "[cartesian grid leveling strategy] y_size = 40",
    "[cartesian grid leveling strategy] grid_x_size = 4",
    "[cartesian grid leveling strategy] grid_y_size = 4",
];
const SPINDLE: &[&str] = &[
    "[pwm1] frequency = 5000",
    "[switch] spindle.output_pin = PWM1_1",
    "[switch] spindle.output_type = hwpwm",
    "[switch] spindle.startup_value = 0",
    "[endstops] minx.max_travel = 40",
    "[endstops] miny.max_travel = 50",
    "[endstops] maxz.max_travel = 30",
    "[endstops] maxz.fast_rate = 20",
    "[conveyor] queue_delay_time_ms = 5",
];

/// All machines of the target, by name.
pub const MACHINES: &[Machine] = &[
    Machine { name: "printer", sample: CARTESIAN, changes: &[SMALL, INPUTS, SHARP] },
    Machine { name: "corners", sample: CARTESIAN, changes: &[SMALL, INPUTS, CORNERS] },
    Machine { name: "mill", sample: MILL, changes: &[SPINDLE, INPUTS] },
    Machine { name: "delta", sample: DELTA, changes: &[&["[conveyor] queue_delay_time_ms = 5"]] },
    Machine { name: "corexy", sample: COREXY, changes: &[SMALL, SHARP] },
];

/// Returns the configuration of the machine of this name, or of the first one.
#[must_use]
pub fn config(name: &[u8]) -> String {
    let machine = MACHINES.iter().find(|machine| machine.name.as_bytes() == name).unwrap_or(&MACHINES[0]);
    let changes = machine.changes.iter().copied().flatten();
    changes.fold(machine.sample.to_owned(), |text, change| changed(&text, change))
}

fn changed(text: &str, change: &str) -> String {
    let parts = change.strip_prefix('[').and_then(|rest| rest.split_once("] "));
    let (section, setting) = parts.unwrap_or_else(|| panic!("no setting: {change}"));
    let (key, value) = setting.split_once(" = ").unwrap_or_else(|| panic!("no value: {change}"));
    apply(text, Edit { section, key, value: Some(value) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::config::{BoardId, Diagnostic, Severity};

    #[test]
    fn every_machine_can_be_used() {
        for machine in MACHINES {
            let mut findings: Vec<Diagnostic> = Vec::new();
            let text = config(machine.name.as_bytes());
            let _ = ::config::parse(text.as_bytes(), BoardId::Prime2590, &mut findings);
            findings.retain(|finding| finding.severity == Severity::Error);
            assert!(findings.is_empty(), "{}: {findings:#?}", machine.name);
        }
    }
}

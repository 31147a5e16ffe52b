//! Examples for the reference, a few lines for each section that people write by hand. Tests load them.

/// The lines of a section, without its header.
pub(super) fn of(section: &str) -> Option<&'static str> {
    EXAMPLES.iter().find(|(name, _)| *name == section).map(|&(_, text)| text)
}

const EXAMPLES: &[(&str, &str)] = &[
    (
        "general",
        "grbl_mode = true           # for senders that speak GRBL\nconfig-override = true     # what M500 saved counts after a reset\n",
    ),
    (
        "uart console",
        "enable = true\nchannel = 0                # header GD: receive PB11, send PD8\nbaudrate = 115200\n",
    ),
    (
        "motion control",
        "arm_solution = corexy\ndefault_feed_rate = 3000   # mm/min\nx_axis_max_speed = 18000   # mm/min\nz_axis_max_speed = 900     # mm/min\n",
    ),
    (
        "planner",
        "junction_deviation = 0.02  # mm: sharper corners are taken slower\nplanner_queue_size = 64    # short lines need more look-ahead\n",
    ),
    (
        "actuator",
        "# 200 steps x 16 microsteps / 40 mm per turn\nalpha.steps_per_mm = 80\nalpha.microsteps = 16\nalpha.max_rate = 18000     # mm/min\nalpha.dir_pin = PD4!       # ! turns it the other way\nbeta.steps_per_mm = 80\nbeta.microsteps = 16\ngamma.steps_per_mm = 400\ngamma.microsteps = 16\ngamma.max_rate = 600\n# A second Z motor that copies every step of the first\ndelta.steps_per_mm = 400\ndelta.microsteps = 16\ndelta.max_rate = 600\ndelta.slaved_to = gamma\n",
    ),
    (
        "tmc2590",
        "# On the board: nothing but the resistor is needed\nalpha.sense_resistor = 50  # mOhm\nbeta.sense_resistor = 50\nbeta.standstill_current = 500   # mA after ten seconds at rest\ngamma.sense_resistor = 50\ndelta.sense_resistor = 50\n",
    ),
    (
        "current control",
        "alpha.current = 1.2        # A, peak\nbeta.current = 1.2\ngamma.current = 1.2\ndelta.current = 1.2\n",
    ),
    (
        "temperature control",
        "bed.enable = true\nbed.thermistor_pin = ADC1_3      # connector T3\nbed.thermistor = Honeywell100K\nbed.heater_pin = PE3\nbed.bang_bang = true             # a big bed needs no PID\nbed.max_temp = 110\nbed.runaway_heating_timeout = 900\n",
    ),
    (
        "endstops",
        "minx.enable = true\nminx.pin = PD0^            # connector X min; ^ is its pull-up\nminx.axis = X\nminx.homing_direction = home_to_min\nminx.homing_position = 0   # mm\nminx.fast_rate = 50        # mm/s\nminx.slow_rate = 5\n# The other end limits travel only\nmaxx.enable = true\nmaxx.pin = PI3^\nmaxx.axis = X\nmaxx.homing_direction = none\nmaxx.limit_enable = true\n",
    ),
    (
        "switch",
        "# A fan: M106 S128 is half speed\nfan.enable = true\nfan.input_on_command = M106\nfan.input_off_command = M107\nfan.output_pin = PE1\nfan.output_type = sigmadeltapwm\n# A button that homes\nhome.enable = true\nhome.input_pin = PJ9^!\nhome.output_on_command = G28\n",
    ),
    ("voltage monitor", "vmotor = ADC3_5,11         # input and divider\nvfet = ADC3_2,11\n"),
    ("kill button", "enable = true\npin = PJ6^                 # pressed is low\n"),
    ("safety door", "enable = true\npin = PJ8^                 # the closed door pulls it low\n"),
    (
        "player",
        "on_boot_gcode = /sd/start.g\non_boot_gcode_enable = true\nafter_suspend_gcode = G91 G0 Z10\nbefore_resume_gcode = G91 G0 Z-10\n",
    ),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BoardId, Diagnostic, parse};
    use std::format;
    use std::string::String;
    use std::vec::Vec;

    /// All at once are a machine, and it has no finding.
    #[test]
    fn the_examples_together_are_a_machine_without_a_finding() {
        let text: String = EXAMPLES.iter().map(|(section, lines)| format!("[{section}]\n{lines}\n")).collect();
        let mut findings: Vec<Diagnostic> = Vec::new();
        let (config, _) = parse(text.as_bytes(), BoardId::Prime2590, &mut findings);
        assert!(findings.is_empty(), "{findings:#?}");
        assert_eq!((config.actuators().count(), config.switches.len(), config.endstops.len()), (4, 2, 2));
    }
}

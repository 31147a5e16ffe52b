//! Settings that Smoothieware v2 takes, and that an earlier checker refused, dropped or cut without a word:
//! one row each.

mod common;

use common::{SAMPLE, read};
use config::MachineConfig;
use config::edit::{Edit, apply};
use units::{Actuator, Micros};

/// Settings as `[section] key = value`, what is told of them (a part of each finding's words, in order), and
/// whether the machine has the value that it should have.
type Row = (&'static [&'static str], &'static [&'static str], fn(&MachineConfig) -> bool);

const ROWS: &[Row] = &[
    // Codes of any 16-bit number.
    (&["[switch] fan.input_on_command = M2000"], &[], |c| c.switches[0].input_on_command.unwrap().number == 2_000),
    (&["[switch] fan.input_off_command = G300"], &[], |c| {
        c.switches[0].input_off_command.unwrap() == gcode::Code::g(300)
    }),
    (&["[temperature control] bed.set_m_code = 3140"], &[], |c| c.temperatures[0].set_m_code == 3_140),
    (&["[temperature control] bed.set_and_wait_m_code = 65535"], &[], |c| {
        c.temperatures[0].set_and_wait_m_code == 65_535
    }),
    (&[RULE[0], RULE[1], RULE[2], "[temperature switch] hot.arm_mcode = 1100"], &[], |c| {
        c.temperature_switches[0].arm_mcode == Some(1_100)
    }),
    // An order that leaves an axis out is none: all are homed.
    (&["[endstops] common.homing_order = ZX"], &[], |c| c.homing.order.is_empty()),
    (&["[endstops] common.homing_order = Y"], &[], |c| c.homing.order.is_empty()),
    (&["[endstops] common.homing_order = ZXY"], &[], |c| c.homing.order.len() == 3),
    // Buttons.
    (&["[button box] one.pin = PJ1^!", "[button box] one.press = play /sd/a_part.g"], &[], |c| {
        c.buttons[0].press == "play /sd/a_part.g"
    }),
    (&["[button box] one.pin = PJ1^!", "[button box] one.release = M117 a_b"], &[], |c| {
        c.buttons[0].release == "M117 a_b"
    }),
    (&["[button box] one.pin = external", "[button box] one.press = G33 K1"], &["panels are not supported yet"], |c| {
        c.buttons[0].pin.is_none() && c.off.is_empty()
    }),
    // Numbers of heaters without one: 253 less those before it by name; `board` has 253 for its own here.
    (&AUX, &[], |c| c.temperatures.iter().any(|heater| heater.name == "aux" && heater.tool_id.0 == 252)),
    (&["[switch] fan.input_pin = nc"], &[], |c| !c.switches[0].is_input() && c.switches[0].output_pin.is_some()),
    // Fractions are cut.
    (&["[cartesian grid leveling strategy] grid_x_size = 7.6"], &["7.6 is taken as 7"], |c| {
        c.leveling.grid.count[0] == 7
    }),
    (&["[cartesian grid leveling strategy] grid_y_size = 5.9"], &["5.9 is taken as 5"], |c| {
        c.leveling.grid.count[1] == 5
    }),
    (&["[delta grid leveling strategy] size = 7.5"], &["7.5 is taken as 7"], |c| c.leveling.delta.count == 7),
    (&["[switch] fan.max_pwm = 199.9"], &["199.9 is taken as 199"], |c| c.switches[0].max_pwm.0 == 199),
    (&["[temperature control] bed.max_pwm = 127.5"], &["127.5 is taken as 127"], |c| {
        c.temperatures[0].max_pwm.0 == 127
    }),
    (&[RULE[0], RULE[1], RULE[2], "[temperature switch] hot.heatup_poll = 2.5"], &["2.5 is taken as 2"], |c| {
        c.temperature_switches[0].heatup_poll == Micros::from_seconds(2)
    }),
    (&[RULE[0], RULE[1], RULE[2], "[temperature switch] hot.cooldown_poll = 60.9"], &["60.9 is taken as 60"], |c| {
        c.temperature_switches[0].cooldown_poll == Micros::from_seconds(60)
    }),
    (&["[button box] common.poll_frequency_hz = 20.5"], &["20.5 is taken as 20"], |c| c.button_poll_hz == 20),
    (&["[actuator] alpha.microsteps = 16.5"], &["16.5 is taken as 16"], |c| {
        c.actuators[Actuator::Alpha].microsteps == 16
    }),
    // More than Velvet can do is limited.
    (&["[button box] common.poll_frequency_hz = 1000"], &["1000 is taken as 100"], |c| c.button_poll_hz == 100),
    (&["[temperature control] bed.readings_per_second = 1000"], &["1000 is taken as 100"], |c| {
        c.temperatures[0].sensor.readings_per_second == 100
    }),
    (&["[planner] planner_queue_size = 1000"], &["1000 is taken as 224"], |c| c.planner.queue_size == 224),
    (&["[system] step_pulse_us = 50"], &["50 is taken as 20"], |c| c.system.step_pulse_us == 20),
    (&["[system] step_frequency = 2000000"], &["2000000 is taken as 1000000"], |c| {
        c.system.step_frequency_hz == 1_000_000
    }),
    (&["[conveyor] queue_delay_time_ms = 90000"], &["90000 is taken as 60000"], |c| {
        c.planner.queue_delay == Micros::from_seconds(60)
    }),
    // What means nothing, or off.
    (&["[motion control] default_feed_rate = 0"], &[], |c| c.motion.default_feed_rate.0 == 0.0),
    (&["[planner] z_junction_deviation = -5"], &[], |c| c.planner.z_junction_deviation.is_none()),
    (&["[current control] alpha.current = 0"], &["the least its driver can give"], |c| {
        c.actuators[Actuator::Alpha].current.is_none() && c.off.is_empty()
    }),
    (&["[temperature control] bed.preset1 = 130"], &["130"], |c| c.temperatures[0].presets[0].0 == 130.0),
];

/// A sensor without a number of its own.
const AUX: [&str; 4] = [
    "[temperature control] aux.enable = true",
    "[temperature control] aux.sensor = thermistor",
    "[temperature control] aux.thermistor = Semitec",
    "[temperature control] aux.thermistor_pin = ADC1_2",
];

/// A rule of the hot end for the fan.
const RULE: [&str; 3] = [
    "[temperature switch] hot.enable = true",
    "[temperature switch] hot.designator = T",
    "[temperature switch] hot.switch = fan",
];

fn with(lines: &[&str]) -> String {
    lines.iter().fold(SAMPLE.to_owned(), |text, line| {
        let (section, setting) = line.strip_prefix('[').and_then(|rest| rest.split_once("] ")).expect("a section");
        let (key, value) = setting.split_once(" = ").expect("a value");
        apply(&text, Edit { section, key, value: Some(value) })
    })
}

#[test]
fn what_smoothieware_takes_is_taken_and_told_where_it_is_another_value() {
    for (lines, told, holds) in ROWS {
        let text = with(lines);
        let (config, findings) = read(&text);
        let said: Vec<String> = findings.iter().map(ToString::to_string).collect();
        assert_eq!(said.len(), told.len(), "{lines:?}: {said:#?}");
        for (said, told) in said.iter().zip(*told) {
            assert!(said.contains(told), "{lines:?}: {told} is not in {said}");
        }
        assert!(findings.iter().all(|finding| finding.severity == config::Severity::Warning), "{lines:?}: {said:#?}");
        assert!(holds(&config), "{lines:?}");
        let mut none = ();
        let (_, summary) = config::parse(text.as_bytes(), config::BoardId::Prime2590, &mut none);
        assert!(summary.is_usable() && summary.is_complete(), "{lines:?}: {summary:?}");
    }
}

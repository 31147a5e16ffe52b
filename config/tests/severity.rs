//! Severity of errors: the whole machine does not start, or only a part stays off.

mod common;

use common::{SAMPLE, edited, read};
use config::{BoardId, MachineConfig, Summary};
use proptest::prelude::*;

fn parsed(text: &str) -> (MachineConfig, Summary) {
    config::parse(text.as_bytes(), BoardId::Prime2590, &mut ())
}

fn off(config: &MachineConfig) -> Vec<String> {
    config.off.iter().map(ToString::to_string).collect()
}

/// Broken lines, and the part that each puts out of service.
const SLIPS: &[(&str, &str, &[&str])] = &[
    ("bed.max_temp = 120", "bed.max_temp = hot", &["temperature control bed"]),
    ("bed.max_temp = 120", "bed.max_tmp = 120", &["temperature control bed"]),
    ("bed.max_temp = 120", "bed.max_temp 120", &["temperature control bed"]),
    ("bed.max_temp = 120", "max_temp = 120", &["every temperature control"]),
    ("bed.enable = true", "bed.enable = yes", &["temperature control bed"]),
    ("bed.enable = true", "bed.enabel = true", &["temperature control bed"]),
    ("bed.thermistor_pin = ADC1_3", "bed.thermistor_pin = nc", &["temperature control bed"]),
    ("fan.output_pin = PE1 ", "fan.output_pin = PE3 ", &["temperature control bed", "switch fan"]),
    ("fan.output_type = sigmadeltapwm", "fan.output_type = pwm", &["switch fan"]),
    ("fan.enable = true", "fan.enable = yes", &["switch fan"]),
    ("hotend.filament_diameter = 0 ", "hotend.filament_diameter = thick ", &["extruder hotend"]),
];

#[test]
fn an_error_puts_its_own_part_out_of_service_and_no_other() {
    let (sound, _) = parsed(SAMPLE);
    for (from, to, parts) in SLIPS {
        let (config, summary) = parsed(&edited(from, to));
        assert!(summary.is_usable() && !summary.is_complete(), "{to}: {summary:?}");
        let mut found = off(&config);
        found.sort();
        let mut expected = parts.to_vec();
        expected.sort_unstable();
        assert_eq!(found, expected, "{to}");
        // A part that is off stays in its list, so that its commands can be refused with the reason.
        assert_eq!(config.temperatures.len(), sound.temperatures.len(), "{to}");
        for (heater, before) in config.temperatures.iter().zip(&sound.temperatures) {
            let is_off = config.off("temperature control", &heater.name).is_some();
            assert_eq!(heater.heater_pin, before.heater_pin.filter(|_| !is_off), "{to}: {}", heater.name);
        }
        let fan = &config.switches[0];
        assert_eq!(fan.output_pin, sound.switches[0].output_pin.filter(|_| config.off("switch", "fan").is_none()));
    }
}

#[test]
fn what_motion_and_safety_depend_on_is_fatal() {
    for (from, to) in [
        ("arm_solution = cartesian", "arm_solution = cartesain"),
        ("planner_queue_size = 32 ", "planner_queue_size = few "),
        ("alpha.step_pin = PD3", "alpha.step_pin = PL3"),
        ("minx.pin = PD0^", "minx.pin = PD0+"),
        ("[endstops]", "[endstosp]"),
        // A pin that a motor needs as well.
        ("fan.output_pin = PE1 ", "fan.output_pin = PD3 "),
    ] {
        let (_, summary) = parsed(&edited(from, to));
        assert!(!summary.is_usable(), "{to}: {summary:?}");
    }
}

#[test]
fn what_is_not_enabled_is_not_out_of_service() {
    for addition in [
        "[zprobe]\nslow_feedrate = fast\n",
        "[uart console]\nenable = false\nbaudrate = fast\n",
        "[switch]\npump.enable = false\npump.output_pin = PL1\n",
    ] {
        let (config, summary) = parsed(&format!("{SAMPLE}\n{addition}"));
        assert_eq!((summary.errors, off(&config)), (1, vec![]), "{addition}");
    }
}

#[test]
fn a_timer_takes_its_switches_with_it() {
    let (config, summary) = parsed(&format!(
        "{SAMPLE}\n[pwm1]\nfreqency = 5000\n[switch]\nspindle.enable = true\nspindle.output_pin = PWM1_1\n\
         spindle.output_type = hwpwm\nspindle.input_on_command = M3\n"
    ));
    assert!(summary.is_usable());
    assert_eq!(off(&config), ["[pwm1]", "switch spindle"]);
    assert_eq!(config.pwm_frequency_hz[0], None);
}

#[test]
fn more_than_can_be_kept_is_fatal() {
    let heaters: String = (0..5).map(|n| format!("[temperature control]\nh{n}.max_temp = hot\n")).collect();
    let switches: String = (0..15).map(|n| format!("[switch]\ns{n}.output_pin = PL1\n")).collect();
    let rest = "[zprobe]\nslow_feedrate = x\n[player]\nleave_heaters_on_suspend = x\n[laser]\nenable = x\n\
                [lathe]\nenable = x\n[pwm1]\nfrequency = x\n[pwm2]\nfrequency = x\n";
    let (config, summary) = parsed(&format!("{SAMPLE}\n{heaters}{switches}{rest}"));
    assert_eq!(summary.errors, 24);
    assert!(!summary.is_usable() && config.off.len() <= 24);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// Machines that may start in spite of any error drive nothing that has an error.
    #[test]
    fn nothing_with_an_error_is_wired(
        damage in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut bytes = SAMPLE.as_bytes().to_vec();
        for (at, byte) in damage {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        let mut findings: heapless::Vec<config::Diagnostic, 64> = heapless::Vec::new();
        let (config, summary) = config::parse(&bytes, BoardId::Prime2590, &mut findings);
        let fatals = findings.iter().filter(|finding| finding.severity == config::Severity::Fatal).count();
        prop_assert_eq!(summary.fatals as usize, fatals);
        for heater in config.temperatures.iter().filter(|heater| config.off("temperature control", &heater.name).is_some()) {
            prop_assert!(heater.heater_pin.is_none() && heater.sensor.thermistor.input.is_none());
        }
        for switch in config.switches.iter().filter(|switch| config.off("switch", &switch.name).is_some()) {
            prop_assert!(switch.output_pin.is_none() && switch.input_pin.is_none());
        }
        for finding in &findings {
            let is_error = finding.severity == config::Severity::Error;
            prop_assert_eq!(is_error, !finding.off.is_empty(), "{}", finding);
        }
    }
}

#[test]
fn the_message_on_the_machine_names_the_part() {
    let (_, findings) = read(&edited("bed.max_temp = 120", "bed.max_temp = hot"));
    assert!(findings[0].to_string().ends_with("; stays off: temperature control bed"), "{}", findings[0]);
}

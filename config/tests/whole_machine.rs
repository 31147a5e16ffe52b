//! Findings that need the whole file.

mod common;

use common::{Findings, SAMPLE, edited, expect, line_of, read};
use config::{
    BoardId,
    Severity::{Error, Fatal, Warning},
    Summary,
};
use units::{Actuator, Amps, MmPerSecond};

#[test]
fn a_pin_with_two_owners_names_both() {
    let text = edited("fan.output_pin = PE1 ", "fan.output_pin = PE3");
    let (_, findings) = read(&text);
    let [finding] = findings.as_slice() else { panic!("{findings:#?}") };
    assert_eq!(finding.key, "[switch] fan.output_pin");
    let heater = line_of(&text, "bed.heater_pin");
    let expected = format!("PE3 is used by [temperature control] bed.heater_pin already, in line {heater}");
    assert_eq!(finding.reason, expected.as_str());
}

#[test]
fn pins_of_the_board_and_its_buses_are_refused() {
    let key = "[switch] fan.output_pin";
    for (pin, reason) in [
        ("PD11", "belongs to the QSPI flash"),
        ("PC8", "belongs to the SD card"),
        ("PA1", "belongs to Ethernet"),
        ("PA12", "belongs to USB"),
        ("PH9", "belongs to the board's lamps"),
        ("PA13", "belongs to the debug probe"),
        ("PE12", "used by SPI bus 1"),
        ("PD8", "used by [uart console]"),
        ("PF11", "used by [temperature control] hotend.thermistor_pin"),
        ("PD7", "used by [system] fets_power_enable_pin"),
        ("PJ14", "the boot button drives it, so it cannot be an output"),
        ("PI3", "the end stops' buffer drives it, so it cannot be an output"),
        ("PB10!", "the probe's comparator drives it, so it cannot be an output"),
        ("PK5", "a motor driver's stallGuard line drives it, so it cannot be an output"),
    ] {
        let to = format!("fan.output_pin = {pin} ");
        expect("fan.output_pin = PE1 ", &to, Error, &to, key, reason, "use another pin");
    }
    // The finding stands at the later line.
    let reason = "used by [switch] fan.output_pin already";
    let (from, to) = ("fan.output_pin = PE1 ", "fan.output_pin = PH5 ");
    expect(from, to, Error, "vmotor = ", "[voltage monitor] vmotor", reason, "use another pin");
    expect("PF14!o", "PF14!", Error, "PF14", "[system] fets_enable_pin", "open drain", "PF14!o");
}

#[test]
fn a_default_pin_can_be_an_owner_too() {
    let text = edited("fets_power_enable_pin = PD7 ", "#").replace("fan.output_pin = PE1 ", "fan.output_pin = PD7 ");
    let (_, findings) = read(&text);
    assert_eq!(findings.len(), 1, "{findings:#?}");
    assert!(findings[0].reason.contains("fets_power_enable_pin already, by default"), "{}", findings[0]);
}

#[test]
fn what_is_not_enabled_owns_no_pin() {
    let (config, findings) =
        read(&format!("{SAMPLE}\n").replace(
            "[endstops]",
            "lamp.output_pin = PE3\nlamp.output_type = digital\nlamp.enable = false\n[endstops]",
        ));
    assert!(findings.is_empty(), "{findings:#?}");
    assert_eq!(config.switches.len(), 1, "a disabled switch is left out");
}

#[test]
fn motors_are_checked_against_their_drivers() {
    for (from, to, severity, at, key, reason, fix) in [
        (
            "alpha.max_rate = 18000 ",
            "alpha.max_rate = 600000",
            Warning,
            "alpha.max_rate",
            "[actuator] alpha.max_rate",
            "800000 steps/s",
            "write 150000",
        ),
        (
            "beta.microsteps = 16",
            "beta.microsteps = 20",
            Error,
            "beta.microsteps",
            "[actuator] beta.microsteps",
            "20 microsteps",
            "1, 2, 4, 8",
        ),
        (
            "beta.step_pin = PK2",
            "beta.step_pin = nc",
            Error,
            "beta.step_pin",
            "[actuator] beta.step_pin",
            "needs a step_pin",
            "",
        ),
        (
            "gamma.current = 1.2",
            "gamma.current = 4.0",
            Warning,
            "gamma.current",
            "[current control] gamma.current",
            "above the driver's max_current",
            "3 or less",
        ),
        (
            "gamma.sense_resistor = 50",
            "gamma.sense_resistor = 500",
            Error,
            "gamma.current",
            "[current control] gamma.current",
            "500 mOhm",
            "0.65",
        ),
        (
            "gamma.current = 1.2",
            "",
            Warning,
            "gamma.driver",
            "[actuator] gamma.driver",
            "has no current",
            "gamma.current",
        ),
        (
            "beta.spi_cs_pin = PG8",
            "beta.spi_cs_pin = PG8!",
            Error,
            "beta.spi_cs_pin",
            "[tmc2590] beta.spi_cs_pin",
            "active low by itself",
            "",
        ),
        (
            "delta.driver = tmc2590",
            "delta.driver = tmc2660",
            Error,
            "delta.driver",
            "[actuator] delta.driver",
            "no entry in [tmc2660]",
            "there is one in [tmc2590]",
        ),
        (
            "delta.driver = tmc2590",
            "delta.driver = external",
            Warning,
            "delta.current",
            "[current control] delta.current",
            "cannot be set",
            "delete",
        ),
    ] {
        expect(from, to, severity, at, key, reason, fix);
    }
}

#[test]
fn what_is_too_high_is_lowered() {
    let (config, _) = read(&edited("alpha.max_rate = 18000 ", "alpha.max_rate = 600000"));
    assert_eq!(config.actuators[Actuator::Alpha].max_rate, MmPerSecond(200_000.0 / 80.0));
    let (config, _) = read(&edited("gamma.current = 1.2", "gamma.current = 4.0"));
    assert_eq!(config.actuators[Actuator::Gamma].current, Some(Amps(3.0)));
}

#[test]
fn a_slave_must_be_like_its_master() {
    // The extruder would turn the slave: not this test's matter.
    let text = edited("hotend.enable = true\nhotend.tool_id = 0 ", "hotend.enable = false #");
    let slave =
        |line: &str| read(&text.replace("delta.driver = tmc2590", &format!("delta.driver = tmc2590\n{line}"))).1;
    let findings = slave("delta.slaved_to = gamma");
    assert_eq!(findings.len(), 1, "{findings:#?}");
    assert!(findings[0].reason.contains("415 steps/mm, gamma has 400"), "{}", findings[0]);
    let findings = slave("delta.slaved_to = X");
    assert!(findings[0].reason.contains("not one of the possible values"), "{}", findings[0]);
    let (_, findings) = read(&edited("beta.driver = tmc2590", "beta.driver = tmc2590\nbeta.slaved_to = alpha"));
    assert!(findings[0].reason.contains("only delta, epsilon and zeta"), "{}", findings[0]);
}

#[test]
fn a_slave_takes_its_masters_current() {
    let text = edited("hotend.enable = true\nhotend.tool_id = 0 ", "hotend.enable = false #")
        .replace("delta.driver = tmc2590", "delta.driver = tmc2590\ndelta.slaved_to = gamma")
        .replace("gamma.current = 1.2", "gamma.current = 1.1");
    let current = |text: &str| read(text).0.actuators[Actuator::Delta].current;
    let own = text.lines().find(|line| line.starts_with("delta.current")).expect("a current of its own");
    assert_eq!(current(&text.replace(own, "delta.current = 0.7")), Some(Amps(0.7)));
    assert_eq!(current(&text.replace(own, "")), Some(Amps(1.1)));
}

#[test]
fn an_extruder_needs_its_motor() {
    expect(
        "hotend.tool_id = 0                     # T0",
        "hotend.tool_id = 1 # T0",
        Error,
        "# T0",
        "[extruder] hotend.tool_id",
        "motor epsilon, which is not there",
        "[actuator] epsilon",
    );
}

#[test]
fn a_machine_without_motors_is_not_usable() {
    let mut findings = Findings::new();
    let (_, summary) = config::parse(b"", BoardId::Prime2590, &mut findings);
    assert_eq!(summary, Summary { warnings: 0, errors: 0, fatals: 3 });
    assert!(!summary.is_usable());
    assert_eq!(
        findings[0].to_string(),
        "fatal: [actuator] alpha.steps_per_mm: there is no motor alpha (describe it: motors are alpha, beta, gamma and up, without a gap)"
    );
}

#[test]
fn heaters_need_sensors_and_sensible_limits() {
    for (from, to, severity, at, key, reason) in [
        (
            "bed.thermistor_pin = ADC1_3 ",
            "bed.thermistor_pin = nc",
            Error,
            "bed.thermistor_pin",
            "thermistor_pin",
            "a heater without a sensor",
        ),
        ("bed.thermistor = Honeywell100K", "", Warning, "bed.enable", "thermistor", "beta 4066"),
        (
            "bed.thermistor = Honeywell100K",
            "bed.thermistor = Honeywel100K",
            Error,
            "bed.thermistor =",
            "thermistor",
            "not one of the possible values",
        ),
        ("bed.max_temp = 120", "bed.max_temp = 2", Error, "bed.max_temp", "max_temp", "is not above min_temp"),
        (
            "bed.max_temp = 120",
            "bed.max_temp = 120\nbed.preset1 = 200",
            Warning,
            "bed.preset1",
            "preset1",
            "above max_temp",
        ),
        ("bed.designator = B", "bed.designator = T", Warning, "", "designator", "has the designator T as well"),
        ("bed.designator = B", "bed.tool_id = 0", Error, "bed.tool_id", "tool_id", "has tool_id 0 as well"),
        ("bed.bang_bang = false", "bed.max_pwm = 0", Warning, "bed.max_pwm", "max_pwm", "never heats"),
        ("bed.bang_bang = false", "bed.sensor = max31855", Error, "", "", ""),
    ] {
        if key.is_empty() {
            let (_, findings) = read(&edited(from, to));
            let keys: Vec<_> = findings.iter().map(|finding| finding.key.as_str()).collect();
            assert_eq!(keys, ["spi_channel", "spi_select_pin"].map(|key| format!("[temperature control] bed.{key}")));
            continue;
        }
        let at = if at.is_empty() { "bed.designator" } else { at };
        expect(from, to, severity, at, &format!("[temperature control] bed.{key}"), reason, "");
    }
}

#[test]
fn runaway_protection_is_not_switched_off_unnoticed() {
    let text = edited("bed.runaway_range = 15", "bed.runaway_range = 0")
        .replace("bed.runaway_heating_timeout = 900", "bed.runaway_heating_timeout = 0");
    let (config, findings) = read(&text);
    assert_eq!(findings.len(), 1, "{findings:#?}");
    assert!(findings[0].reason.contains("all runaway checks are off"));
    assert_eq!((config.temperatures[0].runaway.range, config.temperatures[0].runaway.heating_timeout), (None, None));
}

#[test]
fn endstops_are_checked_against_their_axes() {
    for (from, to, severity, key, reason) in [
        ("minx.pin = PD0^ ", "minx.pin = nc", Error, "minx.pin", "needs a pin"),
        ("minx.axis = X", "", Error, "minx.axis", "which axis"),
        ("minx.axis = X", "minx.axis = C", Error, "minx.axis", "axis C has no motor"),
        ("minx.axis = X", "minx.axis = Y", Error, "miny.homing_direction", "Y homes to 'minx' already"),
        (
            "miny.axis = Y\nminy.homing_direction = home_to_min",
            "miny.axis = Y\nminy.homing_direction = home_to_max",
            Warning,
            "miny.homing_direction",
            "contradict each other",
        ),
        ("minz.fast_rate = 10", "minz.fast_rate = 100", Warning, "minz.fast_rate", "faster than the motor's max_rate"),
        ("minz.slow_rate = 2", "minz.slow_rate = 12", Warning, "minz.slow_rate", "faster than the first"),
        ("minz.slow_rate = 2", "minz.slow_rate = 10", Warning, "minz.slow_rate", "takes 0.27 mm past the switch"),
        (
            "alpha.acceleration = 3000",
            "alpha.acceleration = 50",
            Warning,
            "minx.slow_rate",
            "takes 1.01 mm past the switch",
        ),
    ] {
        let at = if key == "minx.axis" && to.is_empty() { "minx.enable" } else { key };
        expect(from, to, severity, at, &format!("[endstops] {key}"), reason, "");
    }
}

/// The cartesian sample: 80 steps/mm and 16 microsteps, so a cycle of 0.8 mm.
#[test]
fn phases_of_switches_are_checked_against_their_motors() {
    for (more, fix) in [
        ("minx.phase_tolerance = 0.4", "write less than 0.4000"),
        ("minx.phase = 1024", "write 0 to 1023.999"),
        ("minx.phase = -1", "write 0 to 1023.999"),
    ] {
        let (_, findings) = read(&edited("minx.axis = X", &format!("minx.axis = X\nminx.phase_check = true\n{more}")));
        assert!(findings.len() == 1 && findings[0].fix.contains(fix), "{more}: {findings:?}");
    }
    let good = "minx.axis = X\nminx.phase_check = true\nminx.phase_tolerance = 0.399\nminx.phase = 1023.5";
    let (config, findings) = read(&edited("minx.axis = X", good));
    assert!(findings.is_empty(), "{findings:?}");
    assert_eq!(config.endstops[0].phase.calibrated, Some(1_023.5));
    // With CoreXY the cycle of one motor moves each axis by half of it, so phases repeat twice as often.
    let corexy = edited("minx.axis = X", good).replace("arm_solution = cartesian", "arm_solution = corexy");
    let (_, findings) = read(&corexy);
    assert!(findings.iter().any(|finding| finding.reason.contains("repeat every 0.4000 mm")), "{findings:?}");
    let unlike = corexy.replace("0.399", "0.1").replace("beta.microsteps = 16", "beta.microsteps = 32");
    assert!(read(&unlike).1.iter().any(|finding| finding.reason.contains("unlike steps")));
    let polar = edited("minx.axis = X", good).replace("arm_solution = cartesian", "arm_solution = polar");
    assert!(read(&polar).1.iter().any(|finding| finding.reason.contains("say nothing of it")));
    let of_none = edited("minx.homing_direction = home_to_min", "minx.phase_check = true");
    assert!(read(&of_none).1.iter().any(|finding| finding.reason.contains("no axis homes to this switch")));
}

#[test]
fn endstops_homed_together_need_interrupt_lines_of_their_own() {
    expect(
        "miny.pin = PI1^ ",
        "miny.pin = PJ0^",
        Warning,
        "miny.pin",
        "[endstops] miny.pin",
        "share interrupt line 0",
        "homing_order",
    );
    let text =
        edited("miny.pin = PI1^ ", "miny.pin = PJ0^").replace("[endstops]", "[endstops]\ncommon.homing_order = XYZ");
    assert!(read(&text).1.is_empty(), "one after the other they may share");
}

#[test]
fn switches_are_checked_against_their_outputs() {
    for (from, to, at, key, reason) in [
        ("fan.output_type = sigmadeltapwm", "", "fan.enable", "output_type", "how its output is driven"),
        (
            "fan.output_pin = PE1 ",
            "fan.output_pin = PWM1_1",
            "fan.output_type",
            "output_type",
            "needs output_type = hwpwm",
        ),
        ("fan.output_pin = PE1 ", "", "fan.enable", "output_pin", "neither an output_pin nor an input_pin"),
        (
            "fan.input_on_command = M106",
            "fan.input_on_command = fan on",
            "fan.input_on_command",
            "input_on_command",
            "not a G or M code",
        ),
        (
            "fan.startup_value = 255",
            "fan.input_pin = PJ6^",
            "fan.enable",
            "output_on_command",
            "the input does nothing",
        ),
    ] {
        expect(from, to, Error, at, &format!("[switch] fan.{key}"), reason, "");
    }
    let (_, findings) = read(
        &edited("fan.output_pin = PE1 ", "fan.output_pin = PWM1_1 #")
            .replace("sigmadeltapwm", "hwpwm")
            .replace("fan.startup_value = 255", ""),
    );
    assert_eq!(findings.len(), 1, "{findings:#?}");
    assert!(findings[0].fix.contains("[pwm1]"), "{}", findings[0]);
}

#[test]
fn reversing_a_motor_twice_is_pointed_out() {
    let text = edited("delta.dir_pin = PG5", "delta.dir_pin = PG5!\ndelta.reversed = true");
    let (config, findings) = read(&text);
    assert_eq!(findings.len(), 1, "{findings:#?}");
    assert!(findings[0].reason.contains("together they count once"), "{}", findings[0]);
    assert!(config.actuators[Actuator::Delta].direction_inverted());
}

#[test]
fn a_standstill_current_above_the_ceiling_is_an_error() {
    let (_, findings) =
        read(&edited("beta.max_current = 3000", "beta.max_current = 3000\nbeta.standstill_current = 3500"));
    let errors: Vec<_> = findings.iter().filter(|finding| finding.severity == Fatal).collect();
    assert_eq!(errors.len(), 1, "{findings:#?}");
    assert_eq!(errors[0].key, "[tmc2590] beta.standstill_current");
    assert!(errors[0].reason.contains("above max_current"));
}

#[test]
fn input_shapers_are_checked_against_what_they_are_made_for() {
    let with = |lines: &str| read(&format!("{SAMPLE}\n[input shaper]\n{lines}\n"));
    let (config, findings) = with("shaper_type_x = ei\nshaper_freq_x = 48.5\ndamping_ratio_x = 0.05");
    assert!(findings.is_empty(), "{findings:?}");
    let [x, y, _] = config.input_shapers;
    assert_eq!((x.shaper, x.frequency_hz, x.damping_ratio), (units::ShaperKind::Ei, Some(48.5), 0.05));
    assert_eq!((y.shaper, y.frequency_hz, y.damping_ratio), (units::ShaperKind::Mzv, None, 0.1));
    for (lines, key, reason) in [
        ("shaper_freq_y = 2", "[input shaper] shaper_freq_y", "too slow to shape"),
        (
            "shaper_freq_z = 40\nshaper_type_z = 3hump_ei\ndamping_ratio_z = 0.25",
            "[input shaper] damping_ratio_z",
            "more than this shaper is made for",
        ),
    ] {
        let (_, findings) = with(lines);
        assert!(
            findings.iter().any(|f| f.severity == Error && f.key == key && f.reason.contains(reason)),
            "{lines}: {findings:?}"
        );
    }
    // The damping ratio of an axis without a shaper does not matter.
    assert!(with("shaper_type_z = 3hump_ei\ndamping_ratio_z = 0.25").1.is_empty());
}

/// A curve of voltages must say one temperature for each voltage that the input can read.
#[test]
fn a_curve_of_voltages_is_checked() {
    for (points, reason) in [
        ("", "one point makes no curve"),
        ("20,1", "one point makes no curve"),
        ("20,1, 90,3.4", "reads 0 to 3.3 V only"),
        ("20,1, 90,1", "the same voltage"),
        ("20,1, 90,2, 50,3", "temperature must rise"),
    ] {
        let to = format!("bed.bang_bang = false\nbed.sensor = voltage\nbed.voltage_curve = {points}");
        let (_, findings) = read(&edited("bed.bang_bang = false", &to));
        assert!(findings.iter().any(|finding| finding.reason.contains(reason)), "{points}: {findings:#?}");
    }
    let to = "bed.bang_bang = false\nbed.voltage_curve = 20,1, 90,2";
    let (_, findings) = read(&edited("bed.bang_bang = false", to));
    assert!(findings.iter().any(|finding| finding.reason.contains("has no such curve")), "{findings:#?}");
}

/// Control by a model needs one, and a fan that there is; presets have temperatures.
#[test]
fn control_by_a_model_is_checked() {
    let figures = "bed.model_capacity = 400\nbed.model_late = 4\n";
    for (lines, reason) in [
        ("bed.control = model\nbed.model_capacity = 400", "control = model needs it"),
        ("bed.control = model\nbed.bang_bang = true", "bang_bang = true is another control"),
        ("bed.presets = pla 60, petg", "no temperature follows petg"),
        ("bed.presets = pla 60, abs 150", "abs: 150"),
        ("bed.fan = fam", "there is no [switch] fam"),
    ] {
        let (_, findings) = read(&edited("bed.bang_bang = false", lines));
        assert!(findings.iter().any(|finding| finding.reason.contains(reason)), "{lines}: {findings:#?}");
    }
    let lines = format!("{figures}bed.control = model\nbed.fan = fan");
    let (config, findings) = read(&edited("bed.bang_bang = false", &lines));
    assert!(findings.is_empty(), "{findings:#?}");
    let bed = config.temperatures.iter().find(|heater| heater.name == "bed").expect("a bed");
    assert_eq!(bed.law(), config::LawSettings::Model(bed.model));
    let fan = bed.fan.map(|place| config.switches[usize::from(place)].name.as_str());
    assert_eq!((fan, bed.model.power_w), (Some("fan"), 200.0));
}

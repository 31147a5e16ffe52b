//! Findings of the reader about single lines.

mod common;

use common::{Findings, SAMPLE, edited, expect, read};
use config::{
    BoardId,
    Severity::{Error, Warning},
    ToolId,
};
use units::{Actuator, Amps, Celsius, MmPerSecond};

#[test]
fn misspelt_names_are_errors_with_the_right_name() {
    for (from, to, key, reason, fix) in [
        (
            "junction_deviation =",
            "junction_devation =",
            "junction_devation",
            "no setting",
            "did you mean junction_deviation?",
        ),
        ("alpha.max_rate", "alpha.maxrate", "alpha.maxrate", "no setting", "did you mean max_rate?"),
        ("alpha.max_rate", "alpa.max_rate", "alpa", "there is no motor 'alpa'", "did you mean alpha?"),
        ("[player]", "[plaeyr]", "", "no section", "did you mean [player]?"),
        ("[conveyor]", "[Conveyor]", "", "no section", "did you mean [conveyor]?"),
        ("minx.retract =", "retract =", "retract", "does not say which endstop", "write name.retract"),
        ("minx.retract =", "home_z_first =", "home_z_first", "does not say which endstop", "write common.home_z_first"),
        ("minx.retract =", "minx.home_z_first =", "minx.home_z_first", "no setting", "write common.home_z_first"),
        (
            "planner_queue_size = 32 ",
            "acceleration = 32 ",
            "acceleration",
            "no setting",
            "[motion control], as default_acceleration",
        ),
    ] {
        expect(from, to, Error, to, key, reason, fix);
    }
}

#[test]
fn unknown_leftovers_are_warnings() {
    expect("must_be_homed = false", "colour = blue", Warning, "colour", "colour", "no setting", "delete the line");
    let (_, findings) = read(&format!("{SAMPLE}\n[thermal camera]\nenable = true\nx.y = 5\n"));
    let [finding] = findings.as_slice() else { panic!("one finding for the whole section: {findings:#?}") };
    assert_eq!(finding.severity, Warning);
}

#[test]
fn bad_values_are_errors_at_the_value() {
    const MOTION: &str = "[motion control] ";
    for (from, to, key, reason, fix) in [
        (
            "default_feed_rate = 3000 ",
            "default_feed_rate = fast",
            "default_feed_rate",
            "'fast' is not a number",
            "only the number",
        ),
        (
            "default_feed_rate = 3000 ",
            "default_feed_rate = 3000 mm/min",
            "default_feed_rate",
            "not a number",
            "without unit",
        ),
        (
            "default_feed_rate = 3000 ",
            "default_feed_rate = 3000 ; mm/min",
            "default_feed_rate",
            "not a number",
            "comments begin with #",
        ),
        (
            "default_feed_rate = 3000 ",
            "default_feed_rate = 3,5",
            "default_feed_rate",
            "not a number",
            "a point for decimals",
        ),
        ("default_seek_rate = 9000 ", "default_seek_rate = 0", "default_seek_rate", "not more than 0", "more than 0"),
        ("default_feed_rate = 3000 ", "default_feed_rate = nan", "default_feed_rate", "not a number", ""),
        ("default_feed_rate = 3000 ", "default_feed_rate =", "default_feed_rate", "has no value", "delete the line"),
        (
            "must_be_homed = false",
            "must_be_homed = yes",
            "must_be_homed",
            "neither true nor false",
            "write true or false",
        ),
        ("must_be_homed = false", "must_be_homed = True", "must_be_homed", "neither true nor false", ""),
        (
            "arm_solution = cartesian",
            "arm_solution = cartesain",
            "arm_solution",
            "not one of the possible values",
            "did you mean cartesian?",
        ),
        (
            "arm_solution = cartesian",
            "arm_solution = tripod",
            "arm_solution",
            "not one of the possible values",
            "generic_cartesian or lathe",
        ),
        ("arm_solution = cartesian", "arm_solution = winch", "arm_solution", "three winches", "alpha, beta and gamma"),
    ] {
        expect(from, to, Error, to, &format!("{MOTION}{key}"), reason, fix);
    }
    let section = "[planner] planner_queue_size";
    for (to, reason, fix) in [
        ("planner_queue_size = 1e2", "not a whole number", "its digits alone"),
        ("planner_queue_size = 3.5.1", "not a whole number", ""),
        ("planner_queue_size = 032", "octal", "write 32"),
        ("planner_queue_size = 70000", "out of range", "1 to 65535"),
        ("planner_queue_size = -1", "out of range", "1 to 65535"),
    ] {
        expect("planner_queue_size = 32 ", to, Error, to, section, reason, fix);
    }
}

/// A value that is limited or rounded is reported, and writing what the report advises ends the warning.
#[test]
fn a_value_that_is_limited_or_cut_is_told() {
    const QUEUE: (&str, &str) = ("planner_queue_size = 32 ", "[planner] planner_queue_size");
    const RATE: (&str, &str) = ("bed.enable = true", "[temperature control] bed.readings_per_second");
    const SPEED: (&str, &str) = ("baudrate = 115200", "[uart console] baudrate");
    for ((from, key), to, reason, fix) in [
        (QUEUE, "planner_queue_size = 1000", "1000 is taken as 224: Velvet can do 4 to 224", "write 224"),
        (QUEUE, "planner_queue_size = 3", "3 is taken as 4", "write 4"),
        (QUEUE, "planner_queue_size = 32.9", "32.9 is taken as 32: it is a whole number", "write 32"),
        (RATE, "bed.enable = true\nbed.readings_per_second = 1000", "1000 is taken as 100", "write 100"),
        (RATE, "bed.enable = true\nbed.readings_per_second = 0", "0 is taken as 1", "write 1"),
        (SPEED, "baudrate = 9600.5", "9600.5 is taken as 9600", "write 9600"),
    ] {
        let at = to.lines().last().unwrap();
        expect(from, to, Warning, at, key, reason, fix);
        let (name, _) = to.rsplit_once(' ').unwrap();
        let advice = edited(from, &format!("{name} {}", fix.trim_start_matches("write ")));
        assert!(read(&advice).1.is_empty(), "{advice}");
    }
}

#[test]
fn the_column_of_a_value_is_where_it_begins() {
    let (_, findings) = read("[planner]\n   junction_deviation   =   0.0.2  # mm\n");
    let finding = findings.iter().find(|finding| finding.line == 2).unwrap();
    assert_eq!((finding.column, finding.length), (29, 5));
}

#[test]
fn numbers_are_read_as_smoothieware_does_where_it_is_no_trap() {
    let text = edited("planner_queue_size = 32 ", "planner_queue_size = 0x20")
        .replace("baudrate = 115200", "baudrate = 9600.0");
    let (config, findings) = read(&text);
    assert!(findings.is_empty(), "{findings:#?}");
    assert_eq!((config.planner.queue_size, config.uart.baudrate), (32, 9600));
}

#[test]
fn bad_pins_say_what_a_pin_looks_like() {
    let key = "[switch] fan.output_pin";
    for (to, reason) in [
        ("fan.output_pin = E1", "is not a pin name"),
        ("fan.output_pin = PE16", "0 to 15"),
        ("fan.output_pin = PL1", "ports are A to K"),
        ("fan.output_pin = PE1i", "not a pin modifier"),
        ("fan.output_pin = ADC1_2", "another kind of pin"),
    ] {
        expect("fan.output_pin = PE1 ", to, Error, to, key, reason, "a pin as in PE1");
    }
}

#[test]
fn lines_that_are_no_settings_are_errors() {
    for (to, reason, fix) in [
        ("just words", "has no =", "key = value"),
        ("; comment", "has no =", "comments begin with #"),
        ("[planer", "has no ]", "write [planer]"),
    ] {
        let (_, findings) = read(&format!("{SAMPLE}{to}\n"));
        let finding = findings.last().unwrap();
        assert_eq!(finding.line, SAMPLE.lines().count() as u32 + 1);
        assert!(finding.reason.contains(reason) && finding.fix.contains(fix), "{finding}");
    }
    let (_, findings) = read(&format!("alpha_steps_per_mm = 80\n{SAMPLE}"));
    assert_eq!(findings[0].fix, "write it under [actuator] as alpha.steps_per_mm");
}

#[test]
fn a_second_value_and_a_second_section_count_with_a_warning() {
    let (config, findings) = read(&edited("bed.max_temp = 120", "bed.max_temp = 120\nbed.max_temp = 100"));
    assert_eq!(findings.len(), 1, "{findings:#?}");
    assert!(findings[0].reason.contains("is set before, in line"));
    assert_eq!(config.temperatures[0].max_temp, Celsius(100.0));
    let (config, findings) = read(&format!("{SAMPLE}\n[planner]\nminimum_planner_speed = 5\n"));
    assert_eq!(findings.len(), 1, "{findings:#?}");
    assert!(findings[0].reason.contains("Smoothieware ignores"));
    assert_eq!(config.planner.minimum_planner_speed, MmPerSecond(5.0));
}

#[test]
fn what_velvet_cannot_do_yet_is_refused_only_when_it_is_used() {
    let (_, findings) = read(&format!("{SAMPLE}[lathe]\nenable = false\nencoder_ppr = 400\n"));
    assert!(findings.is_empty(), "{findings:#?}");
    let (_, findings) = read(&format!("{SAMPLE}[lathe]\nenable = true\n"));
    assert_eq!(
        findings[0].to_string(),
        format!(
            "line {}, column 10: error: [lathe] enable: not supported yet (leave it disabled until Velvet can do it); \
             stays off: [lathe]",
            SAMPLE.lines().count() + 2
        )
    );
}

#[test]
fn two_instances_of_a_section_to_come_are_no_second_value() {
    let text = format!(
        "{SAMPLE}[temperature switch]\na.enable = false\na.trigger = level\nb.enable = false\nb.trigger = rising\n"
    );
    let (_, findings) = read(&text);
    assert!(findings.is_empty(), "{findings:#?}");
}

#[test]
fn the_board_decides_the_driver() {
    let mut findings = Findings::new();
    let (config, _) = config::parse(
        b"[actuator]\nalpha.steps_per_mm = 80\nepsilon.steps_per_mm = 80\n",
        BoardId::Prime2660,
        &mut findings,
    );
    assert_eq!(config.actuators[Actuator::Alpha].driver, config::DriverKind::Tmc2660);
    assert_eq!(config.actuators[Actuator::Epsilon].driver, config::DriverKind::External);
}

#[test]
fn defaults_that_follow_others_do() {
    let (config, _) = read(
        "[temperature control]\nchamber.max_pwm = 100\nchamber.enable = true\nchamber.runaway_heating_timeout = 60\n[motion control]\narm_solution = corexy\n[actuator]\nalpha.reversed = t\nzeta.reversed = t\n[tmc2590]\nalpha.sense_resistor = 75\n[switch]\npsu.enable = true\npsu.subcode = 2\npsu.input_on_command = M80\n",
    );
    let chamber = &config.temperatures[0];
    assert_eq!((chamber.tool_id, chamber.set_m_code, chamber.pid.i_max), (ToolId(253), 141, 100.0));
    assert_eq!(chamber.runaway.cooling_timeout, chamber.runaway.heating_timeout);
    assert!(config.homing.corexy && !config.homing.move_to_origin);
    assert_eq!(config.tmc2590.axes[Actuator::Alpha].max_current, Amps(4.4));
    let setup = |actuator| config.actuators[actuator].dir_setup_ns;
    assert_eq!((setup(Actuator::Alpha), setup(Actuator::Zeta)), (500, 5_000));
    assert_eq!(config.switches[0].input_on_command.unwrap().subcode, 2, "a subcode counts wherever it is written");
}

#[test]
fn values_that_smoothieware_takes_are_taken() {
    let (config, findings) = read(
        "[motion control]\ndefault_feed_rate = 0\n[planner]\nplanner_queue_size = 1000\nz_junction_deviation = -5\n\
         [button box]\ncommon.poll_frequency_hz = 1000\n[endstops]\ncommon.homing_order = ZX\n\
         [temperature switch]\npsu.arm_mcode = 1100\n",
    );
    let told = findings.iter().filter(|finding| finding.reason.contains("is taken as")).count();
    assert_eq!(told, 2, "{findings:?}");
    // But for the motors, which are not described here.
    let of_values = findings.iter().filter(|finding| finding.severity != Warning && finding.line > 0).count();
    assert_eq!(of_values, 0, "{findings:?}");
    assert_eq!((config.planner.queue_size, config.planner.z_junction_deviation), (224, None));
    assert_eq!((config.button_poll_hz, config.motion.default_feed_rate.0), (100, 0.0));
    assert!(config.homing.order.is_empty(), "an order of two leaves an axis unhomed");
}

//! The samples are what a user starts from: they must be complete and without a finding.

use config::{ArmSolution, BoardId, Diagnostic, DriverKind, MachineConfig, Summary};
use units::{Actuator, Axis, MmPerSecond};

type Findings = heapless::Vec<Diagnostic, 64>;

fn read(text: &str, board: BoardId) -> (MachineConfig, Summary, Findings) {
    let mut findings = Findings::new();
    let (config, summary) = config::parse(text.as_bytes(), board, &mut findings);
    (config, summary, findings)
}

const CARTESIAN: &str = include_str!("../samples/cartesian.ini");
const COREXY: &str = include_str!("../samples/corexy.ini");
const DELTA: &str = include_str!("../samples/delta.ini");

#[test]
fn the_samples_have_no_finding() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/samples");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let samples: Vec<_> =
        files.map(|path| (path.display().to_string(), std::fs::read_to_string(path).unwrap())).collect();
    assert!(samples.len() >= 4);
    for (name, text) in &samples {
        let (_, summary, findings) = read(text, BoardId::Prime2590);
        let texts: Vec<_> = findings.iter().map(ToString::to_string).collect();
        assert_eq!(summary, Summary::default(), "{name}: {texts:#?}");
    }
}

#[test]
fn the_cartesian_sample_is_the_printer_it_says() {
    let (config, ..) = read(CARTESIAN, BoardId::Prime2590);
    assert_eq!(config.motion.arm_solution, ArmSolution::Cartesian);
    let steps: Vec<_> = config.actuators().map(|(_, motor)| motor.steps_per_mm).collect();
    assert_eq!(steps, [80.0, 80.0, 400.0, 415.0]);
    assert!(config.actuators().all(|(_, motor)| motor.driver == DriverKind::Tmc2590 && motor.microsteps == 16));
    assert_eq!(config.actuators[Actuator::Alpha].max_rate, MmPerSecond(300.0));
    let names: Vec<_> = config.temperatures.iter().map(|heater| heater.name.as_str()).collect();
    assert_eq!(names, ["bed", "board", "hotend"]);
    assert_eq!(config.temperatures[0].heater_pin.unwrap().to_string(), "PE3");
    assert_eq!(config.temperatures[2].sensor.thermistor.table, Some("Semitec-104NT4"));
    for (axis, pin) in [(Axis::X, "PD0^"), (Axis::Y, "PI1^"), (Axis::Z, "PI0^")] {
        assert_eq!(config.homing_endstop(axis).unwrap().pin.unwrap().to_string(), pin);
    }
    assert_eq!(config.switches.len(), 1);
    assert_eq!(config.extruders[0].actuator(), Some(Actuator::Delta));
    assert_eq!(config.voltages.len(), 2);
}

#[test]
fn the_corexy_sample_homes_as_a_corexy() {
    let (config, ..) = read(COREXY, BoardId::Prime2590);
    assert_eq!(config.motion.arm_solution, ArmSolution::CoreXy);
    assert!(config.homing.corexy);
}

#[test]
fn the_delta_sample_homes_its_towers_upwards() {
    let (config, ..) = read(DELTA, BoardId::Prime2590);
    assert_eq!(config.motion.arm_solution, ArmSolution::LinearDelta);
    assert!(config.homing.delta && config.homing.move_to_origin && config.motion.must_be_homed);
    assert_eq!(config.motion.lines.segments_per_second, Some(100.0));
    assert_eq!(config.motion.arms.linear_delta.arm_length, 250.0);
    assert_eq!(config.homing_endstop(Axis::Z).unwrap().homing_position.0, 250.0);
}

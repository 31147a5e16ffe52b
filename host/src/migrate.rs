//! `velvet migrate`: a Smoothieware v1 `config` or Klipper's `printer.cfg` becomes a `config.ini`, with a
//! list of what a person has to do.

mod board;
mod convert;
mod ini;
mod klipper;
mod old;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use config::{BoardId, Diagnostic, Summary};

use crate::run::Chip;
use board::Board;
use convert::{Conversion, ToDo};

/// First line of a file that was a v1 config.
const HEAD: &str = "Migrated from a Smoothieware v1 config by velvet migrate.";

/// What `velvet migrate` takes.
#[derive(clap::Args)]
pub struct Options {
    /// Smoothieware's v1 file, usually called config, or Klipper's printer.cfg
    file: PathBuf,
    /// Where to write: of a v1 config the new file [default: standard output], of a printer.cfg the folder
    /// for config.ini, report.html, report.json and the printer.cfg with what it includes
    #[arg(long)]
    out: Option<PathBuf>,
    /// v1: which new pin takes the place of which old one, `2.5 = PE3` a line [default: the Smoothieboard
    /// v1's]
    #[arg(long, value_name = "FILE")]
    board: Option<PathBuf>,
    /// Klipper: which drivers the new board has
    #[arg(long, value_enum, default_value_t = Chip::Tmc2590)]
    drivers: Chip,
}

/// Writes the new file and prints the work that is left; returns whether the machine could start with the
/// file.
pub fn migrate(options: &Options) -> Result<bool> {
    if klipper::is_klipper(&options.file)? {
        return klipper::migrate(&options.file, options.out.as_deref(), options.drivers.board());
    }
    let read = |path: &Path| std::fs::read(path).with_context(|| format!("cannot read {}", path.display()));
    let text = String::from_utf8_lossy(&read(&options.file)?).into_owned();
    let board = match &options.board {
        Some(path) => Board::parse(&String::from_utf8_lossy(&read(path)?))
            .with_context(|| format!("the board file {}", path.display()))?,
        None => Board::smoothieboard(),
    };
    let migrated = Migration::new(&text, &board);
    match &options.out {
        Some(path) => {
            std::fs::write(path, &migrated.text).with_context(|| format!("cannot write {}", path.display()))?;
        }
        None => print!("{}", migrated.text),
    }
    let name = options.out.as_deref().unwrap_or(Path::new("config.ini")).display().to_string();
    eprint!("{}", migrated.report(&name));
    Ok(migrated.summary.is_complete())
}

/// New configuration file, and the checker's findings about it.
struct Migration {
    text: String,
    to_do: Vec<ToDo>,
    findings: Vec<Diagnostic>,
    summary: Summary,
}

impl Migration {
    fn new(old: &str, board: &Board) -> Self {
        let lines = old::read(old);
        let mut conversion = Conversion::new(&lines, board);
        conversion.run();
        let to_do: Vec<String> = conversion.to_do.iter().map(told).collect();
        let text = ini::write(HEAD, &to_do, &conversion.entries);
        let mut findings: Vec<Diagnostic> = Vec::new();
        let (_, summary) = config::parse(text.as_bytes(), BoardId::default(), &mut findings);
        Self { text, to_do: conversion.to_do, findings, summary }
    }

    fn report(&self, name: &str) -> String {
        let mut out = String::new();
        for to_do in &self.to_do {
            let _ = writeln!(out, "to do: {}", told(to_do));
        }
        out + &config::render_all(&self.findings, self.summary, name, &self.text)
    }
}

fn told(to_do: &ToDo) -> String {
    to_do.line.map_or_else(|| to_do.text.clone(), |line| format!("{} (v1 line {line})", to_do.text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use config::{DriverKind, OutputKind};
    use units::{Actuator, Celsius, Mm, MmPerSecond};

    const PRINTER: &str = include_str!("../tests/v1/printer.config");

    fn migrated(old: &str) -> (config::MachineConfig, Migration) {
        let migration = Migration::new(old, &Board::smoothieboard());
        let (config, _) = config::parse(migration.text.as_bytes(), BoardId::default(), &mut ());
        (config, migration)
    }

    #[test]
    fn a_printer_of_the_previous_generation_loads_without_an_error() {
        let (config, migration) = migrated(PRINTER);
        assert_eq!(migration.summary, Summary::default(), "{}", migration.report("config.ini"));
        assert_eq!(config.actuators[Actuator::Alpha].steps_per_mm, 80.0);
        assert_eq!(config.actuators[Actuator::Delta].steps_per_mm, 140.0);
        assert_eq!(config.actuators[Actuator::Delta].max_rate, MmPerSecond(50.0));
        assert!(config.actuators().all(|(_, motor)| motor.driver == DriverKind::Tmc2590));
        let names: Vec<_> = config.temperatures.iter().map(|heater| heater.name.as_str()).collect();
        assert_eq!(names, ["bed", "hotend"]);
        assert_eq!(config.temperatures[1].max_temp, Celsius(260.0));
        let stop = config.homing_endstop(units::Axis::Y).unwrap();
        assert_eq!((stop.name.as_str(), stop.homing_position), ("maxy", Mm(190.0)));
        assert!(stop.limit_enable && stop.pin.unwrap().to_string() == "PA9!^");
        assert_eq!(config.switches[0].output_kind, OutputKind::SigmaDelta);
        assert_eq!(config.player.after_suspend_gcode, "G91 G0 Z10");
    }

    /// Both firmwares drive a plain direction pin low for positive motion, so a motor that turned the right
    /// way goes on doing so.
    #[test]
    fn direction_pins_keep_their_exclamation_marks() {
        let (config, _) = migrated(PRINTER);
        let inverted = |motor: Actuator| config.actuators[motor].direction_inverted();
        let motors = [Actuator::Alpha, Actuator::Beta, Actuator::Gamma, Actuator::Delta];
        assert_eq!(motors.map(inverted), [true, false, false, false]);
        let plain = PRINTER.replace(" 0.5! ", " 0.5 ").replace(" 0.22", " 0.22!");
        let (config, _) = migrated(&plain);
        let inverted = |motor: Actuator| config.actuators[motor].direction_inverted();
        assert_eq!(motors.map(inverted), [false, false, false, true]);
    }

    #[test]
    fn what_cannot_be_carried_over_is_on_the_list_with_its_line() {
        let (_, migration) = migrated(PRINTER);
        let list: Vec<String> = migration.to_do.iter().map(told).collect();
        for part in ["the bed to the bed output", "panel.enable: not supported yet", "32 microsteps"] {
            assert!(list.iter().any(|item| item.contains(part)), "{part}: {list:#?}");
        }
        let line = PRINTER.lines().position(|line| line.starts_with("panel.enable")).unwrap() + 1;
        assert!(list.iter().any(|item| item.ends_with(&format!("(v1 line {line})"))), "{list:#?}");
        assert!(list.iter().all(|item| !item.contains("laser") && !item.contains("hotend2")), "{list:#?}");
        assert!(list.iter().all(|item| migration.text.contains(item)), "the file holds the list too");
    }

    #[test]
    fn a_pin_without_a_counterpart_is_asked_for_by_name() {
        let (_, migration) = migrated(&PRINTER.replace("output_pin                       2.6", "output_pin 1.22"));
        assert!(!migration.summary.is_complete());
        let list: Vec<String> = migration.to_do.iter().map(told).collect();
        assert!(list.iter().any(|item| item.starts_with("fan.output_pin: choose a pin; v1's 1.22")), "{list:#?}");
    }

    #[test]
    fn comments_of_the_owner_stay() {
        let (_, migration) = migrated(PRINTER);
        assert!(migration.text.contains("# measured with a calliper"), "{}", migration.text);
    }
}

//! Klipper's printer.cfg becomes a config.ini for the Prime, with a report of what became of every option.

mod account;
mod files;
mod migration;
mod page;
mod pins;
mod reader;
mod rules;
mod sections;
mod source;
mod wiring;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use config::{BoardId, Diagnostic, Severity, Summary};

use super::ini;
use account::Account;
use migration::Migration;
use source::Source;
use wiring::Wire;

/// First line of the new file.
const HEAD: &str =
    "Migrated from Klipper's printer.cfg by velvet migrate. report.html says what became of every option.";

/// Returns whether a file is Klipper's: it is called so, or has a line that begins a section.
pub fn is_klipper(path: &Path) -> Result<bool> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("cfg")) {
        return Ok(true);
    }
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    Ok(String::from_utf8_lossy(&bytes).lines().any(|line| line.starts_with('[') && line.contains(']')))
}

/// Writes the folder of the new machine; returns whether it could start with it.
pub fn migrate(path: &Path, out: Option<&Path>, board: BoardId) -> Result<bool> {
    let source = files::read(path)?;
    let outcome = Outcome::new(&source, board);
    match out {
        None => print!("{}", outcome.text),
        Some(folder) if folder.is_file() => {
            bail!("{} is a file: of a printer.cfg --out names a folder", folder.display())
        }
        Some(folder) => outcome.save(&source, folder)?,
    }
    let name = out.map_or_else(|| PathBuf::from("config.ini"), |folder| folder.join("config.ini"));
    eprint!("{}", outcome.told(&name.display().to_string()));
    Ok(outcome.summary.is_complete())
}

/// Result of a migration.
struct Outcome {
    /// The new config.ini.
    text: String,
    account: Account,
    to_do: Vec<String>,
    wires: Vec<Wire>,
    findings: Vec<Diagnostic>,
    summary: Summary,
}

impl Outcome {
    fn new(source: &Source, board: BoardId) -> Self {
        let mut migration = Migration::new(source, board);
        rules::apply(&mut migration);
        let Migration { account, entries, mut to_do, wiring, .. } = migration;
        for (place, remark) in &source.remarks {
            to_do.push(format!("{}: {remark}", source.told(*place)));
        }
        to_do.push("motors: try the direction of each; to turn one, add or take away the ! of its dir_pin".to_owned());
        let text = ini::write(HEAD, &to_do, &entries);
        let mut findings: Vec<Diagnostic> = Vec::new();
        let (_, summary) = config::parse(text.as_bytes(), board, &mut findings);
        Self { text, account, to_do, wires: wiring.wires, findings, summary }
    }

    /// Writes config.ini, the report, and printer.cfg with its includes.
    fn save(&self, source: &Source, folder: &Path) -> Result<()> {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
        };
        let config = folder.join("config.ini");
        // What a person has changed since an earlier migration is not lost.
        if std::fs::read_to_string(&config).is_ok_and(|known| known != self.text) {
            let previous = folder.join("previous-config.ini");
            std::fs::rename(&config, &previous).with_context(|| format!("cannot write {}", previous.display()))?;
        }
        write("config.ini", &self.text)?;
        write("report.json", &page::json(self, source))?;
        write("report.html", &page::html(self, source))?;
        for (from, to) in copies(source) {
            let to = folder.join(to);
            if let Some(parent) = to.parent() {
                std::fs::create_dir_all(parent).with_context(|| format!("cannot make {}", parent.display()))?;
            }
            if std::path::absolute(&from)? != std::path::absolute(&to)? {
                std::fs::copy(&from, &to).with_context(|| format!("cannot write {}", to.display()))?;
            }
        }
        Ok(())
    }

    /// Returns what a person reads at the console.
    fn told(&self, name: &str) -> String {
        let mut out = String::new();
        for item in &self.to_do {
            out += &format!("to do: {item}\n");
        }
        let count = self.account.options();
        out += &format!(
            "{} options: {} converted ({} kept in printer.cfg), {} needless, {} refused\n",
            count.all, count.converted, count.kept, count.needless, count.refused
        );
        out + &config::render_all(&self.findings, self.summary, name, &self.text)
    }

    fn errors(&self) -> usize {
        self.findings.iter().filter(|finding| finding.severity != Severity::Warning).count()
    }
}

/// Returns the files to copy and their places in the new folder: as they lie to each other.
fn copies(source: &Source) -> Vec<(PathBuf, PathBuf)> {
    let whole = |path: &PathBuf| files::simplified(&std::path::absolute(path).unwrap_or_else(|_| path.clone()));
    let all: Vec<PathBuf> = source.files.iter().map(whole).collect();
    let mut root = all.first().and_then(|path| path.parent()).map(Path::to_owned).unwrap_or_default();
    while !all.iter().all(|path| path.starts_with(&root)) && root.pop() {}
    let placed = |path: &PathBuf| path.strip_prefix(&root).unwrap_or(path).to_owned();
    source.files.iter().cloned().zip(all.iter().map(placed)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use source::{Entry, Section};

    /// Sections and options that rules look at, and some that no rule knows.
    const KINDS: &[&str] = &[
        "printer",
        "stepper_x",
        "stepper_y",
        "stepper_z",
        "stepper_z1",
        "extruder",
        "extruder1",
        "heater_bed",
        "fan",
        "heater_fan a",
        "controller_fan b",
        "temperature_fan c",
        "output_pin d",
        "probe",
        "bltouch",
        "bed_mesh",
        "z_tilt",
        "quad_gantry_level",
        "screws_tilt_adjust",
        "tmc2209 stepper_x",
        "tmc5160 stepper_z1",
        "servo e",
        "neopixel f",
        "led g",
        "gcode_button h",
        "filament_switch_sensor i",
        "input_shaper",
        "safe_z_home",
        "board_pins",
        "verify_heater extruder",
        "thermistor j",
        "adc_temperature k",
        "gcode_macro L",
        "display",
        "mmu_servo m",
        "xyz",
    ];
    const OPTIONS: &[&str] = &[
        "kinematics",
        "max_velocity",
        "max_accel",
        "max_z_accel",
        "step_pin",
        "dir_pin",
        "enable_pin",
        "microsteps",
        "rotation_distance",
        "gear_ratio",
        "endstop_pin",
        "position_endstop",
        "position_max",
        "position_min",
        "pin",
        "heater_pin",
        "sensor_type",
        "sensor_pin",
        "control",
        "pid_kp",
        "max_temp",
        "heater",
        "value",
        "pwm",
        "scale",
        "run_current",
        "cs_pin",
        "uart_address",
        "points",
        "z_positions",
        "gantry_corners",
        "screw1",
        "mesh_min",
        "mesh_max",
        "probe_count",
        "faulty_region_1_min",
        "faulty_region_1_max",
        "press_gcode",
        "switch_pin",
        "shaper_type",
        "shaper_freq_x",
        "home_xy_position",
        "aliases",
        "check_gain_time",
        "temperature1",
        "voltage1",
        "temperature2",
        "voltage2",
        "control_pin",
        "color_order",
        "shared_heater",
        "nonsense",
        "red_pin",
        "gcode",
    ];
    const VALUES: &[&str] = &[
        "",
        "0",
        "1",
        "-3",
        "16",
        "40",
        "1e9",
        "nan",
        "yes",
        "pid",
        "watermark",
        "cartesian",
        "corexy",
        "delta",
        "generic_cartesian",
        "^!PA1",
        "PB2",
        "z:PB2",
        "probe:z_virtual_endstop",
        "tmc2209_stepper_x:virtual_endstop",
        "EPCOS 100K B57560G104F",
        "temperature_host",
        "MAX31856",
        "j",
        "k",
        "10, 20",
        "10,20\n30,40",
        "80:20",
        "0:0",
        "extruder",
        "extruder, heater_bed",
        "G28",
        "{x}",
        "A=B, B=A",
        "GRB,RGB",
        "mzv",
        "ei",
        "bicubic",
        "lagrange",
    ];

    fn any_of(list: &'static [&'static str]) -> impl Strategy<Value = String> {
        proptest::sample::select(list).prop_map(str::to_owned)
    }

    fn any_section() -> impl Strategy<Value = Section> {
        let options = proptest::collection::btree_map(any_of(OPTIONS), any_of(VALUES), 0..24);
        (any_of(KINDS), options).prop_map(|(name, options)| {
            let entry = |(name, value)| Entry { name, value, ..Entry::default() };
            Section { name, options: options.into_iter().map(entry).collect(), ..Section::default() }
        })
    }

    proptest! {
        /// Whatever a file says: every option has one verdict with a reason or a result, the new file can be
        /// read, and no pin is given out twice.
        #[test]
        fn every_file_comes_to_an_account(sections in proptest::collection::vec(any_section(), 0..16)) {
            let mut once: Vec<Section> = Vec::new();
            for section in sections {
                if once.iter().all(|known| known.name != section.name) {
                    once.push(section);
                }
            }
            let source = Source { files: vec!["printer.cfg".into()], sections: once, ..Source::default() };
            let outcome = Outcome::new(&source, BoardId::default());
            for (section, of) in source.sections.iter().zip(&outcome.account.0) {
                prop_assert!(of.section.is_some(), "{}", section.name);
                for (entry, verdict) in section.options.iter().zip(&of.options) {
                    let told = verdict.as_ref().is_some_and(|v| !v.reason.is_empty() || !v.becomes.is_empty());
                    prop_assert!(told, "[{}] {}", section.name, entry.name);
                }
            }
            let twice = outcome.findings.iter().find(|finding| finding.reason.contains("is used by"));
            prop_assert!(twice.is_none(), "{:?}\n{}", twice, outcome.text);
        }

        /// No text makes the reader panic.
        #[test]
        fn any_text_is_read_or_refused(text in "[\\[\\]a-z:=#; \\n\\t_]{0,120}") {
            let mut source = Source { files: vec!["printer.cfg".into()], ..Source::default() };
            let mut reader = reader::Reader::new(&mut source);
            let place = source::Place::default();
            let is_read = text.split('\n').all(|line| reader.line(line, place).is_ok());
            reader.end();
            if is_read {
                let options: usize = source.sections.iter().map(|section| section.options.len()).sum();
                prop_assert_eq!(Outcome::new(&source, BoardId::default()).account.options().all, options);
            }
        }
    }
}

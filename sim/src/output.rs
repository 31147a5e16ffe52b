//! The files a run leaves: `console.log`, `steps.csv`, `telemetry.csv` and `summary.json`; with a laser
//! `power.csv` too.
//!
//! Edges are written as they come, so a long run needs no memory for them. Every file is a function of the
//! run alone: no wall-clock time, no path.

mod json;
mod summary;

pub use summary::{Outcome, StepError};

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use units::Direction;

use crate::trace::PowerChange;
use crate::world::World;

/// Interval of telemetry rows.
const TELEMETRY_NS: u64 = 100_000_000;

/// File of the changes of a laser's power, with the duty in 1/65535.
const POWER: &str = "power.csv";

/// Writes a run's files into one directory.
#[derive(Debug)]
pub struct Recorder {
    directory: PathBuf,
    console: BufWriter<File>,
    steps: BufWriter<File>,
    /// Made with the first change of power.
    power: Option<BufWriter<File>>,
    telemetry: BufWriter<File>,
    next_telemetry_ns: u64,
}

impl Recorder {
    /// Creates the directory, if need be, and the files in it.
    ///
    /// # Errors
    /// What the file system says, with the path.
    pub fn create(directory: &Path, world: &World) -> io::Result<Self> {
        let named =
            |path: &Path, error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
        fs::create_dir_all(directory).map_err(|error| named(directory, error))?;
        let file = |name: &str| {
            let path = directory.join(name);
            File::create(&path).map(BufWriter::new).map_err(|error| named(&path, error))
        };
        let mut recorder = Self {
            directory: directory.to_owned(),
            console: file("console.log")?,
            steps: file("steps.csv")?,
            power: None,
            telemetry: file("telemetry.csv")?,
            next_telemetry_ns: 0,
        };
        // A run without power must not show that of the run before.
        match fs::remove_file(directory.join(POWER)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(named(&directory.join(POWER), error)),
            _ => {}
        }
        writeln!(recorder.steps, "time_ns,actuator,direction")?;
        write!(recorder.telemetry, "time_s")?;
        for heater in &world.config().heaters {
            write!(recorder.telemetry, ",{0}_c,{0}_duty", heater.name)?;
        }
        writeln!(recorder.telemetry, ",vmotor_v,vfet_v,cpu_load")?;
        Ok(recorder)
    }

    /// Bytes of the console, as they came.
    ///
    /// # Errors
    /// What the file system says.
    pub fn console(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.console.write_all(bytes)
    }

    /// Writes the edges since the last call, and a telemetry row when one is due. `cpu_load` is the share of
    /// time the processor did not sleep, 0 to 1; not a number when it is not known.
    ///
    /// # Errors
    /// What the file system says.
    pub fn observe(&mut self, world: &mut World, cpu_load: f64) -> io::Result<()> {
        for edge in world.trace_mut().take() {
            let direction = match edge.direction {
                Direction::Forward => "1",
                Direction::Backward => "-1",
            };
            writeln!(self.steps, "{},{},{direction}", edge.time_ns, edge.actuator.name())?;
        }
        self.power(&world.trace_mut().take_power())?;
        if world.now_ns() < self.next_telemetry_ns {
            return Ok(());
        }
        self.next_telemetry_ns = world.now_ns() / TELEMETRY_NS * TELEMETRY_NS + TELEMETRY_NS;
        write!(self.telemetry, "{:.3}", world.now_ns() as f64 * 1e-9)?;
        for index in 0..world.config().heaters.len() {
            write!(self.telemetry, ",{:.2},{:.4}", world.heater_c(index), world.heater_mean_duty(index))?;
        }
        let load = if cpu_load.is_finite() { format!("{cpu_load:.4}") } else { String::new() };
        writeln!(self.telemetry, ",{:.2},{:.2},{load}", world.vmotor_v(), world.vfet_v())
    }

    fn power(&mut self, changes: &[PowerChange]) -> io::Result<()> {
        if changes.is_empty() {
            return Ok(());
        }
        let power = match &mut self.power {
            Some(power) => power,
            None => {
                let mut file = BufWriter::new(File::create(self.directory.join(POWER))?);
                writeln!(file, "time_ns,duty")?;
                self.power.insert(file)
            }
        };
        changes.iter().try_for_each(|change| writeln!(power, "{},{}", change.time_ns, change.duty))
    }

    /// Writes what is left and the summary.
    ///
    /// # Errors
    /// What the file system says.
    pub fn finish(mut self, world: &mut World, outcome: &Outcome) -> io::Result<()> {
        self.observe(world, f64::NAN)?;
        self.console.flush()?;
        self.steps.flush()?;
        self.telemetry.flush()?;
        self.power.as_mut().map_or(Ok(()), Write::flush)?;
        fs::write(self.directory.join("summary.json"), summary::render(world, outcome))
    }
}

/// Writes the result of a verification that came after the run into its summary: the distances, or one more
/// error.
///
/// # Errors
/// What the file system says, with the path; or that the file is no summary of ours.
pub fn add_verification(directory: &Path, result: &Result<StepError, String>) -> Result<(), String> {
    let path = directory.join("summary.json");
    let fail = |error: io::Error| format!("{}: {error}", path.display());
    let text = fs::read_to_string(&path).map_err(fail)?;
    let text = summary::with_verification(&text, result)
        .ok_or_else(|| format!("{}: not a summary that a run has left", path.display()))?;
    fs::write(&path, text).map_err(fail)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::WorldConfig;
    use units::Actuator;

    #[test]
    fn a_run_leaves_every_edge_and_a_summary_of_them() {
        let directory = std::env::temp_dir().join(format!("sim-output-{}", std::process::id()));
        let mut world = World::new(WorldConfig::default());
        let mut recorder = Recorder::create(&directory, &world).expect("a directory to write to");
        world.turn(0, Actuator::Beta, Direction::Backward);
        for step in 1..=3 {
            world.step(step * 1_000, Actuator::Beta);
        }
        world.trace_mut().push_power(PowerChange { time_ns: 2_500, duty: 65_535 });
        recorder.console(b"ok\n").expect("written");
        let starved_ns = Some(vec![1_500_000_000, 2_000_000_000]);
        let outcome = Outcome { halted: Some("a \"reason\"".into()), lines: 7, starved_ns, ..Outcome::default() };
        recorder.finish(&mut world, &outcome).expect("written");
        let read = |name: &str| fs::read_to_string(directory.join(name)).expect("written before");
        assert_eq!(read("steps.csv"), "time_ns,actuator,direction\n1000,beta,-1\n2000,beta,-1\n3000,beta,-1\n");
        assert_eq!(read("power.csv"), "time_ns,duty\n2500,65535\n");
        assert_eq!(read("console.log"), "ok\n");
        assert!(
            read("telemetry.csv")
                .starts_with("time_s,hotend_c,hotend_duty,bed_c,bed_duty,vmotor_v,vfet_v,cpu_load\n0.000,22.00")
        );
        let summary = read("summary.json");
        for part in [
            "\"lines\": 7",
            "\"starved_at_s\": [1.5000, 2.0000]",
            "\"halted\": \"a \\\"reason\\\"\"",
            "\"beta\": {\"steps\": 3,",
        ] {
            assert!(summary.contains(part), "{part} is not in {summary}");
        }
        for result in [Err("a \"step\"".to_owned()), Ok(StepError { max_ns: 7.0, rms_ns: 2.5, bins: [0; 12] })] {
            add_verification(&directory, &result).expect("a summary");
        }
        let verified = read("summary.json");
        let without = verified.replace("[\"a \\\"step\\\"\"]", "[]");
        assert_eq!(without.replace(",\n  \"step_error_ns\": {\"max\": 7.0, \"rms\": 2.50}", ""), summary);
        assert_ne!(without, verified);
        Recorder::create(&directory, &world).expect("the same directory");
        assert!(!directory.join(POWER).exists(), "a new run without power has no such file");
        fs::remove_dir_all(directory).expect("ours to remove");
    }
}

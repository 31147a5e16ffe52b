//! Jobs on the virtual board: runs them, as many at a time as there are processors, and reads what they gave.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::thread;

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

/// The tasks, by the interrupts that run them (`firmware/src/main.rs`).
pub const FEED: &str = "TIM6_DAC";
pub const HEAT: &str = "TIM7";
pub const BYTES: &str = "USART2";
pub const USB: &str = "OTG_FS";
/// The part of the heat task that stops heaters, whatever controls them.
pub const GUARD: &str = "look_at_heaters";
/// Called by the step interrupt when it missed an event by more than 250 ns.
pub const LATE: &str = "fall_behind";
/// The step interrupt, and the parts of it that are functions of their own.
pub const STEP: [&str; 4] = ["TIM2", "play_carefully", "catch_up", LATE];
/// What software asks for: the slow watch over drivers and supplies, the planner, and the chips of sensors.
pub const WATCH: &str = "LPTIM1";
pub const PLANNER: &str = "LPTIM2";
const SOFTWARE: [&str; 3] = [WATCH, PLANNER, "LPTIM3"];
/// The network's interrupt, and the executor's work for the network.
pub const ETHERNET: &str = "ETH";
pub const NETWORK: &str = "serve_network";
/// Interrupts besides the step interrupt.
const OTHERS: [&str; 3] = ["SDMMC1", USB, ETHERNET];

/// Where the step queue lies in the image, and when to look at it: at each run of the feed. The offset is
/// that of `queue` in the step interrupt's static (`bsp-prime/src/step_engine.rs`): four words, ten of
/// pulses, sixteen bytes and then eight for each of eight motors, and three words.
const QUEUE: &str = "TIM6_DAC,step_engine6SHARED,260";

/// The program and image of a measurement.
pub struct Job {
    pub name: String,
    pub config: String,
    pub gcode: String,
    /// Further words for the virtual board.
    pub words: Vec<String>,
    /// The machine may halt, because more is asked of it than it can do: then there is no result.
    may_halt: bool,
}

impl Job {
    pub fn new(name: impl Into<String>, config: &str, gcode: String) -> Self {
        Self { name: name.into(), config: config.to_owned(), gcode, words: Vec::new(), may_halt: false }
    }

    /// The console is flooded, and interrupt masks and the step queue are watched. It may be too much.
    pub fn under_load(mut self) -> Self {
        self.may_halt = true;
        self.words.extend(["--flood", "--masked", "--queue", QUEUE].map(str::to_owned));
        self
    }

    /// A computer at the USB socket says and hears all it can.
    pub fn with_computer(mut self) -> Self {
        self.words.push("--usb-flood".to_owned());
        self
    }

    /// The cable is in, with this traffic while the machine moves.
    pub fn with_network(mut self, traffic: &str) -> Self {
        self.words.extend(["--network", traffic].map(str::to_owned));
        self
    }

    /// A hold is asked for after this many steps, and `delay_us` microseconds.
    pub fn held_after(mut self, steps: u64, delay_us: u64) -> Self {
        let (steps, delay_us) = (steps.to_string(), delay_us.to_string());
        self.words.extend(["--hold-after".to_owned(), steps, "--hold-delay-us".to_owned(), delay_us]);
        self
    }
}

/// Paths of the image, the board and the tools.
pub struct Bench<'a> {
    pub elf: &'a Path,
    pub virtual_prime: &'a Path,
    pub velvet: &'a Path,
    pub scratch: PathBuf,
}

/// Results of a job: the virtual board's counts, and the run's summary.
#[derive(Debug)]
pub struct Measured {
    counts: Value,
    summary: Value,
    /// The folder of its files.
    pub out: PathBuf,
}

/// Results by the jobs' names.
pub struct Results(BTreeMap<String, Measured>);

impl Results {
    pub fn of(&self, name: &str) -> Result<&Measured> {
        self.0.get(name).with_context(|| format!("no job {name}"))
    }
}

impl<'a> Bench<'a> {
    /// Creates the bench for an image, without the programs that verify its steps.
    pub fn of(root: &Path, elf: &'a Path, virtual_prime: &'a Path) -> Self {
        Self { elf, virtual_prime, velvet: Path::new(""), scratch: root.join("out/bench") }
    }

    /// Runs all of them.
    pub fn run(&self, jobs: Vec<Job>) -> Result<Results> {
        let workers = thread::available_parallelism().map_or(1, usize::from).min(jobs.len());
        let (queue, results) = (Mutex::new(jobs.into_iter()), Mutex::new(BTreeMap::new()));
        let next = || queue.lock().ok()?.next();
        let work = || -> Result<()> {
            while let Some(job) = next() {
                let measured = match self.job(&job) {
                    Err(halt) if job.may_halt => {
                        eprintln!("{halt:#}");
                        continue;
                    }
                    measured => measured?,
                };
                if let Ok(mut results) = results.lock() {
                    results.insert(job.name, measured);
                }
            }
            Ok(())
        };
        thread::scope(|scope| {
            let running: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
            running.into_iter().try_for_each(|worker| worker.join().unwrap_or_else(|_| bail!("a job panicked")))
        })?;
        Ok(Results(results.into_inner().unwrap_or_default()))
    }

    fn job(&self, job: &Job) -> Result<Measured> {
        let name = &job.name;
        let out = self.scratch.join(name);
        let write = |file: &str, text: &str| -> Result<PathBuf> {
            let path = out.join(file);
            fs::write(&path, text).with_context(|| path.display().to_string())?;
            Ok(path)
        };
        fs::create_dir_all(&out).with_context(|| out.display().to_string())?;
        eprintln!("measuring {name}");
        let functions: Vec<&str> =
            STEP.into_iter().chain([FEED, HEAT, GUARD, BYTES, NETWORK]).chain(SOFTWARE).chain(OTHERS).collect();
        let output = Command::new(self.virtual_prime)
            .arg("bench")
            .arg("--elf")
            .arg(self.elf)
            .arg("--config")
            .arg(write("config.ini", &job.config)?)
            .arg("--gcode")
            .arg(write("job.gcode", &job.gcode)?)
            .arg("--out")
            .arg(&out)
            .args(["--until", "60", "--function", &functions.join(",")])
            .args(&job.words)
            .output()
            .with_context(|| self.virtual_prime.display().to_string())?;
        if !output.status.success() {
            bail!("{name}: {}", String::from_utf8_lossy(&output.stderr).trim());
        }
        let counts = serde_json::from_slice(&output.stdout).with_context(|| format!("{name}: the counts"))?;
        let summary = summary(&out).with_context(|| format!("{name}: the summary"))?;
        ensure!(
            summary["board"].as_array().is_none_or(Vec::is_empty),
            "{name}: the board complains: {}",
            summary["board"]
        );
        Ok(Measured { counts, summary, out })
    }

    /// Largest and mean distance of a run's steps from where the oracle puts them, nanoseconds.
    pub fn step_error(&self, run: &Measured) -> Result<(f64, f64)> {
        let output = Command::new(self.velvet)
            .arg("verify")
            .arg(&run.out)
            .arg("--config")
            .arg(run.out.join("config.ini"))
            .arg("--gcode")
            .arg(run.out.join("job.gcode"))
            .output()
            .with_context(|| self.velvet.display().to_string())?;
        ensure!(output.status.success(), "verify: {}", String::from_utf8_lossy(&output.stdout).trim());
        let summary = summary(&run.out)?;
        let number =
            |key: &str| summary["step_error_ns"][key].as_f64().with_context(|| format!("no step_error_ns.{key}"));
        Ok((number("max")?, number("rms")?))
    }
}

fn summary(out: &Path) -> Result<Value> {
    let path = out.join("summary.json");
    let text = fs::read(&path).with_context(|| path.display().to_string())?;
    serde_json::from_slice(&text).with_context(|| path.display().to_string())
}

impl Measured {
    /// A number of the counts.
    pub fn number(&self, path: &[&str]) -> Result<f64> {
        let value = path.iter().fold(&self.counts, |value, key| &value[key]);
        value.as_f64().with_context(|| format!("no number {}", path.join(".")))
    }

    /// Steps of all motors.
    pub fn steps(&self) -> Result<f64> {
        self.summary["edges"].as_f64().context("no number of edges")
    }

    /// Lines of the job.
    pub fn lines(&self) -> Result<f64> {
        self.number(&["lines"])
    }

    /// Instructions of a function from just before the first step to the last one.
    pub fn moving(&self, function: &str) -> Result<f64> {
        self.number(&["functions", function, "moving"])
    }

    /// The same of the whole step interrupt.
    pub fn emitting(&self) -> Result<f64> {
        STEP.into_iter().map(|function| self.moving(function)).sum()
    }

    /// All instructions from just before the first step to the last one.
    pub fn while_moving(&self) -> Result<f64> {
        self.number(&["moving", "instructions"])
    }

    /// Seconds from the first step to the last one.
    pub fn seconds_moving(&self) -> Result<f64> {
        self.number(&["moving", "seconds"])
    }

    /// Of a function's calls, `min`, `median`, `p99` or `max`.
    pub fn calls(&self, function: &str, statistic: &str) -> Result<f64> {
        self.number(&["functions", function, statistic])
    }

    /// Instructions of consoles and executor to the last step: what no counted task executed.
    pub fn executor(&self) -> Result<f64> {
        let tasks = STEP.into_iter().chain([FEED, HEAT, BYTES]).chain(SOFTWARE).chain(OTHERS);
        let counted: Result<f64> = tasks.map(|function| self.number(&["functions", function, "to_last_step"])).sum();
        Ok(self.number(&["to_last_step"])? - counted?)
    }
}

//! A whole job on the native runner, as `make run BOARD=native` does it.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use base::sessions::SessionId;

use super::{FeedPhase, InSearches, Mismatch, Plan, Runner, Setup};
use crate::models::tmc26x::Chip;
use crate::output::{Outcome, Recorder, StepError};
use crate::session::{Opening, Session};
use crate::trace::StepEdge;
use crate::world::TimedFault;

/// Name of the job on the card.
const FILE: &str = "job.gcode";
/// Greatest number of starvations of the planner that a summary lists.
const MOST_STARVED: usize = 1_000;

/// Job with the settings of its run.
#[derive(Clone, Debug)]
pub struct Job {
    /// File of the machine's configuration.
    pub config: PathBuf,
    /// File of the job's G-code.
    pub gcode: PathBuf,
    /// Folder for the run's files.
    pub out: PathBuf,
    /// Give up after this much virtual time.
    pub until_ns: Option<u64>,
    /// Model of the board's driver chips.
    pub chip: Chip,
    /// Faults, and when they happen.
    pub faults: Vec<TimedFault>,
    /// Whether to compare every step edge with the oracle.
    pub verify: bool,
}

/// Machine with the job on its card, and the operator.
struct Played {
    runner: Runner,
    session: Session,
    errors: Vec<String>,
}

/// Runs a job and writes its files. `progress` hears the share done, 0 to 1, as it grows.
///
/// # Errors
/// When files cannot be read or written, or a fault names something the machine does not have. How the job
/// itself went is in the [`Outcome`].
pub fn run(job: &Job, progress: &mut dyn FnMut(f64)) -> Result<Outcome, String> {
    let fail = |error: io::Error| format!("{}: {error}", job.out.display());
    let text = fs::read(&job.gcode).map_err(|error| format!("{}: {error}", job.gcode.display()))?;
    let lines = text.split(|byte| *byte == b'\n').filter(|line| !line.is_empty()).count() as u64;
    let mut played = Played::set_up(job, &job.out.join("card"))?;
    if job.verify {
        played.runner.verify()?;
    }
    let mut recorder = played.runner.world(|world| Recorder::create(&job.out, world)).map_err(fail)?;
    let mut starved = Vec::new();
    let mut counted = 0;
    played.play(job.until_ns, progress, &mut |runner, sent| {
        recorder.console(sent)?;
        let count = runner.motion(|motion| motion.counters().starved);
        let new = (counted..count).take(MOST_STARVED.saturating_sub(starved.len()));
        starved.extend(new.map(|_| runner.now_ns()));
        counted = count;
        // The host has no processor whose load could be measured.
        runner.world(|world| recorder.observe(world, f64::NAN))?;
        Ok(true)
    })?;
    let Played { runner, session, mut errors } = played;
    let step_error = runner.step_error().and_then(|result| result.map_err(|stray| errors.push(stray)).ok());
    let halted = session.halted().map(str::to_owned);
    let outcome = Outcome { lines, halted, errors, step_error, starved_ns: Some(starved), ..Outcome::default() };
    runner.world(|world| recorder.finish(world, &outcome)).map_err(fail)?;
    Ok(outcome)
}

/// Compares step edges that another board made of a job with the job's ideal motion. `edges` gives them
/// anew for each try: a board may have begun to brake at a switch a segment sooner or later than the native
/// runner ([`FeedPhase`]), and only the comparison tells which.
///
/// # Errors
/// As [`plan`], and the place where the board did something else than any plan has.
pub fn verify<E>(
    job: &Job,
    progress: &mut dyn FnMut(f64),
    edges: &mut dyn FnMut() -> Result<E, String>,
) -> Result<StepError, String>
where
    E: Iterator<Item = Result<StepEdge, String>>,
{
    let mut phases = Vec::new();
    loop {
        let ideal = plan(job, &phases, None, progress)?;
        let mismatch = match ideal.compare(edges()?, InSearches::Doubt) {
            Ok(error) => return Ok(error),
            Err(mismatch) => mismatch,
        };
        let mut better = None;
        for trial in other_phases(&ideal, &mismatch, &phases) {
            // The next motion shows whether the plan is right; the rest of the job need not run for that.
            let ideal = plan(job, &trial, Some(mismatch.motion + 2), progress)?;
            if ideal.compare(edges()?, InSearches::Doubt).map_or_else(|next| next.motion > mismatch.motion, |_| true) {
                better = Some(trial);
                break;
            }
        }
        phases = match better {
            Some(trial) => trial,
            None if mismatch.is_doubt => {
                return ideal.compare(edges()?, InSearches::Count).map_err(|mismatch| mismatch.reason);
            }
            None => return Err(mismatch.reason),
        };
    }
}

/// Returns the other possible phases of the last two searches before a mismatch.
fn other_phases(ideal: &Plan, mismatch: &Mismatch, phases: &[FeedPhase]) -> Vec<Vec<FeedPhase>> {
    let begun = ideal.motions().nth(mismatch.motion.saturating_sub(1)).map_or(0, |motion| motion.searches);
    let mut all = Vec::new();
    for search in (begun.saturating_sub(2)..begun).rev() {
        for phase in [FeedPhase::After, FeedPhase::Before] {
            let mut trial = phases.to_vec();
            trial.resize(search + 1, FeedPhase::Exact);
            trial[search] = phase;
            all.push(trial);
        }
    }
    // The phases tried before led to this mismatch.
    all.retain(|trial| trial != phases);
    all
}

/// Runs a job for its ideal motion, or the first so many motions of it. Leaves no files.
///
/// # Errors
/// As [`run`], and when the job does not go through: then there is nothing to compare with.
pub fn plan(
    job: &Job,
    phases: &[FeedPhase],
    motions: Option<usize>,
    progress: &mut dyn FnMut(f64),
) -> Result<Plan, String> {
    let card = std::env::temp_dir().join(format!("velvet-plan-{}-{job:p}", std::process::id()));
    let result = plan_on(job, phases, motions, &card, progress);
    // A folder left behind harms nobody.
    let _ = fs::remove_dir_all(&card);
    result
}

fn plan_on(
    job: &Job,
    phases: &[FeedPhase],
    motions: Option<usize>,
    card: &Path,
    progress: &mut dyn FnMut(f64),
) -> Result<Plan, String> {
    let mut played = Played::set_up(job, card)?;
    played.runner.record(phases)?;
    played.play(job.until_ns, progress, &mut |runner, _| {
        runner.world(|world| world.trace_mut().take());
        Ok(motions.is_none_or(|enough| runner.recorded_motions() <= enough))
    })?;
    match played.session.halted().or(played.errors.first().map(String::as_str)) {
        Some(reason) => Err(format!("the native run of the job, whose plan is the reference, ended with: {reason}")),
        None => played.runner.take_plan().ok_or_else(|| "nothing was recorded".to_owned()),
    }
}

impl Played {
    fn set_up(job: &Job, card: &Path) -> Result<Self, String> {
        let explain = |path: &Path| {
            let path = path.display().to_string();
            move |error: io::Error| format!("{path}: {error}")
        };
        fs::create_dir_all(card).map_err(explain(card))?;
        fs::copy(&job.config, card.join("config.ini")).map_err(explain(&job.config))?;
        fs::copy(&job.gcode, card.join(FILE)).map_err(explain(&job.gcode))?;
        let setup = Setup { chip: job.chip, faults: job.faults.clone(), ..Setup::new(card) };
        Ok(Self { runner: Runner::new(&setup)?, session: Session::new(FILE, Opening::AtOnce), errors: Vec::new() })
    }

    /// Plays the job to its end; `each` sees the machine after each slot with its new text, and decides
    /// whether to go on.
    fn play(
        &mut self,
        until_ns: Option<u64>,
        progress: &mut dyn FnMut(f64),
        each: &mut dyn FnMut(&mut Runner, &[u8]) -> io::Result<bool>,
    ) -> Result<(), String> {
        let console = SessionId(0);
        let mut late = None;
        while !self.session.is_over() && late.is_none() {
            let runner = &mut self.runner;
            if until_ns.is_some_and(|until| runner.now_ns() >= until) {
                late = Some(format!("the job had not ended after {:.1} s", runner.now_ns() as f64 * 1e-9));
                continue;
            }
            runner.step();
            let sent = runner.read_from(console);
            self.session.hear(runner.now_ns(), &sent);
            if let Some(line) = self.session.say(runner.now_ns()) {
                runner.type_on(console, &line);
            }
            if !each(runner, &sent).map_err(|error| error.to_string())? {
                return Ok(());
            }
            if let Some(done) = self.session.progress() {
                progress(done);
            }
        }
        self.errors.extend(self.session.errors().iter().cloned());
        self.errors.extend(late);
        Ok(())
    }
}

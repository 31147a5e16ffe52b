//! The machine's side of a forecast: its needs of the machine, and its listeners.
//!
//! The work itself goes on beside the executor ([`preflight::forecast`]). At the waiting points it is brought
//! the bytes it asks for, a block of the card at a time, and only while the look-ahead queue is empty, takes
//! no more, or has all there is of the job.

mod input;
mod time_left;

use core::fmt::Arguments;

use base::clock_time::Clock;
use base::failure::{Failure, Outcome};
use base::paths::Path;
use base::ports::{OpenMode, StorageError};
use base::safety::travel::Travel;
use base::secrets::open_to_show;
use base::sessions::{Listing, Recipient, Reply};
use base::taken_codes::TakenCodes;
use base::tuning::Tuning;
use base::{Ports, World};
use config::JobPreflight;
use jobs::player::{Jobs, Lookup, PausePlace};
use preflight::forecast::{Answer, ForecastFiles, Forecaster, Purpose, SharedForecast, Stage};
use preflight::{AsItIs, Kind, TOLD_LINES, Told};
use printer_cfg::Looks;
use program::{Dialect, Interpreter};
use units::{AxisSet, Celsius, MAX_HEATERS, Micros};

use self::input::{bring, look};
use self::time_left::follow;
pub(crate) use self::time_left::{say_bytes, say_progress, time_left};
use crate::machine::moments::{JobBegins, JobStart, Moments};
use crate::machine::work_hands::WorldHands;
use crate::machine::{Machine, long_answers};

/// Time after which a job's wait for the look at its file is told first; later each time the wait has
/// doubled.
const TOLD_FIRST: Micros = Micros::from_seconds(1);
/// Greatest number of findings told that stop a job.
const MOST_WARNINGS: u32 = 5;
const CHANGED: &str = "the file has changed meanwhile";

/// A forecast, and what the file is looked at with.
pub(crate) struct Forecasting<'m, 'c, P> {
    forecast: &'c SharedForecast,
    forecaster: &'m mut dyn Forecaster,
    /// Files that the forecast reads.
    files: &'m mut ForecastFiles,
    jobs: &'m mut Jobs,
    world: &'m mut World<'c, P>,
    program: &'m Interpreter,
    tuning: &'m Tuning,
    travel: &'m Travel,
    homed: AxisSet,
    taken: TakenCodes,
    /// Macros that the look has entered.
    looks: &'m mut Looks,
}

/// The machine for looks ahead at a file.
pub(crate) trait ForecastHands<'c>: WorldHands<'c> {
    /// Whether a file is being looked at.
    fn looks_at_file(&self) -> bool;

    /// Whether there is a job, played or paused.
    fn has_job(&self) -> bool;

    /// Returns the forecast.
    fn forecast(&mut self) -> Forecasting<'_, 'c, Self::Ports>;
}

impl<'c, P: Ports> ForecastHands<'c> for Machine<'c, P> {
    fn looks_at_file(&self) -> bool {
        self.forecast_files.is_open()
    }

    fn has_job(&self) -> bool {
        self.jobs.is_open()
    }

    // Many places ask, and each would gather all of this for itself.
    #[inline(never)]
    fn forecast(&mut self) -> Forecasting<'_, 'c, P> {
        Forecasting {
            forecast: self.forecast,
            forecaster: self.forecaster,
            files: &mut self.forecast_files,
            jobs: &mut self.jobs,
            world: &mut self.world,
            program: &self.program,
            tuning: &self.tuning,
            travel: &self.safety.travel,
            homed: self.axes.homed(),
            taken: self.taken_codes,
            looks: self.features.macros.memory.store.looks(),
        }
    }
}

/// The look ahead at a file, at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: ForecastHands<'c>> Moments<M> for Feature {
    fn each_turn(hands: &mut M) {
        if hands.looks_at_file() {
            serve(&mut hands.forecast());
        }
    }

    fn each_10_ms(hands: &mut M, _now: Micros) {
        if hands.has_job() {
            follow(&mut hands.forecast());
        }
    }

    fn job_may_start(hands: &mut M) -> JobStart {
        job_begins(&mut hands.forecast())
    }

    fn job_begins(hands: &mut M, from: JobBegins) {
        if from == JobBegins::Again {
            job_goes_on(&mut hands.forecast());
        }
    }

    fn long_answer(hands: &mut M, listing: &mut Listing, to: Recipient) -> Option<Result<bool, Failure>> {
        match listing {
            Listing::Check { line } => Some(check_piece(&mut hands.forecast(), line, to)),
            _ => None,
        }
    }
}

/// Begins a forecast of a file for the machine as it is now (`check file`).
pub(crate) fn check<P: Ports>(ahead: &mut Forecasting<'_, '_, P>, path: &Path, to: Recipient) -> Outcome {
    let forecast = ahead.forecast;
    if forecast.is_under_way() {
        return Err(ahead.world.texts.because(match forecast.purpose() {
            Purpose::Job => "the file that is played is still looked at: ask again in a moment",
            Purpose::Check => "a file is being looked at already",
        }));
    }
    begin(ahead, path, Purpose::Check, None)?;
    long_answers::begin(ahead.world, Listing::Check { line: 0 }, to)
}

/// Begins the forecast of a job that is about to begin, which waits for it if so configured.
pub(crate) fn job_begins<P: Ports>(ahead: &mut Forecasting<'_, '_, P>) -> JobStart {
    let waits = matches!(ahead.world.config.player.preflight, JobPreflight::Travel | JobPreflight::Refuse);
    start(ahead, waits && !ahead.jobs.is_forced())
}

/// Begins the forecast of a job that goes on after a power cut: the job does not wait for it.
pub(crate) fn job_goes_on<P: Ports>(ahead: &mut Forecasting<'_, '_, P>) {
    // A job that does not wait for its forecast cannot be ended by it.
    let _now = start(ahead, false);
}

fn start<P: Ports>(ahead: &mut Forecasting<'_, '_, P>, holds: bool) -> JobStart {
    let forecast = ahead.forecast;
    if ahead.files.holds && ahead.files.job == ahead.jobs.count() {
        return match (ahead.world.config.player.preflight, forecast.is_under_way()) {
            (JobPreflight::Travel, _) => looked_at_for_a_while(ahead, forecast),
            (_, true) => {
                tell_how_far(ahead, forecast);
                JobStart::Later
            }
            (_, false) => looked_at(ahead, forecast),
        };
    }
    forecast.forget_course();
    let Some(path) = ahead.jobs.path().cloned() else { return JobStart::Now };
    if ahead.world.config.player.preflight == JobPreflight::Off {
        return JobStart::Now;
    }
    let dialect = ahead.jobs.dialect();
    match begin(ahead, &path, Purpose::Job, dialect) {
        Err(why) if why.is_refusal() && holds && ahead.world.config.player.preflight == JobPreflight::Refuse => {
            return refuse(ahead, format_args!("{}", ahead.world.texts.of(why)));
        }
        // A file that cannot be read twice is played all the same.
        Err(_) => return JobStart::Now,
        Ok(()) => {}
    }
    (ahead.files.job, ahead.files.holds) = (ahead.jobs.count(), holds);
    if holds {
        let now = ahead.world.ports.now();
        (ahead.files.waits_since, ahead.files.told_at) = (now, now);
        if ahead.world.config.player.preflight == JobPreflight::Travel {
            return JobStart::Later;
        }
        let size = u64::from(ahead.files.size).div_ceil(1_024);
        ahead.world.announce(format_args!(
            "// the whole file is looked at before it is begun, {size} kB; play --force file would not wait\n"
        ));
        return JobStart::Later;
    }
    JobStart::Now
}

/// Tells now and then how far the look is that the job waits for, and its remaining time at that pace.
fn tell_how_far<P: Ports>(ahead: &mut Forecasting<'_, '_, P>, forecast: &SharedForecast) {
    let (now, since) = (ahead.world.ports.now(), ahead.files.waits_since);
    let (waited, told) = (now.since(since), ahead.files.told_at.since(since));
    if waited < TOLD_FIRST || waited.0 < 2 * told.0 {
        return;
    }
    ahead.files.told_at = now;
    let seconds = waited.0 as f64 * 1e-6;
    let percent = looked_at_share(ahead, forecast);
    if percent > 0 {
        let left = seconds * (100.0 / f64::from(percent) - 1.0);
        ahead.world.announce(format_args!("// looked at {percent} % of the file, about {left:.0} s to go\n"));
    }
}

/// Returns the share of the file read, per cent; with loops and subroutines, the place of the look.
fn looked_at_share<P: Ports>(ahead: &Forecasting<'_, '_, P>, forecast: &SharedForecast) -> u8 {
    let share = u64::from(forecast.lines(|lines| lines.read())) * 100 / u64::from(ahead.files.size.max(1));
    share.min(100) as u8
}

/// Has the job wait for a configured time for a line that leaves the travel; the look goes on beside it.
fn looked_at_for_a_while<P: Ports>(ahead: &mut Forecasting<'_, '_, P>, forecast: &SharedForecast) -> JobStart {
    warn(ahead, forecast);
    if let Some(why) = ahead.files.spoilt {
        forecast.forget();
        return refuse(ahead, format_args!("{why}"));
    }
    let waited = ahead.world.ports.now().since(ahead.files.waits_since);
    if forecast.is_under_way() && waited < ahead.world.config.player.preflight_wait {
        return JobStart::Later;
    }
    ahead.files.holds = false;
    JobStart::Now
}

/// Decides on the job once its file has been looked at, or could not be.
fn looked_at<P: Ports>(ahead: &mut Forecasting<'_, '_, P>, forecast: &SharedForecast) -> JobStart {
    warn(ahead, forecast);
    ahead.files.holds = false;
    let stops = forecast.totals().stops;
    match forecast.stage() {
        Stage::Done if stops == 0 => {
            let (warnings, time) = (forecast.totals().warnings, Clock(forecast.totals().seconds()));
            ahead.world.announce(format_args!(
                "// nothing in it stops the job: {warnings} warnings, {time} without heating\n"
            ));
            JobStart::Now
        }
        Stage::Done => refuse(ahead, format_args!("{stops} of its lines would stop it")),
        Stage::Failed(why) => refuse(ahead, format_args!("it could not be looked at: {why}")),
        _ => refuse(ahead, format_args!("the look at it was broken off")),
    }
}

fn refuse<P: Ports>(ahead: &mut Forecasting<'_, '_, P>, why: Arguments<'_>) -> JobStart {
    let to = ahead.jobs.tells_end();
    ahead.jobs.close(&mut ahead.world.ports);
    ahead
        .world
        .announce(format_args!("error:the job was not begun: {why}; play --force file begins it all the same\n"));
    // Listeners for the end of the job need not wait any longer.
    if to != Recipient::Nobody {
        ahead.world.say(to, format_args!("Done printing file\n"));
    }
    JobStart::Never
}

fn begin<P: Ports>(
    ahead: &mut Forecasting<'_, '_, P>,
    path: &Path,
    purpose: Purpose,
    dialect: Option<Dialect>,
) -> Result<(), Failure> {
    let Forecasting { files, forecaster, forecast, world: World { ports, texts, .. }, .. } = ahead;
    forecast.forget();
    ahead.looks.clear();
    let can_look = ports.motion(|motion| forecaster.stand_as(motion));
    files.close(ports);
    let failed = |error: StorageError| texts.about_file(path, error.text());
    let file = open_to_show(ports, path, OpenMode::Beside).map_err(failed)?;
    let size = ports.size(file).map_err(failed)?;
    let forced = ahead.world.config.player.dialect.or(dialect);
    let lookup = forced.is_none().then(|| Lookup::new(size));
    // A check leaves everything known of the job.
    let (job, made) = (files.job, files.made);
    **files =
        ForecastFiles { path: path.clone(), file: Some(file), size, lookup, job, made, ..ForecastFiles::default() };
    let (targets, most_celsius) = ahead.world.ports.heat(|heat| {
        let mut targets = [Celsius(0.0); MAX_HEATERS];
        targets.iter_mut().zip(heat.heaters()).for_each(|(target, (_, heater))| *target = heater.target());
        let mut most = [Celsius(0.0); MAX_HEATERS];
        most.iter_mut().zip(heat.heaters()).for_each(|(most, (_, heater))| *most = heater.settings.max);
        (targets, most)
    });
    let Forecasting { program, tuning, travel, homed, taken, forecaster, forecast, .. } = ahead;
    let state = AsItIs {
        program,
        tuning,
        travel,
        homed: *homed,
        targets,
        most_celsius,
        dialect: forced,
        taken: *taken,
        goes_on: purpose == Purpose::Job,
    };
    forecaster.begin(purpose, file, &state);
    if !can_look {
        forecast.fail("there is no machine that could move, or no memory to look ahead");
    }
    Ok(())
}

// --- at the waiting points ---

/// Brings the input that the work waits for, and closes the files of ended work.
#[cold]
#[inline(never)]
pub(crate) fn serve<P: Ports>(ahead: &mut Forecasting<'_, '_, P>) {
    let forecast = ahead.forecast;
    if !forecast.is_under_way() {
        if forecast.stage() == Stage::Done && is_heard(ahead, forecast.purpose()) {
            // Findings of the last turn are still untold.
            warn(ahead, forecast);
        }
        let Forecasting { files, world: World { ports, .. }, .. } = ahead;
        return files.close(ports);
    }
    if !is_heard(ahead, forecast.purpose()) {
        return forecast.forget();
    }
    warn(ahead, forecast);
    let is_read = ahead.jobs.is_read();
    let may_run = ahead.world.ports.motion(|motion| is_read || motion.queue_level().0 == 0 || motion.is_full());
    let Forecasting { files, forecaster, world: World { ports, .. }, .. } = ahead;
    if let Some(lookup) = &mut files.lookup {
        forecast.allow(false);
        if may_run && look(lookup, files.file, forecast, *forecaster, ports).is_some() {
            files.lookup = None;
        }
        return;
    }
    forecast.allow(may_run);
    let is_at_hand = may_run && ports.is_at_hand(forecast.lines(|lines| lines.file()));
    if is_at_hand && let Some(wanted) = forecast.take_wanted(false) {
        let answer = bring(&wanted, files, forecast, ports).unwrap_or_else(|error| match error {
            StorageError::NotFound => Answer::Failed(CHANGED),
            error => Answer::Failed(error.text()),
        });
        forecast.answer(answer);
    }
}

/// Tells findings that stop the job, and has the job pause before them.
fn warn<P: Ports>(ahead: &mut Forecasting<'_, '_, P>, forecast: &SharedForecast) {
    if forecast.purpose() != Purpose::Job {
        return;
    }
    while let Some(finding) = forecast.take_finding() {
        // A line of a subroutine's own file may come again.
        let comes = finding.sub.is_some() || finding.line > ahead.jobs.line();
        let holds = ahead.files.holds;
        let waits_for_all = holds && ahead.world.config.player.preflight == JobPreflight::Refuse;
        // A bed without leveling is told beside the findings that stop the job.
        let stops_it = finding.kind != Kind::Unleveled;
        ahead.files.warned += u32::from(stops_it);
        // Findings at lines that the machine has come to are told by the machine itself.
        let is_news = holds || comes;
        // Lines behind a first finding are judged as if its move had been made.
        let most = if waits_for_all { MOST_WARNINGS } else { 1 };
        if ahead.world.config.player.preflight == JobPreflight::Time
            || stops_it && ahead.files.warned > most
            || !is_news
        {
            continue;
        }
        // The machine would stop there by itself, or halt and lose its place. Findings that depend on an
        // input or a probe, or lie in the file of a subroutine, may never be reached.
        let why = finding.kind.spoils_the_job();
        let is_sure = !forecast.guesses() && finding.sub.is_none();
        let stops = !waits_for_all && !ahead.jobs.is_forced() && why.is_some() && is_sure;
        if stops && holds {
            ahead.files.spoilt = ahead.files.spoilt.or(why);
        }
        if stops && !holds && comes && ahead.jobs.pauses.add(PausePlace::Line(finding.line), "").is_ok() {
            ahead.world.announce(format_args!("// WARNING {finding}: the job pauses before it\n"));
        } else {
            ahead.world.announce(format_args!("// WARNING {finding}\n"));
        }
    }
}

/// Whether anybody waits for the result.
fn is_heard<P: Ports>(ahead: &Forecasting<'_, '_, P>, purpose: Purpose) -> bool {
    match purpose {
        Purpose::Job => ahead.jobs.is_open(),
        Purpose::Check => ahead
            .world
            .sessions
            .ids()
            .filter_map(|id| ahead.world.sessions.get(id))
            .any(|session| matches!(session.listing, Some(Listing::Check { .. }))),
    }
}

// --- what comes of it ---

/// Tells some more of a check's findings. False when that was all.
///
/// # Errors
/// When the file could not be read to its end.
pub(crate) fn check_piece<P: Ports>(
    ahead: &mut Forecasting<'_, '_, P>,
    line: &mut usize,
    to: Recipient,
) -> Result<bool, Failure> {
    let forecast = ahead.forecast;
    if forecast.purpose() != Purpose::Check {
        return Err(Failure::refused(&"broken off: a job has begun"));
    }
    let config = ahead.world.config;
    let reply = &mut Reply::new(ahead.world.sessions, to);
    if let Some(finding) = forecast.take_finding() {
        reply.say(format_args!("{finding}\n"));
        return Ok(true);
    }
    match forecast.stage() {
        Stage::Ready | Stage::Running => Ok(true),
        Stage::Free => Err(Failure::refused(&"broken off")),
        Stage::Failed(why) => Err(ahead.world.texts.because(why)),
        Stage::Done => {
            if *line == 0 && forecast.missed() > 0 {
                reply.say(format_args!("and {} more\n", forecast.missed()));
            }
            let told = Told { config, totals: &forecast.totals(), line: *line };
            reply.say(format_args!("{told}"));
            *line += 1;
            Ok(*line < TOLD_LINES)
        }
    }
}

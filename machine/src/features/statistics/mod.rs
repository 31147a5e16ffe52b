//! Statistics of jobs: sampled while things move, kept on the card, said by M78.

use core::fmt::Write as _;

use base::failure::Answer;
use base::ports::StorageError;
use base::safe_file::Draft;
use base::sessions::Recipient;
use base::{Ports, World};
use config::HeaterId;
use events::Event;
use jobs::files::program_files::each_line;
use jobs::player::{Duration, HeaterTime, Jobs, STATISTICS_PATH, Statistics, Sums};
use program::{Interpreter, State, Words};
use units::{AxisSet, Micros};

use crate::features::state::States;
use crate::machine::moments::Moments;
use crate::machine::work_hands::WaitHands;
use crate::machine::{Machine, card};

/// Period of asking heaters for their work.
const HEAT_PERIOD: Micros = Micros::from_seconds(1);
/// S of M78 that forgets everything, as Prusa's does.
const RESET: f64 = 78.0;

/// Statistics, and what is counted for them.
pub(crate) struct Counted<'m, 'c, P> {
    world: &'m mut World<'c, P>,
    jobs: &'m mut Jobs,
    program: &'m Interpreter,
    is_checked: bool,
    /// Time of the next count of heaters' work.
    heat_due: &'m mut Micros,
}

/// The machine for statistics, and for saving them.
pub(crate) trait StatisticsHands<'c>: WaitHands<'c> {
    /// Returns the statistics.
    fn counted(&mut self) -> Counted<'_, 'c, Self::Ports>;
}

impl<'c, P: Ports> StatisticsHands<'c> for Machine<'c, P> {
    fn counted(&mut self) -> Counted<'_, 'c, P> {
        let is_checked = self.safety.state() == State::Check;
        let Self { world, jobs, program, features: States { heat_due, .. }, .. } = self;
        Counted { world, jobs, program, is_checked, heat_due }
    }
}

/// Statistics at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: StatisticsHands<'c>> Moments<M> for Feature {
    fn read_files(hands: &mut M) {
        let Counted { world, jobs, .. } = hands.counted();
        load(world, &mut jobs.statistics);
    }

    fn each_10_ms(hands: &mut M, now: Micros) {
        let Counted { world, jobs, program, is_checked, heat_due } = hands.counted();
        let plays = jobs.is_open() && !is_checked;
        sample(&mut world.ports, &mut jobs.statistics, program, plays, now);
        if now >= *heat_due {
            *heat_due = now.plus(HEAT_PERIOD);
            count_heat(world, &mut jobs.statistics);
        }
    }

    /// Saves new statistics, once nothing else is to be done.
    fn idle(hands: &mut M) -> bool {
        let Counted { jobs, .. } = hands.counted();
        if jobs.is_open() || !jobs.statistics.take_unsaved() {
            return false;
        }
        card::at_rest(hands);
        let Counted { world, jobs, .. } = hands.counted();
        let draft = write(&mut world.ports, &jobs.statistics);
        let written = draft.and_then(|draft| card::finish(hands, draft));
        if let Err(error) = written
            && error != StorageError::NoCard
        {
            hands.announce(format_args!("WARNING: {STATISTICS_PATH} was not written: {}\n", error.text()));
        }
        false
    }

    /// Ends the job's statistics, and tells them.
    fn job_ends(hands: &mut M, is_done: bool, to: Recipient) {
        let Counted { world, jobs, .. } = hands.counted();
        if jobs.is_open() {
            world.record(&Event::JobEnded { complete: is_done, line: jobs.line() });
        }
        if let Some(job) = jobs.statistics.end_job(is_done) {
            say_job(world, &job, to);
        }
    }

    fn job_is_dropped(hands: &mut M) {
        // They are saved when the machine has come to rest.
        let _ = hands.counted().jobs.statistics.end_job(false);
    }

    fn extruders_count_anew(hands: &mut M) {
        hands.counted().jobs.statistics.rest();
    }
}

/// Reads the statistics at boot. There need not be any.
fn load<P: Ports>(world: &mut World<'_, P>, statistics: &mut Statistics) {
    let mut bad = 0;
    let read = each_line(&mut world.ports, STATISTICS_PATH, |_, line| {
        let line = line.and_then(|line| core::str::from_utf8(line).ok());
        bad += u32::from(!line.is_some_and(|line| statistics.read(line)));
    });
    match read {
        Ok(()) if bad == 0 => {}
        Ok(()) => world.announce(format_args!("WARNING: {STATISTICS_PATH}: {bad} lines were left out\n")),
        Err(StorageError::NotFound | StorageError::NoCard) => {}
        Err(error) => world.announce(format_args!("WARNING: {STATISTICS_PATH} was not read: {}\n", error.text())),
    }
}

/// Samples the place of the tool; `plays`: a job is under way.
fn sample<P: Ports>(ports: &mut P, statistics: &mut Statistics, program: &Interpreter, plays: bool, now: Micros) {
    let moves = !ports.motion(|motion| motion.is_idle());
    if !moves && !plays {
        return statistics.rest();
    }
    let place = ports.motion(|motion| motion.live_position());
    let extruders = AxisSet::collect(program.tools().all().iter().map(|tool| tool.settings.axis));
    statistics.sample(now, plays, moves, &place, extruders);
}

/// Counts the work of heaters.
fn count_heat<P: Ports>(World { ports, config, .. }: &mut World<'_, P>, statistics: &mut Statistics) {
    statistics.heaters.heats(ports.heat(|heat| heat.any_on()));
    for (id, heater) in HeaterId::all().zip(&config.temperatures) {
        statistics.heaters.add(&heater.name, ports.heat(|heat| heat.take_work(id)));
    }
}

fn say_job<P: Ports>(world: &mut World<'_, P>, job: &Sums, to: Recipient) {
    let (time, still, way, filament) =
        (Duration(job.job), Duration(job.still), job.way / 1000.0, job.filament / 1000.0);
    world.say(to, format_args!("the job took {time} ({still} of it still): {way:.2} m of way"));
    if filament > 0.0 {
        world.say(to, format_args!(", {filament:.3} m of filament"));
    }
    world.say(to, format_args!("\n"));
}

/// Tells the statistics, or resets them (M78, M78 S78).
pub(crate) fn told<P: Ports>(
    world: &mut World<'_, P>,
    statistics: &mut Statistics,
    words: &Words<'_>,
    to: Recipient,
) -> Answer {
    if words.get('S') == Some(RESET) {
        statistics.reset();
        return Answer::Ok;
    }
    if let Some(job) = statistics.before {
        say_job(world, &job, to);
    }
    let life = statistics.life;
    let (done, broken_off) = (life.done, life.broken_off);
    world.say(to, format_args!("jobs: {done} done, {broken_off} broken off\n"));
    let (job, still, longest) = (Duration(life.sums.job), Duration(life.sums.still), Duration(life.longest));
    world.say(to, format_args!("time: {job} in jobs ({still} of it still), the longest {longest}\n"));
    let (moving, way, filament) = (Duration(life.moving), life.sums.way / 1000.0, life.sums.filament / 1000.0);
    world.say(
        to,
        format_args!("the machine has moved for {moving}; in jobs {way:.1} m of way, {filament:.2} m of filament\n"),
    );
    for &HeaterTime { ref name, on_s, full_s } in statistics.heaters.all() {
        let time = |s: f64| Duration(Micros((s * 1e6) as u64));
        world.say(to, format_args!("heater {name}: on for {}, as much as {} at full power", time(on_s), time(full_s)));
        if let Some(heater) = world.config.temperatures.iter().find(|heater| heater.name == *name) {
            let kwh = full_s / 3.6e6 * f64::from(heater.model.power_w);
            world.say(to, format_args!(", {kwh:.3} kWh with a heater_power of {} W", heater.model.power_w));
        }
        world.say(to, format_args!("\n"));
    }
    Answer::Ok
}

/// Writes the statistics into a new file, which is still to be put in the place of the old one.
fn write<P: Ports>(ports: &mut P, statistics: &Statistics) -> Result<Draft<P>, StorageError> {
    let mut text = heapless::String::<512>::new();
    if write!(text, "{}", statistics.life).is_err() {
        return Err(StorageError::Full);
    }
    let mut draft = Draft::begin(ports, STATISTICS_PATH)?;
    let written = draft.write(ports, text.as_bytes());
    let mut lines = statistics.heaters.lines().map(|line| draft.write(ports, line.as_bytes()));
    if let Err(error) = written.and_then(|_| lines.try_for_each(|line| line.map(drop))) {
        draft.give_up(ports);
        return Err(error);
    }
    drop(lines);
    Ok(draft)
}

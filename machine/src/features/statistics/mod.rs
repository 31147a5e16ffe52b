//! Statistics of jobs: sampled while things move, kept on the card, said by M78.

use core::fmt::Write as _;

use base::Ports;
use base::failure::Answer;
use base::ports::StorageError;
use base::safe_file::Draft;
use base::sessions::Recipient;
use config::HeaterId;
use events::Event;
use jobs::files::program_files::each_line;
use jobs::player::{Duration, HeaterTime, STATISTICS_PATH, Sums};
use program::{State, Words};
use units::{AxisSet, Micros};

use crate::machine::Machine;
use crate::machine::card;
use crate::machine::moments::Moments;

/// Period of asking heaters for their work.
const HEAT_PERIOD: Micros = Micros::from_seconds(1);
/// S of M78 that forgets everything, as Prusa's does.
const RESET: f64 = 78.0;

/// Statistics at the machine's moments.
pub(crate) struct Feature;

impl<P: Ports> Moments<P> for Feature {
    fn read_files(machine: &mut Machine<'_, P>) {
        load(machine);
    }

    fn each_10_ms(machine: &mut Machine<'_, P>, now: Micros) {
        sample(machine, now);
        count_heat(machine, now);
    }

    fn idle(machine: &mut Machine<'_, P>) -> bool {
        save(machine);
        false
    }

    fn job_ends(machine: &mut Machine<'_, P>, is_done: bool, to: Recipient) {
        end_job(machine, is_done, to);
    }

    fn job_is_dropped(machine: &mut Machine<'_, P>) {
        // They are saved when the machine has come to rest.
        let _ = machine.jobs.statistics.end_job(false);
    }

    fn extruders_count_anew(machine: &mut Machine<'_, P>) {
        machine.jobs.statistics.rest();
    }
}

/// Reads the statistics at boot. There need not be any.
pub(crate) fn load<P: Ports>(machine: &mut Machine<'_, P>) {
    let mut read_in = core::mem::take(&mut machine.jobs.statistics);
    let mut bad = 0;
    let read = each_line(&mut machine.world.ports, STATISTICS_PATH, |_, line| {
        let line = line.and_then(|line| core::str::from_utf8(line).ok());
        bad += u32::from(!line.is_some_and(|line| read_in.read(line)));
    });
    machine.jobs.statistics = read_in;
    match read {
        Ok(()) if bad == 0 => {}
        Ok(()) => machine.announce(format_args!("WARNING: {STATISTICS_PATH}: {bad} lines were left out\n")),
        Err(StorageError::NotFound | StorageError::NoCard) => {}
        Err(error) => machine.announce(format_args!("WARNING: {STATISTICS_PATH} was not read: {}\n", error.text())),
    }
}

/// Samples the place of the tool.
pub(crate) fn sample<P: Ports>(machine: &mut Machine<'_, P>, now: Micros) {
    let moves = !machine.world.ports.motion(|motion| motion.is_idle());
    let plays = machine.jobs.is_open() && machine.safety.state() != State::Check;
    if !moves && !plays {
        return machine.jobs.statistics.rest();
    }
    let place = machine.world.ports.motion(|motion| motion.live_position());
    let extruders = AxisSet::collect(machine.program.tools().all().iter().map(|tool| tool.settings.axis));
    machine.jobs.statistics.sample(now, plays, moves, &place, extruders);
}

/// Counts the work of heaters once a second.
pub(crate) fn count_heat<P: Ports>(machine: &mut Machine<'_, P>, now: Micros) {
    if now < machine.features.heat_due {
        return;
    }
    machine.features.heat_due = now.plus(HEAT_PERIOD);
    let heats = machine.world.ports.heat(|heat| heat.any_on());
    machine.jobs.statistics.heaters.heats(heats);
    for (id, heater) in HeaterId::all().zip(&machine.world.config.temperatures) {
        let work = machine.world.ports.heat(|heat| heat.take_work(id));
        machine.jobs.statistics.heaters.add(&heater.name, work);
    }
}

/// Ends the job's statistics, and tells them.
pub(crate) fn end_job<P: Ports>(machine: &mut Machine<'_, P>, is_done: bool, to: Recipient) {
    if machine.jobs.is_open() {
        machine.record(&Event::JobEnded { complete: is_done, line: machine.jobs.line() });
    }
    if let Some(job) = machine.jobs.statistics.end_job(is_done) {
        say_job(machine, &job, to);
    }
}

fn say_job<P: Ports>(machine: &mut Machine<'_, P>, job: &Sums, to: Recipient) {
    let (time, still, way, filament) =
        (Duration(job.job), Duration(job.still), job.way / 1000.0, job.filament / 1000.0);
    machine.say(to, format_args!("the job took {time} ({still} of it still): {way:.2} m of way"));
    if filament > 0.0 {
        machine.say(to, format_args!(", {filament:.3} m of filament"));
    }
    machine.say(to, format_args!("\n"));
}

/// Tells the statistics, or resets them (M78, M78 S78).
pub(crate) fn told<P: Ports>(machine: &mut Machine<'_, P>, words: &Words<'_>, to: Recipient) -> Answer {
    if words.get('S') == Some(RESET) {
        machine.jobs.statistics.reset();
        return Answer::Ok;
    }
    if let Some(job) = machine.jobs.statistics.before {
        say_job(machine, &job, to);
    }
    let life = machine.jobs.statistics.life;
    let (done, broken_off) = (life.done, life.broken_off);
    machine.say(to, format_args!("jobs: {done} done, {broken_off} broken off\n"));
    let (job, still, longest) = (Duration(life.sums.job), Duration(life.sums.still), Duration(life.longest));
    machine.say(to, format_args!("time: {job} in jobs ({still} of it still), the longest {longest}\n"));
    let (moving, way, filament) = (Duration(life.moving), life.sums.way / 1000.0, life.sums.filament / 1000.0);
    machine.say(
        to,
        format_args!("the machine has moved for {moving}; in jobs {way:.1} m of way, {filament:.2} m of filament\n"),
    );
    for HeaterTime { name, on_s, full_s } in machine.jobs.statistics.heaters.all().clone() {
        let time = |s: f64| Duration(Micros((s * 1e6) as u64));
        machine
            .say(to, format_args!("heater {name}: on for {}, as much as {} at full power", time(on_s), time(full_s)));
        if let Some(heater) = machine.world.config.temperatures.iter().find(|heater| heater.name == name) {
            let kwh = full_s / 3.6e6 * f64::from(heater.model.power_w);
            machine.say(to, format_args!(", {kwh:.3} kWh with a heater_power of {} W", heater.model.power_w));
        }
        machine.say(to, format_args!("\n"));
    }
    Answer::Ok
}

/// Saves new statistics, once nothing else is to be done.
pub(crate) fn save<P: Ports>(machine: &mut Machine<'_, P>) {
    if machine.jobs.is_open() || !machine.jobs.statistics.take_unsaved() {
        return;
    }
    if let Err(error) = write(machine)
        && error != StorageError::NoCard
    {
        machine.announce(format_args!("WARNING: {STATISTICS_PATH} was not written: {}\n", error.text()));
    }
}

fn write<P: Ports>(machine: &mut Machine<'_, P>) -> Result<(), StorageError> {
    card::at_rest(machine);
    let mut text = heapless::String::<512>::new();
    if write!(text, "{}", machine.jobs.statistics.life).is_err() {
        return Err(StorageError::Full);
    }
    let ports = &mut machine.world.ports;
    let mut draft = Draft::begin(ports, STATISTICS_PATH)?;
    let hours = machine.jobs.statistics.heaters.lines();
    let written = draft.write(ports, text.as_bytes());
    let mut lines = hours.map(|line| draft.write(ports, line.as_bytes()));
    if let Err(error) = written.and_then(|_| lines.try_for_each(|line| line.map(drop))) {
        draft.give_up(ports);
        return Err(error);
    }
    drop(lines);
    card::finish(machine, draft)
}

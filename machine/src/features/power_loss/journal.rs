//! Journal entries of a job: every few seconds, before Z goes to another height, on arrival there, and where
//! a halt comes to rest. One block at a time.

use base::brown_out;
use base::failure::Failure;
use base::ports::{OpenMode, StorageError, Wake};
use base::{Ports, World};
use jobs::journal::{Blank, Doing, Entry, Found, Look, PlayedFile, find, forget, machine_value, stray};
use motion::compensation::Bed;
use program::State;
use units::{Axis, AxisSet, Micros, PerAxis, Volts};

use crate::features::state::States;
use crate::machine::{Machine, card};

/// Time between entries because of another height: see `recover::UNNOTICED_S`.
const HEIGHT_PERIOD: Micros = Micros::from_millis(500);
/// Time between such entries while the job is suspended.
const SUSPENDED_HEIGHT_PERIOD: Micros = Micros::from_millis(100);
/// Difference below which two heights are one, mm.
const SAME_HEIGHT: f64 = 0.005;
/// Greatest way of Z beyond the noted height, mm: less than the tolerance of equal heights afterwards.
const UNNOTED: f64 = 0.015;
/// Time that the heights of an entry look ahead, s: longer than the executor is held by a card, so that
/// another height is noted before Z begins to go there.
const AHEAD_S: f64 = 0.3;
/// Period of the looks at a job: motion knows where its motors are every 16 ms.
const LOOK_PERIOD: Micros = Micros::from_millis(20);

/// Prepares the note of a brown-out for a job without a journal, if supplies are watched.
fn note_of_brown_out<P: Ports>(machine: &mut Machine<'_, P>) {
    let is_looked_for =
        !machine.world.config.voltages.is_empty() && machine.world.config.system.brown_out_volts != Some(Volts(0.0));
    if machine.features.journal.is_on || !is_looked_for {
        return;
    }
    card::at_rest(machine);
    if brown_out::is_prepared(&mut machine.world.ports) {
        return;
    }
    card::at_rest(machine);
    // A card that takes no writes keeps no note.
    let Ok(file) = machine.world.ports.open(brown_out::PATH, OpenMode::Write) else { return };
    card::at_rest(machine);
    // The next job finds a block that was not written by its wrong size.
    let _ = brown_out::prepare(&mut machine.world.ports, file);
    card::at_rest(machine);
    // A failed close shows as a wrong size, too.
    let _ = machine.world.ports.close(file);
}

/// Begins the journal of a file that is about to be played: the first line has not been read.
pub(crate) fn begin<P: Ports>(machine: &mut Machine<'_, P>) {
    machine.features.journal.close(&mut machine.world.ports);
    // The boot file is no job, and a job that goes on after a power cut is noted already.
    let is_job = machine.features.recovery.is_none() && machine.safety.state() != State::Check;
    if !is_job || machine.jobs.is_boot_file(machine.world.config) {
        return;
    }
    // Everybody is served between the steps: each reads directories and tables.
    card::at_rest(machine);
    give_up_offer(machine);
    note_of_brown_out(machine);
    if !machine.features.journal.is_on {
        return;
    }
    let Some(beginning) = program::beginning(&mut machine.program) else {
        return machine.announce(format_args!(
            "// NOTE no journal of this job: modes are in force (G64, G93, G18 cycles, loops) that it does not keep\n"
        ));
    };
    match make(machine) {
        Err(Failure::HALTED) => return,
        Err(why) if why.is_refusal() => {
            return machine
                .announce(format_args!("// WARNING no journal of this job: {}\n", machine.world.texts.of(why)));
        }
        _ => {}
    }
    card::at_rest(machine);
    let counted = machine.features.journal.count(&mut machine.world.ports);
    card::at_rest(machine);
    let value = counted.and_then(|()| machine_value(&mut machine.world.ports));
    card::at_rest(machine);
    let played = value.and_then(|value| machine.jobs.played_file(value, &mut machine.world.ports));
    card::at_rest(machine);
    if !machine.jobs.is_open() {
        return;
    }
    let Machine { features: States { journal, .. }, world: World { ports, .. }, .. } = machine;
    let begun = match played {
        Ok(file) if PlayedFile::fits(&file.path) => journal.begin(&file, &beginning, ports),
        Ok(_) => return machine.announce(format_args!("// NOTE no journal of this job: its path is too long\n")),
        Err(error) => Err(error),
    };
    let now = machine.world.ports.now();
    machine.features.journal.due = now.plus(machine.world.config.player.power_loss.period);
    (machine.features.journal.halts, machine.features.journal.has_laid) = (false, false);
    if let Err(error) = begun {
        machine.announce(format_args!("// WARNING no journal of this job: {}\n", error.text()));
    }
}

/// Makes the journal's file, where there is none: M413 may have switched it on, or the card is another one.
/// Everybody is served between its blocks.
fn make<P: Ports>(machine: &mut Machine<'_, P>) -> Result<(), Failure> {
    let failed = |error: StorageError| machine.world.texts.because(error.text());
    card::at_rest(machine);
    let Some(mut blank) = Blank::begin(&mut machine.world.ports).map_err(failed)? else { return Ok(()) };
    machine.announce(format_args!("// NOTE the journal is made on the card, before the job begins\n"));
    let made = loop {
        if let Err(halted) = machine.wait(Wake::Any).unless_halted() {
            break Err(halted);
        }
        card::at_rest(machine);
        match blank.write(&mut machine.world.ports) {
            Ok(false) => {}
            Ok(true) => break Ok(()),
            Err(error) => break Err(failed(error)),
        }
    };
    card::at_rest(machine);
    let made = made.and(blank.close(&mut machine.world.ports).map_err(failed));
    card::at_rest(machine);
    made
}

/// Gives up the offer of another job: playing a file ends it, whether a journal is kept or not.
pub(crate) fn give_up_offer<P: Ports>(machine: &mut Machine<'_, P>) {
    if !core::mem::take(&mut machine.features.journal.has_offer) {
        return;
    }
    if let Ok(Found::Offer(offer)) = find(&mut machine.world.ports)
        && forget(&offer, &mut machine.world.ports).is_ok()
    {
        machine.announce(format_args!("// NOTE {} is not gone on with any more\n", offer.file.path));
    }
}

/// Notes axes that are moved while the card has a job to go on with: they are not where that job has left
/// them, which is to be known after another power cut too.
fn watch_offer<P: Ports>(machine: &mut Machine<'_, P>) {
    if !machine.features.journal.has_offer
        || machine.features.journal.is_noting()
        || machine.features.recovery.is_some()
    {
        return;
    }
    let (here, stood) =
        (machine.world.ports.motion(|motion| motion.live_position()), machine.features.journal.stood_at);
    let is_away = |axis: &Axis| libm::fabs(here[*axis] - stood[*axis]) > UNNOTED;
    let strayed = AxisSet::collect(Axis::PRIMARY.into_iter().filter(is_away));
    if machine.features.journal.strayed.has_all(strayed) {
        return;
    }
    if !machine.world.ports.is_ready() {
        return;
    }
    machine.features.journal.strayed = machine.features.journal.strayed.or(strayed);
    let Ok(Found::Offer(offer)) = find(&mut machine.world.ports) else { return };
    let noted = offer.entry.strayed | bits(machine.features.journal.strayed);
    if noted != offer.entry.strayed
        && let Err(error) = stray(&offer, noted, &mut machine.world.ports)
    {
        machine.announce(format_args!(
            "// WARNING the journal does not know that the machine was moved: {}\n",
            error.text()
        ));
    }
}

/// Returns a bit for each axis.
fn bits(axes: AxisSet) -> u8 {
    axes.axes().fold(0, |bits, axis| bits | 1 << axis as u8)
}

/// Ends the journal of a job that is over.
pub(crate) fn end<P: Ports>(machine: &mut Machine<'_, P>) {
    machine.features.journal.end(&mut machine.world.ports);
}

/// Keeps that state before a session's line, under a job that is noted.
pub(crate) fn before_session<P: Ports>(machine: &mut Machine<'_, P>) {
    let counts =
        machine.features.journal.is_noting() || machine.features.stalls.beginning_of(machine.jobs.count()).is_some();
    machine.features.before_session = counts.then(|| program::standing(&mut machine.program));
}

/// Ends the journal if a session's line has changed the program: the file alone does not lead there any more.
pub(crate) fn after_session<P: Ports>(machine: &mut Machine<'_, P>) {
    let before = machine.features.before_session.take();
    if before.is_none() || !machine.jobs.is_open() || machine.jobs.is_suspended() {
        return;
    }
    if before == Some(program::standing(&mut machine.program)) {
        return;
    }
    machine.features.stalls.forget_beginning();
    if machine.features.journal.is_noting() {
        machine.features.journal.end(&mut machine.world.ports);
        machine.announce(format_args!(
            "// NOTE a console has changed modes or offsets under the job: it cannot be gone on with after a power cut\n"
        ));
    }
}

/// Looks at the job, and notes an entry that is due.
pub(crate) fn tick<P: Ports>(machine: &mut Machine<'_, P>, now: Micros) {
    watch_offer(machine);
    let is_away = machine.features.recovery.is_some() || machine.features.stalls.is_under_way();
    if !machine.features.journal.is_noting() || machine.features.journal.halts || is_away {
        return;
    }
    if !machine.jobs.is_open() {
        return machine.features.journal.end(&mut machine.world.ports);
    }
    if now < machine.features.journal.look_due {
        return;
    }
    machine.features.journal.look_due = now.plus(LOOK_PERIOD);
    let (is_elsewhere, period) = (look(machine), machine.world.config.player.power_loss.period);
    // A suspended job's file does not say where Z goes.
    let apart = if machine.jobs.is_suspended() { SUSPENDED_HEIGHT_PERIOD } else { HEIGHT_PERIOD };
    let is_elsewhere = is_elsewhere && now.plus(period) >= machine.features.journal.due.plus(apart);
    // A busy card takes the entry a look later.
    let is_due = machine.features.journal.has_laid && (now >= machine.features.journal.due || is_elsewhere);
    if is_due && machine.world.ports.is_ready() {
        machine.features.journal.due = now.plus(machine.world.config.player.power_loss.period);
        note(machine, Heights::Planned, false);
    }
}

/// Whether Z is about to leave the heights that were noted, or has come to rest at one of several. The first
/// filament that is laid is worth an entry too: before that there is nothing to go on with.
fn look<P: Ports>(machine: &mut Machine<'_, P>) -> bool {
    let (place, ahead) =
        machine.world.ports.motion(|motion| (motion.live_position(), motion.range_ahead(Axis::Z, AHEAD_S)));
    let filament = machine.program.tools().active().map_or(0.0, |tool| place[tool.settings.axis]);
    let (before, z) = (machine.features.journal.look, place[Axis::Z]);
    machine.features.journal.look = Look { z, filament };
    let rests = (z - before.z).abs() < SAME_HEIGHT && ahead[1] - ahead[0] < SAME_HEIGHT;
    if !machine.features.journal.has_laid {
        machine.features.journal.has_laid = rests && filament > before.filament && machine.axes.homed().has(Axis::Z);
        return machine.features.journal.has_laid;
    }
    let noted = machine.features.journal.last.z;
    let leaves = ahead[0] < noted[0] - UNNOTED || ahead[1] > noted[1] + UNNOTED;
    leaves || rests && noted[1] - noted[0] > SAME_HEIGHT
}

/// The heights that the machine may be at before the next entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Heights {
    /// Heights that motion knows from its plan.
    Planned,
    /// Heights between these two, mm.
    Between([f64; 2]),
    /// Any height: a script moves as it likes.
    Any,
}

/// Notes the place of the job.
pub(crate) fn note<P: Ports>(machine: &mut Machine<'_, P>, heights: Heights, stands: bool) {
    let entry = entry(machine, heights, stands);
    let Machine { features: States { journal, .. }, world: World { ports, .. }, .. } = machine;
    match journal.note(entry, ports) {
        Ok(()) => (journal.stood_at, journal.strayed) = (PerAxis(entry.position), AxisSet::NONE),
        Err(error) => {
            machine.announce(format_args!("// WARNING the journal of the job is not kept any more: {}\n", error.text()))
        }
    }
}

/// Whether there is something to go on with, and more of it to be noted.
fn is_kept<P: Ports>(machine: &Machine<'_, P>) -> bool {
    machine.features.journal.is_noting()
        && machine.features.journal.has_laid
        && !machine.features.journal.halts
        && machine.features.recovery.is_none()
}

/// Notes that a person has left an object out, or taken one in again.
pub(crate) fn objects_change<P: Ports>(machine: &mut Machine<'_, P>) {
    if is_kept(machine) && machine.jobs.objects.left_out() != machine.features.journal.last.left_out {
        note(machine, Heights::Planned, false);
    }
}

/// Notes heights that the machine goes to now, and that the file does not say.
pub(crate) fn leaves_height<P: Ports>(machine: &mut Machine<'_, P>, [least, most]: [f64; 2]) {
    if !is_kept(machine) {
        return;
    }
    let here = machine.world.ports.motion(|motion| motion.live_position())[Axis::Z];
    let (least, most) = (here.min(least), here.max(most));
    if most - least > UNNOTED {
        note(machine, Heights::Between([least, most]), false);
    }
}

fn entry<P: Ports>(machine: &mut Machine<'_, P>, heights: Heights, stands: bool) -> Entry {
    let last = machine.features.journal.last;
    let now = machine.world.ports.now();
    let (tag, position, ahead, factors, bed) = machine.world.ports.motion(|motion| {
        let tag = (!motion.is_idle()).then(|| motion.passed().tag);
        let ahead = motion.range_ahead(Axis::Z, AHEAD_S);
        (tag, motion.live_position(), ahead, motion.overrides(), motion.compensation().bed())
    });
    let z = match heights {
        Heights::Between(z) => z,
        _ if stands => [position[Axis::Z]; 2],
        _ => ahead,
    };
    let is_away = machine.features.recovery.is_some() || machine.features.stalls.is_under_way();
    if is_away || machine.features.journal.halts {
        // On the way back to the job, and once it is closed, only the machine's place changes.
        let doing = match last.doing {
            _ if heights == Heights::Any => Doing::WaitsAnywhere,
            Doing::Job if !is_away => Doing::Job,
            Doing::Passes => Doing::Passes,
            _ => Doing::Waits,
        };
        return Entry { position: position.0, z, stands, doing, strayed: 0, ..last };
    }
    let (made, doing) = match tag {
        Some(tag) => match machine.jobs.made(tag) {
            Some(made) => (made, Doing::Job),
            // Moves of a session are no part of the job.
            None => (last.made, Doing::Passes),
        },
        // The last line may still wait for something.
        None => (machine.jobs.begun().saturating_sub(1), Doing::Job),
    };
    let doing = if machine.jobs.is_suspended() { Doing::Waits } else { doing };
    let targets = targets(machine, &last);
    let mut flow = [1.0; 3];
    flow.iter_mut().zip(machine.program.tools().all()).for_each(|(to, tool)| *to = tool.flow);
    Entry {
        made,
        line: machine.jobs.line_now(),
        seconds: machine.jobs.progress(now).map_or(last.seconds, |(seconds, _)| seconds as u32),
        position: position.0,
        z,
        targets,
        feed_factor: machine.feed_waits.unwrap_or(factors.feed) * machine.program.modal().speed_factor,
        flow,
        homed: bits(machine.axes.homed()),
        has_mesh: u8::from(bed != Bed::Flat),
        left_out: machine.jobs.objects.left_out(),
        frame: machine.thermal.reference().unwrap_or(0.0),
        thermal_z: machine.thermal.offset(),
        strayed: 0,
        stands,
        doing,
        ..last
    }
}

/// Returns the temperatures that the job goes on with, C.
fn targets<P: Ports>(machine: &mut Machine<'_, P>, last: &Entry) -> [f64; units::MAX_HEATERS] {
    let mut targets = last.targets;
    if machine.safety.is_halted() {
        // The halt has switched heaters off: the targets of the entry before are meant.
    } else if let Some(suspended) = machine.jobs.suspended() {
        targets.iter_mut().zip(&suspended.targets).for_each(|(to, target)| *to = f64::from(target.0));
    } else {
        targets = [0.0; units::MAX_HEATERS];
        machine.world.ports.heat(|heat| {
            targets.iter_mut().zip(heat.heaters()).for_each(|(to, (_, heater))| *to = f64::from(heater.target().0));
        });
    }
    targets
}

/// Notes the line at which the machine halts, outputs off already; where it comes to rest is not known yet.
pub(crate) fn halts<P: Ports>(machine: &mut Machine<'_, P>) {
    if !machine.features.journal.is_noting() || machine.features.journal.halts {
        return;
    }
    if !machine.features.journal.has_laid {
        return machine.features.journal.end(&mut machine.world.ports);
    }
    if machine.features.recovery.as_ref().is_some_and(|recovery| !recovery.is_placed) {
        // A recovery without a place has not moved: the entry that was noted stays.
        return machine.features.journal.close(&mut machine.world.ports);
    }
    if machine.features.recovery.is_none() && machine.jobs.is_open() {
        note(machine, Heights::Planned, false);
    }
    machine.features.journal.halts = true;
}

/// Notes where the halted machine stands.
pub(crate) fn stands<P: Ports>(machine: &mut Machine<'_, P>) {
    if machine.features.journal.is_noting() && machine.features.journal.halts {
        note(machine, Heights::Planned, true);
        machine.features.journal.close(&mut machine.world.ports);
    }
    (machine.features.journal.halts, machine.features.recovery) = (false, None);
    crate::machine::fast_forward::put_back(machine);
}

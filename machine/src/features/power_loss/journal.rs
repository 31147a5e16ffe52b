//! Journal entries of a job: every few seconds, before Z goes to another height, on arrival there, and where
//! a halt comes to rest. One block at a time.

use base::brown_out;
use base::failure::Failure;
use base::ports::{Clock as _, OpenMode, Storage as _, StorageError, Wake};
use base::{Ports, World};
use jobs::journal::{
    Blank, Doing, Entry, Found, Journal, Look, PlayedFile, Recovery, find, forget, machine_value, stray,
};
use jobs::player::Jobs;
use motion::compensation::Bed;
use parts::z_thermal::Thermal;
use procedures::stall_recovery::StallRecovery;
use program::{Interpreter, State};
use units::{Axis, AxisSet, Micros, PerAxis, Volts};

use crate::features::power_loss::standing::Standing;
use crate::features::state::States;
use crate::machine::work_hands::{HaltHands, WaitHands};
use crate::machine::{Machine, card, fast_forward};

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

/// What the journal notes, and notes it of.
pub(crate) struct Noted<'m, 'c, P> {
    pub journal: &'m mut Journal,
    /// Job on its way back after a power cut.
    pub recovery: &'m mut Option<Recovery>,
    /// Recovery after a stall has stopped the job.
    pub stalls: &'m mut StallRecovery,
    pub world: &'m mut World<'c, P>,
    pub jobs: &'m Jobs,
    pub program: &'m mut Interpreter,
    /// Compensation of a frame that grows with heat.
    pub thermal: &'m Thermal,
    pub homed: AxisSet,
    pub is_halted: bool,
    /// Operator's factor of feed rates, while the program does not let it count.
    pub feed_waits: Option<f64>,
}

/// A job that is noted, and the line of a session beside it.
pub(crate) struct Beside<'m, 'c, P> {
    journal: &'m mut Journal,
    stalls: &'m mut StallRecovery,
    /// Program's state before the line.
    before: &'m mut Option<Standing>,
    world: &'m mut World<'c, P>,
    jobs: &'m Jobs,
    program: &'m mut Interpreter,
}

/// The machine for the journal of a job.
pub(crate) trait JournalHands<'c>: WaitHands<'c> + HaltHands<'c> {
    /// Returns what the journal notes.
    fn noted(&mut self) -> Noted<'_, 'c, Self::Ports>;

    /// Returns the job, and the line of a session beside it. Every such line passes here.
    fn beside(&mut self) -> Beside<'_, 'c, Self::Ports>;

    /// Returns the journal, and the card that it is kept on.
    fn journal(&mut self) -> (&mut Journal, &mut World<'c, Self::Ports>);

    /// Whether a job is on its way back after a power cut.
    fn comes_back(&self) -> bool;

    /// Puts limits, steps and filters back as before a file was read over.
    fn put_back(&mut self);
}

impl<'c, P: Ports> JournalHands<'c> for Machine<'c, P> {
    // Many places note, and each would gather all of this for itself.
    #[inline(never)]
    fn noted(&mut self) -> Noted<'_, 'c, P> {
        let States { journal, recovery, stalls, .. } = &mut self.features;
        Noted {
            journal,
            recovery,
            stalls,
            world: &mut self.world,
            jobs: &self.jobs,
            program: &mut self.program,
            thermal: &self.thermal,
            homed: self.axes.homed(),
            is_halted: self.safety.is_halted(),
            feed_waits: self.feed_waits,
        }
    }

    fn beside(&mut self) -> Beside<'_, 'c, P> {
        let Self { world, jobs, program, features: States { journal, stalls, before_session, .. }, .. } = self;
        Beside { journal, stalls, before: before_session, world, jobs, program }
    }

    fn journal(&mut self) -> (&mut Journal, &mut World<'c, P>) {
        (&mut self.features.journal, &mut self.world)
    }

    fn comes_back(&self) -> bool {
        self.features.recovery.is_some()
    }

    fn put_back(&mut self) {
        fast_forward::put_back(self);
    }
}

/// Prepares the note of a brown-out for a job without a journal, if supplies are watched.
fn note_of_brown_out<'c>(hands: &mut impl JournalHands<'c>) {
    let config = hands.world().config;
    let is_looked_for = !config.voltages.is_empty() && config.system.brown_out_volts != Some(Volts(0.0));
    if hands.journal().0.is_on || !is_looked_for {
        return;
    }
    card::at_rest(hands);
    if brown_out::is_prepared(&mut hands.world().ports) {
        return;
    }
    card::at_rest(hands);
    // A card that takes no writes keeps no note.
    let Ok(file) = hands.world().ports.open(brown_out::PATH, OpenMode::Write) else { return };
    card::at_rest(hands);
    // The next job finds a block that was not written by its wrong size.
    let _ = brown_out::prepare(&mut hands.world().ports, file);
    card::at_rest(hands);
    // A failed close shows as a wrong size, too.
    let _ = hands.world().ports.close(file);
}

/// Begins the journal of a file that is about to be played: the first line has not been read.
pub(crate) fn begin<'c>(hands: &mut impl JournalHands<'c>) {
    let is_checked = hands.state() == State::Check;
    let Noted { journal, recovery, world, jobs, .. } = hands.noted();
    journal.close(&mut world.ports);
    // The boot file is no job, and a job that goes on after a power cut is noted already.
    if recovery.is_some() || is_checked || jobs.is_boot_file(world.config) {
        return;
    }
    // Everybody is served between the steps: each reads directories and tables.
    card::at_rest(hands);
    give_up_offer(&mut hands.noted());
    note_of_brown_out(hands);
    let Noted { journal, program, world, .. } = hands.noted();
    if !journal.is_on {
        return;
    }
    let Some(beginning) = program::beginning(program) else {
        return world.announce(format_args!(
            "// NOTE no journal of this job: modes are in force (G64, G93, G18 cycles, loops) that it does not keep\n"
        ));
    };
    match make(hands) {
        Err(Failure::HALTED) => return,
        Err(why) if why.is_refusal() => {
            let why = hands.world().texts.of(why);
            return hands.announce(format_args!("// WARNING no journal of this job: {why}\n"));
        }
        _ => {}
    }
    card::at_rest(hands);
    let (journal, world) = hands.journal();
    let counted = journal.count(&mut world.ports);
    card::at_rest(hands);
    let value = counted.and_then(|()| machine_value(&mut hands.world().ports));
    card::at_rest(hands);
    let Noted { jobs, world, .. } = hands.noted();
    let played = value.and_then(|value| jobs.played_file(value, &mut world.ports));
    card::at_rest(hands);
    let Noted { journal, world, jobs, .. } = hands.noted();
    if !jobs.is_open() {
        return;
    }
    let begun = match played {
        Ok(file) if PlayedFile::fits(&file.path) => journal.begin(&file, &beginning, &mut world.ports),
        Ok(_) => return world.announce(format_args!("// NOTE no journal of this job: its path is too long\n")),
        Err(error) => Err(error),
    };
    journal.due = world.ports.now().plus(world.config.player.power_loss.period);
    (journal.halts, journal.has_laid) = (false, false);
    if let Err(error) = begun {
        world.announce(format_args!("// WARNING no journal of this job: {}\n", error.text()));
    }
}

/// Makes the journal's file, where there is none: M413 may have switched it on, or the card is another one.
/// Everybody is served between its blocks.
fn make<'c>(hands: &mut impl WaitHands<'c>) -> Result<(), Failure> {
    let texts = hands.world().texts;
    let failed = |error: StorageError| texts.because(error.text());
    card::at_rest(hands);
    let Some(mut blank) = Blank::begin(&mut hands.world().ports).map_err(failed)? else { return Ok(()) };
    hands.announce(format_args!("// NOTE the journal is made on the card, before the job begins\n"));
    let made = loop {
        if let Err(halted) = hands.wait(Wake::Any).unless_halted() {
            break Err(halted);
        }
        card::at_rest(hands);
        match blank.write(&mut hands.world().ports) {
            Ok(false) => {}
            Ok(true) => break Ok(()),
            Err(error) => break Err(failed(error)),
        }
    };
    card::at_rest(hands);
    let made = made.and(blank.close(&mut hands.world().ports).map_err(failed));
    card::at_rest(hands);
    made
}

/// Gives up the offer of another job: playing a file ends it, whether a journal is kept or not.
pub(crate) fn give_up_offer<P: Ports>(noted: &mut Noted<'_, '_, P>) {
    if !core::mem::take(&mut noted.journal.has_offer) {
        return;
    }
    if let Ok(Found::Offer(offer)) = find(&mut noted.world.ports)
        && forget(&offer, &mut noted.world.ports).is_ok()
    {
        noted.world.announce(format_args!("// NOTE {} is not gone on with any more\n", offer.file.path));
    }
}

/// Notes axes that are moved while the card has a job to go on with: they are not where that job has left
/// them, which is to be known after another power cut too.
fn watch_offer<P: Ports>(noted: &mut Noted<'_, '_, P>) {
    if !noted.journal.has_offer || noted.journal.is_noting() || noted.recovery.is_some() {
        return;
    }
    let (here, stood) = (noted.world.ports.motion(|motion| motion.live_position()), noted.journal.stood_at);
    let is_away = |axis: &Axis| libm::fabs(here[*axis] - stood[*axis]) > UNNOTED;
    let strayed = AxisSet::collect(Axis::PRIMARY.into_iter().filter(is_away));
    if noted.journal.strayed.has_all(strayed) {
        return;
    }
    if !noted.world.ports.is_ready() {
        return;
    }
    noted.journal.strayed = noted.journal.strayed.or(strayed);
    let Ok(Found::Offer(offer)) = find(&mut noted.world.ports) else { return };
    let strayed = offer.entry.strayed | bits(noted.journal.strayed);
    if strayed != offer.entry.strayed
        && let Err(error) = stray(&offer, strayed, &mut noted.world.ports)
    {
        noted.world.announce(format_args!(
            "// WARNING the journal does not know that the machine was moved: {}\n",
            error.text()
        ));
    }
}

/// Returns a bit for each axis.
fn bits(axes: AxisSet) -> u8 {
    axes.axes().fold(0, |bits, axis| bits | 1 << axis as u8)
}

/// Keeps that state before a session's line, under a job that is noted.
pub(crate) fn before_session<P>(beside: Beside<'_, '_, P>) {
    let Beside { journal, stalls, before, jobs, program, .. } = beside;
    let counts = journal.is_noting() || stalls.beginning_of(jobs.count()).is_some();
    *before = counts.then(|| program::standing(program));
}

/// Ends the journal if a session's line has changed the program: the file alone does not lead there any more.
pub(crate) fn after_session<P: Ports>(beside: Beside<'_, '_, P>) {
    let Beside { journal, stalls, before, world, jobs, program } = beside;
    let before = before.take();
    if before.is_none() || !jobs.is_open() || jobs.is_suspended() {
        return;
    }
    if before == Some(program::standing(program)) {
        return;
    }
    stalls.forget_beginning();
    if journal.is_noting() {
        journal.end(&mut world.ports);
        world.announce(format_args!(
            "// NOTE a console has changed modes or offsets under the job: it cannot be gone on with after a power cut\n"
        ));
    }
}

/// Looks at the job, and notes an entry that is due.
pub(crate) fn tick<P: Ports>(noted: &mut Noted<'_, '_, P>, now: Micros) {
    watch_offer(noted);
    let is_away = noted.recovery.is_some() || noted.stalls.is_under_way();
    if !noted.journal.is_noting() || noted.journal.halts || is_away {
        return;
    }
    if !noted.jobs.is_open() {
        return noted.journal.end(&mut noted.world.ports);
    }
    if now < noted.journal.look_due {
        return;
    }
    noted.journal.look_due = now.plus(LOOK_PERIOD);
    let (is_elsewhere, period) = (look(noted), noted.world.config.player.power_loss.period);
    // A suspended job's file does not say where Z goes.
    let apart = if noted.jobs.is_suspended() { SUSPENDED_HEIGHT_PERIOD } else { HEIGHT_PERIOD };
    let is_elsewhere = is_elsewhere && now.plus(period) >= noted.journal.due.plus(apart);
    // A busy card takes the entry a look later.
    let is_due = noted.journal.has_laid && (now >= noted.journal.due || is_elsewhere);
    if is_due && noted.world.ports.is_ready() {
        noted.journal.due = now.plus(noted.world.config.player.power_loss.period);
        note(noted, Heights::Planned, false);
    }
}

/// Whether Z is about to leave the heights that were noted, or has come to rest at one of several. The first
/// filament that is laid is worth an entry too: before that there is nothing to go on with.
fn look<P: Ports>(noted: &mut Noted<'_, '_, P>) -> bool {
    let (place, ahead) =
        noted.world.ports.motion(|motion| (motion.live_position(), motion.range_ahead(Axis::Z, AHEAD_S)));
    let filament = noted.program.tools().active().map_or(0.0, |tool| place[tool.settings.axis]);
    let (before, z) = (noted.journal.look, place[Axis::Z]);
    noted.journal.look = Look { z, filament };
    let rests = (z - before.z).abs() < SAME_HEIGHT && ahead[1] - ahead[0] < SAME_HEIGHT;
    if !noted.journal.has_laid {
        noted.journal.has_laid = rests && filament > before.filament && noted.homed.has(Axis::Z);
        return noted.journal.has_laid;
    }
    let noted = noted.journal.last.z;
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
pub(crate) fn note<P: Ports>(noted: &mut Noted<'_, '_, P>, heights: Heights, stands: bool) {
    let entry = entry(noted, heights, stands);
    let Noted { journal, world: World { ports, .. }, .. } = noted;
    match journal.note(entry, ports) {
        Ok(()) => (journal.stood_at, journal.strayed) = (PerAxis(entry.position), AxisSet::NONE),
        Err(error) => noted
            .world
            .announce(format_args!("// WARNING the journal of the job is not kept any more: {}\n", error.text())),
    }
}

/// Whether there is something to go on with, and more of it to be noted.
fn is_kept<P: Ports>(noted: &Noted<'_, '_, P>) -> bool {
    noted.journal.is_noting() && noted.journal.has_laid && !noted.journal.halts && noted.recovery.is_none()
}

/// Notes that a person has left an object out, or taken one in again.
pub(crate) fn objects_change<P: Ports>(noted: &mut Noted<'_, '_, P>) {
    if is_kept(noted) && noted.jobs.objects.left_out() != noted.journal.last.left_out {
        note(noted, Heights::Planned, false);
    }
}

/// Notes heights that the machine goes to now, and that the file does not say.
pub(crate) fn leaves_height<P: Ports>(noted: &mut Noted<'_, '_, P>, [least, most]: [f64; 2]) {
    if !is_kept(noted) {
        return;
    }
    let here = noted.world.ports.motion(|motion| motion.live_position())[Axis::Z];
    let (least, most) = (here.min(least), here.max(most));
    if most - least > UNNOTED {
        note(noted, Heights::Between([least, most]), false);
    }
}

fn entry<P: Ports>(noted: &mut Noted<'_, '_, P>, heights: Heights, stands: bool) -> Entry {
    let last = noted.journal.last;
    let now = noted.world.ports.now();
    let (tag, position, ahead, factors, bed) = noted.world.ports.motion(|motion| {
        let tag = (!motion.is_idle()).then(|| motion.passed().tag);
        let ahead = motion.range_ahead(Axis::Z, AHEAD_S);
        (tag, motion.live_position(), ahead, motion.overrides(), motion.compensation().bed())
    });
    let z = match heights {
        Heights::Between(z) => z,
        _ if stands => [position[Axis::Z]; 2],
        _ => ahead,
    };
    let is_away = noted.recovery.is_some() || noted.stalls.is_under_way();
    if is_away || noted.journal.halts {
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
        Some(tag) => match noted.jobs.made(tag) {
            Some(made) => (made, Doing::Job),
            // Moves of a session are no part of the job.
            None => (last.made, Doing::Passes),
        },
        // The last line may still wait for something.
        None => (noted.jobs.begun().saturating_sub(1), Doing::Job),
    };
    let doing = if noted.jobs.is_suspended() { Doing::Waits } else { doing };
    let targets = targets(noted, &last);
    let mut flow = [1.0; 3];
    flow.iter_mut().zip(noted.program.tools().all()).for_each(|(to, tool)| *to = tool.flow);
    Entry {
        made,
        line: noted.jobs.line_now(),
        seconds: noted.jobs.progress(now).map_or(last.seconds, |(seconds, _)| seconds as u32),
        position: position.0,
        z,
        targets,
        feed_factor: noted.feed_waits.unwrap_or(factors.feed) * noted.program.modal().speed_factor,
        flow,
        homed: bits(noted.homed),
        has_mesh: u8::from(bed != Bed::Flat),
        left_out: noted.jobs.objects.left_out(),
        frame: noted.thermal.reference().unwrap_or(0.0),
        thermal_z: noted.thermal.offset(),
        strayed: 0,
        stands,
        doing,
        ..last
    }
}

/// Returns the temperatures that the job goes on with, C.
fn targets<P: Ports>(noted: &mut Noted<'_, '_, P>, last: &Entry) -> [f64; units::MAX_HEATERS] {
    let mut targets = last.targets;
    if noted.is_halted {
        // The halt has switched heaters off: the targets of the entry before are meant.
    } else if let Some(suspended) = noted.jobs.suspended() {
        targets.iter_mut().zip(&suspended.targets).for_each(|(to, target)| *to = f64::from(target.0));
    } else {
        targets = [0.0; units::MAX_HEATERS];
        noted.world.ports.heat(|heat| {
            targets.iter_mut().zip(heat.heaters()).for_each(|(to, (_, heater))| *to = f64::from(heater.target().0));
        });
    }
    targets
}

/// Notes the line at which the machine halts, outputs off already; where it comes to rest is not known yet.
pub(crate) fn halts<P: Ports>(noted: &mut Noted<'_, '_, P>) {
    if !noted.journal.is_noting() || noted.journal.halts {
        return;
    }
    if !noted.journal.has_laid {
        return noted.journal.end(&mut noted.world.ports);
    }
    if noted.recovery.as_ref().is_some_and(|recovery| !recovery.is_placed) {
        // A recovery without a place has not moved: the entry that was noted stays.
        return noted.journal.close(&mut noted.world.ports);
    }
    if noted.recovery.is_none() && noted.jobs.is_open() {
        note(noted, Heights::Planned, false);
    }
    noted.journal.halts = true;
}

/// Notes where the halted machine stands.
pub(crate) fn stands<P: Ports>(noted: &mut Noted<'_, '_, P>) {
    if noted.journal.is_noting() && noted.journal.halts {
        note(noted, Heights::Planned, true);
        noted.journal.close(&mut noted.world.ports);
    }
    (noted.journal.halts, *noted.recovery) = (false, None);
}

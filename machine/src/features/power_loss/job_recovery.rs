//! M1000, M916: a job is gone on with after a power cut or a halt.
//!
//! No recovery begins by itself. First the journal is held against the card, the file and the machine; then
//! the file is read up to the line that was made, which says what the program stood on there, and a little
//! further, which says whether Z can have changed since the last entry. Only then anything heats, and then
//! moves: bed, nozzle, up, X and Y to their switches, the configuration's script, back over the part, and
//! down.

use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands as _;
use base::ports::{Board as _, Clock as _, MotionPort as _, StorageError};
use base::sessions::Recipient;
use base::{Ports, World};
use config::{HomingDirection, MachineConfig};
use jobs::journal::{Doing, Found, Offer, Recovery, Step, find, forget, machine_value};
use jobs::player::{Scripts, Starter};
use motion::Mode;
use motion::compensation::Bed;
use parts::z_thermal::Thermal;
use procedures::homing;
use program::{BEGINNING_BYTES, Dialect, Words};
use units::{Axis, AxisSet, Celsius, MmPerSecond, PerAxis};

use crate::features::power_loss::journal;
use crate::features::power_loss::journal::{Heights, JournalHands, Noted};
use crate::features::state;
use crate::machine::effects::EffectHands;
use crate::machine::fast_forward_record::{Passed, Until};
use crate::machine::frames::{Frame, Then};
use crate::machine::moments::{Features, JobBegins, Moments as _};
use crate::machine::{Machine, fast_forward, heat_restoring, suspend};

/// Heights that differ by less than this are the same, mm.
const SAME_Z: f64 = 0.02;
/// Greatest uncertainty of Z for which its middle is near enough, mm: a vase rises all the time.
const NEAR_Z: f64 = 2.0 * SAME_Z;
/// Time within which another height of Z is noted, s: half a second after the entry before, and as long as a
/// card takes.
const UNNOTICED_S: f64 = 1.0;
/// Greatest difference of equal places, mm: corners are rounded, and the feed is ahead of the motors.
const SAME_PLACE: f64 = 3.0;
const OTHER_MODES: &str = "modes are in force that the job did not begin with: reset, then M1000";
const ENDS_BEFORE: &str = "the file ends before the line that was made";
/// Speed down onto the part, mm/s.
const SLOWLY: MmPerSecond = MmPerSecond(5.0);

/// The machine for a job's way back after a power cut.
pub(crate) trait RecoveryHands<'c>: EffectHands<'c> + JournalHands<'c> {
    /// Returns the compensation of a frame that grows with heat.
    fn thermal(&mut self) -> &mut Thermal;

    /// Has features act as the file is read once more.
    fn job_begins_again(&mut self);

    /// Has features act as the job goes on, which began with this state.
    fn job_goes_on(&mut self, beginning: [u8; BEGINNING_BYTES]);
}

impl<'c, P: Ports> RecoveryHands<'c> for Machine<'c, P> {
    fn thermal(&mut self) -> &mut Thermal {
        &mut self.thermal
    }

    fn job_begins_again(&mut self) {
        Features::<P>::job_begins(self, JobBegins::Again);
    }

    fn job_goes_on(&mut self, beginning: [u8; BEGINNING_BYTES]) {
        Features::<P>::job_goes_on(self, beginning);
    }
}

/// Says at boot which job can go on, and what that would do.
pub(crate) fn say_offer<'c>(hands: &mut impl JournalHands<'c>) {
    let (journal, world) = hands.journal();
    if world.config.player.power_loss.enable
        && let Err(error) = jobs::journal::prepare(&mut world.ports, |ports| ports.report_alive())
    {
        world.announce(format_args!("// WARNING there will be no journal of jobs: {}\n", error.text()));
    }
    journal.stood_at = world.ports.motion(|motion| motion.live_position());
    match find(&mut world.ports) {
        Ok(Found::Offer(offer)) => {
            journal.has_offer = true;
            say(world, &offer, Recipient::All);
        }
        Ok(Found::Broken) => world.announce(format_args!(
            "// NOTE a job was interrupted, but its journal is damaged: it cannot be gone on with\n"
        )),
        Ok(Found::Nothing) | Err(_) => {}
    }
}

fn say<P: Ports>(world: &mut World<'_, P>, offer: &Offer, to: Recipient) {
    let (file, entry) = (&offer.file, &offer.entry);
    let settings = &world.config.player.power_loss;
    let (lift, sag) = (settings.lift, settings.sag);
    world.say(
        to,
        format_args!(
            "// NOTE a job was interrupted: {}, line {}, after {} s, at X{:.2} Y{:.2} Z{:.2}\n// M1000 goes on with it, M1000 \
             C forgets it, M1000 S says this again. Clear nothing from the bed.\n",
            file.path, entry.line, entry.seconds, entry.position[0], entry.position[1], entry.position[2],
        ),
    );
    world.say(
        to,
        format_args!(
            "// M1000: 1. compares file, card and configuration; 2. heats bed and nozzle; 3. lifts by {lift} mm (from {sag} mm \
             below where it was); 4. homes X and Y; 5. goes back over the part and down; 6. goes on with line {}\n",
            entry.line
        ),
    );
}

/// Runs M1000 and M916. `S` tells the offer, `C` forgets it, `Z` says where the tool stands.
pub(crate) fn command<'c>(hands: &mut impl RecoveryHands<'c>, words: &Words<'_>, to: Recipient) -> Outcome {
    if hands.jobs().is_open() || hands.jobs().is_suspended() {
        return Err(Failure::refused(&"a job is under way: abort ends it"));
    }
    let texts = hands.world().texts;
    let failed = |error: StorageError| texts.about_file(jobs::journal::PATH, error.text());
    let offer = match find(&mut hands.world().ports).map_err(failed)? {
        Found::Offer(offer) => offer,
        Found::Broken => return Err(Failure::refused(&"the journal is damaged: the job cannot be gone on with")),
        Found::Nothing => return Err(Failure::refused(&"no job was interrupted on this card")),
    };
    if words.has('C') {
        forget(&offer, &mut hands.world().ports).map_err(failed)?;
        hands.journal().0.has_offer = false;
        hands.say(to, format_args!("{} is not gone on with\n", offer.file.path));
        return Ok(Answer::Ok);
    }
    if words.has('S') {
        say(hands.world(), &offer, to);
        return Ok(Answer::Ok);
    }
    let told = words.get('Z').map(|z| z + hands.program().modal().offset(Axis::Z));
    begin(hands, offer, told, to).inspect_err(|_| give_up(hands))
}

fn begin<'c>(hands: &mut impl RecoveryHands<'c>, offer: Offer, z: Option<f64>, to: Recipient) -> Outcome {
    let starter = Starter::of(&hands.world().reply(to));
    let (jobs, World { ports, texts, .. }) = hands.jobs_in_world();
    let (texts, now) = (*texts, ports.now());
    jobs.open(texts, &offer.file.path, starter, ports, now)?;
    let _begun_before = (jobs.take_new(), jobs.scripts().map(Scripts::take_before));
    let failed = |error: StorageError| texts.about_file(&offer.file.path, error.text());
    let file = machine_value(ports).and_then(|value| jobs.played_file(value, ports)).map_err(failed)?;
    let is_same = (file.size, file.written, file.check) == (offer.file.size, offer.file.written, offer.file.check);
    if !is_same {
        let path = &offer.file.path;
        return Err(texts.refused(format_args!("{path} is not the file that was played: M1000 C forgets the job")));
    }
    if file.machine != offer.file.machine {
        return Err(Failure::refused(
            &"config.ini or the saved settings are not those the job was begun with: put them back, or M1000 C forgets the job",
        ));
    }
    let bed = hands.world().ports.motion(|motion| motion.compensation().bed());
    let (made, frame) = (offer.entry.made, offer.entry.frame);
    let has_mesh = offer.entry.has_mesh != 0;
    if has_mesh && bed == Bed::Flat {
        return Err(Failure::refused(
            &"the job was made with the bed's mesh: M375 loads it as M374 has saved it, then M1000",
        ));
    }
    let here = hands.position();
    let before = program::beginning(hands.program());
    let before = before.ok_or_else(|| Failure::refused(&OTHER_MODES))?;
    fast_forward::keep(hands);
    *hands.noted().recovery = Some(Recovery {
        z: z.unwrap_or(offer.entry.position[Axis::Z as usize]),
        z_is_told: z.is_some(),
        goes_up_blind: false,
        highest: f64::NEG_INFINITY,
        is_placed: false,
        has_heated: false,
        before,
        place: here,
        kept: None,
        switches: Default::default(),
        offer,
    });
    if z.is_none() && !hands.axes().homed().has(Axis::Z) {
        // Z is as it was when the job stopped, and so is the temperature at which it is right.
        hands.thermal().refer_to(Some(frame).filter(|frame| *frame != 0.0));
    }
    hands.say(to, format_args!("// the file is read up to where the job was\n"));
    read_up_to(hands, made + 1, Step::Compare, to)
}

/// Reads the file from its beginning until so many lines have begun; then follows this step.
fn read_up_to<'c>(hands: &mut impl RecoveryHands<'c>, lines: u32, then: Step, to: Recipient) -> Outcome {
    let Noted { recovery: Some(recovery), program, .. } = hands.noted() else { return Err(Failure::HALTED) };
    let dialect = usize::from(recovery.offer.file.dialect).checked_sub(1);
    if !program::begin_again(program, &mut recovery.offer.beginning) {
        return Err(Failure::refused(&"the journal is damaged: the job cannot be gone on with"));
    }
    // The offset of the entry counts: the offset at the job's beginning is another temperature's.
    program.set_thermal_z(recovery.offer.entry.thermal_z);
    let (jobs, World { ports, texts, .. }) = hands.jobs_in_world();
    jobs.read_again(ports).map_err(|error| texts.because(error.text()))?;
    if let Some(dialect) = dialect.and_then(|place| Dialect::ALL.get(place)) {
        jobs.read_as(*dialect);
    }
    read_on(hands, Until::Begun(lines), then, to)
}

fn read_on<'c>(hands: &mut impl RecoveryHands<'c>, until: Until, then: Step, to: Recipient) -> Outcome {
    if !hands.frames().push(Frame::Then(Then::Step(state::Step::Recover(then, to)))) {
        return Err(Failure::refused(&"scripts start each other without end"));
    }
    fast_forward::begin(hands, until)?;
    // The job has begun once: its journal is not begun anew, and nothing refuses it.
    if hands.jobs().take_new() {
        hands.job_begins_again();
    }
    Ok(Answer::Ok)
}

/// Gives up the recovery: the program and its modes are as before the request, and the offer stays.
pub(crate) fn give_up<'c>(hands: &mut impl RecoveryHands<'c>) {
    *hands.passed() = None;
    let Noted { journal, recovery, world, .. } = hands.noted();
    journal.close(&mut world.ports);
    let recovery = recovery.take();
    let (jobs, world) = hands.jobs_in_world();
    jobs.close(&mut world.ports);
    if let Some(mut recovery) = recovery {
        fast_forward::put_back(hands);
        let thermal_z = hands.thermal().offset();
        // The modes from before are the program's own.
        let _ = program::begin_again(hands.program(), &mut recovery.before);
        hands.program().set_thermal_z(thermal_z);
        // Heaters that somebody else has switched on before stay so.
        if recovery.has_heated {
            heat_restoring::cool(&mut hands.world().ports);
        }
    }
    hands.resynchronise();
}

/// Carries out the next step of the recovery.
///
/// # Errors
/// When the step cannot be done; then nothing of the recovery is left.
pub(crate) fn go_on<'c>(hands: &mut impl RecoveryHands<'c>, step: Step, to: Recipient) -> Result<(), Failure> {
    let done = match step {
        Step::Compare => compare(hands, to).map(drop),
        Step::Look => look(hands, to).map(drop),
        Step::Prepare => prepare(hands, to),
        Step::GoBack => go_back(hands, to),
    };
    if done.is_err_and(|failure| failure.is_refusal()) {
        give_up(hands);
    }
    done
}

fn compare<'c>(hands: &mut impl RecoveryHands<'c>, to: Recipient) -> Outcome {
    let passed = Passed::arrived(hands.passed().take(), &ENDS_BEFORE)?;
    let Noted { recovery: Some(recovery), program, .. } = hands.noted() else { return Err(Failure::HALTED) };
    let (from, end, was) = (passed.line_began_at, *program.position(), recovery.offer.entry.position);
    // An arc may go beyond its ends.
    let slack = SAME_PLACE + Axis::PRIMARY.into_iter().map(|axis| (end[axis] - from[axis]).abs()).sum::<f64>();
    let is_there = |axis: Axis| {
        let (least, most) = (from[axis].min(end[axis]) - slack, from[axis].max(end[axis]) + slack);
        (least..=most).contains(&was[axis as usize])
    };
    let was_at_it = recovery.offer.entry.left_out == 0 && recovery.offer.entry.doing == Doing::Job;
    if was_at_it && !Axis::PRIMARY.into_iter().all(is_there) {
        return Err(Failure::refused(&"the file does not lead to where the machine was: M1000 C forgets the job"));
    }
    recovery.highest = passed.z[1].max(end[Axis::Z]);
    // The second reading of the file has to lead to the same place.
    recovery.place = from;
    let stands = recovery.offer.entry.stands || recovery.offer.entry.doing.waits();
    let seconds = UNNOTICED_S * recovery.offer.entry.feed_factor.max(1.0);
    read_on(hands, Until::Seconds(if stands { 0.0 } else { seconds }), Step::Look, to)
}

fn look<'c>(hands: &mut impl RecoveryHands<'c>, to: Recipient) -> Outcome {
    // The file may end within that time.
    let passed = hands.passed().take().ok_or(Failure::HALTED)?;
    let can_home = hands.can_home();
    let Noted { recovery: Some(recovery), journal, world, homed, .. } = hands.noted() else {
        return Err(Failure::HALTED);
    };
    let (up, texts) = (homes_upwards(world.config), world.texts);
    let entry = &recovery.offer.entry;
    // Movements of axes since the machine was switched on are known.
    let is_lost = |axis: Axis| entry.strayed & 1 << axis as u8 != 0 && !journal.strayed.has(axis);
    let known = homed.or(can_home);
    if let Some(axis) = [Axis::X, Axis::Y].into_iter().find(|axis| is_lost(*axis) && !known.has(*axis)) {
        return Err(texts.refused(format_args!(
            "{} was moved after the job and has no switch: M1000 C forgets the job",
            axis.letter()
        )));
    }
    let [mut least, mut most] = entry.z;
    if !entry.stands && !entry.doing.waits() {
        (least, most) = (least.min(passed.z[0]), most.max(passed.z[1]));
    }
    let is_told = recovery.z_is_told || homed.has(Axis::Z);
    if is_lost(Axis::Z) && !is_told && !up {
        return Err(Failure::refused(
            &"Z was moved after the job: measure it, then M1000 Z with where the tool stands",
        ));
    }
    if entry.doing == Doing::WaitsAnywhere && !is_told && !up {
        return Err(Failure::refused(
            &"power_loss_gcode may have moved Z: measure it, then M1000 Z with where the tool stands",
        ));
    }
    if most - least >= NEAR_Z && !is_told && !up {
        return Err(texts.refused(format_args!(
            "Z may be anywhere from {least:.2} to {most:.2}: measure it, then M1000 Z with where the tool stands"
        )));
    }
    let is_anywhere = entry.doing == Doing::WaitsAnywhere || is_lost(Axis::Z) || most - least >= NEAR_Z;
    recovery.goes_up_blind = is_anywhere && !is_told;
    if !recovery.z_is_told && !is_anywhere {
        recovery.z = (least + most) / 2.0;
    }
    recovery.highest = recovery.highest.max(most);
    let made = recovery.offer.entry.made;
    read_up_to(hands, made, Step::Prepare, to)
}

/// Whether Z homes by going up, away from the part.
fn homes_upwards(config: &MachineConfig) -> bool {
    let stop = config.homing_endstop(Axis::Z);
    stop.is_some_and(|stop| stop.homing_direction == HomingDirection::ToMax)
}

fn prepare<'c>(hands: &mut impl RecoveryHands<'c>, to: Recipient) -> Result<(), Failure> {
    let passed = Passed::arrived(hands.passed().take(), &ENDS_BEFORE)?;
    let Noted { recovery: Some(recovery), journal, program, world, .. } = hands.noted() else {
        return Err(Failure::HALTED);
    };
    let (kept, place) = (program.keep(), *program.position());
    if Axis::PRIMARY.into_iter().any(|axis| (place[axis] - recovery.place[axis]).abs() > SAME_Z) {
        return Err(Failure::refused(
            &"the file leads to another place each time that it is read: M1000 C forgets the job",
        ));
    }
    (recovery.kept, recovery.place, recovery.switches) = (Some(kept), place, passed.switches);
    recovery.has_heated = true;
    let entry = recovery.offer.entry;
    let noted = journal.go_on(&recovery.offer, &mut world.ports).map_err(|error| world.texts.because(error.text()));
    hands.jobs().objects.set_left_out(entry.left_out);
    noted?;
    heat_restoring::heat(&mut hands.sequence(to), &entry.targets.map(|target| Celsius(target as f32)))?;
    lift(hands, &entry.position, to)?;
    // The script moves from the tool's place, not from the file's.
    hands.standstill()?;
    hands.resynchronise();
    let script = hands.world().config.player.power_loss.gcode.as_str();
    if !script.is_empty() {
        journal::note(&mut hands.noted(), Heights::Any, false);
    }
    suspend::start_script(hands.frames(), script, Then::Step(state::Step::Recover(Step::GoBack, to))).map(drop)
}

/// Lifts the tool clear of everything that stands on the bed; then homes X and Y, and Z where that is
/// upwards.
fn lift<'c>(hands: &mut impl RecoveryHands<'c>, was: &[f64], to: Recipient) -> Result<(), Failure> {
    let sag = hands.world().config.player.power_loss.sag;
    let Noted { recovery: Some(recovery), journal, homed, .. } = hands.noted() else { return Err(Failure::HALTED) };
    let (z, z_is_told, is_blind, highest) = (recovery.z, recovery.z_is_told, recovery.goes_up_blind, recovery.highest);
    let stood_at = journal.stood_at;
    let mut here = hands.position();
    for axis in Axis::PRIMARY.into_iter().filter(|axis| !homed.has(*axis)) {
        // Somebody may have moved the axis by hand since.
        here[axis] += was.get(axis as usize).copied().unwrap_or(0.0) - stood_at[axis];
    }
    if !homed.has(Axis::Z) {
        let has_moved = here[Axis::Z] - was.get(Axis::Z as usize).copied().unwrap_or(0.0);
        here[Axis::Z] = if z_is_told { z } else { z + has_moved - sag };
    }
    hands.sequence(to).set_position(here)?;
    if let Some(recovery) = hands.noted().recovery {
        recovery.is_placed = true;
    }
    if !is_blind {
        go_up(hands, here, highest, to)?;
    }
    let mut homes = AxisSet::of(Axis::X).with(Axis::Y).and(hands.can_home());
    if homes_upwards(hands.world().config) {
        // Until Z is homed it may be anywhere between.
        journal::note(&mut hands.noted(), Heights::Any, false);
        hands.announce(format_args!("// homing Z, upwards\n"));
        hands.axes().mark_homed(AxisSet::PRIMARY);
        homing::home(&mut hands.sequence(to), AxisSet::of(Axis::Z))?;
        journal::note(&mut hands.noted(), Heights::Planned, false);
        // Towers and arms have homed together.
        homes = if procedures::arms::homes_by_motor(hands.world().config) { AxisSet::NONE } else { homes };
    } else if homes.is_empty() {
        hands.announce(format_args!("// WARNING X and Y have no switches: they are taken to be where they were\n"));
    }
    if homes.is_empty() {
        return Ok(());
    }
    hands.announce(format_args!("// homing X and Y\n"));
    homing::home(&mut hands.sequence(to), homes)
}

/// Lifts Z so high that X and Y can go to their switches.
fn go_up<'c>(
    hands: &mut impl RecoveryHands<'c>,
    here: PerAxis<f64>,
    highest: f64,
    to: Recipient,
) -> Result<(), Failure> {
    let mut up = here;
    up[Axis::Z] = above(hands, here[Axis::Z].max(highest)).max(here[Axis::Z]);
    hands.announce(format_args!("// up to Z{:.2}\n", up[Axis::Z]));
    // Until Z has arrived it may be anywhere between.
    journal::note(&mut hands.noted(), Heights::Between([here[Axis::Z], up[Axis::Z]]), false);
    hands.axes().mark_homed(AxisSet::PRIMARY);
    hands.sequence(to).enable_motors()?;
    hands.sequence(to).go_there(up, SLOWLY)?;
    journal::note(&mut hands.noted(), Heights::Planned, false);
    Ok(())
}

/// Returns the height that clears everything up to this height, mm.
fn above<'c>(hands: &mut impl RecoveryHands<'c>, highest: f64) -> f64 {
    let [_, most] = hands.travel().ends();
    (highest + hands.world().config.player.power_loss.lift).min(most[Axis::Z])
}

fn go_back<'c>(hands: &mut impl RecoveryHands<'c>, to: Recipient) -> Result<(), Failure> {
    hands.standstill()?;
    let Some(recovery) = hands.noted().recovery.clone() else { return Err(Failure::HALTED) };
    let (entry, mut place) = (recovery.offer.entry, recovery.place);
    // The frame's temperature differs from that at the entry.
    place[Axis::Z] += hands.thermal().offset() - entry.thermal_z;
    let mut over = hands.position();
    // Filament counts from here as in the file; and nothing has turned A, B or C since.
    Axis::ALL.into_iter().filter(|axis| !Axis::PRIMARY.contains(axis)).for_each(|axis| over[axis] = place[axis]);
    hands.sequence(to).set_position(over)?;
    // The script may have left the tool low, and homing at its highest: there a delta goes nowhere else.
    let from = over;
    over[Axis::Z] = above(hands, recovery.highest);
    let up = over;
    (over[Axis::X], over[Axis::Y]) = (place[Axis::X], place[Axis::Y]);
    hands.stays_within(&from, &up)?;
    hands.stays_within(&up, &over)?;
    hands.stays_within(&over, &place)?;
    hands.announce(format_args!("// back to X{:.2} Y{:.2}, and down\n", place[Axis::X], place[Axis::Y]));
    let rate = hands.program().modal().seek_rate;
    hands.sequence(to).go(up, rate, Mode::Rapid)?;
    hands.sequence(to).go_there(over, rate)?;
    let [low, high] = [place[Axis::Z].min(over[Axis::Z]), over[Axis::Z].max(place[Axis::Z])];
    journal::note(&mut hands.noted(), Heights::Between([low, high]), false);
    hands.sequence(to).go_there(place, SLOWLY)?;
    let (jobs, program) = hands.jobs_and_program();
    program.set_thermal_z(place[Axis::Z] - recovery.place[Axis::Z] + entry.thermal_z);
    if let Some(kept) = recovery.kept {
        program.come_back_to(kept);
    }
    program.resynchronise(place);
    // The job may go on within an object that was left out.
    program::objects::leave_out(program, jobs.objects.is_left_out());
    let factor = entry.feed_factor / program.modal().speed_factor;
    program::set_flow(program, &entry.flow);
    hands.world().ports.motion(|motion| motion.set_overrides(factor, motion.overrides().rapid));
    let (outputs, _, World { config, ports, .. }) = hands.outputs_in_world();
    heat_restoring::switch(outputs, config, ports, &recovery.switches);
    (*hands.noted().recovery, *hands.set_before()) = (None, None);
    hands.job_goes_on(recovery.offer.beginning);
    journal::note(&mut hands.noted(), Heights::Planned, false);
    hands
        .announce(format_args!("// the job goes on with line {}: what was made behind it is made twice\n", entry.line));
    Ok(())
}

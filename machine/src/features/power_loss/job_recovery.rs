//! M1000, M916: a job is gone on with after a power cut or a halt.
//!
//! No recovery begins by itself. First the journal is held against the card, the file and the machine; then
//! the file is read up to the line that was made, which says what the program stood on there, and a little
//! further, which says whether Z can have changed since the last entry. Only then anything heats, and then
//! moves: bed, nozzle, up, X and Y to their switches, the configuration's script, back over the part, and
//! down.

use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands as _;
use base::sessions::Recipient;
use base::{Ports, World};
use config::{HomingDirection, MachineConfig};
use jobs::journal::{Doing, Found, Offer, Recovery, Step, find, forget, machine_value};
use jobs::player::{Listeners, Scripts};
use motion::Mode;
use motion::compensation::Bed;
use procedures::homing;
use program::{Dialect, Words};
use units::{Axis, AxisSet, Celsius, MmPerSecond, PerAxis};

use crate::features::power_loss::journal;
use crate::features::power_loss::journal::Heights;
use crate::features::state;
use crate::features::state::States;
use crate::machine::fast_forward_record::{Passed, Until};
use crate::machine::frames::{Frame, Then};
use crate::machine::hands::MachineHands;
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

/// Says at boot which job can go on, and what that would do.
pub(crate) fn say_offer<P: Ports>(machine: &mut Machine<'_, P>) {
    if machine.world.config.player.power_loss.enable
        && let Err(error) = jobs::journal::prepare(&mut machine.world.ports, P::report_alive)
    {
        machine.announce(format_args!("// WARNING there will be no journal of jobs: {}\n", error.text()));
    }
    machine.features.journal.stood_at = machine.world.ports.motion(|motion| motion.live_position());
    match find(&mut machine.world.ports) {
        Ok(Found::Offer(offer)) => {
            machine.features.journal.has_offer = true;
            say(machine, &offer, Recipient::All);
        }
        Ok(Found::Broken) => machine.announce(format_args!(
            "// NOTE a job was interrupted, but its journal is damaged: it cannot be gone on with\n"
        )),
        Ok(Found::Nothing) | Err(_) => {}
    }
}

fn say<P: Ports>(machine: &mut Machine<'_, P>, offer: &Offer, to: Recipient) {
    let (file, entry) = (&offer.file, &offer.entry);
    let settings = &machine.world.config.player.power_loss;
    let (lift, sag) = (settings.lift, settings.sag);
    machine.say(
        to,
        format_args!(
            "// NOTE a job was interrupted: {}, line {}, after {} s, at X{:.2} Y{:.2} Z{:.2}\n// M1000 goes on with it, M1000 \
             C forgets it, M1000 S says this again. Clear nothing from the bed.\n",
            file.path, entry.line, entry.seconds, entry.position[0], entry.position[1], entry.position[2],
        ),
    );
    machine.say(
        to,
        format_args!(
            "// M1000: 1. compares file, card and configuration; 2. heats bed and nozzle; 3. lifts by {lift} mm (from {sag} mm \
             below where it was); 4. homes X and Y; 5. goes back over the part and down; 6. goes on with line {}\n",
            entry.line
        ),
    );
}

/// Runs M1000 and M916. `S` tells the offer, `C` forgets it, `Z` says where the tool stands.
pub(crate) fn command<P: Ports>(machine: &mut Machine<'_, P>, words: &Words<'_>, to: Recipient) -> Outcome {
    if machine.jobs.is_open() || machine.jobs.is_suspended() {
        return Err(Failure::refused(&"a job is under way: abort ends it"));
    }
    let failed = |error: base::ports::StorageError| machine.world.texts.about_file(jobs::journal::PATH, error.text());
    let offer = match find(&mut machine.world.ports).map_err(failed)? {
        Found::Offer(offer) => offer,
        Found::Broken => return Err(Failure::refused(&"the journal is damaged: the job cannot be gone on with")),
        Found::Nothing => return Err(Failure::refused(&"no job was interrupted on this card")),
    };
    if words.has('C') {
        forget(&offer, &mut machine.world.ports).map_err(failed)?;
        machine.features.journal.has_offer = false;
        machine.say(to, format_args!("{} is not gone on with\n", offer.file.path));
        return Ok(Answer::Ok);
    }
    if words.has('S') {
        say(machine, &offer, to);
        return Ok(Answer::Ok);
    }
    let told = words.get('Z').map(|z| z + machine.program.modal().offset(Axis::Z));
    begin(machine, offer, told, to).inspect_err(|_| give_up(machine))
}

fn begin<P: Ports>(machine: &mut Machine<'_, P>, offer: Offer, z: Option<f64>, to: Recipient) -> Outcome {
    let now = machine.world.ports.now();
    let listeners = Listeners { tells_end: to, ..Listeners::default() };
    machine.jobs.open(machine.world.texts, &offer.file.path, listeners, &mut machine.world.ports, now)?;
    let Machine { jobs, world: World { ports, .. }, .. } = machine;
    let _begun_before = (jobs.take_new(), jobs.scripts().map(Scripts::take_before));
    let failed = |error: base::ports::StorageError| machine.world.texts.about_file(&offer.file.path, error.text());
    let file = machine_value(ports).and_then(|value| jobs.played_file(value, ports)).map_err(failed)?;
    let is_same = (file.size, file.written, file.check) == (offer.file.size, offer.file.written, offer.file.check);
    if !is_same {
        return Err(machine
            .world
            .texts
            .refused(format_args!("{} is not the file that was played: M1000 C forgets the job", offer.file.path)));
    }
    if file.machine != offer.file.machine {
        return Err(Failure::refused(
            &"config.ini or the saved settings are not those the job was begun with: put them back, or M1000 C forgets the job",
        ));
    }
    let bed = machine.world.ports.motion(|motion| motion.compensation().bed());
    let (made, frame) = (offer.entry.made, offer.entry.frame);
    let has_mesh = offer.entry.has_mesh != 0;
    if has_mesh && bed == Bed::Flat {
        return Err(Failure::refused(
            &"the job was made with the bed's mesh: M375 loads it as M374 has saved it, then M1000",
        ));
    }
    let here = machine.world.ports.motion(|motion| motion.commanded_position());
    let before = program::beginning(&mut machine.program);
    let before = before.ok_or_else(|| Failure::refused(&OTHER_MODES))?;
    fast_forward::keep(machine);
    machine.features.recovery = Some(Recovery {
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
    if z.is_none() && !machine.axes.homed().has(Axis::Z) {
        // Z is as it was when the job stopped, and so is the temperature at which it is right.
        machine.thermal.refer_to(Some(frame).filter(|frame| *frame != 0.0));
    }
    machine.say(to, format_args!("// the file is read up to where the job was\n"));
    read_up_to(machine, made + 1, Step::Compare, to)
}

/// Reads the file from its beginning until so many lines have begun; then follows this step.
fn read_up_to<P: Ports>(machine: &mut Machine<'_, P>, lines: u32, then: Step, to: Recipient) -> Outcome {
    let Some(recovery) = &mut machine.features.recovery else { return Err(Failure::HALTED) };
    let dialect = usize::from(recovery.offer.file.dialect).checked_sub(1);
    if !program::begin_again(&mut machine.program, &mut recovery.offer.beginning) {
        return Err(Failure::refused(&"the journal is damaged: the job cannot be gone on with"));
    }
    // The offset of the entry counts: the offset at the job's beginning is another temperature's.
    machine.program.set_thermal_z(recovery.offer.entry.thermal_z);
    machine.jobs.read_again(&mut machine.world.ports).map_err(|error| machine.world.texts.because(error.text()))?;
    if let Some(dialect) = dialect.and_then(|place| Dialect::ALL.get(place)) {
        machine.jobs.read_as(*dialect);
    }
    read_on(machine, Until::Begun(lines), then, to)
}

fn read_on<P: Ports>(machine: &mut Machine<'_, P>, until: Until, then: Step, to: Recipient) -> Outcome {
    if !machine.frames.push(Frame::Then(Then::Step(state::Step::Recover(then, to)))) {
        return Err(Failure::refused(&"scripts start each other without end"));
    }
    fast_forward::begin(machine, until)?;
    // The job has begun once: its journal is not begun anew, and nothing refuses it.
    if machine.jobs.take_new() {
        Features::<P>::job_begins(machine, JobBegins::Again);
    }
    Ok(Answer::Ok)
}

/// Gives up the recovery: the program and its modes are as before the request, and the offer stays.
pub(crate) fn give_up<P: Ports>(machine: &mut Machine<'_, P>) {
    machine.passed = None;
    machine.features.journal.close(&mut machine.world.ports);
    machine.jobs.close(&mut machine.world.ports);
    if let Some(mut recovery) = machine.features.recovery.take() {
        fast_forward::put_back(machine);
        // The modes from before are the program's own.
        let _ = program::begin_again(&mut machine.program, &mut recovery.before);
        machine.program.set_thermal_z(machine.thermal.offset());
        // Heaters that somebody else has switched on before stay so.
        if recovery.has_heated {
            heat_restoring::cool(&mut machine.world.ports);
        }
    }
    machine.resynchronise();
}

/// Carries out the next step of the recovery.
///
/// # Errors
/// When the step cannot be done; then nothing of the recovery is left.
pub(crate) fn go_on<P: Ports>(machine: &mut Machine<'_, P>, step: Step, to: Recipient) -> Result<(), Failure> {
    let done = match step {
        Step::Compare => compare(machine, to).map(drop),
        Step::Look => look(machine, to).map(drop),
        Step::Prepare => prepare(machine, to),
        Step::GoBack => go_back(machine, to),
    };
    if done.is_err_and(|failure| failure.is_refusal()) {
        give_up(machine);
    }
    done
}

fn compare<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Outcome {
    let passed = Passed::arrived(machine.passed.take(), &ENDS_BEFORE)?;
    let Some(recovery) = &mut machine.features.recovery else { return Err(Failure::HALTED) };
    let (from, end, was) = (passed.line_began_at, *machine.program.position(), recovery.offer.entry.position);
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
    read_on(machine, Until::Seconds(if stands { 0.0 } else { seconds }), Step::Look, to)
}

fn look<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Outcome {
    // The file may end within that time.
    let passed = machine.passed.take().ok_or(Failure::HALTED)?;
    let up = homes_upwards(machine.world.config);
    let Some(recovery) = &mut machine.features.recovery else { return Err(Failure::HALTED) };
    let entry = &recovery.offer.entry;
    // Movements of axes since the machine was switched on are known.
    let is_lost = |axis: Axis| entry.strayed & 1 << axis as u8 != 0 && !machine.features.journal.strayed.has(axis);
    let known = machine.axes.homed().or(machine.can_home);
    if let Some(axis) = [Axis::X, Axis::Y].into_iter().find(|axis| is_lost(*axis) && !known.has(*axis)) {
        return Err(machine.world.texts.refused(format_args!(
            "{} was moved after the job and has no switch: M1000 C forgets the job",
            axis.letter()
        )));
    }
    let [mut least, mut most] = entry.z;
    if !entry.stands && !entry.doing.waits() {
        (least, most) = (least.min(passed.z[0]), most.max(passed.z[1]));
    }
    let is_told = recovery.z_is_told || machine.axes.homed().has(Axis::Z);
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
        return Err(machine.world.texts.refused(format_args!(
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
    read_up_to(machine, made, Step::Prepare, to)
}

/// Whether Z homes by going up, away from the part.
fn homes_upwards(config: &MachineConfig) -> bool {
    let stop = config.homing_endstop(Axis::Z);
    stop.is_some_and(|stop| stop.homing_direction == HomingDirection::ToMax)
}

fn prepare<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Result<(), Failure> {
    let passed = Passed::arrived(machine.passed.take(), &ENDS_BEFORE)?;
    let (kept, place) = (machine.program.keep(), *machine.program.position());
    let Machine { jobs, features: States { recovery, journal, .. }, world: World { ports, .. }, .. } = machine;
    let Some(recovery) = recovery else { return Err(Failure::HALTED) };
    if Axis::PRIMARY.into_iter().any(|axis| (place[axis] - recovery.place[axis]).abs() > SAME_Z) {
        return Err(Failure::refused(
            &"the file leads to another place each time that it is read: M1000 C forgets the job",
        ));
    }
    (recovery.kept, recovery.place, recovery.switches) = (Some(kept), place, passed.switches);
    recovery.has_heated = true;
    jobs.objects.set_left_out(recovery.offer.entry.left_out);
    journal.go_on(&recovery.offer, ports).map_err(|error| machine.world.texts.because(error.text()))?;
    let entry = recovery.offer.entry;
    heat_restoring::heat(&mut MachineHands::new(machine, to), &entry.targets.map(|target| Celsius(target as f32)))?;
    lift(machine, &entry.position, to)?;
    // The script moves from the tool's place, not from the file's.
    machine.standstill()?;
    machine.resynchronise();
    let script = machine.world.config.player.power_loss.gcode.as_str();
    if !script.is_empty() {
        journal::note(machine, Heights::Any, false);
    }
    suspend::start_script(&mut machine.frames, script, Then::Step(state::Step::Recover(Step::GoBack, to))).map(drop)
}

/// Lifts the tool clear of everything that stands on the bed; then homes X and Y, and Z where that is
/// upwards.
fn lift<P: Ports>(machine: &mut Machine<'_, P>, was: &[f64], to: Recipient) -> Result<(), Failure> {
    let sag = machine.world.config.player.power_loss.sag;
    let Some(recovery) = &machine.features.recovery else { return Err(Failure::HALTED) };
    let (z, z_is_told, is_blind, highest) = (recovery.z, recovery.z_is_told, recovery.goes_up_blind, recovery.highest);
    let mut here = machine.world.ports.motion(|motion| motion.commanded_position());
    let homed = machine.axes.homed();
    for axis in Axis::PRIMARY.into_iter().filter(|axis| !homed.has(*axis)) {
        // Somebody may have moved the axis by hand since.
        here[axis] += was.get(axis as usize).copied().unwrap_or(0.0) - machine.features.journal.stood_at[axis];
    }
    if !homed.has(Axis::Z) {
        let has_moved = here[Axis::Z] - was.get(Axis::Z as usize).copied().unwrap_or(0.0);
        here[Axis::Z] = if z_is_told { z } else { z + has_moved - sag };
    }
    MachineHands::new(machine, to).set_position(here)?;
    if let Some(recovery) = &mut machine.features.recovery {
        recovery.is_placed = true;
    }
    if !is_blind {
        go_up(machine, here, highest, to)?;
    }
    let mut homes = AxisSet::of(Axis::X).with(Axis::Y).and(machine.can_home);
    if homes_upwards(machine.world.config) {
        // Until Z is homed it may be anywhere between.
        journal::note(machine, Heights::Any, false);
        machine.announce(format_args!("// homing Z, upwards\n"));
        machine.axes.mark_homed(AxisSet::PRIMARY);
        homing::home(&mut MachineHands::new(machine, to), AxisSet::of(Axis::Z))?;
        journal::note(machine, Heights::Planned, false);
        // Towers and arms have homed together.
        homes = if procedures::arms::homes_by_motor(machine.world.config) { AxisSet::NONE } else { homes };
    } else if homes.is_empty() {
        machine.announce(format_args!("// WARNING X and Y have no switches: they are taken to be where they were\n"));
    }
    if homes.is_empty() {
        return Ok(());
    }
    machine.announce(format_args!("// homing X and Y\n"));
    homing::home(&mut MachineHands::new(machine, to), homes)
}

/// Lifts Z so high that X and Y can go to their switches.
fn go_up<P: Ports>(
    machine: &mut Machine<'_, P>,
    here: PerAxis<f64>,
    highest: f64,
    to: Recipient,
) -> Result<(), Failure> {
    let mut up = here;
    up[Axis::Z] = above(machine, here[Axis::Z].max(highest)).max(here[Axis::Z]);
    machine.announce(format_args!("// up to Z{:.2}\n", up[Axis::Z]));
    // Until Z has arrived it may be anywhere between.
    journal::note(machine, Heights::Between([here[Axis::Z], up[Axis::Z]]), false);
    machine.axes.mark_homed(AxisSet::PRIMARY);
    let hands = &mut MachineHands::new(machine, to);
    hands.enable_motors()?;
    hands.go_there(up, SLOWLY)?;
    journal::note(machine, Heights::Planned, false);
    Ok(())
}

/// Returns the height that clears everything up to this height, mm.
fn above<P: Ports>(machine: &mut Machine<'_, P>, highest: f64) -> f64 {
    let [_, most] = machine.travel().ends();
    (highest + machine.world.config.player.power_loss.lift).min(most[Axis::Z])
}

fn go_back<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Result<(), Failure> {
    machine.standstill()?;
    let Some(recovery) = machine.features.recovery.clone() else { return Err(Failure::HALTED) };
    let (entry, mut place) = (recovery.offer.entry, recovery.place);
    // The frame's temperature differs from that at the entry.
    place[Axis::Z] += machine.thermal.offset() - entry.thermal_z;
    let mut over = machine.world.ports.motion(|motion| motion.commanded_position());
    // Filament counts from here as in the file; and nothing has turned A, B or C since.
    Axis::ALL.into_iter().filter(|axis| !Axis::PRIMARY.contains(axis)).for_each(|axis| over[axis] = place[axis]);
    MachineHands::new(machine, to).set_position(over)?;
    // The script may have left the tool low, and homing at its highest: there a delta goes nowhere else.
    let from = over;
    over[Axis::Z] = above(machine, recovery.highest);
    let up = over;
    (over[Axis::X], over[Axis::Y]) = (place[Axis::X], place[Axis::Y]);
    machine.stays_within(&from, &up)?;
    machine.stays_within(&up, &over)?;
    machine.stays_within(&over, &place)?;
    machine.announce(format_args!("// back to X{:.2} Y{:.2}, and down\n", place[Axis::X], place[Axis::Y]));
    let rate = machine.program.modal().seek_rate;
    let hands = &mut MachineHands::new(machine, to);
    hands.go(up, rate, Mode::Rapid)?;
    hands.go_there(over, rate)?;
    let [low, high] = [place[Axis::Z].min(over[Axis::Z]), over[Axis::Z].max(place[Axis::Z])];
    journal::note(machine, Heights::Between([low, high]), false);
    MachineHands::new(machine, to).go_there(place, SLOWLY)?;
    machine.program.set_thermal_z(place[Axis::Z] - recovery.place[Axis::Z] + entry.thermal_z);
    if let Some(kept) = recovery.kept {
        machine.program.come_back_to(kept);
    }
    machine.program.resynchronise(place);
    // The job may go on within an object that was left out.
    program::objects::leave_out(&mut machine.program, machine.jobs.objects.is_left_out());
    let factor = entry.feed_factor / machine.program.modal().speed_factor;
    machine.world.ports.motion(|motion| motion.set_overrides(factor, motion.overrides().rapid));
    program::set_flow(&mut machine.program, &entry.flow);
    let Machine { outputs, world: World { config, ports, .. }, .. } = machine;
    heat_restoring::switch(outputs, config, ports, &recovery.switches);
    (machine.features.recovery, machine.set_before) = (None, None);
    Features::<P>::job_goes_on(machine, recovery.offer.beginning);
    journal::note(machine, Heights::Planned, false);
    machine
        .announce(format_args!("// the job goes on with line {}: what was made behind it is made twice\n", entry.line));
    Ok(())
}

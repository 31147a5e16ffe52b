//! Suspending and resuming a job, and starting the frames of scripts and of saved settings.

use base::axes::Axes;
use base::failure::{Answer, Failure, Outcome, Texts};
use base::hands::Hands as _;
use base::needs::needs;
use base::paths::Path;
use base::ports::{HeatPort, OpenMode, StorageError};
use base::safe_file;
use base::safety::Event;
use base::sessions::Recipient;
use base::{Ports, World};
use config::FilamentChangeConfig;
use events::Event as Happened;
use gcode::LineBuffer;
use heapless::Vec;
use jobs::player::{Jobs, Suspended};
use motion::Mode;
use parts::heat_codes;
use program::Part;
use units::{Axis, AxisSet, Celsius, HeaterId};

use crate::machine::frames::{Frame, Frames, Replay, Then};
use crate::machine::hands::MachineHands;
use crate::machine::moments::{Features, Moments as _};
use crate::machine::{Machine, effects};

/// `suspend`: pauses the job, so that a person can work at the machine.
pub(crate) fn suspend<P: Ports>(machine: &mut Machine<'_, P>, heaters_stay: bool, to: Recipient) -> Outcome {
    if is_already(&machine.jobs, &mut machine.world, to) {
        return Ok(Answer::Ok);
    }
    begin(machine, to)?;
    let targets = targets(&mut machine.world.ports);
    keep(machine, targets, None);
    rest(&mut machine.world, &mut machine.frames, heaters_stay)
}

/// Whether the job is suspended already, which is said.
pub(crate) fn is_already<P: Ports>(jobs: &Jobs, world: &mut World<'_, P>, to: Recipient) -> bool {
    if jobs.is_suspended() {
        world.say(to, format_args!("Already suspended\n"));
    }
    jobs.is_suspended()
}

/// Begins a suspension: the sender has its answer, and nothing moves any more.
///
/// # Errors
/// Without a card for jobs, and when the machine halts.
pub(crate) fn begin<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Result<(), Failure> {
    needs(machine.world.texts, machine.world.config, Part::Player, machine.jobs.is_playing())?;
    machine.announce(format_args!("// Suspending print, waiting for queue to empty...\n"));
    // A host that prints must stop; a host that only follows the file must know.
    let is_file = machine.jobs.set_paused(true);
    machine.world.sessions.tell_hosts(if is_file { "paused" } else { "pause" }, Recipient::Nobody);
    // The sender stops when it has its answer, and the file has stopped already.
    machine.say(to, format_args!("ok\n"));
    machine.announce(format_args!("// Waiting for queue to empty (Host must stop sending)...\n"));
    machine.standstill()?;
    machine.announce(format_args!("// Saving current state...\n"));
    Ok(())
}

/// Keeps where the job is, the temperatures that it goes on with, and a change of filament that it waits for.
pub(crate) fn keep<P: Ports>(
    machine: &mut Machine<'_, P>,
    targets: [Celsius; units::MAX_HEATERS],
    change: Option<FilamentChangeConfig>,
) {
    let position = machine.world.ports.motion(|motion| motion.commanded_position());
    let kept = machine.program.keep();
    machine.jobs.suspend(Suspended { position, kept, targets, change, stall: None });
    machine.axes.keep_place(AxisSet::NONE);
    machine.safety.apply(Event::Suspend);
    machine.record(&Happened::JobSuspended { line: machine.jobs.line() });
}

/// Returns the targets of heaters in the order of the configuration; 0 for heaters that are off.
pub(crate) fn targets(ports: &mut impl HeatPort) -> [Celsius; units::MAX_HEATERS] {
    ports.heat(|heat| {
        let mut targets = [Celsius(0.0); units::MAX_HEATERS];
        targets.iter_mut().zip(heat.heaters()).for_each(|(target, (_, heater))| *target = heater.target());
        targets
    })
}

/// Has the job wait for a person: heaters off, unless they are to stay on, and the script for that.
pub(crate) fn rest<'c, P: Ports, S>(
    world: &mut World<'c, P>,
    frames: &mut Frames<'c, S>,
    heaters_stay: bool,
) -> Outcome {
    let player = &world.config.player;
    if !(heaters_stay || player.leave_heaters_on_suspend) {
        // Switching off is never refused.
        for id in HeaterId::all() {
            let _ = world.ports.heat(|heat| heat.set_target(id, Celsius(0.0)));
        }
    }
    start_script(frames, player.after_suspend_gcode.as_str(), Then::Suspended).map(|_| Answer::Said)
}

/// M601 and `resume`: heats up again, then goes back and goes on.
pub(crate) fn resume<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Outcome {
    let Some(targets) = machine.jobs.suspended().map(|suspended| suspended.targets) else {
        machine.say(to, format_args!("Not suspended\n"));
        return Ok(Answer::Ok);
    };
    needs(machine.world.texts, machine.world.config, Part::Player, machine.jobs.is_playing())?;
    Features::<P>::may_resume(machine)?;
    let homes_itself = machine.jobs.stalled_job().map_or(AxisSet::NONE, |stall| stall.lost);
    if machine.world.config.player.before_resume_gcode.is_empty() {
        knows_the_place(&machine.axes, machine.world.texts, homes_itself)?;
    }
    machine.announce(format_args!("// resuming print...\n"));
    let heated = || HeaterId::all().zip(targets).filter(|(_, target)| target.0 > 0.0);
    for (id, target) in heated() {
        heat_codes::set_target(machine.world.texts, &mut machine.world.ports, machine.world.config, id, target)?;
    }
    if heated().next().is_some() {
        machine.announce(format_args!("// Waiting for heaters...\n"));
    }
    for (id, _) in heated() {
        heat_codes::wait_for_temperature(&mut MachineHands::new(machine, to), id)?;
    }
    Features::<P>::before_going_back(machine)?;
    let script = machine.world.config.player.before_resume_gcode.as_str();
    if !script.is_empty() {
        machine.announce(format_args!("// Executing before resume gcode...\n"));
    }
    start_script(&mut machine.frames, script, Then::Resumed)
}

/// Whether coordinates mean the same as when the job was suspended, but for these axes.
fn knows_the_place(axes: &Axes, texts: &Texts, but: AxisSet) -> Result<(), Failure> {
    let [strayed, comes_back] = axes.strayed().map(|axes| axes.without(but));
    let Some(axis) = strayed.axes().next().map(Axis::letter) else { return Ok(()) };
    let what_to_do = if strayed == comes_back {
        "home it, then resume; abort ends the job"
    } else {
        "it was not homed when the job was suspended: abort ends the job"
    };
    Err(texts.refused(format_args!("{axis} is not where it reads: {what_to_do}")))
}

/// Goes back to the job's place of the work, with the modes of the program as they were. Offsets that were
/// set meanwhile stay: for a longer cutter the place is higher.
pub(crate) fn go_back<P: Ports>(machine: &mut Machine<'_, P>) -> Result<(), Failure> {
    knows_the_place(&machine.axes, machine.world.texts, AxisSet::NONE)?;
    let Some(Suspended { position: was, kept, .. }) = machine.jobs.suspended() else { return Ok(()) };
    let other_tool = program::take_up_tool(&mut machine.program, kept);
    let position = program::same_work_place(&mut machine.program, kept, was);
    let mut from = machine.world.ports.motion(|motion| motion.commanded_position());
    let mut target = from;
    Axis::PRIMARY.into_iter().for_each(|axis| target[axis] = position[axis]);
    machine.stays_within(&from, &target)?;
    if let Some(tool) = other_tool {
        machine.announce(format_args!("// NOTE the job goes on with its own tool, T{}\n", tool.0));
    }
    let Some(suspended) = machine.jobs.take_suspended() else { return Ok(()) };
    let stalled = suspended.stall.map(|mut stall| {
        // Relative words of the stalled line count from its beginning, which moves with the restored place.
        Axis::PRIMARY.into_iter().for_each(|axis| stall.begins[axis] += position[axis] - suspended.position[axis]);
        stall
    });
    if stalled.is_some() {
        // The suspension stays until the machine has arrived: it may stall on its way.
        machine.jobs.suspend(suspended.clone());
    }
    if suspended.change.is_some() || stalled.is_some() {
        // Filament moved meanwhile is not of the program; a line that is made again pushes again.
        machine.standstill()?;
        for axis in Axis::ALL.into_iter().filter(|axis| machine.program.tools().uses(*axis)) {
            (from[axis], target[axis]) = (position[axis], position[axis]);
        }
        MachineHands::new(machine, Recipient::Nobody).set_position(from)?;
    }
    Features::<P>::goes_back(machine);
    machine.safety.apply(Event::Unsuspend);
    program::go_on_from(&mut machine.program, suspended.kept);
    while let Some(what) = machine.program.next_effect() {
        effects::change(machine, what)?;
    }
    let rate = machine.program.modal().seek_rate;
    machine.announce(format_args!("// Restoring saved XYZ positions and state...\n"));
    // Parts on the bed must not be run into: over the place, then down to it; or up, then over it.
    let mut over = target;
    if from[Axis::Z] > target[Axis::Z] {
        over[Axis::Z] = from[Axis::Z];
    } else {
        (over[Axis::X], over[Axis::Y]) = (from[Axis::X], from[Axis::Y]);
    }
    let hands = &mut MachineHands::new(machine, Recipient::Nobody);
    hands.go(over, rate, Mode::Rapid)?;
    hands.go(target, rate, Mode::Rapid)?;
    machine.resynchronise();
    if let Some(stall) = stalled {
        Features::<P>::arrives(machine, &stall)?;
    }
    machine.announce(format_args!("// Resuming print\n"));
    machine.record(&Happened::JobResumed { line: machine.jobs.line() });
    let is_file = machine.jobs.set_paused(false);
    machine.world.sessions.tell_hosts(if is_file { "resumed" } else { "resume" }, Recipient::Nobody);
    Ok(())
}

/// Runs a line of the configuration, and then what follows it.
pub(crate) fn start_script<'c, S>(frames: &mut Frames<'c, S>, script: &'c str, then: Then<S>) -> Outcome {
    let fits = frames.push(Frame::Then(then)) && frames.push_script(script);
    if fits { Ok(Answer::Ok) } else { Err(Failure::refused(&"scripts start each other without end")) }
}

/// Runs a line of the configuration, where there is one. False: there is none, or no room for it.
pub(crate) fn start_unless_empty<'c, S>(frames: &mut Frames<'c, S>, script: &'c str) -> bool {
    !script.is_empty() && start_script(frames, script, Then::Ended(Ok(()))).is_ok()
}

/// Opens a file of saved settings, which is replayed before anything else is done.
pub(crate) fn begin_replay<P: Ports>(
    machine: &mut Machine<'_, P>,
    path: &Path,
    asked: Recipient,
    by_load: bool,
) -> Result<(), StorageError> {
    safe_file::settle(&mut machine.world.ports, path)?;
    let file = machine.world.ports.open(path, OpenMode::Read)?;
    let replay = Replay {
        file,
        path: path.clone(),
        asked,
        by_load,
        inches: machine.program.count_in_mm(),
        gathering: LineBuffer::new(),
        chunk: Vec::new(),
        next: 0,
        at_end: false,
    };
    if machine.frames.push(Frame::Replay(replay)) { Ok(()) } else { Err(StorageError::TooManyOpen) }
}

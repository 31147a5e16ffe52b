//! Suspending and resuming a job, and starting the frames of scripts and of saved settings.

use base::axes::Axes;
use base::failure::{Answer, Failure, Outcome, Texts};
use base::hands::Hands as _;
use base::needs::needs;
use base::paths::Path;
use base::ports::{HeatPort, OpenMode, Storage as _, StorageError};
use base::safe_file;
use base::safety::Event;
use base::sessions::Recipient;
use base::{Ports, World};
use config::FilamentChangeConfig;
use events::Event as Happened;
use gcode::LineBuffer;
use heapless::Vec;
use jobs::player::{Jobs, StalledJob, Suspended};
use motion::Mode;
use parts::heat_codes;
use program::{Effect, Part};
use units::{Axis, AxisSet, Celsius, HeaterId};

use crate::machine::frames::{Frame, Frames, Replay, Then};
use crate::machine::moments::{Features, Moments as _};
use crate::machine::work_hands::JobHands;
use crate::machine::{Machine, effects};

/// The machine for a suspended job's way back: what features and outputs have to do with it.
pub(crate) trait SuspendHands<'c>: JobHands<'c> {
    /// Has features refuse to go on.
    ///
    /// # Errors
    /// With the reason.
    fn may_resume(&mut self) -> Result<(), Failure>;

    /// Has features act before the way back; heaters are hot.
    ///
    /// # Errors
    /// When the job must stay suspended, or the machine halts.
    fn before_going_back(&mut self) -> Result<(), Failure>;

    /// Has features act on the way back.
    fn goes_back(&mut self);

    /// Carries out an effect of the program's modes.
    ///
    /// # Errors
    /// When it is refused, or the machine halts.
    fn change(&mut self, effect: Effect) -> Result<(), Failure>;

    /// Has features act where a stall has stopped the job.
    ///
    /// # Errors
    /// When the machine halts.
    fn arrives(&mut self, stall: &StalledJob) -> Result<(), Failure>;
}

impl<'c, P: Ports> SuspendHands<'c> for Machine<'c, P> {
    fn may_resume(&mut self) -> Result<(), Failure> {
        Features::<P>::may_resume(self)
    }

    fn before_going_back(&mut self) -> Result<(), Failure> {
        Features::<P>::before_going_back(self)
    }

    fn goes_back(&mut self) {
        Features::<P>::goes_back(self);
    }

    fn change(&mut self, effect: Effect) -> Result<(), Failure> {
        effects::change(self, effect)
    }

    fn arrives(&mut self, stall: &StalledJob) -> Result<(), Failure> {
        Features::<P>::arrives(self, stall)
    }
}

/// `suspend`: pauses the job, so that a person can work at the hands.
pub(crate) fn suspend<'c>(hands: &mut impl JobHands<'c>, heaters_stay: bool, to: Recipient) -> Outcome {
    let (jobs, world) = hands.jobs_in_world();
    if is_already(jobs, world, to) {
        return Ok(Answer::Ok);
    }
    begin(hands, to)?;
    let targets = targets(&mut hands.world().ports);
    keep(hands, targets, None);
    rest(hands, heaters_stay)
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
pub(crate) fn begin<'c>(hands: &mut impl JobHands<'c>, to: Recipient) -> Result<(), Failure> {
    let is_playing = hands.jobs().is_playing();
    needs(hands.world().texts, hands.world().config, Part::Player, is_playing)?;
    hands.announce(format_args!("// Suspending print, waiting for queue to empty...\n"));
    // A host that prints must stop; a host that only follows the file must know.
    let is_file = hands.jobs().set_paused(true);
    hands.world().sessions.tell_hosts(if is_file { "paused" } else { "pause" }, Recipient::Nobody);
    // The sender stops when it has its answer, and the file has stopped already.
    hands.say(to, format_args!("ok\n"));
    hands.announce(format_args!("// Waiting for queue to empty (Host must stop sending)...\n"));
    hands.standstill()?;
    hands.announce(format_args!("// Saving current state...\n"));
    Ok(())
}

/// Keeps where the job is, the temperatures that it goes on with, and a change of filament that it waits for.
pub(crate) fn keep<'c>(
    hands: &mut impl JobHands<'c>,
    targets: [Celsius; units::MAX_HEATERS],
    change: Option<FilamentChangeConfig>,
) {
    let position = hands.position();
    let kept = hands.program().keep();
    hands.jobs().suspend(Suspended { position, kept, targets, change, stall: None });
    hands.axes().keep_place(AxisSet::NONE);
    hands.apply(Event::Suspend);
    let line = hands.jobs().line();
    hands.record(&Happened::JobSuspended { line });
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
pub(crate) fn rest<'c>(hands: &mut impl JobHands<'c>, heaters_stay: bool) -> Outcome {
    let world = hands.world();
    let player = &world.config.player;
    if !(heaters_stay || player.leave_heaters_on_suspend) {
        // Switching off is never refused.
        for id in HeaterId::all() {
            let _ = world.ports.heat(|heat| heat.set_target(id, Celsius(0.0)));
        }
    }
    start_script(hands.frames(), player.after_suspend_gcode.as_str(), Then::Suspended).map(|_| Answer::Said)
}

/// M601 and `resume`: heats up again, then goes back and goes on.
pub(crate) fn resume<'c>(hands: &mut impl SuspendHands<'c>, to: Recipient) -> Outcome {
    let Some(targets) = hands.jobs().suspended().map(|suspended| suspended.targets) else {
        hands.say(to, format_args!("Not suspended\n"));
        return Ok(Answer::Ok);
    };
    let is_playing = hands.jobs().is_playing();
    needs(hands.world().texts, hands.world().config, Part::Player, is_playing)?;
    hands.may_resume()?;
    let homes_itself = hands.jobs().stalled_job().map_or(AxisSet::NONE, |stall| stall.lost);
    if hands.world().config.player.before_resume_gcode.is_empty() {
        let texts = hands.world().texts;
        knows_the_place(hands.axes(), texts, homes_itself)?;
    }
    hands.announce(format_args!("// resuming print...\n"));
    let heated = || HeaterId::all().zip(targets).filter(|(_, target)| target.0 > 0.0);
    for (id, target) in heated() {
        let World { ports, texts, config, .. } = hands.world();
        heat_codes::set_target(texts, ports, config, id, target)?;
    }
    if heated().next().is_some() {
        hands.announce(format_args!("// Waiting for heaters...\n"));
    }
    for (id, _) in heated() {
        heat_codes::wait_for_temperature(&mut hands.sequence(to), id)?;
    }
    hands.before_going_back()?;
    let script = hands.world().config.player.before_resume_gcode.as_str();
    if !script.is_empty() {
        hands.announce(format_args!("// Executing before resume gcode...\n"));
    }
    start_script(hands.frames(), script, Then::Resumed)
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
pub(crate) fn go_back<'c>(hands: &mut impl SuspendHands<'c>) -> Result<(), Failure> {
    let texts = hands.world().texts;
    knows_the_place(hands.axes(), texts, AxisSet::NONE)?;
    let (jobs, program) = hands.jobs_and_program();
    let Some(Suspended { position: was, kept, .. }) = jobs.suspended() else { return Ok(()) };
    let other_tool = program::take_up_tool(program, kept);
    let position = program::same_work_place(program, kept, was);
    let mut from = hands.position();
    let mut target = from;
    Axis::PRIMARY.into_iter().for_each(|axis| target[axis] = position[axis]);
    hands.stays_within(&from, &target)?;
    if let Some(tool) = other_tool {
        hands.announce(format_args!("// NOTE the job goes on with its own tool, T{}\n", tool.0));
    }
    let Some(suspended) = hands.jobs().take_suspended() else { return Ok(()) };
    let stalled = suspended.stall.map(|mut stall| {
        // Relative words of the stalled line count from its beginning, which moves with the restored place.
        Axis::PRIMARY.into_iter().for_each(|axis| stall.begins[axis] += position[axis] - suspended.position[axis]);
        stall
    });
    if stalled.is_some() {
        // The suspension stays until the machine has arrived: it may stall on its way.
        hands.jobs().suspend(suspended.clone());
    }
    if suspended.change.is_some() || stalled.is_some() {
        // Filament moved meanwhile is not of the program; a line that is made again pushes again.
        hands.standstill()?;
        let tools = hands.program().tools();
        for axis in Axis::ALL.into_iter().filter(|axis| tools.uses(*axis)) {
            (from[axis], target[axis]) = (position[axis], position[axis]);
        }
        hands.sequence(Recipient::Nobody).set_position(from)?;
    }
    hands.goes_back();
    hands.apply(Event::Unsuspend);
    program::go_on_from(hands.program(), suspended.kept);
    while let Some(what) = hands.program().next_effect() {
        hands.change(what)?;
    }
    let rate = hands.program().modal().seek_rate;
    hands.announce(format_args!("// Restoring saved XYZ positions and state...\n"));
    // Parts on the bed must not be run into: over the place, then down to it; or up, then over it.
    let mut over = target;
    if from[Axis::Z] > target[Axis::Z] {
        over[Axis::Z] = from[Axis::Z];
    } else {
        (over[Axis::X], over[Axis::Y]) = (from[Axis::X], from[Axis::Y]);
    }
    hands.sequence(Recipient::Nobody).go(over, rate, Mode::Rapid)?;
    hands.sequence(Recipient::Nobody).go(target, rate, Mode::Rapid)?;
    hands.resynchronise();
    if let Some(stall) = stalled {
        hands.arrives(&stall)?;
    }
    hands.announce(format_args!("// Resuming print\n"));
    let line = hands.jobs().line();
    hands.record(&Happened::JobResumed { line });
    let is_file = hands.jobs().set_paused(false);
    hands.world().sessions.tell_hosts(if is_file { "resumed" } else { "resume" }, Recipient::Nobody);
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
pub(crate) fn begin_replay<'c>(
    hands: &mut impl JobHands<'c>,
    path: &Path,
    asked: Recipient,
    by_load: bool,
) -> Result<(), StorageError> {
    safe_file::settle(&mut hands.world().ports, path)?;
    let file = hands.world().ports.open(path, OpenMode::Read)?;
    let replay = Replay {
        file,
        path: path.clone(),
        asked,
        by_load,
        inches: hands.program().count_in_mm(),
        gathering: LineBuffer::new(),
        chunk: Vec::new(),
        next: 0,
        at_end: false,
    };
    if hands.frames().push(Frame::Replay(replay)) { Ok(()) } else { Err(StorageError::TooManyOpen) }
}

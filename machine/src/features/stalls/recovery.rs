//! Recovery from a stall that stops a job: the tool lifts, lost axes are homed, and the job goes on with the
//! line that was under way; or it is suspended there until somebody has it go on.
//!
//! The machine brakes along its path, as in a hold, and moves planned behind are dropped. Z rises. Then the
//! file is read over up to the line that was under way, as after a power cut, so that the program stands
//! there, and the job is suspended. From there on the job takes the way of `resume`, with homing before it:
//! `pause` and `recover` differ only in whether that begins by itself.

use core::fmt::Display;

use base::Ports;
use base::failure::{Failure, FailureKind, short};
use base::hands::Hands as _;
use base::sessions::Recipient;
use config::{MachineConfig, OnStall};
use jobs::player::{StalledJob, Suspended};
use motion::State as Motion;
use procedures::homing;
use procedures::stall_recovery::{Phase, Stopped};
use program::{BEGINNING_BYTES, State};
use units::{Actuator, Axis, AxisSet, PerAxis};

use crate::features::stalls::step::Step;
use crate::features::state;
use crate::machine::fast_forward_record::{Passed, Until};
use crate::machine::frames::{Frame, Then};
use crate::machine::hands::MachineHands;
use crate::machine::moments::{Features, Moments as _};
use crate::machine::{Machine, fast_forward, suspend};

/// Distance within which the stop is on the way of a move, mm: corners are rounded.
const ON_THE_WAY: f64 = 0.05;
const CHANGED: &str = "modes or offsets were changed from a console, or are none that the file can be read again with";

/// Keeps the state that a file about to be read begins with, in case a stall stops it.
pub(crate) fn job_begins<P: Ports>(machine: &mut Machine<'_, P>) {
    if is_wanted(machine.world.config) {
        let beginning = program::beginning(&mut machine.program);
        machine.features.stalls.keep_beginning(machine.jobs.count(), beginning);
    }
}

/// Keeps the state that a file going on after a power cut began with.
pub(crate) fn job_goes_on<P: Ports>(machine: &mut Machine<'_, P>, beginning: [u8; BEGINNING_BYTES]) {
    if is_wanted(machine.world.config) {
        machine.features.stalls.keep_beginning(machine.jobs.count(), Some(beginning));
    }
}

fn is_wanted(config: &MachineConfig) -> bool {
    config.watched_for_stalls().any(|(motor, _)| config.on_stall(motor).keeps_job())
}

/// Stops the job, as a motor has stalled. False where no job can be stopped.
pub(crate) fn brake<P: Ports>(machine: &mut Machine<'_, P>, motor: Actuator) -> bool {
    let is_of_job = machine.jobs.is_playing() || matches!(machine.features.stalls.phase, Phase::Returns);
    let runs = machine.safety.mode().is_in(State::Run) && machine.hold.acts() && machine.features.recovery.is_none();
    if !is_of_job || !runs {
        return false;
    }
    machine.features.stalls.phase = Phase::Brakes(motor);
    machine.world.ports.motion(motion::Motion::hold);
    let letter = letter(motor);
    machine.announce(format_args!(
        "WARNING: motor {letter} stalls: it hit something, or its load is too high; the job stops\n"
    ));
    true
}

fn letter(motor: Actuator) -> char {
    Axis::ALL.get(motor as usize).map_or('?', |axis| axis.letter())
}

/// Watches a machine that brakes because of a stall: when it stands, all waits for its moves end.
pub(crate) fn watch<P: Ports>(machine: &mut Machine<'_, P>) {
    let Phase::Brakes(motor) = machine.features.stalls.phase else { return };
    let (state, stands, under_way, at) = machine.world.ports.motion(|motion| {
        let under_way = motion.waiting().next();
        (motion.state(), motion.is_held_still(), under_way, motion.held_at())
    });
    let is_idle = machine.world.ports.motion(|motion| motion.is_idle());
    if !stands && !is_idle {
        if state == Motion::Running {
            machine.world.ports.motion(motion::Motion::hold);
        }
        return;
    }
    let made = match under_way {
        Some(waiting) => machine.jobs.made(waiting.request.tag),
        // The job's last line has been made.
        None => Some(machine.jobs.begun()),
    };
    let line = under_way.and_then(|waiting| machine.jobs.line_of(waiting.request.tag));
    let mut flow = [1.0; 3];
    flow.iter_mut().zip(machine.program.tools().all()).for_each(|(to, tool)| *to = tool.flow);
    let lost = machine.world.config.motion.arm_solution.axes_of(motor).unwrap_or(AxisSet::PRIMARY);
    let stopped = Stopped {
        motor,
        lost,
        at,
        made,
        line: line.unwrap_or_else(|| machine.jobs.line_now()),
        straight_to: under_way.filter(|waiting| waiting.is_straight).map(|waiting| waiting.request.target),
        left_out: machine.jobs.objects.left_out(),
        flow,
    };
    machine.jobs.set_paused(true);
    machine.axes.forget_homed(lost);
    let now = machine.world.ports.now();
    if machine.safety.begin_reset(now) {
        machine.features.stalls.phase = Phase::Stands(stopped);
        machine.cut = crate::machine::move_dropping::Cut::default();
        machine.world.ports.motion(motion::Motion::stop);
        machine.world.ports.heat(|heat| heat.drop_effects());
        machine.features.riding_lights.clear();
        machine.program.halt();
    }
}

/// Begins the way back, before any other line, once all waits have ended.
pub(crate) fn begin<P: Ports>(machine: &mut Machine<'_, P>) {
    let Phase::Stands(stopped) = machine.features.stalls.phase else { return };
    if !machine.safety.is_halted() && machine.frames.is_empty() {
        machine.features.stalls.phase = Phase::Looks(stopped);
        // There is room, as nothing else is on the stack.
        let _ = machine.frames.push(Frame::Then(Then::Step(state::Step::Stalled(Step::Lift))));
    }
}

/// Carries out the next step of the recovery.
///
/// # Errors
/// When the machine halts, or a script cannot be run.
pub(crate) fn go_on<P: Ports>(machine: &mut Machine<'_, P>, step: Step) -> Result<(), Failure> {
    let Phase::Looks(stopped) = machine.features.stalls.phase else { return Ok(()) };
    let looked = match step {
        Step::Lift => lift_and_look(machine, &stopped),
        Step::Suspend => found(machine, &stopped).map(|()| true),
    };
    match looked {
        Ok(true) => get_over(machine, &stopped),
        Ok(false) => Ok(()),
        Err(why) if why.is_refusal() => end_job(machine, &stopped, machine.world.texts.of(why)),
        Err(failure) => Err(failure),
    }
}

/// Lifts the tool from the part, and has the file read up to where the job was. True: that is known already.
fn lift_and_look<P: Ports>(machine: &mut Machine<'_, P>, stopped: &Stopped) -> Result<bool, Failure> {
    if !machine.jobs.is_open() {
        return Err(Failure::HALTED);
    }
    let [_, most] = machine.travel().ends();
    let top = stopped.at[Axis::Z] + machine.world.config.motors.stall.lift.0;
    rise(machine, top.min(most[Axis::Z]))?;
    machine.resynchronise();
    if let Some(stall) = machine.jobs.stalled_job() {
        // The job was on its way back from a stall.
        stall.lost = stall.lost.or(stopped.lost);
        machine.safety.apply(base::safety::Event::Suspend);
        return Ok(true);
    }
    let made = stopped.made.ok_or_else(|| Failure::refused(&"what moved was none of its lines"))?;
    let beginning = machine.features.stalls.beginning_of(machine.jobs.count());
    let mut beginning = beginning.ok_or_else(|| Failure::refused(&CHANGED))?;
    if !program::begin_again(&mut machine.program, &mut beginning) {
        return Err(Failure::refused(&CHANGED));
    }
    machine.jobs.read_again(&mut machine.world.ports).map_err(|error| machine.world.texts.because(error.text()))?;
    if !machine.frames.push(Frame::Then(Then::Step(state::Step::Stalled(Step::Suspend)))) {
        return Err(Failure::refused(&"scripts start each other without end"));
    }
    machine.announce(format_args!("// the file is read up to line {}, where the job was\n", stopped.line));
    fast_forward::begin(machine, Until::Begun(made)).inspect_err(|_| machine.frames.drop_top())?;
    Ok(false)
}

/// Lifts Z so high, where it is homed and lower.
fn rise<P: Ports>(machine: &mut Machine<'_, P>, top: f64) -> Result<(), Failure> {
    let mut up = machine.world.ports.motion(|motion| motion.commanded_position());
    if !machine.axes.homed().has(Axis::Z) || top <= up[Axis::Z] {
        return Ok(());
    }
    up[Axis::Z] = top;
    Features::<P>::leaves_for_heights(machine, [top; 2]);
    let rate = machine.program.modal().seek_rate;
    MachineHands::new(machine, Recipient::All).go_there(up, rate)
}

/// Suspends the job where the program stands after the reading.
fn found<P: Ports>(machine: &mut Machine<'_, P>, stopped: &Stopped) -> Result<(), Failure> {
    let passed = Passed::arrived(machine.passed.take(), &"the file ends before the line that was under way")?;
    machine.program.set_thermal_z(machine.thermal.offset());
    machine.jobs.objects.set_left_out(stopped.left_out);
    program::objects::leave_out(&mut machine.program, machine.jobs.objects.is_left_out());
    program::set_flow(&mut machine.program, &stopped.flow);
    let begins = *machine.program.position();
    let is_on_its_way = stopped.straight_to.is_some_and(|end| is_between(&begins, &end, &stopped.at));
    // A curve, and a line of several moves, are made again from their beginning.
    let position = if is_on_its_way { stopped.at } else { begins };
    let stall = StalledJob { lost: stopped.lost, begins, above: above(machine, &passed, stopped) };
    let targets = suspend::targets(&mut machine.world.ports);
    let kept = machine.program.keep();
    machine.jobs.suspend(Suspended { position, kept, targets, change: None, stall: Some(stall) });
    machine.axes.keep_place(stopped.lost);
    machine.resynchronise();
    machine.safety.apply(base::safety::Event::Suspend);
    Ok(())
}

/// Whether a place is on a straight way.
fn is_between(from: &PerAxis<f64>, to: &PerAxis<f64>, place: &PerAxis<f64>) -> bool {
    let [way, done] = [to, place].map(|end| Axis::PRIMARY.map(|axis| end[axis] - from[axis]));
    let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let length = dot(&way, &way);
    let share = if length > 0.0 { dot(&way, &done) / length } else { 0.0 };
    let off = [0, 1, 2]
        .map(|axis: usize| done.get(axis).copied().unwrap_or(0.0) - share * way.get(axis).copied().unwrap_or(0.0));
    (-1e-3..=1.0 + 1e-3).contains(&share) && dot(&off, &off) <= ON_THE_WAY * ON_THE_WAY
}

/// Returns the height at which an axis may home over all parts made, mm.
fn above<P: Ports>(machine: &mut Machine<'_, P>, passed: &Passed, stopped: &Stopped) -> f64 {
    let [_, most] = machine.travel().ends();
    let highest = passed.z[1].max(stopped.at[Axis::Z]);
    (highest + machine.world.config.motors.stall.lift.0).min(most[Axis::Z])
}

/// Has the suspended job go on by itself, where it may.
fn get_over<P: Ports>(machine: &mut Machine<'_, P>, stopped: &Stopped) -> Result<(), Failure> {
    machine.features.stalls.rest();
    let settings = &machine.world.config.motors.stall;
    if machine.world.config.on_stall(stopped.motor) != OnStall::Recover {
        return pause(machine, stopped, "");
    }
    let now = machine.world.ports.now();
    let Some(count) = machine.features.stalls.take_recovery(now, settings) else {
        let (most, minutes) = (settings.most, settings.time.seconds() / 60.0);
        let why =
            short(format_args!("{most} stalls within {minutes:.0} minutes are enough: something is in its way; "));
        return pause(machine, stopped, why.as_str());
    };
    let most = settings.most;
    machine.announce(format_args!("// it homes and goes on by itself, {count} of {most}\n"));
    let returned = match rehome(machine) {
        Ok(()) => suspend::go_back(machine),
        Err(failure) => Err(failure),
    };
    match returned {
        Err(why) if why.has_text() => {
            machine.features.stalls.rest();
            let why = short(format_args!("{}; ", machine.world.texts.of(why)));
            pause(machine, stopped, why.as_str())
        }
        returned => returned,
    }
}

/// Lifts above all parts made, and homes the axes that have lost their place.
///
/// # Errors
/// Where Z is not homed, and where an end is not found.
pub(crate) fn rehome<P: Ports>(machine: &mut Machine<'_, P>) -> Result<(), Failure> {
    let Some(StalledJob { lost, above, .. }) = machine.jobs.stalled_job().copied() else { return Ok(()) };
    let homed = machine.axes.homed();
    let lost = lost.without(homed);
    if !homed.has(Axis::Z) {
        return Err(Failure::refused(&"Z is not homed, and is not homed onto a part: home it where that is safe"));
    }
    if let Some(axis) = lost.without(machine.can_home).axes().next() {
        return Err(machine.world.texts.refused(format_args!("{} has nothing to home with: set it", axis.letter())));
    }
    machine.features.stalls.phase = Phase::Returns;
    rise(machine, above)?;
    if lost.is_empty() {
        return Ok(());
    }
    machine.announce(format_args!("// homing what has lost its place\n"));
    let found = homing::home(&mut MachineHands::new(machine, Recipient::All), lost);
    if let Err(why) = found
        && why.is_alarm()
    {
        // Axes that have not stalled are where they were.
        machine.axes.mark_homed(homed);
        machine.features.stalls.rest();
        return Err(why.meaning(FailureKind::Refused));
    }
    found
}

/// Goes on with the rest of the stalled line, when the machine has come back to where the job was.
///
/// # Errors
/// When the machine halts.
pub(crate) fn arrive<P: Ports>(machine: &mut Machine<'_, P>, stall: &StalledJob) -> Result<(), Failure> {
    machine.features.stalls.phase = Phase::Returns;
    machine.standstill()?;
    machine.features.stalls.rest();
    let _arrived = machine.jobs.take_suspended();
    Features::<P>::extruders_count_anew(machine);
    machine.program.resynchronise(stall.begins);
    Ok(())
}

/// Has the job wait for a person, suspended.
fn pause<P: Ports>(machine: &mut Machine<'_, P>, stopped: &Stopped, why: &str) -> Result<(), Failure> {
    machine.features.stalls.rest();
    let (letter, line) = (letter(stopped.motor), stopped.line);
    machine.announce(format_args!(
        "WARNING: the job is paused at line {line}, where motor {letter} stalled: {why}resume homes what has lost its place \
         and goes on, abort ends it\n"
    ));
    suspend::rest(machine, false).map(drop)
}

/// Ends a job that cannot go on: not even its place is known.
fn end_job<P: Ports>(machine: &mut Machine<'_, P>, stopped: &Stopped, why: impl Display) -> Result<(), Failure> {
    machine.features.stalls.rest();
    machine.passed = None;
    let line = stopped.line;
    machine.announce(format_args!(
        "ERROR: the job ends at line {line}, where a motor stalled: {why}. Home, then play its file --from line {line}\n"
    ));
    Features::<P>::extruders_count_anew(machine);
    machine.jobs.close(&mut machine.world.ports);
    machine.resynchronise_if_still();
    suspend::rest(machine, false).map(drop)
}

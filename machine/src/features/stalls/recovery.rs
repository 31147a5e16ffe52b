//! Recovery from a stall that stops a job: the tool lifts, lost axes are homed, and the job goes on with the
//! line that was under way; or it is suspended there until somebody has it go on.
//!
//! The machine brakes along its path, as in a hold, and moves planned behind are dropped. Z rises. Then the
//! file is read over up to the line that was under way, as after a power cut, so that the program stands
//! there, and the job is suspended. From there on the job takes the way of `resume`, with homing before it:
//! `pause` and `recover` differ only in whether that begins by itself.

use core::fmt::Display;

use base::World;
use base::failure::{Failure, FailureKind, short};
use base::hands::Hands as _;
use base::ports::{Clock as _, MotionPort as _};
use base::sessions::Recipient;
use config::{MachineConfig, OnStall};
use jobs::player::{StalledJob, Suspended};
use motion::State as Motion;
use procedures::homing;
use procedures::stall_recovery::{Phase, Stopped};
use program::BEGINNING_BYTES;
use units::{Actuator, Axis, AxisSet, PerAxis};

use crate::features::stalls::StallHands;
use crate::features::stalls::step::Step;
use crate::features::state;
use crate::machine::fast_forward_record::{Passed, Until};
use crate::machine::frames::{Frame, Then};
use crate::machine::{fast_forward, suspend};

/// Distance within which the stop is on the way of a move, mm: corners are rounded.
const ON_THE_WAY: f64 = 0.05;
const CHANGED: &str = "modes or offsets were changed from a console, or are none that the file can be read again with";

/// Keeps the state that a file about to be read begins with, in case a stall stops it.
pub(crate) fn job_begins<'c>(hands: &mut impl StallHands<'c>) {
    if is_wanted(hands.world().config) {
        let (jobs, program) = hands.jobs_and_program();
        let (job, beginning) = (jobs.count(), program::beginning(program));
        hands.stalls().keep_beginning(job, beginning);
    }
}

/// Keeps the state that a file going on after a power cut began with.
pub(crate) fn job_goes_on<'c>(hands: &mut impl StallHands<'c>, beginning: [u8; BEGINNING_BYTES]) {
    if is_wanted(hands.world().config) {
        let job = hands.jobs().count();
        hands.stalls().keep_beginning(job, Some(beginning));
    }
}

fn is_wanted(config: &MachineConfig) -> bool {
    config.watched_for_stalls().any(|(motor, _)| config.on_stall(motor).keeps_job())
}

/// Stops the job, as a motor has stalled. False where no job can be stopped.
pub(crate) fn brake<'c>(hands: &mut impl StallHands<'c>, motor: Actuator) -> bool {
    let is_of_job = hands.jobs().is_playing() || matches!(hands.stalls().phase, Phase::Returns);
    let runs = hands.may_be_stopped();
    if !is_of_job || !runs {
        return false;
    }
    hands.stalls().phase = Phase::Brakes(motor);
    hands.world().ports.motion(motion::Motion::hold);
    let letter = letter(motor);
    hands.announce(format_args!(
        "WARNING: motor {letter} stalls: it hit something, or its load is too high; the job stops\n"
    ));
    true
}

fn letter(motor: Actuator) -> char {
    Axis::ALL.get(motor as usize).map_or('?', |axis| axis.letter())
}

/// Watches a machine that brakes because of a stall: when it stands, all waits for its moves end.
pub(crate) fn watch<'c>(hands: &mut impl StallHands<'c>) {
    let Phase::Brakes(motor) = hands.stalls().phase else { return };
    let (state, stands, under_way, at) = hands.world().ports.motion(|motion| {
        let under_way = motion.waiting().next();
        (motion.state(), motion.is_held_still(), under_way, motion.held_at())
    });
    let is_idle = hands.world().ports.motion(|motion| motion.is_idle());
    if !stands && !is_idle {
        if state == Motion::Running {
            hands.world().ports.motion(motion::Motion::hold);
        }
        return;
    }
    let jobs = hands.jobs();
    let made = match under_way {
        Some(waiting) => jobs.made(waiting.request.tag),
        // The job's last line has been made.
        None => Some(jobs.begun()),
    };
    let line = under_way.and_then(|waiting| jobs.line_of(waiting.request.tag));
    let (line, left_out) = (line.unwrap_or_else(|| jobs.line_now()), jobs.objects.left_out());
    let mut flow = [1.0; 3];
    flow.iter_mut().zip(hands.program().tools().all()).for_each(|(to, tool)| *to = tool.flow);
    let lost = hands.world().config.motion.arm_solution.axes_of(motor).unwrap_or(AxisSet::PRIMARY);
    let stopped = Stopped {
        motor,
        lost,
        at,
        made,
        line,
        straight_to: under_way.filter(|waiting| waiting.is_straight).map(|waiting| waiting.request.target),
        left_out,
        flow,
    };
    hands.jobs().set_paused(true);
    hands.axes().forget_homed(lost);
    if hands.begin_reset() {
        hands.stalls().phase = Phase::Stands(stopped);
        hands.drop_planned();
        hands.program().halt();
    }
}

/// Begins the way back, before any other line, once all waits have ended.
pub(crate) fn begin<'c>(hands: &mut impl StallHands<'c>) {
    let Phase::Stands(stopped) = hands.stalls().phase else { return };
    if !hands.is_halted() && hands.frames().is_empty() {
        hands.stalls().phase = Phase::Looks(stopped);
        // There is room, as nothing else is on the stack.
        let _ = hands.frames().push(Frame::Then(Then::Step(state::Step::Stalled(Step::Lift))));
    }
}

/// Carries out the next step of the recovery.
///
/// # Errors
/// When the machine halts, or a script cannot be run.
pub(crate) fn go_on<'c>(hands: &mut impl StallHands<'c>, step: Step) -> Result<(), Failure> {
    let Phase::Looks(stopped) = hands.stalls().phase else { return Ok(()) };
    let looked = match step {
        Step::Lift => lift_and_look(hands, &stopped),
        Step::Suspend => found(hands, &stopped).map(|()| true),
    };
    match looked {
        Ok(true) => get_over(hands, &stopped),
        Ok(false) => Ok(()),
        Err(why) if why.is_refusal() => {
            let texts = hands.world().texts;
            end_job(hands, &stopped, texts.of(why))
        }
        Err(failure) => Err(failure),
    }
}

/// Lifts the tool from the part, and has the file read up to where the job was. True: that is known already.
fn lift_and_look<'c>(hands: &mut impl StallHands<'c>, stopped: &Stopped) -> Result<bool, Failure> {
    if !hands.jobs().is_open() {
        return Err(Failure::HALTED);
    }
    let [_, most] = hands.travel().ends();
    let top = stopped.at[Axis::Z] + hands.world().config.motors.stall.lift.0;
    rise(hands, top.min(most[Axis::Z]))?;
    hands.resynchronise();
    if let Some(stall) = hands.jobs().stalled_job() {
        // The job was on its way back from a stall.
        stall.lost = stall.lost.or(stopped.lost);
        hands.apply(base::safety::Event::Suspend);
        return Ok(true);
    }
    let made = stopped.made.ok_or_else(|| Failure::refused(&"what moved was none of its lines"))?;
    let job = hands.jobs().count();
    let beginning = hands.stalls().beginning_of(job);
    let mut beginning = beginning.ok_or_else(|| Failure::refused(&CHANGED))?;
    if !program::begin_again(hands.program(), &mut beginning) {
        return Err(Failure::refused(&CHANGED));
    }
    let (jobs, World { ports, texts, .. }) = hands.jobs_in_world();
    jobs.read_again(ports).map_err(|error| texts.because(error.text()))?;
    if !hands.frames().push(Frame::Then(Then::Step(state::Step::Stalled(Step::Suspend)))) {
        return Err(Failure::refused(&"scripts start each other without end"));
    }
    hands.announce(format_args!("// the file is read up to line {}, where the job was\n", stopped.line));
    let begun = fast_forward::begin(hands, Until::Begun(made));
    begun.inspect_err(|_| hands.frames().drop_top()).map(|()| false)
}

/// Lifts Z so high, where it is homed and lower.
fn rise<'c>(hands: &mut impl StallHands<'c>, top: f64) -> Result<(), Failure> {
    let mut up = hands.position();
    if !hands.axes().homed().has(Axis::Z) || top <= up[Axis::Z] {
        return Ok(());
    }
    up[Axis::Z] = top;
    hands.leaves_for_heights([top; 2]);
    let rate = hands.program().modal().seek_rate;
    hands.sequence(Recipient::All).go_there(up, rate)
}

/// Suspends the job where the program stands after the reading.
fn found<'c>(hands: &mut impl StallHands<'c>, stopped: &Stopped) -> Result<(), Failure> {
    let passed = Passed::arrived(hands.passed().take(), &"the file ends before the line that was under way")?;
    let thermal_z = hands.thermal_z();
    let (jobs, program) = hands.jobs_and_program();
    program.set_thermal_z(thermal_z);
    jobs.objects.set_left_out(stopped.left_out);
    program::objects::leave_out(program, jobs.objects.is_left_out());
    program::set_flow(program, &stopped.flow);
    let begins = *program.position();
    let is_on_its_way = stopped.straight_to.is_some_and(|end| is_between(&begins, &end, &stopped.at));
    // A curve, and a line of several moves, are made again from their beginning.
    let position = if is_on_its_way { stopped.at } else { begins };
    let stall = StalledJob { lost: stopped.lost, begins, above: above(hands, &passed, stopped) };
    let targets = suspend::targets(&mut hands.world().ports);
    let kept = hands.program().keep();
    hands.jobs().suspend(Suspended { position, kept, targets, change: None, stall: Some(stall) });
    hands.axes().keep_place(stopped.lost);
    hands.resynchronise();
    hands.apply(base::safety::Event::Suspend);
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
fn above<'c>(hands: &mut impl StallHands<'c>, passed: &Passed, stopped: &Stopped) -> f64 {
    let [_, most] = hands.travel().ends();
    let highest = passed.z[1].max(stopped.at[Axis::Z]);
    (highest + hands.world().config.motors.stall.lift.0).min(most[Axis::Z])
}

/// Has the suspended job go on by itself, where it may.
fn get_over<'c>(hands: &mut impl StallHands<'c>, stopped: &Stopped) -> Result<(), Failure> {
    hands.stalls().rest();
    let settings = &hands.world().config.motors.stall;
    if hands.world().config.on_stall(stopped.motor) != OnStall::Recover {
        return pause(hands, stopped, "");
    }
    let now = hands.world().ports.now();
    let Some(count) = hands.stalls().take_recovery(now, settings) else {
        let (most, minutes) = (settings.most, settings.time.seconds() / 60.0);
        let why =
            short(format_args!("{most} stalls within {minutes:.0} minutes are enough: something is in its way; "));
        return pause(hands, stopped, why.as_str());
    };
    let most = settings.most;
    hands.announce(format_args!("// it homes and goes on by itself, {count} of {most}\n"));
    let returned = match rehome(hands) {
        Ok(()) => suspend::go_back(hands),
        Err(failure) => Err(failure),
    };
    match returned {
        Err(why) if why.has_text() => {
            hands.stalls().rest();
            let why = short(format_args!("{}; ", hands.world().texts.of(why)));
            pause(hands, stopped, why.as_str())
        }
        returned => returned,
    }
}

/// Lifts above all parts made, and homes the axes that have lost their place.
///
/// # Errors
/// Where Z is not homed, and where an end is not found.
pub(crate) fn rehome<'c>(hands: &mut impl StallHands<'c>) -> Result<(), Failure> {
    let Some(StalledJob { lost, above, .. }) = hands.jobs().stalled_job().copied() else { return Ok(()) };
    let homed = hands.axes().homed();
    let lost = lost.without(homed);
    if !homed.has(Axis::Z) {
        return Err(Failure::refused(&"Z is not homed, and is not homed onto a part: home it where that is safe"));
    }
    if let Some(axis) = lost.without(hands.can_home()).axes().next() {
        return Err(hands.world().texts.refused(format_args!("{} has nothing to home with: set it", axis.letter())));
    }
    hands.stalls().phase = Phase::Returns;
    rise(hands, above)?;
    if lost.is_empty() {
        return Ok(());
    }
    hands.announce(format_args!("// homing what has lost its place\n"));
    let found = homing::home(&mut hands.sequence(Recipient::All), lost);
    if let Err(why) = found
        && why.is_alarm()
    {
        // Axes that have not stalled are where they were.
        hands.axes().mark_homed(homed);
        hands.stalls().rest();
        return Err(why.meaning(FailureKind::Refused));
    }
    found
}

/// Goes on with the rest of the stalled line, when the machine has come back to where the job was.
///
/// # Errors
/// When the machine halts.
pub(crate) fn arrive<'c>(hands: &mut impl StallHands<'c>, stall: &StalledJob) -> Result<(), Failure> {
    hands.stalls().phase = Phase::Returns;
    hands.standstill()?;
    hands.stalls().rest();
    let _arrived = hands.jobs().take_suspended();
    hands.extruders_count_anew();
    hands.program().resynchronise(stall.begins);
    Ok(())
}

/// Has the job wait for a person, suspended.
fn pause<'c>(hands: &mut impl StallHands<'c>, stopped: &Stopped, why: &str) -> Result<(), Failure> {
    hands.stalls().rest();
    let (letter, line) = (letter(stopped.motor), stopped.line);
    hands.announce(format_args!(
        "WARNING: the job is paused at line {line}, where motor {letter} stalled: {why}resume homes what has lost its place \
         and goes on, abort ends it\n"
    ));
    suspend::rest(hands, false).map(drop)
}

/// Ends a job that cannot go on: not even its place is known.
fn end_job<'c>(hands: &mut impl StallHands<'c>, stopped: &Stopped, why: impl Display) -> Result<(), Failure> {
    hands.stalls().rest();
    *hands.passed() = None;
    let line = stopped.line;
    hands.announce(format_args!(
        "ERROR: the job ends at line {line}, where a motor stalled: {why}. Home, then play its file --from line {line}\n"
    ));
    hands.extruders_count_anew();
    let (jobs, world) = hands.jobs_in_world();
    jobs.close(&mut world.ports);
    hands.resynchronise_if_still();
    suspend::rest(hands, false).map(drop)
}

//! `play file --from`: a job that begins in the middle of its file.
//!
//! Lines before that place are read over, so that units, offsets, tools, E and objects are as the file has
//! them there. Then the machine heats as the file has asked for, rises, goes over the place and down to it,
//! and the job goes on.

use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands as _;
use base::sessions::Recipient;
use base::{Ports, World};
use jobs::player::Scripts;
use motion::Mode;
use units::{Axis, MmPerSecond};

use crate::features::state::Step;
use crate::machine::effects::EffectHands;
use crate::machine::fast_forward_record::{Passed, Until};
use crate::machine::frames::{Frame, Then};
use crate::machine::moments::{Features, JobBegins, Moments as _};
use crate::machine::{Machine, fast_forward, heat_restoring};

/// Height above the place, before the tool goes down to it, mm.
const LIFT: f64 = 5.0;
/// Speed down to the place, mm/s.
const DOWN: MmPerSecond = MmPerSecond(10.0);
const ENDS_BEFORE: &str = "the file ends before this place, or marks no layers";
const USAGE: &str = "play takes: file --from line N, layer N or byte N";

/// Splits the arguments of `play` into those before `--from` and the place to begin at.
///
/// # Errors
/// When the place is not understood.
pub(crate) fn split(arguments: &str) -> Result<(&str, Option<Until>), Failure> {
    let Some((before, from)) = arguments.split_once(" --from ") else { return Ok((arguments, None)) };
    let mut words = from.split_whitespace();
    let (kind, number) = (words.next(), words.next().and_then(|number| number.parse().ok()));
    match (kind, number, words.next()) {
        (Some("line"), Some(line), None) => Ok((before, Some(Until::Line(line)))),
        (Some("layer"), Some(layer), None) => Ok((before, Some(Until::Layer(layer)))),
        (Some("byte"), Some(offset), None) => Ok((before, Some(Until::Offset(offset)))),
        _ => Err(Failure::refused(&USAGE)),
    }
}

/// The machine for a job that begins in the middle of its file.
pub(crate) trait PlayFromHands<'c>: EffectHands<'c> {
    /// Has features act as the job begins there.
    fn begins_elsewhere(&mut self);
}

impl<'c, P: Ports> PlayFromHands<'c> for Machine<'c, P> {
    fn begins_elsewhere(&mut self) {
        Features::<P>::job_begins(self, JobBegins::Elsewhere);
    }
}

/// Has the job that has just been opened begin at a place.
///
/// # Errors
/// On a machine that is not homed or moves; the job is closed then.
pub(crate) fn begin<'c>(hands: &mut impl PlayFromHands<'c>, until: Until, to: Recipient) -> Outcome {
    let begun = start(hands, until, to);
    if begun.is_err() {
        fast_forward::put_back(hands);
        let (jobs, world) = hands.jobs_in_world();
        jobs.close(&mut world.ports);
    }
    begun
}

fn start<'c>(hands: &mut impl PlayFromHands<'c>, until: Until, to: Recipient) -> Outcome {
    if !hands.facts().all_homed() {
        return Err(Failure::refused(&"home first: a job that begins in the middle goes straight to its place"));
    }
    fast_forward::keep(hands);
    // The script before jobs would move away from where the job is to go on.
    hands.jobs().scripts().map(Scripts::take_before);
    if !hands.frames().push(Frame::Then(Then::Step(Step::PlayFrom(to)))) {
        return Err(Failure::refused(&"scripts start each other without end"));
    }
    if let Err(failure) = fast_forward::begin(hands, until) {
        hands.frames().drop_top();
        return Err(failure);
    }
    hands.say(to, format_args!("// the file is read up to there\n"));
    Ok(Answer::Ok)
}

/// Takes the machine to the place, once the lines before it have been read over.
///
/// # Errors
/// When the job cannot begin there; it is closed then, and what has begun to heat is off.
pub(crate) fn go_on<'c>(hands: &mut impl PlayFromHands<'c>, to: Recipient) -> Result<(), Failure> {
    if !hands.jobs().is_open() {
        // The job was refused, or aborted, and that was said.
        *hands.passed() = None;
        fast_forward::put_back(hands);
        hands.resynchronise_if_still();
        return Ok(());
    }
    let mut has_heated = false;
    let done = go_there(hands, to, &mut has_heated);
    if done.is_err_and(|failure| failure.is_refusal()) {
        let (jobs, world) = hands.jobs_in_world();
        jobs.close(&mut world.ports);
        fast_forward::put_back(hands);
        if has_heated {
            heat_restoring::cool(&mut hands.world().ports);
        }
        hands.resynchronise_if_still();
    }
    done
}

fn go_there<'c>(hands: &mut impl PlayFromHands<'c>, to: Recipient, has_heated: &mut bool) -> Result<(), Failure> {
    let passed = Passed::arrived(hands.passed().take(), &ENDS_BEFORE)?;
    let (jobs, program) = hands.jobs_and_program();
    let (kept, place, line) = (program.keep(), *program.position(), jobs.line() + 1);
    // The tool's place, with the file's count of filament.
    let mut here = hands.position();
    let tools = hands.program().tools();
    for axis in Axis::ALL.into_iter().filter(|axis| tools.uses(*axis)) {
        here[axis] = place[axis];
    }
    let homed = hands.axes().homed();
    let (mut up, mut over) = (here, place);
    // Above all parts made before; not higher, for at its highest a delta goes nowhere else.
    up[Axis::Z] = passed.z[1].max(place[Axis::Z]) + LIFT;
    let up = hands.travel().cut(&here, &up, homed);
    over[Axis::Z] = up[Axis::Z].max(place[Axis::Z]);
    hands.stays_within(&here, &up)?;
    hands.stays_within(&up, &over)?;
    hands.stays_within(&over, &place)?;
    hands.announce(format_args!(
        "// the job begins with line {line}, at X{:.2} Y{:.2} Z{:.2}\n",
        place[Axis::X],
        place[Axis::Y],
        place[Axis::Z]
    ));
    // Refusals must come before anything heats.
    hands.sequence(to).enable_motors()?;
    hands.begins_elsewhere();
    *has_heated = true;
    heat_restoring::heat(&mut hands.sequence(to), &passed.targets.map(|target| target.unwrap_or_default()))?;
    let rate = hands.program().modal().seek_rate;
    hands.sequence(to).set_position(here)?;
    hands.sequence(to).go(up, rate, Mode::Rapid)?;
    hands.sequence(to).go_there(over, rate)?;
    let (outputs, _, World { config, ports, .. }) = hands.outputs_in_world();
    heat_restoring::switch(outputs, config, ports, &passed.switches);
    hands.sequence(to).go_there(place, DOWN)?;
    *hands.set_before() = None;
    hands.program().come_back_to(kept);
    hands.program().resynchronise(place);
    Ok(())
}

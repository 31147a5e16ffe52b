//! Moves that follow the spindle: G33, G33.1 and the threading cycle G76, with LinuxCNC's words.

use units::{Axis, Plane, PowerLaw};

use crate::action::{Action, Corner, Move, Rate, Shape};
use crate::context::{Context, Meaning, NOTHING};
use crate::cycles::thread_passes::{Passes, Thread};
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::meaning::{moves, spindle};
use crate::state::modal::{FeedMode, MotionMode};
use crate::words::Words;

/// Limit of passes; more indicate a mistake in J or R.
const MOST_PASSES: f64 = 1_000.0;

/// G33 and G33.1: moves in step with the spindle, or taps rigidly.
pub(crate) fn follow<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    if words.are_rates_alone() {
        return moves::take_rates(program, context).map(|()| Meaning::Nothing);
    }
    let taps = words.code().subcode != 0;
    begin(program, context, MotionMode::Synchronised)?;
    let pitch = words.length('K').filter(|_| words.has('K')).ok_or(Problem::MustSupply('K').refused(words.column()))?;
    if !"XYZABC@^".chars().any(|letter| words.has(letter)) {
        return Err(Problem::NoWay.refused(words.column()));
    }
    let (target, _) = moves::target_of(program, context)?;
    program.modal.machine_next = false;
    if taps {
        // Rigid tapping ends at its beginning, so the position stays.
        let faster = words.get('I').unwrap_or(1.0);
        return Ok(Meaning::Action(Action::RigidTap {
            target,
            pitch,
            faster: if faster > 1.0 { faster } else { 1.0 },
        }));
    }
    if target == program.position {
        return NOTHING;
    }
    program.position = target;
    let shape = Shape::Line { names_xy: words.has('X') || words.has('Y') };
    let (rate, power) = (Rate::PerRevolution(pitch), program.modal.power);
    Ok(Meaning::Action(Action::Move(Move {
        target,
        shape,
        rate,
        power,
        power_law: PowerLaw::Off,
        corner: Corner::Sharp,
    })))
}

/// Checks the conditions common to all moves that follow the spindle.
fn begin(program: &mut Interpreter, context: &Context<'_>, mode: MotionMode) -> Result<(), Fault> {
    spindle::needs_encoder(program, context)?;
    program.end_cycles();
    program.modal.motion = mode;
    let column = context.words.column();
    if program.modal.feed_mode == FeedMode::InverseTime {
        return Err(Problem::NeedsFeedPerMinute.refused(column));
    }
    if program.modal.auxiliary.spindle == crate::Spindle::Stopped {
        return Err(Problem::SpindleStands.refused(column));
    }
    Ok(())
}

/// G76: cuts a thread in passes.
pub(crate) fn cycle<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    if words.are_rates_alone() {
        return moves::take_rates(program, context).map(|()| Meaning::Nothing);
    }
    begin(program, context, MotionMode::Threading)?;
    if program.modal.plane != Plane::Xz {
        return Err(Problem::ThreadPlane.refused(words.column()));
    }
    if let Some(letter) = "XYABCE@^".chars().find(|letter| words.has(*letter) && *letter != 'E') {
        return Err(Problem::NotInCycle(letter).refused(words.column_of(letter)));
    }
    if program.modal.turn().is_some() {
        return Err(Problem::TurnedPlane.refused(words.column()));
    }
    let thread = thread(program, words)?;
    if f64::from(thread.passes()) > MOST_PASSES {
        return Err(Problem::TooManyPasses.refused(words.column_of('J')));
    }
    let Some(first) = program.cycles.begin_thread(Passes::new(thread)) else { return NOTHING };
    program.follow(&first);
    Ok(Meaning::Action(first))
}

fn thread(program: &Interpreter, words: &Words<'_>) -> Result<Thread, Fault> {
    let modal = &program.modal;
    let needed = |letter: char| words.get(letter).ok_or(Problem::CycleNeeds(76, letter).refused(words.column()));
    // After G7, words I, J and K are diameters, as X is.
    let half = if modal.diameters { 0.5 } else { 1.0 };
    let (pitch, end, peak) = (needed('P')?, needed('Z')?, needed('I')? * half);
    let (first_cut, height) = (needed('J')? * half, needed('K')? * half);
    if peak == 0.0 {
        return Err(Problem::NoThreadSide.refused(words.column_of('I')));
    }
    if height <= first_cut {
        return Err(Problem::ThreadHeight.refused(words.column_of('K')));
    }
    let start = program.position;
    let end = modal.machine(Axis::Z, end, start[Axis::Z]);
    let way = if end > start[Axis::Z] { 1.0 } else { -1.0 };
    let taper = words.get('E').unwrap_or(0.0);
    if taper > libm::fabs(end - start[Axis::Z]) / 2.0 {
        return Err(Problem::TaperTooLong.refused(words.column_of('E')));
    }
    let degression = words.get('R').unwrap_or(1.0);
    if libm::pow(height / first_cut, degression) > MOST_PASSES {
        return Err(Problem::TooManyPasses.refused(words.column_of('J')));
    }
    let tapers = if taper > 0.0 { words.get('L').unwrap_or(0.0) as u8 } else { 0 };
    Ok(Thread {
        start,
        end,
        side: if peak > 0.0 { 1.0 } else { -1.0 },
        pitch,
        crest: libm::fabs(peak),
        first_cut,
        height,
        degression,
        slope: -way * libm::tan(words.get('Q').unwrap_or(0.0).to_radians()),
        last_passes: words.get('H').unwrap_or(0.0) as u32 + 1,
        taper: way * taper,
        taper_in: tapers & 1 != 0,
        taper_out: tapers & 2 != 0,
        rapid: Rate::Rapid(modal.seek_rate),
        power: if program.setup.laser.is_some() { 0.0 } else { modal.power },
        auxiliary: modal.auxiliary,
    })
}

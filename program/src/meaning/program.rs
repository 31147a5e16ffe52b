//! Codes of the program as a whole: end, messages, suspending, halting.

use crate::action::{Action, Pause};
use crate::context::{Context, Meaning, NOTHING};
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::meaning::{extruders, modes, moves};
use crate::state::auxiliary::Spindle;
use crate::state::modal::{FeedMode, MotionMode};

/// M2, and M30 in dialects where M30 ends programs: resets modes and ends the program.
pub(crate) fn end<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    program.modal.system = 0;
    program.modal.absolute = true;
    program.modal.corner = crate::Corner::Sharp;
    program.modal.feed_mode = FeedMode::PerMinute;
    program.modal.arc_absolute = false;
    if matches!(program.modal.motion, MotionMode::Cycle | MotionMode::Cancelled | MotionMode::Search(_)) {
        program.end_cycles();
        program.modal.motion = MotionMode::Linear;
    }
    program.splines = crate::state::splines::Splines::default();
    let modes = &mut program.modal.auxiliary;
    (modes.feed_override, modes.spindle_override, modes.surface_speed) = (true, true, false);
    if context.dialect.stops_spindle_at_end() {
        program.modal.plane = units::Plane::Xy;
        modes::stop(program);
    }
    Ok(Meaning::Action(Action::EndProgram))
}

/// M0, M1, M60: pauses. Marlin's S and P, seconds and milliseconds, give the longest wait.
pub(crate) fn pause<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let why = match words.code().number {
        0 => Pause::Program,
        1 => Pause::Optional,
        _ => Pause::Pallet,
    };
    let time = Some(moves::time_of(context, 1e-3)?).filter(|time| time.0 > 0);
    Ok(Meaning::Action(Action::Pause { why, time, text: words.text() }))
}

/// M6: stops the spindle, for the operator's safety, and changes the tool. Machines with extruders change by
/// T alone.
pub(crate) fn change_tool<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    if let Some(tool) = words.get('T') {
        extruders::select_tool(program, tool as u16, words.column_of('T'))?;
    }
    if program.tools.has_extruders() {
        return NOTHING;
    }
    if program.modal.auxiliary.spindle != Spindle::Stopped {
        program.turn_spindle(Spindle::Stopped);
    }
    Ok(Meaning::Action(Action::ChangeTool(program.tools.change())))
}

/// M98: calls a subroutine by number.
pub(crate) fn call<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    if words.has('P') && words.get('P').is_none() {
        return Err(Problem::Needs(words.code(), "the name of a macro").refused(words.column_of('P')));
    }
    let number = words.get('P').ok_or(Problem::MustSupply('P').refused(words.column()))?;
    let times = words.get('L').unwrap_or(1.0);
    Ok(Meaning::Action(Action::Call { number: number as u32, times: times as u32 }))
}

/// M99: returns from a subroutine.
pub(crate) fn end_call<'b>(_: &mut Interpreter, _: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    Ok(Meaning::Action(Action::Return))
}

/// M30: ends the program or removes a file, as the dialect says; without a name, ends the program.
pub(crate) fn m30<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    match context.words.text() {
        _ if context.dialect.ends_by_m30() => end(program, context),
        Some(_) => Ok(context.function()),
        None => end(program, context),
    }
}

/// M20: lists the files of the card.
pub(crate) fn list_files<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    Ok(if context.dialect.lists_by_m20() { context.function() } else { Meaning::Unknown })
}

/// M112: halts the machine at once.
pub(crate) fn halt_now<'b>(_: &mut Interpreter, _: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    Ok(Meaning::Action(Action::Halt))
}

/// M999: clears a halt.
pub(crate) fn release<'b>(_: &mut Interpreter, _: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    Ok(Meaning::Action(Action::Release))
}

/// M117: shows a message to the operator.
pub(crate) fn message<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    Ok(Meaning::Action(Action::Message(context.words.text().unwrap_or(""))))
}

/// M400: waits until all motion has stopped.
pub(crate) fn finish<'b>(_: &mut Interpreter, _: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    Ok(Meaning::Action(Action::Finish))
}

/// M600, M600.1: suspends the job.
pub(crate) fn suspend<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = context.words;
    Ok(Meaning::Action(Action::Suspend { heaters_stay: words.code().subcode == 1, words }))
}

/// M601: resumes the suspended job.
pub(crate) fn resume<'b>(_: &mut Interpreter, _: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    Ok(Meaning::Action(Action::Resume))
}

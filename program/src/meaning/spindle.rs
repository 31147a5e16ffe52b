//! What turns and flows: spindle, coolant, and the operator's overrides of speeds.

use crate::action::Action;
use crate::auxiliary::Spindle;
use crate::context::{Context, Meaning, NOTHING};
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;

/// M3, M4 and M5: the S of moves that follow, and how the spindle turns.
pub(crate) fn power<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let code = context.words.code();
    match (code.number, context.words.get('S')) {
        (5, _) => program.modal.power = 0.0,
        (_, Some(power)) => program.modal.power = power as f32,
        _ => {}
    }
    program.modal.auxiliary.spindle = match code.number {
        3 => Spindle::Clockwise,
        // Nothing turns it the other way.
        4 if program.setup.claims.of(code).next().is_none() => return Ok(Meaning::Unknown),
        4 => Spindle::CounterClockwise,
        _ => Spindle::Stopped,
    };
    NOTHING
}

/// M7, M8 and M9.
pub(crate) fn coolant<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let code = context.words.code();
    if program.setup.claims.of(code).next().is_none() {
        return Ok(Meaning::Unknown);
    }
    let modes = &mut program.modal.auxiliary;
    match code.number {
        7 => modes.mist = true,
        8 => modes.flood = true,
        _ => (modes.mist, modes.flood) = (false, false),
    }
    NOTHING
}

/// M48 to M51: whether the operator's overrides count.
pub(crate) fn overrides<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let on = words.get('P') != Some(0.0);
    let modes = &mut program.modal.auxiliary;
    match words.code().number {
        48 => (modes.feed_override, modes.spindle_override) = (true, true),
        49 => (modes.feed_override, modes.spindle_override) = (false, false),
        50 => modes.feed_override = on,
        _ => modes.spindle_override = on,
    }
    Ok(Meaning::Action(Action::Overrides { feed: modes.feed_override, spindle: modes.spindle_override }))
}

/// M52 and M53: the first needs an input, the second cannot be switched off.
pub(crate) fn feed_inputs<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let (code, on) = (words.code(), words.get('P') != Some(0.0));
    match (code.number, on) {
        (52, true) => Err(Problem::Needs(code, "an input of adaptive feed").refused(words.column())),
        (53, false) => Err(Problem::HoldStays.refused(words.column_of('P'))),
        _ => NOTHING,
    }
}

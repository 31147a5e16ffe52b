//! Codes of spindle, coolant, and the operator's overrides of speeds.

use gcode::Code;
use units::Micros;

use crate::action::{Action, Turning};
use crate::context::{Context, Meaning, NOTHING};
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::state::auxiliary::Spindle;

/// Sets S for moves and for the spindle. A turning spindle changes speed at the current end of the path,
/// without a stop of motion. Beside a laser S is the power of moves alone.
pub(crate) fn set_speed(program: &mut Interpreter, speed: f32) {
    (program.modal.power, program.modal.auxiliary.speed) = (speed, Some(speed));
    let spindle = program.modal.auxiliary.spindle;
    if spindle != Spindle::Stopped && program.setup.laser.is_none() {
        program.switch(spindle.code());
    }
}

/// M3, M4 and M5: sets the spindle's direction, or the law of a laser's power, and the S of later moves.
/// Outputs that listen to the codes have already been switched. Nothing waits for that: a laser's power is
/// the moves' own.
pub(crate) fn power<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let code = context.words.code();
    if context.words.get('S').is_some_and(|speed| speed < 0.0) {
        return Err(Problem::NegativeSpeed.refused(context.words.column_of('S')));
    }
    let laser = program.setup.laser;
    let listens = |code| laser.is_some() || program.setup.claims.of(code).next().is_some();
    if code.number == 4 && !listens(code) {
        let turns = listens(Code::m(3));
        return if turns { Err(Problem::NoReverse.refused(context.words.column())) } else { Ok(Meaning::Unknown) };
    }
    let modes = &mut program.modal.auxiliary;
    modes.spindle = Spindle::of(code).unwrap_or_default();
    modes.speed = context.words.get('S').map(|speed| speed as f32).or(modes.speed);
    modes.speed = modes.speed.or(laser.map(|laser| laser.default_s));
    // M5 keeps S for the next M3; moves behind M5 have no power.
    program.modal.power = if modes.spindle == Spindle::Stopped { 0.0 } else { modes.speed.unwrap_or(0.0) };
    NOTHING
}

/// M7, M8 and M9: switches coolant.
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

/// M48 to M51: enables or disables the operator's overrides.
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
    Ok(Meaning::Action(modes.overrides()))
}

/// M52 and M53: refuses M52, which needs an input, and switching M53 off.
pub(crate) fn feed_inputs<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let (code, on) = (words.code(), words.get('P') != Some(0.0));
    match (code.number, on) {
        (52, true) => Err(Problem::Needs(code, "an input of adaptive feed").refused(words.column())),
        (53, false) => Err(Problem::HoldStays.refused(words.column_of('P'))),
        _ => NOTHING,
    }
}

/// M19: turns the spindle to an angle, and holds it there.
pub(crate) fn orient<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let degrees = words.get('R').ok_or(Problem::MustSupply('R').refused(words.column()))?;
    let turning = match words.get('P') {
        None | Some(0.0) => Turning::Shortest,
        Some(1.0) => Turning::Clockwise,
        _ => Turning::CounterClockwise,
    };
    let patience = words.get('Q').map(|seconds| Micros((seconds * 1e6) as u64));
    needs_encoder(program, context)?;
    program.modal.auxiliary.spindle = Spindle::Stopped;
    Ok(Meaning::Action(Action::Orient { degrees, turning, patience }))
}

/// Refuses codes that need an encoder on a spindle without one, by the name of the code.
pub(crate) fn needs_encoder(program: &Interpreter, context: &Context<'_>) -> Result<(), Fault> {
    if program.setup.spindle.has_encoder {
        return Ok(());
    }
    Err(Problem::Needs(context.words.code(), "a spindle encoder").refused(context.words.column()))
}

/// G96 and G97: sets whether S is surface speed or spindle speed.
pub(crate) fn speed_mode<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let speed = words.get('S');
    if words.code().number == 97 {
        program.modal.auxiliary.surface_speed = false;
        if let Some(speed) = speed {
            set_speed(program, speed as f32);
        }
        return Ok(Meaning::Action(Action::SurfaceSpeed(None)));
    }
    let speed = speed.ok_or(Problem::MustSupply('S').refused(words.column()))?;
    if !program.setup.spindle.has_speed_control {
        return Err(Problem::Needs(words.code(), "control of the spindle's speed").refused(words.column()));
    }
    // S is a surface speed now, so the spindle's output is not switched.
    (program.modal.power, program.modal.auxiliary.speed) = (speed as f32, Some(speed as f32));
    program.modal.auxiliary.surface_speed = true;
    Ok(Meaning::Action(Action::SurfaceSpeed(Some(words.get('D').unwrap_or(f64::INFINITY)))))
}

//! M42, M62 to M68, M226: outputs that a program sets by number, and inputs that a program reads or waits
//! for. The setting `io_number` assigns numbers to switches.

use units::{Micros, SwitchId};

use crate::action::{Action, AwaitInput, Effect, InputEvent};
use crate::context::{Context, Meaning, NOTHING};
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::state::setup::IoKind;

/// M42, M62 to M65, M67 and M68: sets an output, either in step with the path or after motion has stopped.
pub(crate) fn output<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let effect = match words.code().number {
        67 | 68 => {
            let switch = numbered(program, context, 'E', |kind| kind == IoKind::Analog)?;
            let value = words.get('Q').ok_or(Problem::MustSupply('Q').refused(words.column()))? as f32;
            Effect::Switch { switch, on: value != 0.0, value: Some(value).filter(|value| *value != 0.0) }
        }
        42 => {
            let switch = numbered(program, context, 'P', |kind| kind != IoKind::Input)?;
            let value = words.get('S').ok_or(Problem::MustSupply('S').refused(words.column()))? as f32;
            let value = if context.dialect.takes_shares() && value <= 1.0 { value * 255.0 } else { value };
            Effect::Switch { switch, on: value != 0.0, value: Some(value).filter(|value| *value != 0.0) }
        }
        number => {
            let switch = numbered(program, context, 'P', |kind| kind != IoKind::Input)?;
            Effect::Switch { switch, on: matches!(number, 62 | 64), value: None }
        }
    };
    if matches!(words.code().number, 42 | 62 | 63 | 67) {
        program.by_the_way(effect);
        return NOTHING;
    }
    program.then(Action::Effect(effect));
    Ok(Meaning::Action(Action::Finish))
}

/// M66: reads an input once all motion has stopped, or waits for the input.
pub(crate) fn await_input<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let event = match words.get('L') {
        None | Some(0.0) => None,
        Some(1.0) => Some(InputEvent::Rise),
        Some(2.0) => Some(InputEvent::Fall),
        Some(3.0) => Some(InputEvent::High),
        _ => Some(InputEvent::Low),
    };
    if words.has('E') {
        let problem = if words.has('P') { Problem::DigitalOrAnalog } else { Problem::NoAnalogInput };
        return Err(problem.refused(words.column_of('E')));
    }
    let input = numbered(program, context, 'P', |kind| kind == IoKind::Input)?;
    let seconds = words.get('Q').unwrap_or(0.0);
    if event.is_some() && seconds <= 0.0 {
        return Err(Problem::NoPatience.refused(words.column_of('Q')));
    }
    Ok(Meaning::Action(Action::AwaitInput(AwaitInput { input, event, patience: Micros((seconds * 1e6) as u64) })))
}

/// M226: waits for an input once all motion has stopped, without a time limit unless Q is given.
pub(crate) fn await_level<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let event = match words.get('S') {
        Some(1.0) => InputEvent::High,
        Some(0.0) => InputEvent::Low,
        _ => InputEvent::Change,
    };
    let input = numbered(program, context, 'P', |kind| kind == IoKind::Input)?;
    let patience = words.get('Q').map_or(AwaitInput::FOR_EVER, |seconds| Micros((seconds * 1e6) as u64));
    Ok(Meaning::Action(Action::AwaitInput(AwaitInput { input, event: Some(event), patience })))
}

/// Returns the switch that has a number and fits the purpose.
fn numbered(
    program: &Interpreter,
    context: &Context<'_>,
    letter: char,
    fits: impl Fn(IoKind) -> bool,
) -> Result<SwitchId, Fault> {
    let words = &context.words;
    let number = words.get(letter).ok_or(Problem::MustSupply(letter).refused(words.column()))?;
    let found = program.setup.io.iter().find(|io| f64::from(io.number) == number && fits(io.kind));
    let problem = || match letter {
        'E' => Problem::NoAnalogOutput(number as u8),
        _ if matches!(words.code().number, 66 | 226) => Problem::NoInput(number as u8),
        _ => Problem::NoOutput(number as u8),
    };
    found.map(|io| io.switch).ok_or_else(|| problem().refused(words.column_of(letter)))
}

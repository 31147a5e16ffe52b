//! Functions that a template calls by name.

use crate::arguments::{Arguments, whole};
use crate::environment::Action;
use crate::fault::{Fault, Result, Words};
use crate::memory::Text;
use crate::methods;
use crate::names::{Function, parameters};
use crate::run::Run;
use crate::value::{Map, Value};

/// Result of a function.
pub fn call(run: &mut Run<'_, '_>, number: u8, arguments: Arguments) -> Result<Value> {
    let names = parameters(Function::NAMES, number);
    match Function::from_number(number) {
        Function::Range => range(run, arguments, names),
        Function::Dict => fill(run, Map::Dict, arguments),
        Function::Namespace => fill(run, Map::Namespace, arguments),
        Function::Respond => act(run, Action::Respond, arguments.bind(run, names)?[0]),
        Function::EmergencyStop => {
            let [message, ..] = arguments.bind(run, names)?;
            let message = if message.is_none() { Some(run.str("action_emergency_stop")) } else { message };
            act(run, Action::EmergencyStop, message)
        }
        Function::RaiseError => {
            let [message, ..] = arguments.bind(run, names)?;
            let text = run.text_of(message.ok_or(run.memory.fault(Words::NoMessage))?)?;
            act(run, Action::RaiseError, Some(Value::str(text)))?;
            Err(Fault::about(&run.memory, Words::Raised, text))
        }
        Function::CallRemoteMethod => act(run, Action::CallRemoteMethod, arguments.position(run, 0)),
    }
}

fn act(run: &mut Run<'_, '_>, action: Action, message: Option<Value>) -> Result<Value> {
    let text: Text = run.text_of(message.ok_or(run.memory.fault(Words::NoMessage))?)?;
    run.machine.act(action, run.memory.text(text));
    Ok(run.str(""))
}

fn fill(run: &mut Run<'_, '_>, kind: Map, arguments: Arguments) -> Result<Value> {
    let map = run.map(kind, arguments.count);
    if let Some(head) = map.head() {
        methods::dicts::fill(run, head, arguments)?;
    }
    Ok(map)
}

fn range(run: &mut Run<'_, '_>, arguments: Arguments, names: &'static [u8]) -> Result<Value> {
    if arguments.positions(run) < arguments.count {
        return run.memory.fail(Words::TooManyArguments);
    }
    let mut bounds = [0; 3];
    for (bound, value) in bounds.iter_mut().zip(arguments.bind(run, names)?.into_iter().flatten()) {
        *bound = whole(run, value)?;
    }
    match (arguments.count, bounds) {
        (1, [end, ..]) => Ok(run.new_range([0, end, 1])),
        (2, [start, end, _]) => Ok(run.new_range([start, end, 1])),
        (3, [_, _, 0]) => run.memory.fail(Words::ZeroStep),
        (3, bounds) => Ok(run.new_range(bounds)),
        _ => run.memory.fail(Words::TooManyArguments),
    }
}

//! What a program tells the operator, and waits for: messages, M0, M1, M60, M6.

use program::{Pause, Remark, State};

use super::Machine;
use crate::failure::{Answer, Failure, Message, Outcome};
use crate::ports::Ports;
use crate::safety::Event;
use crate::wait::yield_once;

/// A comment that says something.
pub(super) fn remark<P: Ports>(machine: &mut Machine<'_, P>, comment: &[u8]) {
    let mut text = Message::new();
    match Remark::read(comment) {
        Some(Remark::Message(said)) => machine.announce(format_args!("// {said}\n")),
        Some(Remark::Values(said) | Remark::Printed(said)) => {
            // What does not fit is cut.
            let _ = program::write_values(&machine.program, said, &mut text);
            machine.announce(format_args!("// {text}\n"));
        }
        Some(Remark::Log(what)) => {
            machine.announce(format_args!("// WARNING ({what}) is not carried out: there are no log files\n"));
        }
        None => {}
    }
}

/// M0, M1, M60.
pub(super) async fn pause<P: Ports>(machine: &mut Machine<'_, P>, why: Pause) -> Outcome {
    machine.standstill().await?;
    let code = match why {
        Pause::Program => "M0",
        Pause::Optional => "M1",
        Pause::Pallet => "M60",
    };
    wait(machine, format_args!("the program waits ({code})")).await
}

/// M6.
pub(super) async fn change_tool<P: Ports>(machine: &mut Machine<'_, P>, tool: u32) -> Outcome {
    machine.standstill().await?;
    if tool == 0 {
        return wait(machine, format_args!("take the tool out (T0 M6)")).await;
    }
    wait(machine, format_args!("put in tool {tool} (M6)")).await
}

/// A job is paused; lines of a session are held.
async fn wait<P: Ports>(machine: &mut Machine<'_, P>, what: core::fmt::Arguments<'_>) -> Outcome {
    if machine.jobs.is_playing() {
        machine.announce(format_args!("// {what}: ~ or M24 goes on, abort ends the job\n"));
        machine.jobs.wait_for_operator();
        return Ok(Answer::Ok);
    }
    machine.announce(format_args!("// {what}: ~ goes on\n"));
    // Held as by `!`, so that everybody sees why nothing moves, and `~` goes on.
    if !machine.safety.apply(Event::Started) || !machine.safety.apply(Event::Hold) {
        return Err(Failure::Halted);
    }
    while machine.safety.state() == State::Hold {
        machine.serve();
        yield_once().await;
    }
    if machine.safety.is_halted() { Err(Failure::Halted) } else { Ok(Answer::Ok) }
}

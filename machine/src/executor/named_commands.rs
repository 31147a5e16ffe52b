//! Commands by name, `SET_VELOCITY_LIMIT ACCEL=3000`, and their translation into lines of codes.

use base::Ports;
use base::failure::{Answer, Failure, Outcome};
use base::program_setup::PartNames;
use base::sessions::LineBytes;
use gcode::{Extended, Line};
use jobs::player::Name;
use program::extended::{self, Asked, CodeLine};

use crate::machine::Machine;
use crate::machine::frames::{Frame, NextCode, Rest};
use crate::machine::job_control;
use crate::machine::source::{Origin, Source};

/// Result of a command by name.
pub(crate) enum Named<'a> {
    /// Codes that come next, and answer the command.
    Codes,
    /// Command of the console that it means.
    Console(&'a str),
    /// Outcome of a command that is not carried out, or cannot be.
    Ended(Outcome),
}

/// Classifies a line that is neither codes nor a flow word: a command of the console, or one by name.
#[cold]
pub(crate) fn command_of<'a, P: Ports>(machine: &mut Machine<'_, P>, line: &Line<'a>, source: Source) -> Named<'a> {
    match *line {
        Line::Console(text) if is_named(text) => start(machine, &Extended::new(text), source),
        Line::Console(text) => Named::Console(text),
        Line::Extended(command) => start(machine, &command, source),
        _ => Named::Ended(Ok(Answer::Ok)),
    }
}

/// Has the codes of a command by name carried out next.
fn start<P: Ports>(machine: &mut Machine<'_, P>, command: &Extended<'_>, source: Source) -> Named<'static> {
    let mut codes = CodeLine::new();
    let names = PartNames { config: machine.world.config, dialect: source.dialect };
    match extended::translate(command, &names, &mut codes) {
        Ok(Asked::Codes) => {
            // Both buffers have the same room.
            let line = LineBytes::from_slice(codes.as_bytes()).unwrap_or_default();
            let rest = Rest { line, next: NextCode::At(0), source, last: None, answer: Answer::Ok };
            if machine.frames.push(Frame::Rest(rest)) {
                return Named::Codes;
            }
            Named::Ended(Err(Failure::refused(&"scripts start each other without end")))
        }
        Ok(Asked::Console(asked)) => Named::Console(asked),
        Ok(Asked::Tower) => Named::Ended(job_control::tower(machine, command)),
        Ok(Asked::PassedOver(name)) => {
            if let Some(noted) = machine.jobs.noted().filter(|_| source.origin == Origin::Job) {
                noted.passed_over.count(Name::Command(name));
            }
            Named::Ended(Ok(Answer::PassedOver))
        }
        Err(fault) => Named::Ended(Err(machine.world.texts.refused(format_args!("{} {fault}", command.name())))),
    }
}

/// Whether a line of a console is a command by name: in lower case only its name tells it from the console's
/// own.
fn is_named(text: &str) -> bool {
    let command = Extended::new(text);
    program::commands::find(command.name()).is_none() && extended::find(command.name()).is_some()
}

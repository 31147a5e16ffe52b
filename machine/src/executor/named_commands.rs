//! Commands by name, `SET_VELOCITY_LIMIT ACCEL=3000`, and their translation into lines of codes.

use base::failure::{Answer, Failure, Outcome, Texts};
use base::program_setup::PartNames;
use base::sessions::LineBytes;
use config::MachineConfig;
use gcode::{Extended, Line};
use jobs::player::{Jobs, Name};
use program::extended::{self, Asked, CodeLine};

use crate::machine::frames::{Frame, Frames, NextCode, Rest};
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

/// Classifies a line that is neither codes nor a flow word: a command of the console, or one by name, whose
/// codes are carried out next.
#[cold]
pub(crate) fn command_of<'a, S>(
    frames: &mut Frames<'_, S>,
    jobs: &mut Jobs,
    (config, texts): (&MachineConfig, &Texts),
    line: &Line<'a>,
    source: Source,
) -> Named<'a> {
    let command = match *line {
        Line::Console(text) if is_named(text) => Extended::new(text),
        Line::Console(text) => return Named::Console(text),
        Line::Extended(command) => command,
        _ => return Named::Ended(Ok(Answer::Ok)),
    };
    let mut codes = CodeLine::new();
    let names = PartNames { config, dialect: source.dialect };
    match extended::translate(&command, &names, &mut codes) {
        Ok(Asked::Codes) => {
            // Both buffers have the same room.
            let line = LineBytes::from_slice(codes.as_bytes()).unwrap_or_default();
            let rest = Rest { line, next: NextCode::At(0), source, last: None, answer: Answer::Ok };
            if frames.push(Frame::Rest(rest)) {
                return Named::Codes;
            }
            Named::Ended(Err(Failure::refused(&"scripts start each other without end")))
        }
        Ok(Asked::Console(asked)) => Named::Console(asked),
        Ok(Asked::Tower) => Named::Ended(job_control::tower(jobs, texts, &command)),
        // A feature has carried it out, wherever there are macros.
        Ok(Asked::Macros) => Named::Ended(Ok(Answer::Ok)),
        Ok(Asked::PassedOver(name)) => {
            if let Some(noted) = jobs.noted().filter(|_| source.origin == Origin::Job) {
                noted.passed_over.count(Name::Command(name));
            }
            Named::Ended(Ok(Answer::PassedOver))
        }
        Err(fault) => Named::Ended(Err(texts.refused(format_args!("{} {fault}", command.name())))),
    }
}

/// Returns the line of a command by name, or of one that may be a feature's: a console's own words are not.
pub(crate) fn text_of<'a>(line: &Line<'a>) -> Option<&'a str> {
    match *line {
        Line::Extended(command) => Some(command.text()),
        Line::Console(text) if program::commands::find(Extended::new(text).name()).is_none() => Some(text),
        _ => None,
    }
}

/// Whether a line of a console is a command by name: in lower case only its name tells it from the console's
/// own.
fn is_named(text: &str) -> bool {
    let command = Extended::new(text);
    program::commands::find(command.name()).is_none() && extended::find(command.name()).is_some()
}

//! What of a file is not carried out.

use gcode::{Block, Letter};
use program::Dialect;

use super::Machine;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::jobs::Name;
use crate::ports::Ports;
use crate::sessions::Recipient;

/// A code of a file that is not carried out. What would make another part pauses the file; the rest is
/// counted.
#[cold]
pub(super) fn settle<P: Ports>(machine: &mut Machine<'_, P>, block: &Block<'_>, dialect: Dialect) -> Outcome {
    let Some(code) = block.code else { return Ok(Answer::Unknown) };
    let row = machine.program.row(block, dialect);
    let is_off = block.get('S') == Some(0.0);
    let why = match row {
        None if code.letter == Letter::G => "is not known here, and what follows counts on it",
        Some(row) if row.is_missing() => {
            return Err(Failure::Refused(message(format_args!("{code} is not carried out here: {}", row.help))));
        }
        Some(row) if row.is_needed && !is_off || code.letter == Letter::G => "is for a part that this machine has not",
        _ => {
            if let Some(noted) = machine.jobs.noted() {
                noted.passed_over.count(Name::Code(code));
            }
            return Ok(if row.is_some() { Answer::PassedOver } else { Answer::Unknown });
        }
    };
    Err(Failure::Refused(message(format_args!("{code} {why}"))))
}

/// What of the job was not carried out, said once.
pub(super) fn say<P: Ports>(machine: &mut Machine<'_, P>) {
    let Machine { jobs, sessions, .. } = machine;
    if let Some(noted) = jobs.noted().filter(|noted| !noted.passed_over.is_empty()) {
        sessions.say(Recipient::All, format_args!("// NOTE not carried out: {}\n", noted.passed_over));
    }
}

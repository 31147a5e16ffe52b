//! Klipper's commands by name: the table of those that are known, and what each comes to: a line of codes, a
//! console command, nothing, or a refusal.
//!
//! Source: Klipper's "G-Codes" and "Status reference". Names of heaters and fans are the machine's, so it
//! says what they are ([`Names`]).

mod calibration;
mod jobs;
mod leveling;
mod outline;
mod row;

use gcode::Extended;
use row::Becomes;
pub use row::{CodeLine, ExtendedFault, ExtendedInfo, NamedSwitch, Names};

/// What a command asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// The line of codes that was written.
    Codes,
    /// This console command.
    Console(&'static str),
    /// That a setting changes with the height of the part.
    Tower,
    /// Nothing: it is passed over, by the name of its row.
    PassedOver(&'static str),
}

/// Every command that is known, by topic.
const TOPICS: [&[ExtendedInfo]; 3] = [jobs::COMMANDS, calibration::COMMANDS, leveling::COMMANDS];

/// Every command that is known.
pub fn all() -> impl Iterator<Item = &'static ExtendedInfo> {
    TOPICS.into_iter().flatten()
}

/// The row of a command.
#[must_use]
pub fn find(name: &str) -> Option<&'static ExtendedInfo> {
    all().find(|row| match row.name.strip_suffix('*') {
        Some(begin) => name.get(..begin.len()).is_some_and(|start| start.eq_ignore_ascii_case(begin)),
        None => row.name.eq_ignore_ascii_case(name),
    })
}

/// What a command comes to; its codes are written into `line`, which is empty.
///
/// # Errors
/// When it is not known, or cannot be carried out.
pub fn translate(command: &Extended<'_>, names: &dyn Names, line: &mut CodeLine) -> Result<Asked, ExtendedFault> {
    let row = find(command.name()).ok_or(ExtendedFault::Unknown)?;
    match row.becomes {
        Becomes::Codes(write) => {
            write(command, names, line)?;
            Ok(Asked::Codes)
        }
        Becomes::Console(text) => Ok(Asked::Console(text)),
        Becomes::Tower => Ok(Asked::Tower),
        Becomes::PassedOver => Ok(Asked::PassedOver(row.name)),
    }
}

#[cfg(test)]
mod tests;

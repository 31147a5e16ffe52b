//! Klipper's commands by name: the table of known commands, each translated to a line of codes, a console
//! command, nothing, or a refusal.
//!
//! Source: Klipper's "G-Codes" and "Status reference". Names of heaters and fans come from the machine
//! ([`Names`]).

mod calibration;
mod jobs;
mod leveling;
mod machine;
mod macros;
mod outline;
mod refused;
mod row;

use gcode::Extended;
use row::Becomes;
pub use row::{CodeLine, ExtendedFault, ExtendedInfo, NamedSwitch, Names};

/// Translation of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// Codes, which have been written to the line.
    Codes,
    /// Console command to run instead.
    Console(&'static str),
    /// Setting that changes with the height of the part (tuning tower).
    Tower,
    /// Nothing to do; the name is that of the command's row.
    PassedOver(&'static str),
    /// Something that is kept for macros, beside the program.
    Macros,
}

/// All known commands, by topic.
const TOPICS: [&[ExtendedInfo]; 6] =
    [jobs::COMMANDS, calibration::COMMANDS, leveling::COMMANDS, machine::COMMANDS, macros::COMMANDS, refused::COMMANDS];

/// Returns every known command.
pub fn all() -> impl Iterator<Item = &'static ExtendedInfo> {
    TOPICS.into_iter().flatten()
}

/// Returns the row of a command.
#[must_use]
pub fn find(name: &str) -> Option<&'static ExtendedInfo> {
    all().find(|row| match row.name.strip_suffix('*') {
        Some(begin) => name.get(..begin.len()).is_some_and(|start| start.eq_ignore_ascii_case(begin)),
        None => row.name.eq_ignore_ascii_case(name),
    })
}

/// Translates a command; its codes are written into `line`, which is empty.
///
/// # Errors
/// When the command is unknown, or cannot be carried out.
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
        Becomes::Macros => Ok(Asked::Macros),
        Becomes::Refused => Err(ExtendedFault::Missing(row.help)),
    }
}

#[cfg(test)]
mod tests;

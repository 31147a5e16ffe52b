//! Names of instances and lines of G-code in the configuration.

use heapless::String;

/// Name of an instance: `hotend`, `fan`, `minx`.
pub type Name = String<24>;
/// A line of G-code or a console command kept in the configuration.
pub type Command = String<96>;

/// Returns a line of G-code in which underscores stand for blanks.
pub(crate) fn spaced(text: &str) -> Command {
    text.chars().map(|c| if c == '_' { ' ' } else { c }).fold(Command::new(), |mut line, c| {
        // The schema limits the text to the length of a Command.
        let _ = line.push(c);
        line
    })
}

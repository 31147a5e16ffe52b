//! Comments with a meaning: `(MSG, hello)`, `(PRINT, X is #<x>)`.

use core::fmt::{self, Write};

use gcode::expression::value_at;

use crate::interpreter::Interpreter;

/// Meaning of a comment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Remark<'t> {
    /// Text for the operator, unchanged.
    Message(&'t str),
    /// Text for the console that watches the program run, with parameters replaced by their values: see
    /// [`write_values`].
    Printed(&'t str),
    /// Text with values, shown as a message while `#5599` is not 0.
    Debug(&'t str),
    /// Open the log file, emptied or for appending.
    OpenLog {
        /// Name of the log file.
        name: &'t str,
        /// Whether the file keeps its contents.
        appends: bool,
    },
    /// Line for the log file, with parameters replaced by their values.
    Log(&'t str),
    /// Close the log file.
    CloseLog,
    /// Open the file for the positions of probe contacts.
    OpenProbe(&'t str),
    /// Close the file of probe contacts.
    CloseProbe,
}

impl<'t> Remark<'t> {
    /// Reads the text between the brackets; `None` for a plain comment, or for invalid UTF-8.
    #[must_use]
    pub fn read(comment: &'t [u8]) -> Option<Self> {
        let comment = core::str::from_utf8(comment).ok()?.trim();
        let (word, text) = comment.split_once(',').unwrap_or((comment, ""));
        let word = word.trim();
        let is = |wanted: &str| word.eq_ignore_ascii_case(wanted);
        if is("MSG") {
            Some(Self::Message(text.trim()))
        } else if is("PRINT") {
            Some(Self::Printed(text.trim()))
        } else if is("DEBUG") {
            Some(Self::Debug(text.trim()))
        } else if is("LOG") {
            Some(Self::Log(text.trim()))
        } else if is("LOGOPEN") || is("LOGAPPEND") {
            Some(Self::OpenLog { name: text.trim(), appends: is("LOGAPPEND") })
        } else if is("LOGCLOSE") {
            Some(Self::CloseLog)
        } else if is("PROBECLOSE") {
            Some(Self::CloseProbe)
        } else {
            let open = "PROBEOPEN";
            let begins = comment.get(..open.len()).is_some_and(|start| start.eq_ignore_ascii_case(open));
            let name = comment.get(open.len()..).filter(|_| begins)?;
            Some(Self::OpenProbe(name.trim_start_matches([' ', '\t', ',']).trim()))
        }
    }
}

/// Writes a text with the values of its parameters, six decimals each. A parameter without a value is written
/// unchanged. `%d`, `%f` and `%.3f` set the number of decimals for later values: none, four, three
/// (LinuxCNC's).
///
/// # Errors
/// When `out` returns an error.
pub fn write_values(program: &Interpreter, text: &str, out: &mut impl Write) -> fmt::Result {
    let (mut rest, mut decimals) = (text, 6);
    while let Some(begin) = rest.find(['#', '%']) {
        let (before, from) = rest.split_at(begin);
        out.write_str(before)?;
        let length = if let Some((wanted, length)) = decimals_at(from) {
            decimals = wanted;
            length
        } else if let Some((value, length)) = value_at(from.as_bytes(), program).filter(|_| from.starts_with('#')) {
            write!(out, "{value:.decimals$}")?;
            length
        } else {
            out.write_str(from.get(..1).unwrap_or(""))?;
            1
        };
        rest = from.get(length..).unwrap_or("");
    }
    out.write_str(rest)
}

/// Returns the number of decimals that a format at the beginning of a text selects, and the format's length.
fn decimals_at(text: &str) -> Option<(usize, usize)> {
    for (format, decimals) in [("%d", 0), ("%f", 4), ("%lf", 4)] {
        if text.starts_with(format) {
            return Some((decimals, format.len()));
        }
    }
    let digit = text.strip_prefix("%.")?.chars().next()?.to_digit(10)?;
    text.get(3..)?.starts_with('f').then_some((digit as usize, 4))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Setup;
    use gcode::{Parameter, Parameters};

    #[test]
    fn comments_are_for_something_or_plain() {
        assert_eq!(Remark::read(b"MSG, turn the part"), Some(Remark::Message("turn the part")));
        assert_eq!(Remark::read(b" print,#1"), Some(Remark::Printed("#1")));
        assert_eq!(Remark::read(b"debug,#1"), Some(Remark::Debug("#1")));
        assert_eq!(Remark::read(b"LOGOPEN,a.txt"), Some(Remark::OpenLog { name: "a.txt", appends: false }));
        assert_eq!(Remark::read(b"LogAppend, a b.txt"), Some(Remark::OpenLog { name: "a b.txt", appends: true }));
        assert_eq!(Remark::read(b"LOG, x #<_x>"), Some(Remark::Log("x #<_x>")));
        assert_eq!(Remark::read(b"LOGCLOSE"), Some(Remark::CloseLog));
        assert_eq!(Remark::read(b"PROBEOPEN points.txt"), Some(Remark::OpenProbe("points.txt")));
        assert_eq!(Remark::read(b"PROBECLOSE"), Some(Remark::CloseProbe));
        assert_eq!(Remark::read(b"PROBE the part"), None);
        assert_eq!(Remark::read(b"a bracket"), None);
    }

    #[test]
    fn parameters_are_said_as_their_values() {
        let mut program = Interpreter::new(Setup::default());
        program.set(Parameter::Numbered(1), 2.5).unwrap();
        program.end_line().unwrap();
        let mut said = std::string::String::new();
        write_values(&program, "#1 of #<nobody>, ##1 at #[0.5+0.5]%", &mut said).unwrap();
        assert_eq!(said, "2.500000 of #<nobody>, #2.500000 at 2.500000%");
        for (text, expected) in
            [("#1 %d#1 #1", "2.500000 2 2"), ("%f #1", " 2.5000"), ("%.1f#1 100% %.xf", "2.5 100% %.xf")]
        {
            said.clear();
            write_values(&program, text, &mut said).unwrap();
            assert_eq!(said, expected, "{text}");
        }
    }
}

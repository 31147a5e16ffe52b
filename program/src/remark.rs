//! Comments that say something: `(MSG, hello)`, `(PRINT, X is #<x>)`.

use core::fmt::{self, Write};

use gcode::expression::value_at;

use crate::interpreter::Interpreter;

/// What a comment is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Remark<'t> {
    /// The operator is told this, as it stands.
    Message(&'t str),
    /// The operator is told this, parameters as their values: see [`write_values`].
    Values(&'t str),
    /// The same, for whoever watches the program run.
    Printed(&'t str),
    /// Something is written to a file.
    Log(&'t str),
}

impl<'t> Remark<'t> {
    /// From the text between the brackets; `None` for a plain comment, or one that is no text.
    #[must_use]
    pub fn read(comment: &'t [u8]) -> Option<Self> {
        let comment = core::str::from_utf8(comment).ok()?.trim();
        let (word, text) = comment.split_once(',').unwrap_or((comment, ""));
        let word = word.trim();
        let is = |wanted: &str| word.eq_ignore_ascii_case(wanted);
        if is("MSG") {
            Some(Self::Message(text.trim()))
        } else if is("DEBUG") {
            Some(Self::Values(text.trim()))
        } else if is("PRINT") {
            Some(Self::Printed(text.trim()))
        } else {
            let writes = ["LOG", "PROBE"]
                .iter()
                .any(|wanted| word.get(..wanted.len()).is_some_and(|start| start.eq_ignore_ascii_case(wanted)));
            writes.then_some(Self::Log(comment))
        }
    }
}

/// Writes a text with the values of its parameters, six decimals each. One that has none is written as it
/// stands. `%d`, `%f` and `%.3f` say with how many decimals those that follow are written: none, four, three
/// (LinuxCNC's).
///
/// # Errors
/// Those of `out`.
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

/// The number of decimals that a format at the beginning of a text asks for, and how long it is.
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
        assert_eq!(Remark::read(b"LOGOPEN,a.txt"), Some(Remark::Log("LOGOPEN,a.txt")));
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

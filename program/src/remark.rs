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
        } else if is("DEBUG") || is("PRINT") {
            Some(Self::Values(text.trim()))
        } else {
            let writes = ["LOG", "PROBE"]
                .iter()
                .any(|wanted| word.get(..wanted.len()).is_some_and(|start| start.eq_ignore_ascii_case(wanted)));
            writes.then_some(Self::Log(comment))
        }
    }
}

/// Writes a text with the values of its parameters, six decimals each. One that has none is written as it
/// stands.
///
/// # Errors
/// Those of `out`.
pub fn write_values(program: &Interpreter, text: &str, out: &mut impl Write) -> fmt::Result {
    let mut rest = text;
    while let Some(begin) = rest.find('#') {
        let (before, from) = rest.split_at(begin);
        out.write_str(before)?;
        match value_at(from.as_bytes(), program) {
            Some((value, length)) => {
                write!(out, "{value:.6}")?;
                rest = from.get(length..).unwrap_or("");
            }
            None => {
                out.write_char('#')?;
                rest = from.get(1..).unwrap_or("");
            }
        }
    }
    out.write_str(rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Setup;
    use gcode::{Parameter, Parameters};

    #[test]
    fn comments_are_for_something_or_plain() {
        assert_eq!(Remark::read(b"MSG, turn the part"), Some(Remark::Message("turn the part")));
        assert_eq!(Remark::read(b" print,#1"), Some(Remark::Values("#1")));
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
    }
}

//! O words: subroutines, conditions and loops (LinuxCNC's O codes), and program numbers (`O1001`).

use crate::error::{Problem, SyntaxError};
use crate::expression::{Name, Parameters, Reader};
use crate::scanner::column;

/// What an O word does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the words")]
pub enum FlowWord {
    Sub,
    EndSub,
    Call,
    Return,
    If,
    ElseIf,
    Else,
    EndIf,
    While,
    EndWhile,
    Do,
    Repeat,
    EndRepeat,
    Break,
    Continue,
    /// Nothing: the number alone names the program that follows.
    Number,
}

impl FlowWord {
    /// As written; longer ones before those they begin with.
    const ALL: [(&'static str, Self); 15] = [
        ("SUB", Self::Sub),
        ("ENDSUB", Self::EndSub),
        ("CALL", Self::Call),
        ("RETURN", Self::Return),
        ("IF", Self::If),
        ("ELSEIF", Self::ElseIf),
        ("ELSE", Self::Else),
        ("ENDIF", Self::EndIf),
        ("WHILE", Self::While),
        ("ENDWHILE", Self::EndWhile),
        ("DO", Self::Do),
        ("REPEAT", Self::Repeat),
        ("ENDREPEAT", Self::EndRepeat),
        ("BREAK", Self::Break),
        ("CONTINUE", Self::Continue),
    ];

    /// In lower case.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sub => "sub",
            Self::EndSub => "endsub",
            Self::Call => "call",
            Self::Return => "return",
            Self::If => "if",
            Self::ElseIf => "elseif",
            Self::Else => "else",
            Self::EndIf => "endif",
            Self::While => "while",
            Self::EndWhile => "endwhile",
            Self::Do => "do",
            Self::Repeat => "repeat",
            Self::EndRepeat => "endrepeat",
            Self::Break => "break",
            Self::Continue => "continue",
            Self::Number => "",
        }
    }
}

/// A line that begins with an O word.
#[derive(Clone, Debug)]
pub struct FlowLine<'a> {
    /// Its number or name: `100`, `pocket`.
    pub label: Name,
    /// What it does.
    pub word: FlowWord,
    line: &'a [u8],
    /// Where its values begin.
    at: usize,
}

/// Whether an O word begins here.
pub(crate) fn begins(body: &[u8]) -> bool {
    let label = body.get(1..).unwrap_or(&[]).trim_ascii_start().first();
    matches!(body.first(), Some(b'O' | b'o')) && label.is_some_and(|byte| byte.is_ascii_digit() || *byte == b'<')
}

impl<'a> FlowLine<'a> {
    /// Reads the label and the word of a line at the place of its O.
    pub(crate) fn read(line: &'a [u8], at: usize) -> Result<Self, SyntaxError> {
        let mut reader = Reader::new(line, at + 1, &crate::expression::NoParameters);
        let label = match reader.peek() {
            Some(b'<') => reader.name()?,
            _ => number(line, &mut reader)?,
        };
        let begin = reader.peek().map_or(line.len(), |_| reader.at);
        let rest = line.get(begin..).unwrap_or(&[]);
        if matches!(rest.first(), None | Some(b'(' | b';')) {
            return Ok(Self { label, word: FlowWord::Number, line, at: line.len() });
        }
        let length = rest.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
        let written = rest.get(..length).unwrap_or(&[]);
        let known = FlowWord::ALL.into_iter().find(|(word, _)| written.eq_ignore_ascii_case(word.as_bytes()));
        let (_, word) = known.ok_or(SyntaxError { column: column(begin), problem: Problem::BadFlowWord })?;
        Ok(Self { label, word, line, at: begin + length })
    }

    /// Works out the values behind the word, `[1] [#2]`, each in turn.
    ///
    /// # Errors
    /// What is wrong with one of them, or that something else stands there.
    pub fn values(&self, parameters: &dyn Parameters, mut each: impl FnMut(f64)) -> Result<(), SyntaxError> {
        let mut reader = Reader::new(self.line, self.at, parameters);
        loop {
            match reader.peek() {
                Some(b'[') => each(reader.bracketed()?),
                None | Some(b'(' | b';') => return Ok(()),
                Some(_) => return Err(SyntaxError { column: column(reader.at), problem: Problem::Expected(b'[') }),
            }
        }
    }

    /// Column of its values.
    #[must_use]
    pub fn column(&self) -> u16 {
        column(self.at)
    }
}

/// The digits of a label, without leading zeros.
fn number(line: &[u8], reader: &mut Reader<'_, '_>) -> Result<Name, SyntaxError> {
    let begin = reader.at;
    let mut label = Name::new();
    while let Some(&byte) = line.get(reader.at).filter(|byte| byte.is_ascii_digit()) {
        reader.at += 1;
        if label == "0" {
            label.clear();
        }
        label.push(char::from(byte)).map_err(|_| SyntaxError { column: column(begin), problem: Problem::BadName })?;
    }
    Ok(label)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expression::{NoParameters, Parameter};

    fn read(line: &str) -> Result<FlowLine<'_>, SyntaxError> {
        assert!(begins(line.as_bytes()), "{line}");
        FlowLine::read(line.as_bytes(), 0)
    }

    #[test]
    fn labels_are_numbers_or_names() {
        for (line, label, word) in [
            ("O100 sub", "100", FlowWord::Sub),
            ("o<My Pocket> CALL [1] [2]", "mypocket", FlowWord::Call),
            ("O1001 (the part)", "1001", FlowWord::Number),
            ("o 7endif", "7", FlowWord::EndIf),
            ("o007 elseif [1]", "7", FlowWord::ElseIf),
            ("O0", "0", FlowWord::Number),
        ] {
            let read = read(line).unwrap();
            assert_eq!((read.label.as_str(), read.word), (label, word), "{line}");
        }
        assert!(!begins(b"ok"));
        assert!(!begins(b"O"));
    }

    #[test]
    fn values_come_in_turn() {
        let mut values = std::vec::Vec::new();
        read("o1 call [1+1] [3] (sizes)").unwrap().values(&NoParameters, |value| values.push(value)).unwrap();
        assert_eq!(values, [2.0, 3.0]);
        let error = read("o1 if 5").unwrap().values(&NoParameters, |_| {}).unwrap_err();
        assert_eq!((error.column, error.problem), (7, Problem::Expected(b'[')));
        let error = read("o1 if [#3]").unwrap().values(&NoParameters, |_| {}).unwrap_err();
        assert_eq!((error.column, error.problem), (8, Problem::NoParameter));
        let _ = Parameter::Numbered(1);
    }

    #[test]
    fn a_word_that_nobody_knows_has_its_column() {
        let error = read("o1 fi [1]").unwrap_err();
        assert_eq!((error.column, error.problem), (4, Problem::BadFlowWord));
    }
}

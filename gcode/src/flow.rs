//! O words: subroutines, conditions and loops (LinuxCNC's O codes), and program numbers (`O1001`).

use core::fmt::Write;

use crate::error::{Problem, SyntaxError, column};
use crate::expression::{Name, Parameters, Reader};

/// Action of an O word.
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
    /// The word at the beginning of a text, whichever case its letters are in, and its length in bytes.
    #[inline]
    fn at_start_of(text: &[u8]) -> Option<(Self, usize)> {
        const { assert!("endrepeat".len() <= MOST_PACKED, "the longest word fits") };
        let (mut letters, mut length) = (0, 0);
        for letter in text.iter().take_while(|byte| byte.is_ascii_alphabetic()) {
            letters = pack(letters, *letter);
            length += 1;
        }
        let word = Self::of(letters).filter(|_| length <= MOST_PACKED)?;
        Some((word, length))
    }

    /// The word of these letters, packed.
    fn of(letters: u64) -> Option<Self> {
        const fn is(word: &str) -> u64 {
            let (mut packed, mut left) = (0, word.as_bytes());
            while let [letter, rest @ ..] = left {
                (packed, left) = (pack(packed, *letter), rest);
            }
            packed
        }
        Some(match letters {
            letters if letters == const { is("while") } => Self::While,
            letters if letters == const { is("endwhile") } => Self::EndWhile,
            letters if letters == const { is("if") } => Self::If,
            letters if letters == const { is("endif") } => Self::EndIf,
            letters if letters == const { is("else") } => Self::Else,
            letters if letters == const { is("elseif") } => Self::ElseIf,
            letters if letters == const { is("call") } => Self::Call,
            letters if letters == const { is("sub") } => Self::Sub,
            letters if letters == const { is("endsub") } => Self::EndSub,
            letters if letters == const { is("return") } => Self::Return,
            letters if letters == const { is("do") } => Self::Do,
            letters if letters == const { is("repeat") } => Self::Repeat,
            letters if letters == const { is("endrepeat") } => Self::EndRepeat,
            letters if letters == const { is("break") } => Self::Break,
            letters if letters == const { is("continue") } => Self::Continue,
            _ => return None,
        })
    }

    /// Returns the word in lower case.
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

/// Greatest number of letters that [`pack`] tells apart.
const MOST_PACKED: usize = 12;

/// Adds a letter to packed ones, five bits each, the same for both cases: words are told apart by one
/// comparison each.
const fn pack(packed: u64, letter: u8) -> u64 {
    packed << 5 | (letter & 31) as u64
}

/// A line that begins with an O word.
#[derive(Clone, Debug)]
pub struct FlowLine<'a> {
    /// Number or name of the O word: `100`, `pocket`. Empty where the label is an expression: see
    /// [`Self::labelled`].
    pub label: Name,
    /// Action of the O word.
    pub word: FlowWord,
    line: &'a [u8],
    /// Byte position of the expression that gives the label.
    worked_out: Option<usize>,
    /// Byte position of the word's values.
    at: usize,
}

/// Whether an O word begins here.
pub(crate) fn begins(body: &[u8]) -> bool {
    let label = body.get(1..).unwrap_or(&[]).trim_ascii_start().first();
    matches!(body.first(), Some(b'O' | b'o'))
        && label.is_some_and(|byte| byte.is_ascii_digit() || matches!(byte, b'<' | b'[' | b'#'))
}

impl<'a> FlowLine<'a> {
    /// Reads the label and the word of a line at the place of its O.
    pub(crate) fn read(line: &'a [u8], at: usize) -> Result<Self, SyntaxError> {
        let mut reader = Reader::new(line, at + 1, &crate::expression::NoParameters);
        let (mut label, mut worked_out) = (Name::new(), None);
        match reader.peek() {
            Some(b'<') => label = reader.name()?,
            Some(b'[' | b'#') => {
                worked_out = Some(reader.at);
                reader.at += length_of_value(line.get(reader.at..).unwrap_or(&[]));
            }
            _ => label = number(line, &mut reader)?,
        }
        let begin = reader.peek().map_or(line.len(), |_| reader.at);
        let rest = line.get(begin..).unwrap_or(&[]);
        if matches!(rest.first(), None | Some(b'(' | b';')) {
            return Ok(Self { label, word: FlowWord::Number, line, worked_out, at: line.len() });
        }
        let bad = SyntaxError::at(begin, Problem::BadFlowWord);
        let (word, length) = FlowWord::at_start_of(rest).ok_or(bad)?;
        Ok(Self { label, word, line, worked_out, at: begin + length })
    }

    /// Whether its label is the value of an expression: `O[#1 * 10] call`.
    #[must_use]
    pub const fn works_out_label(&self) -> bool {
        self.worked_out.is_some()
    }

    /// The line with its label, where that is worked out.
    ///
    /// # Errors
    /// A syntax error in the expression, or a value that is no whole number.
    pub fn labelled(&self, parameters: &dyn Parameters) -> Result<Self, SyntaxError> {
        let Some(begin) = self.worked_out else { return Ok(self.clone()) };
        let value = Reader::new(self.line, begin, parameters).value()?;
        let mut label = Name::new();
        let is_number = (0.0..=f64::from(u32::MAX)).contains(&value) && libm::floor(value) == value;
        if !is_number || write!(label, "{}", value as u32).is_err() {
            return Err(SyntaxError::at(begin, Problem::BadLabel));
        }
        Ok(Self { label, worked_out: None, ..self.clone() })
    }

    /// Works out the values behind the word, `[1] [#2]`, each in turn.
    ///
    /// # Errors
    /// A syntax error in one of the values, or something else in their place.
    pub fn values(&self, parameters: &dyn Parameters, mut each: impl FnMut(f64)) -> Result<(), SyntaxError> {
        let mut reader = Reader::new(self.line, self.at, parameters);
        loop {
            match reader.peek() {
                Some(b'[') => each(reader.bracketed()?),
                // A comment may stand between values.
                Some(b'(') => match self.line.get(reader.at..).and_then(|rest| rest.iter().position(|b| *b == b')')) {
                    Some(end) => reader.at += end + 1,
                    None => return Ok(()),
                },
                None | Some(b';') => return Ok(()),
                Some(_) => return Err(SyntaxError::at(reader.at, Problem::Expected(b'['))),
            }
        }
    }

    /// Column of its values.
    #[must_use]
    pub fn column(&self) -> u16 {
        column(self.at)
    }
}

/// Returns the length of a value that begins with a bracket or a parameter, as far as the length can be seen
/// without working out the value.
fn length_of_value(text: &[u8]) -> usize {
    let signs = text.iter().take_while(|byte| matches!(byte, b'#' | b' ')).count();
    let rest = text.get(signs..).unwrap_or(&[]);
    let closing = match rest.first() {
        Some(b'<') => rest.iter().position(|byte| *byte == b'>'),
        Some(b'[') => {
            let mut open = 0_u32;
            rest.iter().position(|byte| {
                match byte {
                    b'[' => open += 1,
                    b']' => open = open.saturating_sub(1),
                    _ => {}
                }
                open == 0
            })
        }
        _ => return signs + rest.iter().take_while(|byte| byte.is_ascii_digit()).count(),
    };
    closing.map_or(text.len(), |closing| signs + closing + 1)
}

/// The digits of a label, without leading zeros.
fn number(line: &[u8], reader: &mut Reader<'_, '_>) -> Result<Name, SyntaxError> {
    let begin = reader.at;
    let rest = line.get(begin..).unwrap_or(&[]);
    let length = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    // A zero by itself stays.
    let zeros = rest.iter().take(length.saturating_sub(1)).take_while(|byte| **byte == b'0').count();
    reader.at += length;
    let mut label = Name::new();
    for digit in rest.get(zeros..length).unwrap_or(&[]) {
        let pushed = label.push(char::from(*digit));
        pushed.map_err(|_| SyntaxError::at(begin, Problem::BadName))?;
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

    /// Keeps #2, which is 10, and `#<sub>`, which is 7.
    struct Few;

    impl Parameters for Few {
        fn get(&self, parameter: &Parameter) -> Option<f64> {
            match parameter {
                Parameter::Numbered(2) => Some(10.0),
                Parameter::Named(name) if name == "sub" => Some(7.0),
                _ => None,
            }
        }

        fn set(&mut self, _: Parameter, _: f64) -> Result<(), Problem> {
            Err(Problem::ReadOnly)
        }
    }

    #[test]
    fn labels_may_be_worked_out() {
        for (line, label) in [
            ("O[#2 * [5 + 5]] call [1]", Ok("100")),
            ("o#<sub> call (seven)", Ok("7")),
            ("O#2 call", Ok("10")),
            ("O ##2call", Err(Problem::NoParameter)),
            ("O[#2 / 4] call", Err(Problem::BadLabel)),
        ] {
            let read = read(line).unwrap();
            assert!(read.works_out_label() && read.label.is_empty() && read.word == FlowWord::Call, "{line}");
            let labelled = read.labelled(&Few).map(|line| line.label).map_err(|error| error.problem);
            assert_eq!(labelled.as_deref().map_err(|problem| *problem), label, "{line}");
        }
    }

    #[test]
    fn comments_may_stand_between_values() {
        let mut values = std::vec::Vec::new();
        let line = "o1 call [1] (one) [2](two)[3] ; three [4]";
        read(line).unwrap().values(&NoParameters, |value| values.push(value)).unwrap();
        assert_eq!(values, [1.0, 2.0, 3.0]);
    }

    #[test]
    fn a_word_that_nobody_knows_has_its_column() {
        let error = read("o1 fi [1]").unwrap_err();
        assert_eq!((error.column, error.problem), (4, Problem::BadFlowWord));
    }
}

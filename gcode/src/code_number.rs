//! The number of a code: `G1`, `G38.2`, and where it is worked out, `G[#1]`.

use crate::block::{Code, Letter, NO_TOOL};
use crate::error::{Problem, SyntaxError};
use crate::expression::{self, Parameters, Reader};
use crate::number;
use crate::scanner::Blocks;

/// Tenths of a code that was worked out may be off a whole number by this.
const WHOLE: f64 = 1e-3;

impl Blocks<'_> {
    /// A code's number and subcode, the letter being at hand.
    #[inline]
    pub(crate) fn code(
        &mut self,
        letter: Letter,
        name: char,
        parameters: &dyn Parameters,
    ) -> Result<Code, SyntaxError> {
        // As most lines begin: `G1 `.
        if let [_, digit @ b'0'..=b'9', b' ', ..] = self.rest() {
            self.at += 2;
            return Ok(Code { letter, number: u16::from(digit - b'0'), subcode: 0 });
        }
        let begin = self.at;
        self.at += 1;
        self.skip_blanks();
        if !self.peek().is_some_and(|byte| byte.is_ascii_digit()) {
            let is_none = matches!(self.rest(), [b'-', b'1', rest @ ..] if !matches!(rest, [b'0'..=b'9' | b'.', ..]));
            if letter == Letter::T && is_none {
                self.at += 2;
                return Ok(Code::t(NO_TOOL));
            }
            return self.code_worked_out(begin, letter, name, parameters);
        }
        let number = number::parse_digits(self.rest()).and_then(|(n, length)| Some((u16::try_from(n).ok()?, length)));
        // The last number is that of no tool.
        let number = number.filter(|(n, _)| letter != Letter::T || *n != NO_TOOL);
        let (number, length) = number.ok_or_else(|| self.error(begin, Problem::BadCode(name)))?;
        self.at += length;
        let mut subcode = 0;
        if self.peek() == Some(b'.') {
            self.at += 1;
            let digits =
                number::parse_digits(self.rest()).and_then(|(n, length)| Some((u8::try_from(n).ok()?, length)));
            let (value, length) = digits.ok_or_else(|| self.error(begin, Problem::BadSubcode(name)))?;
            self.at += length;
            subcode = value;
        }
        if self.peek() == Some(b'.') || (letter == Letter::T && subcode != 0) {
            return Err(self.error(begin, Problem::BadSubcode(name)));
        }
        Ok(Code { letter, number, subcode })
    }

    /// A code whose number is no plain one: `G[#1]`, `T#2`. Tenths are the subcode.
    #[cold]
    fn code_worked_out(
        &mut self,
        begin: usize,
        letter: Letter,
        name: char,
        parameters: &dyn Parameters,
    ) -> Result<Code, SyntaxError> {
        let mut reader = Reader::new(self.line, self.at, parameters);
        let is_value = reader.peek().is_some_and(expression::starts) || reader.is_function();
        if !is_value {
            return Err(self.error(begin, Problem::BadCode(name)));
        }
        let tenths = reader.value()? * 10.0;
        self.at = reader.at;
        let whole = libm::round(tenths);
        let fits = (0.0..=f64::from(u16::MAX)).contains(&whole) && libm::fabs(whole - tenths) < WHOLE;
        let (number, subcode) = ((whole / 10.0) as u16, libm::fmod(whole, 10.0) as u8);
        if !fits || subcode != 0 && letter != Letter::G {
            return Err(self.error(begin, Problem::BadCode(name)));
        }
        Ok(Code { letter, number, subcode })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Block, Parameter};

    /// #1 is 38.2.
    struct One;

    impl Parameters for One {
        fn get(&self, parameter: &Parameter) -> Option<f64> {
            (*parameter == Parameter::Numbered(1)).then_some(38.2)
        }

        fn set(&mut self, _: Parameter, _: f64) -> Result<(), Problem> {
            Err(Problem::ReadOnly)
        }
    }

    fn g(number: u16) -> Block<'static> {
        Block::new(Some(Code::g(number)), 1)
    }

    #[test]
    fn codes_may_be_worked_out() {
        let read = |line: &'static str| {
            let mut block = Block::new(None, 0);
            Blocks::new(line.as_bytes()).read(&mut block, &mut One).map(|_| block)
        };
        assert_eq!(read("G#1 Z-5"), Ok(Block::new(Some(Code::g(38).sub(2)), 1).with('Z', -5.0)));
        assert_eq!(read("G[1+1]X1"), Ok(g(2).with('X', 1.0)));
        assert_eq!(read("T [2*3] M6").unwrap().code, Some(Code::t(6)));
        assert_eq!(read("M ABS[-8]").unwrap().code, Some(Code::m(8)));
        for (line, name) in [("T#1", 'T'), ("M[1/2]", 'M'), ("G[-1]", 'G'), ("G[1.23]", 'G'), ("T[70000]", 'T')] {
            assert_eq!(read(line).unwrap_err().problem, Problem::BadCode(name), "{line}");
        }
    }
}

//! Values that are worked out: `[1 + 2 * SIN[#3]]`, `#5`, `#<depth>`.
//!
//! Operators, functions and parameters of NIST RS-274/NGC (section 3.3.2), with what LinuxCNC's G-code pages
//! add: names, comparisons, logic, `EXISTS`. Angles are degrees. Nothing is written here: parameters are read
//! from whoever keeps them.

mod operator;

use heapless::{String, Vec};

use operator::Operator;

use crate::error::{Problem, SyntaxError};
use crate::number::{self, Flaw};

/// Letters of a name at most.
pub const MAX_NAME: usize = 32;
/// Brackets within brackets at most; a line has no room for many more.
const MOST_NESTED: u8 = 10;
/// Numbers closer than this are equal to `EQ` and `NE` (LinuxCNC's).
const EQUAL: f64 = 1e-4;
/// A parameter's number may be off a whole number by this, as it may be the result of a calculation.
const WHOLE: f64 = 1e-4;

/// The name of a parameter or a subroutine, in lower case, without blanks.
pub type Name = String<MAX_NAME>;

/// A parameter of the program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// A numbered parameter, `#5`.
    Numbered(u16),
    /// A named parameter, `#<depth>`.
    Named(Name),
}

/// Storage of the parameters' values.
pub trait Parameters {
    /// The value of a parameter; `None` when there is none with this number, or nothing was written to the
    /// name.
    fn get(&self, parameter: &Parameter) -> Option<f64>;

    /// Writes a value once the line has been read.
    ///
    /// # Errors
    /// The problem with the parameter or the value.
    fn set(&mut self, parameter: Parameter, value: f64) -> Result<(), Problem>;
}

/// No parameters: each is refused.
#[derive(Clone, Copy, Debug)]
pub struct NoParameters;

impl Parameters for NoParameters {
    fn get(&self, _: &Parameter) -> Option<f64> {
        None
    }

    fn set(&mut self, _: Parameter, _: f64) -> Result<(), Problem> {
        Err(Problem::ReadOnly)
    }
}

/// The value at the beginning of a text, and how long it is there; `None` when there is none.
#[must_use]
pub fn value_at(text: &[u8], parameters: &dyn Parameters) -> Option<(f64, usize)> {
    let mut reader = Reader::new(text, 0, parameters);
    let value = reader.value().ok()?;
    Some((value, reader.at))
}

/// Whether a value begins with this byte that is no plain number.
pub(crate) const fn starts(byte: u8) -> bool {
    matches!(byte, b'[' | b'#')
}

/// Reads values from a place of a line on.
pub(crate) struct Reader<'l, 'p> {
    line: &'l [u8],
    pub at: usize,
    parameters: &'p dyn Parameters,
    nested: u8,
}

impl<'l, 'p> Reader<'l, 'p> {
    /// Creates a reader that begins at this offset in the line.
    pub const fn new(line: &'l [u8], at: usize, parameters: &'p dyn Parameters) -> Self {
        Self { line, at, parameters, nested: 0 }
    }

    fn rest(&self) -> &'l [u8] {
        self.line.get(self.at..).unwrap_or(&[])
    }

    /// Returns the next byte that is no blank, without taking it.
    pub fn peek(&mut self) -> Option<u8> {
        while matches!(self.line.get(self.at), Some(b' ' | b'\t')) {
            self.at += 1;
        }
        self.line.get(self.at).copied()
    }

    fn error(&self, at: usize, problem: Problem) -> SyntaxError {
        SyntaxError::at(at, problem)
    }

    fn expect(&mut self, byte: u8) -> Result<(), SyntaxError> {
        if self.peek() != Some(byte) {
            return Err(self.error(self.at, Problem::Expected(byte)));
        }
        self.at += 1;
        Ok(())
    }

    /// A value: a number, a parameter, an expression in brackets, a function of one.
    pub fn value(&mut self) -> Result<f64, SyntaxError> {
        let begin = self.at;
        if self.nested >= MOST_NESTED {
            return Err(self.error(begin, Problem::NestedTooDeep));
        }
        self.nested += 1;
        let value = match self.peek() {
            Some(b'[') => self.bracketed(),
            Some(b'#') => self.parameter_value(),
            Some(byte @ (b'+' | b'-')) if !self.signs_a_number() => {
                self.at += 1;
                self.value().map(|value| if byte == b'-' { -value } else { value })
            }
            Some(byte) if number::starts(byte) => self.plain(),
            Some(byte) if byte.is_ascii_alphabetic() => self.function(),
            _ => Err(self.error(self.at, Problem::NoValue)),
        }?;
        self.nested -= 1;
        if value.is_finite() { Ok(value) } else { Err(self.error(begin, Problem::NotFinite)) }
    }

    fn signs_a_number(&self) -> bool {
        self.line.get(self.at + 1).is_some_and(|byte| byte.is_ascii_digit() || *byte == b'.')
    }

    #[inline(never)]
    fn plain(&mut self) -> Result<f64, SyntaxError> {
        let (value, length) = number::parse(self.rest()).map_err(|flaw| {
            let problem = if flaw == Flaw::NoDigits { Problem::NoValue } else { Problem::TwoPoints };
            self.error(self.at, problem)
        })?;
        self.at += length;
        Ok(value)
    }

    /// `[` values with operators between them `]`.
    pub fn bracketed(&mut self) -> Result<f64, SyntaxError> {
        self.expect(b'[')?;
        // Operators that wait for their right side; each binds tighter than the one before it.
        let mut waiting: Vec<(f64, Operator), { Operator::RANKS }> = Vec::new();
        let mut left = self.value()?;
        loop {
            let begin = self.at;
            let operator = self.operator()?;
            let rank = operator.map_or(0, Operator::rank);
            while let Some((first, waits)) = waiting.last().copied().filter(|(_, waits)| waits.rank() >= rank) {
                waiting.pop();
                left = waits.of(first, left).map_err(|problem| self.error(begin, problem))?;
            }
            let Some(operator) = operator else { return Ok(left) };
            // Waiting operators all differ in rank, so there is room for each.
            let _ = waiting.push((left, operator));
            left = self.value()?;
        }
    }

    /// The next operator; none at the closing bracket.
    fn operator(&mut self) -> Result<Option<Operator>, SyntaxError> {
        if self.peek() == Some(b']') {
            self.at += 1;
            return Ok(None);
        }
        let (operator, length) =
            Operator::at_start(self.rest()).ok_or_else(|| self.error(self.at, Problem::Expected(b']')))?;
        self.at += length;
        Ok(Some(operator))
    }

    fn parameter_value(&mut self) -> Result<f64, SyntaxError> {
        let begin = self.at;
        let parameter = self.parameter()?;
        self.parameters.get(&parameter).ok_or_else(|| self.error(begin, Problem::NoParameter))
    }

    /// `#5`, `##5`, `#[1+2]`, `#<name>`: which parameter is meant.
    pub fn parameter(&mut self) -> Result<Parameter, SyntaxError> {
        let begin = self.at;
        self.expect(b'#')?;
        if self.peek() == Some(b'<') {
            return Ok(Parameter::Named(self.name()?));
        }
        if let Some(number) = self.written_number() {
            return Ok(Parameter::Numbered(number));
        }
        let number = self.value()?;
        // The nearest whole number: what is less than 1 is refused, and the cast makes nought of it.
        let whole = f64::from((number + 0.5) as u32);
        if libm::fabs(number - whole) > WHOLE || !(1.0..=f64::from(u16::MAX)).contains(&whole) {
            return Err(self.error(begin, Problem::NoParameter));
        }
        Ok(Parameter::Numbered(whole as u16))
    }

    /// Takes the number of a parameter that is written as a whole number, as nearly all are.
    #[inline(always)]
    fn written_number(&mut self) -> Option<u16> {
        let (number, length) = number::parse_digits(self.rest())?;
        let number = u16::try_from(number).ok().filter(|number| *number > 0)?;
        if self.line.get(self.at + length) == Some(&b'.') {
            return None;
        }
        self.at += length;
        Some(number)
    }

    /// `<a name>`.
    pub fn name(&mut self) -> Result<Name, SyntaxError> {
        let begin = self.at;
        self.expect(b'<')?;
        let mut name = Name::new();
        loop {
            let byte = self.peek().ok_or_else(|| self.error(begin, Problem::Expected(b'>')))?;
            self.at += 1;
            if byte == b'>' {
                break;
            }
            let fits = byte.is_ascii() && name.push(char::from(byte.to_ascii_lowercase())).is_ok();
            if !fits {
                return Err(self.error(begin, Problem::BadName));
            }
        }
        if name.is_empty() { Err(self.error(begin, Problem::BadName)) } else { Ok(name) }
    }

    /// Whether a function begins here: its name and a bracket.
    pub fn is_function(&mut self) -> bool {
        let name = self.rest().iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
        let bracket = self.rest().get(name..).unwrap_or(&[]).trim_ascii_start().first() == Some(&b'[');
        bracket && Function::ALL.iter().any(|(word, _)| name == word.len() && starts_with(self.rest(), word))
    }

    fn function(&mut self) -> Result<f64, SyntaxError> {
        let begin = self.at;
        let found = Function::ALL.into_iter().find(|(name, _)| starts_with(self.rest(), name));
        let (name, function) = found.ok_or_else(|| self.error(begin, Problem::NoValue))?;
        self.at += name.len();
        match function {
            Function::Exists => {
                self.expect(b'[')?;
                let exists = match self.parameter() {
                    Ok(parameter) => self.parameters.get(&parameter).is_some(),
                    // No parameter has this number.
                    Err(error) if error.problem == Problem::NoParameter && self.peek() == Some(b']') => false,
                    Err(error) => return Err(error),
                };
                self.expect(b']')?;
                Ok(truth(exists))
            }
            Function::ArcTangent => {
                let y = self.bracketed()?;
                self.expect(b'/')?;
                let x = self.bracketed()?;
                Ok(libm::atan2(y, x).to_degrees())
            }
            Function::Of(of) => {
                let x = self.bracketed()?;
                Ok(of(x))
            }
        }
    }
}

fn starts_with(bytes: &[u8], text: &str) -> bool {
    bytes.get(..text.len()).is_some_and(|start| start.eq_ignore_ascii_case(text.as_bytes()))
}

const fn truth(is: bool) -> f64 {
    if is { 1.0 } else { 0.0 }
}

#[derive(Clone, Copy)]
enum Function {
    Exists,
    ArcTangent,
    /// A function of one number. NaN, its result where there is none, is refused.
    Of(fn(f64) -> f64),
}

impl Function {
    const ALL: [(&'static str, Self); 14] = [
        ("ABS", Self::Of(libm::fabs)),
        ("ACOS", Self::Of(|x| libm::acos(x).to_degrees())),
        ("ASIN", Self::Of(|x| libm::asin(x).to_degrees())),
        ("ATAN", Self::ArcTangent),
        ("COS", Self::Of(|x| libm::cos(x.to_radians()))),
        ("EXISTS", Self::Exists),
        ("EXP", Self::Of(libm::exp)),
        ("FIX", Self::Of(libm::floor)),
        ("FUP", Self::Of(libm::ceil)),
        ("LN", Self::Of(libm::log)),
        ("ROUND", Self::Of(libm::round)),
        ("SIN", Self::Of(|x| libm::sin(x.to_radians()))),
        ("SQRT", Self::Of(libm::sqrt)),
        ("TAN", Self::Of(|x| libm::tan(x.to_radians()))),
    ];
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// #1 to #30 are ten times their number, #<depth> is 4.
    struct Some30;

    impl Parameters for Some30 {
        fn get(&self, parameter: &Parameter) -> Option<f64> {
            match parameter {
                Parameter::Numbered(number) => (*number <= 30).then(|| f64::from(*number) * 10.0),
                Parameter::Named(name) => (name == "depth").then_some(4.0),
            }
        }

        fn set(&mut self, _: Parameter, _: f64) -> Result<(), Problem> {
            Ok(())
        }
    }

    fn value(text: &str) -> Result<f64, SyntaxError> {
        Reader::new(text.as_bytes(), 0, &Some30).value()
    }

    #[track_caller]
    fn is(text: &str, expected: f64) {
        let got = value(text).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert!((got - expected).abs() < 1e-9, "{text} is {got}, not {expected}");
    }

    #[test]
    fn tight_operators_go_first_and_equal_ones_from_left_to_right() {
        is("[1 + 2 * 3]", 7.0);
        is("[[1 + 2] * 3]", 9.0);
        is("[2 ** 3 ** 2]", 64.0);
        is("[2 * 3 ** 2]", 18.0);
        is("[10 - 3 - 2]", 5.0);
        is("[12 / 3 / 2]", 2.0);
        is("[7 MOD 4 + 1]", 4.0);
        is("[-7 mod 4]", 1.0);
        is("[1 + 1 EQ 2]", 1.0);
        is("[1 LT 2 AND 3 GT 2]", 1.0);
        is("[0 OR 1 XOR 1]", 0.0);
        is("[2 - -3]", 5.0);
        is("-[1+1]", -2.0);
    }

    #[test]
    fn functions_take_degrees_and_brackets() {
        is("SIN[30]", 0.5);
        is("cos[60]", 0.5);
        is("TAN[45]", 1.0);
        is("ATAN[1]/[-1]", 135.0);
        is("ACOS[0]", 90.0);
        is("ASIN[1]", 90.0);
        is("FIX[-2.8]", -3.0);
        is("FUP[-2.8]", -2.0);
        is("ROUND[2.5]", 3.0);
        is("ROUND[-2.5]", -3.0);
        is("SQRT[ABS[-16]]", 4.0);
        is("LN[EXP[2]]", 2.0);
        is("EXISTS[#<depth>]", 1.0);
        is("EXISTS[#<nobody>]", 0.0);
    }

    #[test]
    fn parameters_may_be_worked_out() {
        is("#2", 20.0);
        is("##1", 100.0);
        is("#[1+2]", 30.0);
        is("#<De pth>", 4.0);
        is("[#2*#<depth>]", 80.0);
        is("-#1", -10.0);
    }

    #[test]
    fn what_is_wrong_has_its_column() {
        let wrong = |text: &str| value(text).map_err(|error| (error.column, error.problem));
        assert_eq!(wrong("[1 + ]"), Err((6, Problem::NoValue)));
        assert_eq!(wrong("[1 / 0]"), Err((7, Problem::DivisionByZero)));
        assert_eq!(wrong("[1 2]"), Err((4, Problem::Expected(b']'))));
        assert_eq!(wrong("[1"), Err((3, Problem::Expected(b']'))));
        assert_eq!(wrong("SQRT[-1]"), Err((1, Problem::NotFinite)));
        assert_eq!(wrong("SINE[1]"), Err((4, Problem::Expected(b'['))));
        assert_eq!(wrong("#31"), Err((1, Problem::NoParameter)));
        assert_eq!(wrong("#1.5"), Err((1, Problem::NoParameter)));
        assert_eq!(wrong("#<nobody>"), Err((1, Problem::NoParameter)));
        assert_eq!(wrong("#<>"), Err((2, Problem::BadName)));
        assert_eq!(wrong(&"[".repeat(12)), Err((11, Problem::NestedTooDeep)));
        assert_eq!(wrong("[[-8] ** 0.5]"), Err((13, Problem::NotFinite)));
        assert_eq!(wrong("[0 ** -1 GT 2]"), Err((9, Problem::NotFinite)));
    }

    proptest! {
        /// Against the same sums done here.
        #[test]
        fn sums_of_products_come_out(terms in prop::collection::vec((-99_i32..100, 1_i32..20), 1..5)) {
            let text = terms.iter().map(|(a, b)| std::format!("{a}*{b}")).collect::<std::vec::Vec<_>>().join("+");
            let expected: i32 = terms.iter().map(|(a, b)| a * b).sum();
            prop_assert_eq!(value(&std::format!("[{text}]")), Ok(f64::from(expected)));
        }

        #[test]
        fn any_bytes_give_a_value_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..80)) {
            let mut reader = Reader::new(&bytes, 0, &Some30);
            if let Ok(value) = reader.value() {
                prop_assert!(value.is_finite() && reader.at <= bytes.len());
            }
        }

        #[test]
        fn what_looks_like_an_expression_never_runs_on(text in "[\\[\\]#<>0-9+*/a-z -]{0,60}") {
            let _ = value(&text);
        }
    }
}

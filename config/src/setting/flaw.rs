//! Flaws of values: why a text does not fit its setting, and the advice to mend it.

use super::PinRole;
use crate::pin::PinFlaw;
use crate::text::nearest;
use core::fmt;

/// Flaw of a value's text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Flaw<'t> {
    Empty,
    NotBool(&'t str),
    NotWhole(&'t str),
    /// A leading zero, which Smoothieware takes for octal.
    Octal(&'t str),
    NotNumber(&'t str),
    OutOfRange(f64, (f64, f64)),
    Count {
        found: usize,
        wanted: usize,
    },
    PlaceCount {
        found: usize,
        most: usize,
    },
    NotAWord(&'t str, &'static [&'static str]),
    TooLong {
        bytes: usize,
        longest: usize,
    },
    NotACode(&'t str),
    NotARegister(&'t str),
    RegisterCount(usize),
    NotAnAxis(char),
    NotAPin(&'t str, PinFlaw, PinRole),
    OtherPin(&'t str, PinRole),
    NotAVoltage(&'t str),
}

impl Flaw<'_> {
    /// Returns the description of the flaw.
    pub(crate) const fn reason(&self) -> Reason<'_> {
        Reason(self)
    }

    /// Returns the advice to mend the flaw.
    pub(crate) const fn fix(&self) -> Fix<'_> {
        Fix(self)
    }
}

pub(crate) struct Reason<'a>(&'a Flaw<'a>);
pub(crate) struct Fix<'a>(&'a Flaw<'a>);

/// Tiny lower bounds stand for "more than zero", huge upper ones for "any".
const fn is_more_than_zero(low: f64) -> bool {
    low > 0.0 && low <= 1e-6
}
const ANY: f64 = 1e6;

impl fmt::Display for Reason<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self.0 {
            Flaw::Empty => f.write_str("has no value"),
            // Smoothieware reads every other text as false, `yes` and `True` too.
            Flaw::NotBool(text) => write!(f, "'{text}' is neither true nor false"),
            Flaw::NotWhole(text) => write!(f, "'{text}' is not a whole number"),
            Flaw::Octal(text) => write!(f, "'{text}' begins with 0, which Smoothieware reads as octal"),
            Flaw::NotNumber(text) => write!(f, "'{text}' is not a number"),
            Flaw::OutOfRange(value, (low, _)) if value < low && is_more_than_zero(low) => {
                write!(f, "{value} is not more than 0")
            }
            Flaw::OutOfRange(value, (low, high)) if high >= ANY => {
                write!(f, "{value} is too {}", if value < low { "small" } else { "large" })
            }
            Flaw::OutOfRange(value, _) => write!(f, "{value} is out of range"),
            Flaw::Count { found, wanted } => write!(f, "has {found} values where {wanted} belong"),
            Flaw::PlaceCount { found, most } => {
                write!(f, "has {found} numbers; places are pairs of X and Y, at most {most} of them")
            }
            Flaw::NotAWord(text, _) => write!(f, "'{text}' is not one of the possible values"),
            Flaw::TooLong { bytes, longest } => write!(f, "is {bytes} bytes long, but at most {longest} fit"),
            Flaw::NotACode(text) => write!(f, "'{text}' is not a G or M code"),
            Flaw::NotARegister(text) => write!(f, "'{text}' is not a hexadecimal number of 20 bits"),
            Flaw::RegisterCount(count) => write!(f, "has {count} values where 5 belong"),
            Flaw::NotAnAxis(letter) => write!(f, "'{letter}' is not an axis, or is there twice"),
            Flaw::NotAPin(text, problem, _) => write!(f, "'{text}' {problem}"),
            Flaw::OtherPin(text, _) => write!(f, "'{text}' is another kind of pin"),
            Flaw::NotAVoltage(text) => write!(f, "'{text}' is not a voltage input"),
        }
    }
}

impl fmt::Display for Fix<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self.0 {
            Flaw::Empty => f.write_str("write one, or delete the line"),
            Flaw::NotBool(_) => f.write_str("write true or false"),
            Flaw::Octal(text) => write!(f, "write {}", text.trim_start_matches('0')),
            Flaw::NotWhole(text) | Flaw::NotNumber(text) => f.write_str(number_fix(text)),
            Flaw::OutOfRange(value, (low, _)) if value < low && is_more_than_zero(low) => {
                f.write_str("write more than 0")
            }
            Flaw::OutOfRange(value, (low, high)) if high >= ANY && value < low => write!(f, "write at least {low}"),
            Flaw::OutOfRange(_, (_, high)) if high >= ANY => f.write_str("check the unit"),
            Flaw::OutOfRange(_, (low, high)) => write!(f, "write {low} to {high}"),
            Flaw::Count { wanted, .. } => write!(f, "write {wanted} numbers with commas between"),
            Flaw::PlaceCount { .. } => f.write_str("write X,Y of each, as in 10,10 190,10"),
            Flaw::NotAWord(text, words) => match nearest(text, words.iter().copied()) {
                Some(word) => write!(f, "did you mean {word}?"),
                None => write!(f, "write {}", List(words)),
            },
            Flaw::TooLong { .. } => f.write_str("shorten it"),
            Flaw::NotACode(_) => f.write_str("write it as in M106 or M106.1"),
            Flaw::NotARegister(_) | Flaw::RegisterCount(_) => f.write_str("M911 prints the line to write"),
            Flaw::NotAnAxis(_) => f.write_str("write each of X Y Z A B C at most once, as in ZXY"),
            Flaw::NotAPin(_, _, role) | Flaw::OtherPin(_, role) => write!(f, "write {}, or nc for none", example(role)),
            Flaw::NotAVoltage(_) => f.write_str("write ADC3_0 to ADC3_5, as in ADC3_5,11"),
        }
    }
}

/// Returns the advice for a number with other characters behind it.
fn number_fix(text: &str) -> &'static str {
    if text.contains(';') {
        "comments begin with #"
    } else if text.contains(',') {
        "write one number, with a point for decimals"
    } else if gcode::read_f64(text).is_some() {
        "write its digits alone"
    } else {
        "write only the number, without unit"
    }
}

const fn example(role: PinRole) -> &'static str {
    match role {
        PinRole::Output => "a pin as in PE1",
        PinRole::Input | PinRole::Button | PinRole::Interrupt => "a pin as in PD0^",
        PinRole::OutputOrPwm => "a pin as in PE1 or a PWM channel as in PWM1_1",
        PinRole::Pwm => "a PWM channel as in PWM1_1",
        PinRole::Thermistor => "ADC1_0 to ADC1_6",
    }
}

/// `a, b or c`
pub(crate) struct List<'a>(pub(crate) &'a [&'a str]);

impl fmt::Display for List<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, word) in self.0.iter().enumerate() {
            match self.0.len() - index {
                _ if index == 0 => {}
                1 => f.write_str(" or ")?,
                _ => f.write_str(", ")?,
            }
            f.write_str(word)?;
        }
        Ok(())
    }
}

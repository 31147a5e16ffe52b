//! A row of the table of Klipper's commands, and the pieces of the line that one comes to.

use core::fmt::{self, Write};

use gcode::{Code, Extended};
use heapless::String;

/// A line of codes.
pub type CodeLine = String<{ gcode::MAX_LINE_LENGTH }>;

/// What the machine calls its parts.
pub trait Names {
    /// How codes switch an output of this name.
    fn switch(&self, name: &str) -> Option<NamedSwitch>;
    /// The code that sets the target of a heater of this name, and the heater's id.
    fn heater(&self, name: &str) -> Option<(Code, u8)>;
    /// The number of a strip of lights of this name.
    fn strip(&self, name: &str) -> Option<u8>;
    /// Whether there is any strip.
    fn has_strips(&self) -> bool;
    /// The same of the heaters in turn.
    fn heater_at(&self, place: usize) -> Option<(Code, u8)>;
}

/// How codes switch an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedSwitch {
    /// The code that switches it on.
    pub on: Code,
    /// P of that code, where it is the one of all outputs with numbers.
    pub number: Option<u8>,
    /// The code that switches it off, where there is one.
    pub off: Option<Code>,
    /// What S of full power is: 255, 100 for percent.
    pub full: f64,
}

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct ExtendedInfo {
    /// Its name; one that ends in `*` is the beginning of a name.
    pub name: &'static str,
    /// The parameters that it looks at.
    pub takes: &'static str,
    /// What it does here, in one line.
    pub help: &'static str,
    pub(super) becomes: Becomes,
}

/// What a command comes to.
#[derive(Clone, Copy, Debug)]
pub(super) enum Becomes {
    /// A line of codes.
    Codes(Translate),
    /// A console command.
    Console(&'static str),
    /// A setting that changes with the height of the part.
    Tower,
    /// Nothing, and the part is the same.
    PassedOver,
}

pub(super) type Translate = fn(&Extended<'_>, &dyn Names, &mut CodeLine) -> Result<(), ExtendedFault>;

/// Why a command is not carried out.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "their texts say it")]
pub enum ExtendedFault {
    Unknown,
    Missing(&'static str),
    MustSupply(&'static str),
    NotANumber(&'static str),
    ThreeLengths(&'static str),
    List(&'static str, usize),
    NoHeater,
    NoFan,
    NoStrip,
    TooLong,
}

impl fmt::Display for ExtendedFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Unknown => {
                f.write_str("is not known here; if it is a macro, write its commands into the file instead")
            }
            Self::Missing(what) => write!(f, "is not carried out here: {what}"),
            Self::MustSupply(key) => write!(f, "needs {key}="),
            Self::ThreeLengths(key) => write!(f, "needs three lengths for {key}=: AC,BD,AD"),
            Self::List(key, count) => write!(f, "needs {count} lengths for {key}=, with commas between"),
            Self::NotANumber(key) => write!(f, "needs a number for {key}="),
            Self::NoHeater => f.write_str("names no heater of this machine"),
            Self::NoFan => f.write_str("names no switch of this machine"),
            Self::NoStrip => f.write_str("names no strip of this machine"),
            Self::TooLong => f.write_str("is too long"),
        }
    }
}

#[cfg(feature = "docs")]
impl ExtendedInfo {
    /// Whether it is carried out, for a table.
    pub(crate) const fn kept(&self) -> &'static str {
        match self.becomes {
            Becomes::PassedOver => "left out: ",
            _ => "",
        }
    }
}

pub(super) const fn codes(
    name: &'static str,
    takes: &'static str,
    help: &'static str,
    write: Translate,
) -> ExtendedInfo {
    ExtendedInfo { name, takes, help, becomes: Becomes::Codes(write) }
}

pub(super) const fn passed_over(name: &'static str, help: &'static str) -> ExtendedInfo {
    ExtendedInfo { name, takes: "", help, becomes: Becomes::PassedOver }
}

// --- pieces of a line ---

pub(super) fn put(line: &mut CodeLine, text: &str) -> Result<(), ExtendedFault> {
    line.push_str(text).map_err(|_| ExtendedFault::TooLong)
}

/// A parameter that is to be a number.
pub(super) fn number(command: &Extended<'_>, key: &'static str) -> Result<Option<f64>, ExtendedFault> {
    let Some(text) = command.get(key) else { return Ok(None) };
    let number = text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    number.map(Some).ok_or(ExtendedFault::NotANumber(key))
}

/// Appends a word, or a code and its word.
pub(super) fn put_number(line: &mut CodeLine, before: &str, value: f64) -> Result<(), ExtendedFault> {
    write!(line, "{before}{value}").map_err(|_| ExtendedFault::TooLong)
}

/// What is said of an object, by its name.
pub(super) fn label(command: &Extended<'_>, what: &str, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    // Klipper: a definition without a name lists the objects.
    let Some(name) = command.get("NAME") else { return put(line, "M486") };
    put(line, "M486 ")?;
    put(line, what)?;
    put(line, name)
}

//! Row of the table of Klipper's commands, and helpers to write a line of codes.

use core::fmt::{self, Write};

use gcode::{Code, Extended};
use heapless::String;

/// Buffer for a line of codes.
pub type CodeLine = String<{ gcode::MAX_LINE_LENGTH }>;

/// Names that the machine's configuration gives to its parts.
pub trait Names {
    /// Returns the codes that set the output of this name.
    fn switch(&self, name: &str) -> Option<NamedSwitch>;
    /// Returns the code that sets the target of the heater of this name, and the heater's id.
    fn heater(&self, name: &str) -> Option<(Code, u8)>;
    /// Returns the number of the strip of lights of this name.
    fn strip(&self, name: &str) -> Option<u8>;
    /// Whether the machine has any strip of lights.
    fn has_strips(&self) -> bool;
    /// Returns code and id, as `heater` does, of the heater at this index.
    fn heater_at(&self, place: usize) -> Option<(Code, u8)>;
    /// Returns the letter, X to C, of the motor that Klipper's section of this name describes.
    fn motor(&self, name: &str) -> Option<char>;
}

/// Codes that set an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedSwitch {
    /// Code that switches the output on.
    pub on: Code,
    /// P word of that code, if the code is shared by all numbered outputs.
    pub number: Option<u8>,
    /// Code that switches the output off, if there is one.
    pub off: Option<Code>,
    /// Value of S for full power: 255, or 100 for percent.
    pub full: f64,
}

/// Row of the table: a Klipper command.
#[derive(Clone, Copy, Debug)]
pub struct ExtendedInfo {
    /// Name of the command; a name that ends in `*` is a prefix.
    pub name: &'static str,
    /// Parameters that the command reads.
    pub takes: &'static str,
    /// Help text of one line.
    pub help: &'static str,
    pub(super) becomes: Becomes,
}

/// Translation of a command.
#[derive(Clone, Copy, Debug)]
pub(super) enum Becomes {
    /// Line of codes, written by a function.
    Codes(Translate),
    /// Console command to run instead.
    Console(&'static str),
    /// Setting that changes with the height of the part (tuning tower).
    Tower,
    /// Nothing, without change to the part.
    PassedOver,
    /// Something that is kept for macros, beside the program.
    Macros,
    /// A refusal: the row's help is the reason.
    Refused,
}

pub(super) type Translate = fn(&Extended<'_>, &dyn Names, &mut CodeLine) -> Result<(), ExtendedFault>;

/// Reason why a command is not carried out.
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
    NoMotor,
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
            Self::NoMotor => f.write_str("names no motor of this machine: stepper_x, stepper_y, stepper_z, extruder"),
            Self::TooLong => f.write_str("is too long"),
        }
    }
}

#[cfg(feature = "docs")]
impl ExtendedInfo {
    /// Returns a remark for a table when the command is not carried out.
    pub(crate) const fn kept(&self) -> &'static str {
        match self.becomes {
            Becomes::PassedOver => "left out: ",
            Becomes::Refused => "refused: ",
            Becomes::Codes(_) | Becomes::Console(_) | Becomes::Tower | Becomes::Macros => "",
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

/// Parses a parameter as a number.
pub(super) fn number(command: &Extended<'_>, key: &'static str) -> Result<Option<f64>, ExtendedFault> {
    let Some(text) = command.get(key) else { return Ok(None) };
    let number = gcode::read_f64(text.trim()).filter(|number| number.is_finite());
    number.map(Some).ok_or(ExtendedFault::NotANumber(key))
}

/// Appends a word, or a code and its word.
pub(super) fn put_number(line: &mut CodeLine, before: &str, value: f64) -> Result<(), ExtendedFault> {
    write!(line, "{before}{value}").map_err(|_| ExtendedFault::TooLong)
}

/// Appends M486 with a letter and the object's name.
pub(super) fn label(command: &Extended<'_>, what: &str, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    // A definition without a name lists the objects, as in Klipper.
    let Some(name) = command.get("NAME") else { return put(line, "M486") };
    put(line, "M486 ")?;
    put(line, what)?;
    put(line, name)
}

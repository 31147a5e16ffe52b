//! What a row of the table says of a code.

use gcode::Code;

use crate::action::Function;
use crate::fault::{Fault, Part};
use crate::interpreter::{Context, Interpreter, Meaning};
use crate::state::States;

/// A part of the interpreter that says what a code means.
pub(crate) type Interpret = for<'b> fn(&mut Interpreter, &Context<'b>) -> Result<Meaning<'b>, Fault>;

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct CodeInfo {
    /// The code, subcode included.
    pub code: Code,
    /// Other subcodes of its number that have no row are read by this one.
    pub any_subcode: bool,
    /// The words it takes.
    pub words: &'static [WordInfo],
    /// One of them has bounds.
    pub(crate) is_bounded: bool,
    /// Its modal group: of two codes of one group, the later holds.
    pub group: Group,
    /// What it waits for.
    pub waits: Waits,
    /// States in which it runs; in others it is refused.
    pub states: States,
    /// A part that it cannot do without.
    pub part: Option<Part>,
    /// What it does, in one line.
    pub help: &'static str,
    /// What Smoothieware v2 does instead; empty where it does the same.
    pub difference: Doc,
    pub(crate) handler: Handler,
}

/// Who does what a code asks for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Handler {
    /// The interpreter says what it means.
    Interpret(Interpret),
    /// The machine does it.
    Function(Function),
    /// The interpreter does it, and has the machine do something in some cases.
    Both(Interpret, Function),
    /// A tool is selected.
    Tool,
    /// What the configuration says; nobody knows it where that says nothing.
    Claimed,
    /// It is accepted, and there is nothing to do.
    Nothing,
}

/// Modal groups (NIST RS-274/NGC, section 3.4), and those of the printers' codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum Group {
    /// It holds for its own line.
    NonModal,
    Motion,
    Plane,
    Units,
    Distance,
    ExtruderDistance,
    CoordinateSystem,
    ToolLength,
    PathControl,
    Stopping,
    Spindle,
}

/// What a code waits for before its next one is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Waits {
    /// Nothing: it only says or sets something.
    Nothing,
    /// Room in the look-ahead queue: it is a move, or it acts where the path has come this far.
    Path,
    /// Standstill, before it acts.
    Standstill,
    /// Standstill, and its own end: what it finds decides what follows.
    Result,
    /// It is a question, and answered whatever the machine waits for.
    Question,
}

impl Waits {
    /// In one word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nothing => "no",
            Self::Path => "rides",
            Self::Standstill => "standstill",
            Self::Result => "its end",
            Self::Question => "question",
        }
    }
}

/// A word that a code takes.
#[derive(Clone, Copy, Debug)]
pub struct WordInfo {
    /// Its letter.
    pub letter: char,
    /// What its number is.
    pub unit: Unit,
    /// What numbers are allowed.
    pub bounds: Bounds,
    /// What it is for.
    pub text: Doc,
}

/// What the number of a word is, as it is written; [`crate::Words`] gives it in mm, s, mm/s and A.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// mm, or inches where the program counts in them.
    Length,
    /// The same, a minute.
    Feed,
    /// Steps for each mm or inch.
    StepsPerLength,
    /// mm, whatever the program counts in.
    Mm,
    /// mm/min.
    MmPerMinute,
    /// mm/s.
    MmPerSecond,
    /// mm/s2.
    MmPerSecond2,
    /// s.
    Seconds,
    /// ms.
    Milliseconds,
    /// The dialect's unit of time.
    Dwell,
    /// Degrees Celsius.
    Celsius,
    /// Percent.
    Percent,
    /// A.
    Amps,
    /// mA.
    Milliamps,
    /// A plain number.
    Number,
    /// The number of a tool or heater.
    Id,
    /// Nothing: that it is there is enough.
    Flag,
}

impl Unit {
    /// As a reader knows it; empty for plain numbers.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Length => "length",
            Self::Feed => "length/min",
            Self::StepsPerLength => "steps/length",
            Self::Mm => "mm",
            Self::MmPerMinute => "mm/min",
            Self::MmPerSecond => "mm/s",
            Self::MmPerSecond2 => "mm/s2",
            Self::Seconds => "s",
            Self::Milliseconds => "ms",
            Self::Dwell => "ms, in GRBL's dialect s",
            Self::Celsius => "C",
            Self::Percent => "%",
            Self::Amps => "A",
            Self::Milliamps => "mA",
            Self::Number | Self::Id | Self::Flag => "",
        }
    }
}

/// What numbers a word may have, as written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bounds {
    /// Any.
    Any,
    /// This or more.
    AtLeast(f64),
    /// More than this.
    Above(f64),
    /// From this to that.
    Within(f64, f64),
    /// Whole, from this to that.
    Whole(f64, f64),
}

/// Text that only documentation needs. The image does not carry it.
#[derive(Clone, Copy, Debug)]
pub struct Doc {
    #[cfg(feature = "docs")]
    text: &'static str,
}

/// Text for the documentation.
#[cfg_attr(not(feature = "docs"), allow(unused_variables, reason = "then nobody reads it"))]
pub(crate) const fn doc(text: &'static str) -> Doc {
    Doc {
        #[cfg(feature = "docs")]
        text,
    }
}

#[cfg(feature = "docs")]
impl Doc {
    /// The text.
    #[must_use]
    pub const fn text(self) -> &'static str {
        self.text
    }
}

/// Runs in every state but with a configuration that cannot be used: ends, power, reports.
pub(crate) const EVERYWHERE_BUT_INVALID: States = States::WORKING_OR_ALARM;
/// Runs in every state.
pub(crate) const ANYWHERE: States = States::ALL;
/// Needs the card alone.
pub(crate) const FILES: States = States::WORKING_OR_INVALID;

/// A word of any value.
pub(crate) const fn word(letter: char, unit: Unit, text: &'static str) -> WordInfo {
    WordInfo { letter, unit, bounds: Bounds::Any, text: doc(text) }
}

impl WordInfo {
    /// This or more.
    pub const fn least(mut self, least: f64) -> Self {
        self.bounds = Bounds::AtLeast(least);
        self
    }

    /// More than this.
    pub const fn above(mut self, bound: f64) -> Self {
        self.bounds = Bounds::Above(bound);
        self
    }

    /// From this to that.
    pub const fn within(mut self, least: f64, most: f64) -> Self {
        self.bounds = Bounds::Within(least, most);
        self
    }

    /// Whole, from this to that.
    pub const fn whole(mut self, least: f64, most: f64) -> Self {
        self.bounds = Bounds::Whole(least, most);
        self
    }
}

impl CodeInfo {
    const fn new(code: Code, handler: Handler, help: &'static str) -> Self {
        Self {
            code,
            any_subcode: false,
            words: &[],
            is_bounded: false,
            group: Group::NonModal,
            waits: Waits::Nothing,
            states: States::WORKING,
            part: None,
            help,
            difference: doc(""),
            handler,
        }
    }

    /// A code that the interpreter knows the meaning of.
    pub(crate) const fn means(code: Code, interpret: Interpret, help: &'static str) -> Self {
        Self::new(code, Handler::Interpret(interpret), help)
    }

    /// A code that the machine carries out.
    pub(crate) const fn asks(code: Code, function: Function, help: &'static str) -> Self {
        Self::new(code, Handler::Function(function), help)
    }

    /// A code that the interpreter carries out, and the machine in some cases.
    pub(crate) const fn either(code: Code, interpret: Interpret, function: Function, help: &'static str) -> Self {
        Self::new(code, Handler::Both(interpret, function), help)
    }

    /// A code that does what the configuration says: see [`crate::Claims`].
    pub(crate) const fn claimed(code: Code, help: &'static str) -> Self {
        Self::new(code, Handler::Claimed, help)
    }

    /// A code that is accepted and does nothing.
    pub(crate) const fn accepted(code: Code, help: &'static str) -> Self {
        Self::new(code, Handler::Nothing, help)
    }

    /// How T is read.
    pub(crate) const fn tool(help: &'static str) -> Self {
        Self::new(Code::t(0), Handler::Tool, help)
    }

    pub(crate) const fn takes(mut self, words: &'static [WordInfo]) -> Self {
        self.words = words;
        let mut index = 0;
        while index < words.len() {
            self.is_bounded |= !matches!(words[index].bounds, Bounds::Any);
            index += 1;
        }
        self
    }

    pub(crate) const fn any_subcode(mut self) -> Self {
        self.any_subcode = true;
        self
    }

    pub(crate) const fn group(mut self, group: Group) -> Self {
        self.group = group;
        self
    }

    pub(crate) const fn waits(mut self, waits: Waits) -> Self {
        self.waits = waits;
        self
    }

    pub(crate) const fn states(mut self, states: States) -> Self {
        self.states = states;
        self
    }

    pub(crate) const fn part(mut self, part: Part) -> Self {
        self.part = Some(part);
        self
    }

    pub(crate) const fn differs(mut self, text: &'static str) -> Self {
        self.difference = doc(text);
        self
    }

    /// What a letter means here.
    #[must_use]
    pub fn word(&self, letter: char) -> Option<&'static WordInfo> {
        self.words.iter().find(|word| word.letter == letter.to_ascii_uppercase())
    }
}

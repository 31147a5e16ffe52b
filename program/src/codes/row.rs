//! A row of the table of codes, and its parts.

use gcode::{Block, Code, letter_bit};

use crate::context::{Context, Meaning};
use crate::fault::{Fault, Part};
use crate::function::Function;
use crate::interpreter::Interpreter;
use crate::states::States;
use crate::word::{Bounds, Doc, WordInfo, doc};
use crate::words::{Lengths, Words};

/// Interpreter function that gives the meaning of a code's block.
pub(crate) type Interpret = for<'b> fn(&mut Interpreter, &Context<'b>) -> Result<Meaning<'b>, Fault>;

/// Row of the table: everything known about a code.
#[derive(Clone, Copy, Debug)]
pub struct CodeInfo {
    /// Code of the row, subcode included.
    pub code: Code,
    /// Whether the row also reads subcodes of its number that have no row.
    pub any_subcode: bool,
    /// Words that the code takes.
    pub words: &'static [WordInfo],
    /// Set of the words' letters, [`gcode::letter_bit`] each.
    pub(crate) letters: u32,
    /// Whether any of the words has bounds.
    pub(crate) is_bounded: bool,
    /// Modal group of the code: the later of two codes of a group replaces the earlier.
    pub group: Group,
    /// Condition that the code waits for.
    pub waits: Waits,
    /// States in which the code runs; other states refuse the code.
    pub states: States,
    /// Part of the machine that the code needs.
    pub part: Option<Part>,
    /// Whether a file that loses this code makes another part, or harms somebody: the file waits for a
    /// person.
    pub is_needed: bool,
    /// Whether the code levels the bed or prepares that; a job on a machine without probe and leveling skips
    /// the code.
    pub levels: bool,
    /// Help text of one line.
    pub help: &'static str,
    /// Difference from Smoothieware v2; empty without one.
    pub difference: Doc,
    pub(crate) handler: Handler,
}

/// Executor of a code.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Handler {
    /// Interpreter function for the meaning.
    Interpret(Interpret),
    /// Function of the machine.
    Function(Function),
    /// Interpreter function that passes some cases on to the machine.
    Both(Interpret, Function),
    /// Selection of a tool (T).
    Tool,
    /// Effect that the configuration assigns; without one, the code is unknown.
    Claimed,
    /// Accepted code with nothing to do.
    Nothing,
    /// Accepted code that is not carried out, and whose loss does not change the part.
    PassedOver,
    /// Known code that is refused.
    Missing,
}

/// Modal groups (NIST RS-274/NGC, section 3.4), and those of the printers' codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum Group {
    /// Non-modal code, for its own line only.
    NonModal,
    Motion,
    Plane,
    Units,
    Distance,
    ExtruderDistance,
    CoordinateSystem,
    ToolLength,
    PathControl,
    FeedMode,
    ArcDistance,
    CutterCompensation,
    RetractMode,
    Stopping,
    ToolChange,
    SpindleSpeed,
    Overrides,
    SavedModes,
    Diameter,
    Spindle,
}

/// Condition that a code waits for before the next code is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Waits {
    /// No wait: the code only reports or sets something.
    Nothing,
    /// Room in the look-ahead queue, for a move or a change at the current end of the path.
    Path,
    /// Standstill before the code acts.
    Standstill,
    /// Standstill, and the code's own end, because its result decides how the program goes on.
    Result,
    /// No wait: a question, answered whatever the machine waits for.
    Question,
}

impl Waits {
    /// Returns a name for the tables of the documentation.
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

/// States of ends, power and reports: all but an unusable configuration.
pub(crate) const EVERYWHERE_BUT_INVALID: States = States::WORKING_OR_ALARM;
/// All states, without exception.
pub(crate) const ANYWHERE: States = States::ALL;
/// States of codes that need only the card.
pub(crate) const FILES: States = States::WORKING_OR_INVALID;

impl CodeInfo {
    const fn new(code: Code, handler: Handler, help: &'static str) -> Self {
        Self {
            code,
            any_subcode: false,
            words: &[],
            letters: 0,
            is_bounded: false,
            group: Group::NonModal,
            waits: Waits::Nothing,
            states: States::WORKING,
            part: None,
            is_needed: false,
            levels: false,
            help,
            difference: doc(""),
            handler,
        }
    }

    /// Row of a code whose meaning the interpreter knows.
    pub(crate) const fn means(code: Code, interpret: Interpret, help: &'static str) -> Self {
        Self::new(code, Handler::Interpret(interpret), help)
    }

    /// Row of a code that the machine carries out.
    pub(crate) const fn asks(code: Code, function: Function, help: &'static str) -> Self {
        Self::new(code, Handler::Function(function), help)
    }

    /// Row of a code that the interpreter carries out, or the machine in some cases.
    pub(crate) const fn either(code: Code, interpret: Interpret, function: Function, help: &'static str) -> Self {
        Self::new(code, Handler::Both(interpret, function), help)
    }

    /// Row of a code that the configuration gives a meaning to; see [`crate::Claims`].
    pub(crate) const fn claimed(code: Code, help: &'static str) -> Self {
        Self::new(code, Handler::Claimed, help)
    }

    /// Row of a code that is accepted and does nothing.
    pub(crate) const fn accepted(code: Code, help: &'static str) -> Self {
        Self::new(code, Handler::Nothing, help)
    }

    /// Row of a code that is accepted but not carried out, without change to the part.
    pub(crate) const fn passed_over(code: Code, help: &'static str) -> Self {
        Self::new(code, Handler::PassedOver, help)
    }

    /// Row of a known code that is refused, because its loss makes another part or harms somebody.
    pub(crate) const fn missing(code: Code, help: &'static str) -> Self {
        Self::new(code, Handler::Missing, help).needed()
    }

    /// Whether the code is known but refused.
    #[must_use]
    pub const fn is_missing(&self) -> bool {
        matches!(self.handler, Handler::Missing)
    }

    /// Whether the code is accepted but not carried out, without change to the part.
    #[must_use]
    pub const fn is_passed_over(&self) -> bool {
        matches!(self.handler, Handler::PassedOver)
    }

    /// Row of T, the tool selection.
    pub(crate) const fn tool(help: &'static str) -> Self {
        Self::new(Code::t(0), Handler::Tool, help)
    }

    pub(crate) const fn takes(mut self, words: &'static [WordInfo]) -> Self {
        self.words = words;
        let mut index = 0;
        while index < words.len() {
            self.letters |= letter_bit(words[index].letter());
            self.is_bounded |= !matches!(words[index].bounds, Bounds::Any);
            index += 1;
        }
        self
    }

    pub(crate) const fn needed(mut self) -> Self {
        self.is_needed = true;
        self
    }

    pub(crate) const fn levels(mut self) -> Self {
        self.levels = true;
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

    /// Returns the words of a block as the row reads them.
    pub(crate) const fn words_of<'b>(&self, block: &'b Block<'b>, lengths: Lengths) -> Words<'b> {
        Words::new(block, self.code, self.words, lengths)
    }
}

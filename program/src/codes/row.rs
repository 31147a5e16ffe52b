//! What a row of the table says of a code.

use gcode::{Block, Code, letter_bit};

use crate::action::Function;
use crate::context::{Context, Meaning};
use crate::fault::{Fault, Part};
use crate::interpreter::Interpreter;
use crate::state::States;
use crate::word::{Bounds, Doc, WordInfo, doc};
use crate::words::{Lengths, Words};

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
    /// Their letters, [`gcode::letter_bit`] each.
    pub(crate) letters: u32,
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
    /// A file in which it is not carried out makes another part, or harms somebody: the file waits for a
    /// person.
    pub is_needed: bool,
    /// It levels the bed, or prepares that: a job leaves it out on a machine with no probe and no leveling.
    pub levels: bool,
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
    /// It is accepted and not carried out; a file that is played makes the same part.
    PassedOver,
    /// It is known, and not carried out.
    Missing,
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

/// Runs in every state but with a configuration that cannot be used: ends, power, reports.
pub(crate) const EVERYWHERE_BUT_INVALID: States = States::WORKING_OR_ALARM;
/// Runs in every state.
pub(crate) const ANYWHERE: States = States::ALL;
/// Needs the card alone.
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

    /// A code that is accepted and not carried out, which leaves the part as it is.
    pub(crate) const fn passed_over(code: Code, help: &'static str) -> Self {
        Self::new(code, Handler::PassedOver, help)
    }

    /// A code that is known and not carried out, which makes another part or harms somebody.
    pub(crate) const fn missing(code: Code, help: &'static str) -> Self {
        Self::new(code, Handler::Missing, help).needed()
    }

    /// Whether it is known, and not carried out.
    #[must_use]
    pub const fn is_missing(&self) -> bool {
        matches!(self.handler, Handler::Missing)
    }

    /// Whether it is accepted and not carried out, which leaves the part as it is.
    #[must_use]
    pub const fn is_passed_over(&self) -> bool {
        matches!(self.handler, Handler::PassedOver)
    }

    /// How T is read.
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

    /// The words of a block as this row reads them.
    pub(crate) const fn words_of<'b>(&self, block: &'b Block<'b>, lengths: Lengths) -> Words<'b> {
        Words::new(block, self.code, self.words, lengths)
    }
}

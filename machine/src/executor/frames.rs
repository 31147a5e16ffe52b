//! What lines have started and that is to be done before the next line: scripts of the configuration, files
//! of saved settings, and what follows them. A stack: what was started last goes first, so a script may start
//! another one.

use gcode::{Code, LineBuffer};
use heapless::Vec;
use program::{LeftHole, OperatorModes, ScriptModes};

use super::source::Source;
use crate::failure::{Answer, KeptFailure};
use crate::files::Path;
use crate::journal::Step;
use crate::ports::FileHandle;
use crate::probing::Plan;
use crate::sessions::{LineBytes, Recipient};

/// Frames at most: a script that suspends within a line of a file of settings.
const MOST: usize = 8;

/// Where a line goes on.
#[derive(Clone, Copy, Debug)]
pub(super) enum NextCode {
    /// Its next code is looked for here, bytes from its beginning.
    At(usize),
    /// It is read in RS-274's order: where its codes begin, and the place of its next code in that order.
    Ordered { begins: usize, place: usize },
}

/// The rest of a line, of which a command has started something.
#[derive(Debug)]
pub(super) struct Rest {
    pub line: LineBytes,
    pub next: NextCode,
    pub source: Source,
    /// The last command that was carried out.
    pub last: Option<Code>,
    /// What is answered when its end is reached; its sender may have his answer already.
    pub answer: Answer,
}

/// A file of settings that is being replayed.
#[derive(Debug)]
pub(super) struct Replay {
    pub file: FileHandle,
    pub path: Path,
    /// Who asked, and hears of the end.
    pub asked: Recipient,
    /// He asked by the command `load`, not by M501.
    pub by_load: bool,
    /// The program counts in inches; the file never does.
    pub inches: bool,
    pub gathering: LineBuffer,
    pub chunk: Vec<u8, 128>,
    pub next: usize,
    pub at_end: bool,
}

/// What is done once a stall has stopped a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StallStep {
    /// Z rises, and the file is read up to where the job was.
    Lift,
    /// That has been done: the job is suspended there.
    Suspend,
}

/// What is done when a script has ended.
#[derive(Clone, Debug)]
pub(super) enum Then {
    /// The bed is probed by this grid; whoever asked hears how it goes.
    TouchGrid(Plan, Recipient),
    /// What came before the script ended like this.
    Ended(Result<(), KeptFailure>),
    /// A job is gone on with after a power cut: the next step of that.
    Recover(Step, Recipient),
    /// A stall has stopped the job: the next step of getting over it.
    Stalled(StallStep),
    /// The job is suspended.
    Suspended,
    /// The job goes on.
    Resumed,
    /// The lines before the one that a job is to begin with have been read over.
    PlayFrom(Recipient),
}

/// A line of the configuration.
#[derive(Debug)]
pub(super) struct Script<'c> {
    pub text: &'c str,
    /// Where its next command is looked for, bytes.
    pub next: usize,
    /// The program's modes, from its first command on.
    pub modes: Option<ScriptModes>,
}

/// One thing to be done.
#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "the stack is short and in place: there is no heap to put the large ones on"
)]
pub(super) enum Frame<'c> {
    Rest(Rest),
    Replay(Replay),
    Script(Script<'c>),
    /// The startup lines of GRBL's dialect from this one on.
    Startup(u8),
    Then(Then),
    /// Lines of the job are read up to a place, and not carried out.
    FastForward,
    /// The job goes on, with these modes, once the operator has done what it was asked for.
    Operator(OperatorModes),
    /// A hole that the operator draws the tool out of, and those behind it in its line.
    Hole(LeftHole),
    /// The script before a tool change has ended: the operator is to put this one in.
    ToolChange(u32),
}

/// The stack.
#[derive(Debug, Default)]
pub(super) struct Frames<'c> {
    frames: Vec<Frame<'c>, MOST>,
}

impl<'c> Frames<'c> {
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Puts something on top. False when there is no room: scripts that start each other.
    #[must_use]
    pub fn push(&mut self, frame: Frame<'c>) -> bool {
        self.frames.push(frame).is_ok()
    }

    /// Puts a line of the configuration on top. False when there is no room.
    #[must_use]
    pub fn push_script(&mut self, text: &'c str) -> bool {
        self.push(Frame::Script(Script { text, next: 0, modes: None }))
    }

    /// Puts something below what was started since the stack had this height.
    #[must_use]
    pub fn push_below(&mut self, height: usize, frame: Frame<'c>) -> bool {
        self.frames.insert(height.min(self.frames.len()), frame).is_ok()
    }

    /// Drops what was started since the stack had this height.
    pub fn drop_down_to(&mut self, height: usize) {
        self.frames.truncate(height);
    }

    /// Whether this line of the configuration is being run.
    pub fn run_script(&self, line: &str) -> bool {
        self.frames.iter().any(|frame| matches!(frame, Frame::Script(script) if core::ptr::eq(script.text, line)))
    }

    /// What is next is a script around a suspension.
    pub fn is_around_suspension(&self) -> bool {
        let below = self.frames.len().checked_sub(2).and_then(|place| self.frames.get(place));
        matches!(below, Some(Frame::Then(Then::Suspended | Then::Resumed)))
    }

    /// What is next waits for the operator.
    pub fn wait_for_operator(&self) -> bool {
        matches!(self.frames.last(), Some(Frame::Operator(_)))
    }

    /// What is next are lines of the job that are only read.
    pub fn fast_forward(&self) -> bool {
        matches!(self.frames.last(), Some(Frame::FastForward))
    }

    /// Drops what was started last.
    pub fn drop_top(&mut self) {
        self.frames.truncate(self.frames.len().saturating_sub(1));
    }

    pub fn pop(&mut self) -> Option<Frame<'c>> {
        self.frames.pop()
    }

    pub fn top(&mut self) -> Option<&mut Frame<'c>> {
        self.frames.last_mut()
    }
}

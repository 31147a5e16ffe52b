//! Work that lines have started and that comes before the next line: scripts of the configuration, files of
//! saved settings, and what follows them. A stack: the entry started last goes first, so a script may start
//! another one.

use base::failure::{Answer, KeptFailure};
use base::paths::Path;
use base::ports::FileHandle;
use base::sessions::{LineBytes, Recipient};
use gcode::{Code, LineBuffer};
use heapless::Vec;
use procedures::probing::Plan;
use program::{LeftHole, OperatorModes, ScriptModes};

use crate::machine::source::Source;

/// Greatest number of frames: a script that suspends within a line of a file of settings.
const MOST: usize = 8;

/// Place at which a line goes on.
#[derive(Clone, Copy, Debug)]
pub(crate) enum NextCode {
    /// Offset at which the next code is looked for, bytes from the line's beginning.
    At(usize),
    /// Place in RS-274's order of execution: the offset of the line's codes, and the place of the next code.
    Ordered { begins: usize, place: usize },
}

/// The rest of a line, of which a command has started something.
#[derive(Debug)]
pub(crate) struct Rest {
    pub line: LineBytes,
    pub next: NextCode,
    pub source: Source,
    /// Last command that was carried out.
    pub last: Option<Code>,
    /// Answer at the end of the line; the sender may have been answered already.
    pub answer: Answer,
}

/// A file of settings that is being replayed.
#[derive(Debug)]
pub(crate) struct Replay {
    pub file: FileHandle,
    pub path: Path,
    /// Recipient that asked, and hears of the end.
    pub asked: Recipient,
    /// Asked for by the command `load`, not by M501.
    pub by_load: bool,
    /// The program counts in inches; the file never does.
    pub inches: bool,
    pub gathering: LineBuffer,
    pub chunk: Vec<u8, 128>,
    pub next: usize,
    pub at_end: bool,
}

/// Step that follows the end of a script.
#[derive(Clone, Debug)]
pub(crate) enum Then<S> {
    /// The bed is probed by this grid; whoever asked hears how it goes.
    TouchGrid(Plan, Recipient),
    /// The work before the script ended with this result.
    Ended(Result<(), KeptFailure>),
    /// The next step of a feature's sequence.
    Step(S),
    /// The job is suspended.
    Suspended,
    /// The job goes on.
    Resumed,
}

/// A line of the configuration.
#[derive(Debug)]
pub(crate) struct Script<'c> {
    pub text: &'c str,
    /// Offset of the next command in the text, bytes.
    pub next: usize,
    /// The program's modes, from its first command on.
    pub modes: Option<ScriptModes>,
}

/// Entry of the stack: one thing to be done.
#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "the stack is short and in place: there is no heap to put the large ones on"
)]
pub(crate) enum Frame<'c, S> {
    Rest(Rest),
    Replay(Replay),
    Script(Script<'c>),
    /// The startup lines from this one on.
    Startup(u8),
    Then(Then<S>),
    /// Lines of the job are read up to a place, and not carried out.
    FastForward,
    /// The job goes on, with these modes, once the operator has done what it was asked for.
    Operator(OperatorModes),
    /// A hole that the operator draws the tool out of, and those behind it in its line.
    Hole(LeftHole),
    /// The script before a tool change has ended: the operator is to put this one in.
    ToolChange(u32),
}

/// Stack of work to be done.
#[derive(Debug)]
pub(crate) struct Frames<'c, S> {
    frames: Vec<Frame<'c, S>, MOST>,
}

impl<S> Default for Frames<'_, S> {
    fn default() -> Self {
        Self { frames: Vec::new() }
    }
}

impl<'c, S> Frames<'c, S> {
    /// Returns the number of frames.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Returns whether nothing is in work.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Pushes a frame. False when there is no room: scripts that start each other.
    #[must_use]
    pub fn push(&mut self, frame: Frame<'c, S>) -> bool {
        self.frames.push(frame).is_ok()
    }

    /// Pushes a line of the configuration. False when there is no room.
    #[must_use]
    pub fn push_script(&mut self, text: &'c str) -> bool {
        self.push(Frame::Script(Script { text, next: 0, modes: None }))
    }

    /// Puts a frame below those started since the stack had this height.
    #[must_use]
    pub fn push_below(&mut self, height: usize, frame: Frame<'c, S>) -> bool {
        self.frames.insert(height.min(self.frames.len()), frame).is_ok()
    }

    /// Drops all frames started since the stack had this height.
    pub fn drop_down_to(&mut self, height: usize) {
        self.frames.truncate(height);
    }

    /// Whether this line of the configuration is being run.
    pub fn run_script(&self, line: &str) -> bool {
        self.frames.iter().any(|frame| matches!(frame, Frame::Script(script) if core::ptr::eq(script.text, line)))
    }

    /// Whether the next frame is a script around a suspension.
    pub fn is_around_suspension(&self) -> bool {
        let below = self.frames.len().checked_sub(2).and_then(|place| self.frames.get(place));
        matches!(below, Some(Frame::Then(Then::Suspended | Then::Resumed)))
    }

    /// Whether the next frame waits for the operator.
    pub fn wait_for_operator(&self) -> bool {
        matches!(self.frames.last(), Some(Frame::Operator(_)))
    }

    /// Whether the next frame reads lines of the job without carrying them out.
    pub fn fast_forward(&self) -> bool {
        matches!(self.frames.last(), Some(Frame::FastForward))
    }

    /// Notes that whoever waits for the work in progress has its answer already.
    pub fn was_answered(&mut self) {
        let waits = self.frames.iter_mut().rev().find_map(|frame| match frame {
            Frame::Rest(rest) if !rest.source.is_macros() => Some(rest),
            _ => None,
        });
        if let Some(rest) = waits {
            rest.answer = Answer::Said;
        }
    }

    /// Whether whoever waits for the work in progress has its answer already.
    pub fn are_answered(&self) -> bool {
        let waits = |frame: &Frame<'_, S>| matches!(frame, Frame::Rest(rest) if !rest.source.is_macros() && rest.answer == Answer::Said);
        self.frames.iter().any(waits)
    }

    /// Steps of features' sequences that wait, the first started first.
    pub fn steps(&self) -> impl Iterator<Item = &S> {
        self.frames.iter().filter_map(|frame| match frame {
            Frame::Then(Then::Step(step)) => Some(step),
            _ => None,
        })
    }

    /// Returns the step that comes next, if one does.
    pub fn next_step(&self) -> Option<&S> {
        match self.frames.last() {
            Some(Frame::Then(Then::Step(step))) => Some(step),
            _ => None,
        }
    }

    /// Drops the frame that was started last.
    pub fn drop_top(&mut self) {
        self.frames.truncate(self.frames.len().saturating_sub(1));
    }

    /// Takes the topmost frame off.
    pub fn pop(&mut self) -> Option<Frame<'c, S>> {
        self.frames.pop()
    }

    /// Returns the topmost frame.
    pub fn top(&mut self) -> Option<&mut Frame<'c, S>> {
        self.frames.last_mut()
    }
}

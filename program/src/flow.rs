//! Subroutines, conditions and loops: which line of a program comes next.
//!
//! The lines themselves are whoever's who reads them: here stands what has been called and opened, and which
//! lines are passed over. A subroutine is known from the place where it stands once that has been passed;
//! before that, the program is searched forwards for it.

use core::fmt;

use gcode::expression::Name;
use gcode::{FlowLine, FlowWord, SyntaxError};
use heapless::Vec;

use crate::memory::{LOCALS, Locals};

/// Subroutines that call each other, at most.
pub(crate) const MOST_CALLS: usize = 10;
/// Conditions and loops within each other, at most.
const MOST_OPEN: usize = 24;
/// Subroutines whose places are known, at most; others are searched for.
const MOST_PLACES: usize = 32;

/// A place between two lines of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Bytes from the file's beginning.
    pub offset: u32,
    /// Lines before it.
    pub line: u32,
}

/// What line comes next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Next {
    /// The one that follows.
    Following,
    /// The one at this place of the same file.
    At(Place),
    /// The first one of the file of this subroutine, if there is such a file; else tell
    /// [`Flow::search`], and the next is the one that follows.
    FirstOf(Name),
    /// The one that follows the call in the file before: this file is done with.
    Returned,
}

/// A subroutine that runs.
#[derive(Clone, Debug)]
struct Call {
    label: Name,
    /// Where it was called.
    back: Place,
    /// It has a file of its own.
    has_file: bool,
    /// The caller's own parameters; none for one that shares them (M98).
    callers: Option<Locals>,
    /// How many conditions and loops were open.
    open: usize,
    /// How often it runs yet, where it begins (M98 L).
    again: Option<(u32, Place)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    If,
    While,
    Do,
    /// So many turns are left, this one among them.
    Repeat(u32),
}

/// A condition or a loop that has begun.
#[derive(Clone, Debug)]
struct Open {
    label: Name,
    kind: Kind,
    /// Where the next turn begins.
    turn: Place,
}

/// Up to where lines are passed over.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Passing {
    /// The end of a subroutine that was not called.
    Sub(Name),
    /// The beginning of one that was.
    ToSub(Name),
    /// `elseif`, `else` or `endif`.
    ToElse(Name),
    /// `endif`.
    ToEndIf(Name),
    /// Behind the end of a loop.
    BehindLoop(Name),
    /// The end of a loop.
    ToLoopEnd(Name),
}

/// What has been called and opened.
#[derive(Clone, Debug, Default)]
pub struct Flow {
    calls: Vec<Call, MOST_CALLS>,
    open: Vec<Open, MOST_OPEN>,
    passing: Option<Passing>,
    /// Where subroutines begin, and how many files were open.
    places: Vec<(u8, Name, Place), MOST_PLACES>,
    /// Files that calls have opened.
    files: u8,
}

/// Why a line with an O word cannot be carried out, or a file cannot end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlowFault {
    /// The label that is meant.
    pub label: Name,
    /// What is wrong.
    pub problem: FlowProblem,
}

/// What is wrong with a line with an O word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "their texts say it")]
pub enum FlowProblem {
    Syntax(SyntaxError),
    /// The word has no value.
    NoValue(FlowWord),
    /// The word ends, or goes on with, what is not the innermost of what is open.
    NotOpen(FlowWord),
    OpenTooDeep,
    CalledTooDeep,
    TooManyValues,
    NoSuchSub,
    Unclosed,
}

impl fmt::Display for FlowFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let label = &self.label;
        match self.problem {
            FlowProblem::Syntax(error) if label.is_empty() => write!(f, "the label: {error}"),
            FlowProblem::Syntax(error) => write!(f, "O{label}: {error}"),
            FlowProblem::NoValue(word) => write!(f, "O{label} {} needs a value in brackets", word.name()),
            FlowProblem::NotOpen(word) => {
                write!(f, "O{label} {} does not belong to what was begun last and is not ended", word.name())
            }
            FlowProblem::OpenTooDeep => write!(f, "O{label}: more than {MOST_OPEN} conditions and loops in each other"),
            FlowProblem::CalledTooDeep => write!(f, "O{label}: more than {MOST_CALLS} subroutines call each other"),
            FlowProblem::TooManyValues => write!(f, "O{label}: a subroutine takes {LOCALS} values at most"),
            FlowProblem::NoSuchSub => write!(f, "O{label}: there is no such subroutine, in the file or as a file"),
            FlowProblem::Unclosed => write!(f, "O{label} is not ended"),
        }
    }
}

fn wrong(line: &FlowLine<'_>, problem: FlowProblem) -> FlowFault {
    FlowFault { label: line.label.clone(), problem }
}

/// The one value of a condition.
fn value(line: &FlowLine<'_>, values: &[f64]) -> Result<f64, FlowFault> {
    values.first().copied().ok_or(wrong(line, FlowProblem::NoValue(line.word)))
}

impl Flow {
    /// Whether lines are passed over: only those with an O word are of interest.
    #[must_use]
    pub const fn passes_over(&self) -> bool {
        self.passing.is_some()
    }

    /// How many subroutines run.
    pub(crate) fn depth(&self) -> usize {
        self.calls.len()
    }

    /// Nothing was called or opened.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.calls.is_empty() && self.open.is_empty() && self.passing.is_none()
    }

    /// The program has ended, or will not go on. In place: it is large.
    pub(crate) fn reset(&mut self) {
        self.calls.clear();
        self.open.clear();
        self.places.clear();
        (self.passing, self.files) = (None, 0);
    }

    /// Whether the values of a line count: not while it is passed over.
    pub(crate) fn reads_values(&self, line: &FlowLine<'_>) -> bool {
        match &self.passing {
            // Behind a branch that was taken.
            None => line.word != FlowWord::ElseIf,
            Some(Passing::ToElse(label)) => *label == line.label && line.word == FlowWord::ElseIf,
            Some(Passing::ToLoopEnd(label)) => *label == line.label && line.word == FlowWord::While,
            Some(_) => false,
        }
    }

    /// What a line with an O word and these values does; `here` is where it begins and `after` where the next
    /// one does.
    pub(crate) fn step(
        &mut self,
        line: &FlowLine<'_>,
        here: Place,
        after: Place,
        values: &[f64],
    ) -> Result<Step, FlowFault> {
        if let Some(passing) = self.passing.take() {
            return self.pass(passing, line, here, after, values);
        }
        self.act(line, here, after, values)
    }

    /// A line while others are passed over.
    fn pass(
        &mut self,
        passing: Passing,
        line: &FlowLine<'_>,
        here: Place,
        after: Place,
        values: &[f64],
    ) -> Result<Step, FlowFault> {
        use FlowWord as W;
        match (&passing, line.word) {
            (Passing::Sub(label), W::EndSub) if *label == line.label => return Ok(Step::ON),
            (Passing::ToSub(label), W::Sub | W::Number) if *label == line.label => {
                self.remember(label, after);
                if let Some((_, begins)) = self.calls.last_mut().and_then(|call| call.again.as_mut()) {
                    *begins = after;
                }
                return Ok(Step::ON);
            }
            (Passing::ToElse(label), W::ElseIf) if *label == line.label => {
                if value(line, values)? == 0.0 {
                    self.passing = Some(passing);
                }
                return Ok(Step::ON);
            }
            (Passing::ToElse(label), W::Else) if *label == line.label => return Ok(Step::ON),
            (Passing::ToElse(label) | Passing::ToEndIf(label), W::EndIf) if *label == line.label => {
                self.open.pop();
                return Ok(Step::ON);
            }
            (Passing::BehindLoop(label), W::EndWhile | W::EndRepeat) if *label == line.label => {
                return Ok(Step::ON);
            }
            // The end of a `do`; a loop of its own within it would have another label.
            (Passing::BehindLoop(label), W::While) if *label == line.label => return Ok(Step::ON),
            (Passing::ToLoopEnd(label), W::EndWhile | W::EndRepeat | W::While) if *label == line.label => {
                return self.act(line, here, after, values);
            }
            (_, W::Number) => self.remember(&line.label, after),
            _ => {}
        }
        self.passing = Some(passing);
        Ok(Step::ON)
    }

    fn act(&mut self, line: &FlowLine<'_>, here: Place, after: Place, values: &[f64]) -> Result<Step, FlowFault> {
        let label = &line.label;
        match line.word {
            FlowWord::Number => self.remember(label, after),
            FlowWord::Sub => {
                self.remember(label, after);
                self.passing = Some(Passing::Sub(label.clone()));
            }
            FlowWord::Call => return self.call_line(line, after, values),
            FlowWord::EndSub | FlowWord::Return => return self.end_of_sub(line, values),
            FlowWord::If => {
                let is_so = value(line, values)? != 0.0;
                self.begin(line, Kind::If, after)?;
                self.passing = (!is_so).then(|| Passing::ToElse(label.clone()));
            }
            FlowWord::ElseIf | FlowWord::Else => {
                self.innermost(line, |kind| kind == Kind::If)?;
                self.passing = Some(Passing::ToEndIf(label.clone()));
            }
            FlowWord::EndIf => {
                self.innermost(line, |kind| kind == Kind::If)?;
                self.open.pop();
            }
            FlowWord::While => return self.while_line(line, here, values),
            FlowWord::Do => self.begin(line, Kind::Do, after)?,
            FlowWord::Repeat => {
                let turns = libm::round(value(line, values)?);
                if turns < 1.0 {
                    self.passing = Some(Passing::BehindLoop(label.clone()));
                } else {
                    self.begin(line, Kind::Repeat(turns as u32), after)?;
                }
            }
            FlowWord::EndWhile => {
                let turn = self.innermost(line, |kind| kind == Kind::While)?;
                self.open.pop();
                return Ok(Step::to(Next::At(turn)));
            }
            FlowWord::EndRepeat => return self.end_of_repeat(line),
            FlowWord::Break | FlowWord::Continue => self.leave_loop(line)?,
        }
        Ok(Step::ON)
    }

    // --- conditions and loops ---

    /// Of the subroutine that runs.
    fn first_open(&self) -> usize {
        self.calls.last().map_or(0, |call| call.open)
    }

    fn begin(&mut self, line: &FlowLine<'_>, kind: Kind, turn: Place) -> Result<(), FlowFault> {
        let open = Open { label: line.label.clone(), kind, turn };
        self.open.push(open).map_err(|_| wrong(line, FlowProblem::OpenTooDeep))
    }

    /// Where the innermost one's next turn begins, if it has this line's label and is of the right kind.
    fn innermost(&self, line: &FlowLine<'_>, is_right: impl Fn(Kind) -> bool) -> Result<Place, FlowFault> {
        let own = self.open.get(self.first_open()..).unwrap_or(&[]);
        let open = own.last().filter(|open| open.label == line.label && is_right(open.kind));
        open.map(|open| open.turn).ok_or(wrong(line, FlowProblem::NotOpen(line.word)))
    }

    fn while_line(&mut self, line: &FlowLine<'_>, here: Place, values: &[f64]) -> Result<Step, FlowFault> {
        let is_so = value(line, values)? != 0.0;
        if let Ok(turn) = self.innermost(line, |kind| kind == Kind::Do) {
            if is_so {
                return Ok(Step::to(Next::At(turn)));
            }
            self.open.pop();
            return Ok(Step::ON);
        }
        if is_so {
            self.begin(line, Kind::While, here)?;
        } else {
            self.passing = Some(Passing::BehindLoop(line.label.clone()));
        }
        Ok(Step::ON)
    }

    fn end_of_repeat(&mut self, line: &FlowLine<'_>) -> Result<Step, FlowFault> {
        let turn = self.innermost(line, |kind| matches!(kind, Kind::Repeat(_)))?;
        if let Some(Open { kind: Kind::Repeat(left), .. }) = self.open.last_mut()
            && *left > 1
        {
            *left -= 1;
            return Ok(Step::to(Next::At(turn)));
        }
        self.open.pop();
        Ok(Step::ON)
    }

    /// `break` and `continue`: of the loop with this label, out of whatever is open within it.
    fn leave_loop(&mut self, line: &FlowLine<'_>) -> Result<(), FlowFault> {
        let first = self.first_open();
        let own = self.open.get(first..).unwrap_or(&[]);
        let place = own.iter().rposition(|open| open.label == line.label && open.kind != Kind::If);
        let place = first + place.ok_or(wrong(line, FlowProblem::NotOpen(line.word)))?;
        let label = line.label.clone();
        if line.word == FlowWord::Break {
            self.open.truncate(place);
            self.passing = Some(Passing::BehindLoop(label));
        } else {
            self.open.truncate(place + 1);
            self.passing = Some(Passing::ToLoopEnd(label));
        }
        Ok(())
    }

    // --- subroutines ---

    fn remember(&mut self, label: &Name, place: Place) {
        let files = self.files;
        if !self.places.iter().any(|(of, known, _)| *of == files && known == label) {
            // Those that have no room are searched for again.
            let _ = self.places.push((files, label.clone(), place));
        }
    }

    fn place_of(&self, label: &Name) -> Option<Place> {
        let known = self.places.iter().find(|(files, known, _)| *files == self.files && known == label);
        known.map(|(_, _, place)| *place)
    }

    fn call_line(&mut self, line: &FlowLine<'_>, after: Place, values: &[f64]) -> Result<Step, FlowFault> {
        if values.len() > LOCALS {
            return Err(wrong(line, FlowProblem::TooManyValues));
        }
        let mut locals = Locals::default();
        locals.iter_mut().zip(values).for_each(|(local, value)| *local = *value);
        self.call(&line.label, 1, after).map(|next| Step { next, memory: Change::Enter(locals) })
    }

    /// Calls a subroutine so many times; its own parameters are the caller's to set.
    pub(crate) fn call(&mut self, label: &Name, times: u32, after: Place) -> Result<Next, FlowFault> {
        let place = self.place_of(label);
        let call = Call {
            label: label.clone(),
            back: after,
            has_file: false,
            callers: None,
            open: self.open.len(),
            again: (times > 1).then_some((times - 1, place.unwrap_or_default())),
        };
        let full = |call: Call| FlowFault { label: call.label, problem: FlowProblem::CalledTooDeep };
        self.calls.push(call).map_err(full)?;
        Ok(place.map_or_else(|| Next::FirstOf(label.clone()), Next::At))
    }

    /// Keeps the caller's own parameters for the subroutine called last.
    pub(crate) fn keep_callers(&mut self, callers: Locals) {
        if let Some(call) = self.calls.last_mut() {
            call.callers = Some(callers);
        }
    }

    /// The subroutine called last has a file, which is read now.
    pub fn enter_file(&mut self) {
        if let Some(call) = self.calls.last_mut() {
            call.has_file = true;
            self.files = self.files.saturating_add(1);
            // In a file of its own it may stand behind others.
            self.passing = Some(Passing::ToSub(call.label.clone()));
        }
    }

    /// The subroutine called last has no file: the lines that follow are searched for it.
    pub fn search(&mut self) {
        self.passing = self.calls.last().map(|call| Passing::ToSub(call.label.clone()));
    }

    fn end_of_sub(&mut self, line: &FlowLine<'_>, values: &[f64]) -> Result<Step, FlowFault> {
        // The label of `return` may be that of the condition around it (LinuxCNC).
        let is_its = self.calls.last().is_some_and(|call| line.word == FlowWord::Return || call.label == line.label);
        if !is_its {
            return Err(wrong(line, FlowProblem::NotOpen(line.word)));
        }
        let returned = values.first().copied();
        let (next, callers) = self.end_call().ok_or(wrong(line, FlowProblem::NotOpen(line.word)))?;
        Ok(Step { next, memory: Change::Leave(callers, returned) })
    }

    /// The subroutine called last ends, or begins again; `None` when none was called.
    pub(crate) fn end_call(&mut self) -> Option<(Next, Option<Locals>)> {
        let call = self.calls.last_mut()?;
        self.open.truncate(call.open);
        if let Some((left, begins)) = call.again.as_mut().filter(|(left, _)| *left > 0) {
            *left -= 1;
            return Some((Next::At(*begins), None));
        }
        let call = self.calls.pop()?;
        if !call.has_file {
            return Some((Next::At(call.back), call.callers));
        }
        let files = self.files;
        self.places.retain(|(of, ..)| *of != files);
        self.files = files.saturating_sub(1);
        Some((Next::Returned, call.callers))
    }

    /// The end of a file: what is missing, when something is.
    ///
    /// # Errors
    /// A subroutine that stands nowhere, something that was opened and not closed.
    pub(crate) fn end_of_file(&self) -> Result<(), FlowFault> {
        let passed = self.passing.as_ref().map(|passing| match passing {
            Passing::ToSub(label) => (label, FlowProblem::NoSuchSub),
            Passing::Sub(label)
            | Passing::ToElse(label)
            | Passing::ToEndIf(label)
            | Passing::BehindLoop(label)
            | Passing::ToLoopEnd(label) => (label, FlowProblem::Unclosed),
        });
        let unclosed = self.open.last().map(|open| &open.label).or(self.calls.last().map(|call| &call.label));
        let found = passed.or(unclosed.map(|label| (label, FlowProblem::Unclosed)));
        found.map_or(Ok(()), |(label, problem)| Err(FlowFault { label: label.clone(), problem }))
    }
}

/// What a line with an O word comes to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Step {
    pub next: Next,
    pub memory: Change,
}

/// What happens to a program's own parameters.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Change {
    Nothing,
    /// A subroutine begins with these.
    Enter(Locals),
    /// It ends: its caller's come back, unless it begins again. It gives a value, perhaps.
    Leave(Option<Locals>, Option<f64>),
}

impl Step {
    const ON: Self = Self { next: Next::Following, memory: Change::Nothing };

    const fn to(next: Next) -> Self {
        Self { next, memory: Change::Nothing }
    }
}

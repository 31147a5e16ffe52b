//! Subroutines, conditions and loops: the order of a program's lines.
//!
//! The reader of the file owns the lines; this module tracks subroutines, conditions and loops in progress
//! and skips lines. The place of a subroutine is known once the program has passed its definition; until
//! then, the program is searched forwards for it.

use core::fmt;

use gcode::expression::Name;
use gcode::{FlowLine, FlowWord, SyntaxError};
use heapless::Vec;

use crate::flow::memory::{LOCALS, Locals};

/// Greatest depth of nested subroutine calls.
pub(crate) const MOST_CALLS: usize = 10;
/// Greatest depth of nested conditions and loops.
const MOST_OPEN: usize = 24;
/// Greatest number of remembered subroutines; the others are searched for.
const MOST_PLACES: usize = 32;

/// Place between two lines of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Bytes from the file's beginning.
    pub offset: u32,
    /// Lines before the place.
    pub line: u32,
}

/// Line that comes next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Next {
    /// Line that follows in the file.
    Following,
    /// Line at this place of the same file.
    At(Place),
    /// First line of the file of this subroutine, if there is such a file; otherwise call [`Flow::search`],
    /// and the next line is the following one.
    FirstOf(Name),
    /// Line after the call, in the calling file; the current file is finished.
    Returned,
}

/// Subroutine that is running.
#[derive(Clone, Debug)]
struct Call {
    label: Name,
    /// Place to return to.
    back: Place,
    /// Whether the subroutine has a file of its own.
    has_file: bool,
    /// Caller's own parameters; none for a call that shares them (M98).
    callers: Option<Locals>,
    /// Number of open conditions and loops at the call.
    open: usize,
    /// Remaining repetitions and the beginning of the subroutine (M98 L).
    again: Option<(u32, Place)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    If,
    While,
    Do,
    /// Number of turns left, including the current turn.
    Repeat(u32),
}

/// Condition or loop in progress.
#[derive(Clone, Debug)]
struct Open {
    label: Name,
    kind: Kind,
    /// Place where the next turn begins.
    turn: Place,
}

/// End of the lines that are skipped.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Passing {
    /// End of a subroutine's definition that was not called.
    Sub(Name),
    /// Beginning of a called subroutine.
    ToSub(Name),
    /// `elseif`, `else` or `endif` of the condition.
    ToElse(Name),
    /// `endif` of the condition.
    ToEndIf(Name),
    /// Line behind the end of a loop.
    BehindLoop(Name),
    /// Line that ends a loop.
    ToLoopEnd(Name),
}

/// Subroutines, conditions and loops in progress.
#[derive(Clone, Debug, Default)]
pub struct Flow {
    calls: Vec<Call, MOST_CALLS>,
    open: Vec<Open, MOST_OPEN>,
    passing: Option<Passing>,
    /// Beginnings of subroutines, each with the number of files open there.
    places: Vec<(u8, Name, Place), MOST_PLACES>,
    /// Number of files that calls have opened.
    files: u8,
}

/// Reason why a line with an O word cannot be carried out, or a file cannot end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlowFault {
    /// Label of the line with the fault.
    pub label: Name,
    /// Problem with the line.
    pub problem: FlowProblem,
}

/// Problem with a line with an O word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "their texts say it")]
pub enum FlowProblem {
    Syntax(SyntaxError),
    /// The word lacks its value.
    NoValue(FlowWord),
    /// The word ends or continues something other than the innermost open condition, loop or subroutine.
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

/// Returns the single value of a condition.
fn value(line: &FlowLine<'_>, values: &[f64]) -> Result<f64, FlowFault> {
    values.first().copied().ok_or_else(|| wrong(line, FlowProblem::NoValue(line.word)))
}

impl Flow {
    /// Whether lines are skipped, so that only lines with an O word matter.
    #[must_use]
    pub const fn passes_over(&self) -> bool {
        self.passing.is_some()
    }

    /// Returns the number of subroutines in progress.
    pub(crate) fn depth(&self) -> usize {
        self.calls.len()
    }

    /// Whether no subroutine, condition or loop is in progress.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.calls.is_empty() && self.open.is_empty() && self.passing.is_none()
    }

    /// Forgets everything at the end of a program, in place, because the value is large.
    pub(crate) fn reset(&mut self) {
        self.calls.clear();
        self.open.clear();
        self.places.clear();
        (self.passing, self.files) = (None, 0);
    }

    /// Whether the values of a line count, which is false while lines are skipped.
    pub(crate) fn reads_values(&self, line: &FlowLine<'_>) -> bool {
        match &self.passing {
            // An `elseif` behind a taken branch needs no value.
            None => line.word != FlowWord::ElseIf,
            Some(Passing::ToElse(label)) => *label == line.label && line.word == FlowWord::ElseIf,
            Some(Passing::ToLoopEnd(label)) => *label == line.label && line.word == FlowWord::While,
            Some(_) => false,
        }
    }

    /// Carries out a line with an O word at place `here`; the next line is at `after`.
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

    /// Handles a line with an O word while lines are skipped.
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
            // End of a `do`: a nested loop would have another label.
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

    /// Returns the number of conditions and loops that the callers of the current subroutine have open.
    fn first_open(&self) -> usize {
        self.calls.last().map_or(0, |call| call.open)
    }

    fn begin(&mut self, line: &FlowLine<'_>, kind: Kind, turn: Place) -> Result<(), FlowFault> {
        let open = Open { label: line.label.clone(), kind, turn };
        self.open.push(open).map_err(|_| wrong(line, FlowProblem::OpenTooDeep))
    }

    /// Returns the beginning of the innermost loop's next turn, if label and kind are right.
    fn innermost(&self, line: &FlowLine<'_>, is_right: impl Fn(Kind) -> bool) -> Result<Place, FlowFault> {
        let own = self.open.get(self.first_open()..).unwrap_or(&[]);
        let open = own.last().filter(|open| open.label == line.label && is_right(open.kind));
        open.map(|open| open.turn).ok_or_else(|| wrong(line, FlowProblem::NotOpen(line.word)))
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

    /// Leaves the loop with this label, and everything open within it (`break` and `continue`).
    fn leave_loop(&mut self, line: &FlowLine<'_>) -> Result<(), FlowFault> {
        let first = self.first_open();
        let own = self.open.get(first..).unwrap_or(&[]);
        let place = own.iter().rposition(|open| open.label == line.label && open.kind != Kind::If);
        let place = first + place.ok_or_else(|| wrong(line, FlowProblem::NotOpen(line.word)))?;
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
            // Subroutines beyond the capacity are searched for again.
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

    /// Calls a subroutine a number of times; the caller of this function replaces the parameters.
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

    /// Notes that the subroutine called last has a file, which is read next.
    pub fn enter_file(&mut self) {
        if let Some(call) = self.calls.last_mut() {
            call.has_file = true;
            self.files = self.files.saturating_add(1);
            // The subroutine may stand behind others in its own file.
            self.passing = Some(Passing::ToSub(call.label.clone()));
        }
    }

    /// Notes that the subroutine called last has no file, so that the following lines are searched.
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
        let (next, callers) = self.end_call().ok_or_else(|| wrong(line, FlowProblem::NotOpen(line.word)))?;
        Ok(Step { next, memory: Change::Leave(callers, returned) })
    }

    /// Ends or repeats the subroutine called last; `None` when no subroutine was called.
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

    /// Checks that nothing is open at the end of a file.
    ///
    /// # Errors
    /// When a called subroutine was not found, or something that was opened is not closed.
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

/// Result of a line with an O word.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Step {
    pub next: Next,
    pub memory: Change,
}

/// Change of a program's local parameters.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Change {
    Nothing,
    /// A subroutine begins with these parameters.
    Enter(Locals),
    /// A subroutine ends: the caller's parameters come back unless it is repeated, and a value may be
    /// returned.
    Leave(Option<Locals>, Option<f64>),
}

impl Step {
    const ON: Self = Self { next: Next::Following, memory: Change::Nothing };

    const fn to(next: Next) -> Self {
        Self { next, memory: Change::Nothing }
    }
}

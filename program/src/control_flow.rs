//! What lines do to the program besides their codes: parameters are set at a line's end, O words, M98 and M99
//! say which line comes next.

use core::fmt::Write;

use gcode::FlowLine;
use gcode::expression::Name;
use heapless::Vec;

use crate::fault::{Fault, Problem};
use crate::flow::{Change, Flow, FlowFault, FlowProblem, Next, Place};
use crate::interpreter::Interpreter;
use crate::meaning::modes;
use crate::memory::LOCALS;
use crate::parameters;

impl Interpreter {
    /// A line has been read to its end: the parameters that it sets are set now.
    ///
    /// # Errors
    /// When there is no room for one.
    pub fn end_line(&mut self) -> Result<(), Fault> {
        if !self.memory.has_waiting() {
            return Ok(());
        }
        parameters::settle(self).map_err(|problem| {
            self.memory.forget_waiting();
            Problem::Parameter(problem).refused(0)
        })
    }

    /// Of the parameters that outlast a power cycle and are not 0, the one at this place: its number and its
    /// value.
    #[must_use]
    pub fn kept_parameter(&self, place: usize) -> Option<(u16, f64)> {
        parameters::kept_at(self, place)
    }

    /// Whether one of them has been set since the last call.
    pub fn take_parameters_changed(&mut self) -> bool {
        self.memory.take_changed()
    }

    /// Sets one of them as it was before a power cycle. False when there is none with this number, or no
    /// room.
    pub fn restore_parameter(&mut self, number: u16, value: f64) -> bool {
        let restored = number > LOCALS as u16 && value.is_finite() && parameters::restore(self, number, value);
        let _as_on_the_card = self.memory.take_changed();
        restored
    }

    /// A line is not read to its end: the parameters that it sets are not set.
    pub fn drop_line(&mut self) {
        self.memory.forget_waiting();
    }

    /// What a line with an O word does, and which line comes next. `here` is the place where it begins,
    /// `after` that where the next line does.
    ///
    /// # Errors
    /// What is wrong with it; the program cannot go on then.
    pub fn flow_line(&mut self, line: &FlowLine<'_>, here: Place, after: Place) -> Result<Next, FlowFault> {
        let labelled;
        let line = if line.works_out_label() && !self.flow.passes_over() {
            let read = line.labelled(self);
            let wrong = |error| FlowFault { label: Name::new(), problem: FlowProblem::Syntax(error) };
            labelled = read.map_err(wrong)?;
            &labelled
        } else {
            line
        };
        let mut values: Vec<f64, { LOCALS + 1 }> = Vec::new();
        if self.flow.reads_values(line) {
            // One more than there may be is enough to see that they are too many.
            let read = line.values(self, |value| {
                let _ = values.push(value);
            });
            read.map_err(|error| FlowFault { label: line.label.clone(), problem: FlowProblem::Syntax(error) })?;
        }
        let step = self.flow.step(line, here, after, &values)?;
        match step.memory {
            Change::Nothing => {}
            Change::Enter(own) => {
                let callers = self.memory.enter(own);
                self.flow.keep_callers(callers);
            }
            Change::Leave(callers, returned) => {
                if let Some(callers) = callers {
                    self.memory.leave(callers);
                }
                self.memory.give_back(returned);
                modes::subroutines_ended(self);
            }
        }
        Ok(step.next)
    }

    /// M98: calls a subroutine by its number, so many times. It shares its caller's parameters.
    ///
    /// # Errors
    /// When too many call each other.
    pub fn call(&mut self, number: u32, times: u32, after: Place) -> Result<Next, FlowFault> {
        if times == 0 {
            return Ok(Next::Following);
        }
        let mut label = Name::new();
        // A number fits a name.
        let _ = write!(label, "{number}");
        self.flow.call(&label, times, after)
    }

    /// M99: the subroutine ends; `None` when none was called.
    pub fn end_call(&mut self) -> Option<Next> {
        let (next, callers) = self.flow.end_call()?;
        if let Some(callers) = callers {
            self.memory.leave(callers);
        }
        modes::subroutines_ended(self);
        Some(next)
    }

    /// What has been called and opened.
    #[must_use]
    pub const fn flow(&self) -> &Flow {
        &self.flow
    }

    /// The subroutine called last has a file, which is read now.
    pub fn enter_file(&mut self) {
        self.flow.enter_file();
    }

    /// The subroutine called last has no file: the lines that follow are searched for it.
    pub fn search_sub(&mut self) {
        self.flow.search();
    }

    /// The file of the program has ended: nothing may be open.
    ///
    /// # Errors
    /// What is.
    pub fn end_file(&mut self) -> Result<(), FlowFault> {
        let ended = self.flow.end_of_file();
        self.end_program();
        ended
    }

    /// Nothing that was called or opened goes on: the program has ended, or was stopped.
    pub fn end_program(&mut self) {
        self.flow.reset();
        self.frames.clear();
        self.memory.end();
        self.line = 0;
    }
}

//! Effects of lines on the program besides their codes: parameters are set at a line's end, and O words, M98
//! and M99 choose the next line.

use core::fmt::Write;

use gcode::FlowLine;
use gcode::expression::Name;
use heapless::Vec;

use crate::fault::{Fault, Problem};
use crate::flow::memory::LOCALS;
use crate::flow::{Change, Flow, FlowFault, FlowProblem, Next, Place};
use crate::interpreter::Interpreter;
use crate::meaning::modes;
use crate::parameters;

impl Interpreter {
    /// Ends a line: the parameters that the line sets take their values now.
    ///
    /// # Errors
    /// When there is no room for a parameter.
    pub fn end_line(&mut self) -> Result<(), Fault> {
        if !self.memory.has_waiting() {
            return Ok(());
        }
        parameters::settle(self).map_err(|problem| {
            self.memory.forget_waiting();
            Problem::Parameter(problem).refused(0)
        })
    }

    /// Returns number and value of the persistent parameter at this index, counting those that are not 0.
    #[must_use]
    pub fn kept_parameter(&self, place: usize) -> Option<(u16, f64)> {
        parameters::kept_at(self, place)
    }

    /// Returns whether a persistent parameter has been set since the last call.
    pub fn take_parameters_changed(&mut self) -> bool {
        self.memory.take_changed()
    }

    /// Restores a persistent parameter after a power cycle. Returns false when the number is not that of a
    /// persistent parameter, or when there is no room.
    pub fn restore_parameter(&mut self, number: u16, value: f64) -> bool {
        let restored = number > LOCALS as u16 && value.is_finite() && parameters::restore(self, number, value);
        let _as_on_the_card = self.memory.take_changed();
        restored
    }

    /// Drops a line before its end: the parameters that the line sets stay unset.
    pub fn drop_line(&mut self) {
        self.memory.forget_waiting();
    }

    /// Carries out a line with an O word and returns the next line. `here` is the place where this line
    /// begins, `after` the place where the following line begins.
    ///
    /// # Errors
    /// When the line is wrong; the program cannot go on then.
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
            // A value more than allowed is enough to detect that there are too many.
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

    /// Calls a subroutine by its number, a number of times (M98). The subroutine shares its caller's
    /// parameters.
    ///
    /// # Errors
    /// When too many subroutines call each other.
    pub fn call(&mut self, number: u32, times: u32, after: Place) -> Result<Next, FlowFault> {
        if times == 0 {
            return Ok(Next::Following);
        }
        let mut label = Name::new();
        // Every number fits into a name.
        let _ = write!(label, "{number}");
        self.flow.call(&label, times, after)
    }

    /// Ends the subroutine (M99); `None` when no subroutine was called.
    pub fn end_call(&mut self) -> Option<Next> {
        let (next, callers) = self.flow.end_call()?;
        if let Some(callers) = callers {
            self.memory.leave(callers);
        }
        modes::subroutines_ended(self);
        Some(next)
    }

    /// Returns the subroutines, conditions and loops in progress.
    #[must_use]
    pub const fn flow(&self) -> &Flow {
        &self.flow
    }

    /// Notes that the subroutine called last has a file, which is read next.
    pub fn enter_file(&mut self) {
        self.flow.enter_file();
    }

    /// Notes that the subroutine called last has no file, so the lines that follow are searched for the
    /// subroutine.
    pub fn search_sub(&mut self) {
        self.flow.search();
    }

    /// Ends the file of the program.
    ///
    /// # Errors
    /// When a subroutine, condition or loop is still open.
    pub fn end_file(&mut self) -> Result<(), FlowFault> {
        let ended = self.flow.end_of_file();
        self.end_program();
        ended
    }

    /// Abandons all subroutines, conditions and loops: the program has ended, or was stopped.
    pub fn end_program(&mut self) {
        self.flow.reset();
        self.frames.clear();
        self.memory.end();
        self.line = 0;
    }
}

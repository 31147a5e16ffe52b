//! Instructions of function calls, without those of counted functions that interrupted them.

use std::collections::HashMap;

/// A call of a counted function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Call {
    /// Start of the call, nanoseconds since power-on.
    pub at_ns: u64,
    /// Instructions that the core had executed before the call.
    pub before: u64,
    /// Instructions of the call, without those of counted functions that interrupted it.
    pub instructions: u32,
}

/// A call under way.
#[derive(Clone, Debug)]
struct Frame {
    name: String,
    at_ns: u64,
    entered: u64,
    /// Instruction count after the last exit instruction that was reached. A conditional exit may turn out
    /// not to be taken, so the call ends for good only when another function is entered, or an outer call
    /// leaves.
    left: Option<u64>,
    /// Instructions of counted functions that ran in between.
    nested: u64,
}

/// Finished calls by function.
type Finished = HashMap<String, Vec<Call>>;

/// The counted calls under way, outermost first: interrupts nest.
#[derive(Clone, Debug, Default)]
pub struct CallStack(Vec<Frame>);

impl CallStack {
    pub(super) fn enter(&mut self, name: &str, at_ns: u64, count: u64, calls: &mut Finished) {
        while self.0.last().is_some_and(|top| top.left.is_some()) {
            self.close_top(calls);
        }
        self.0.push(Frame { name: name.to_owned(), at_ns, entered: count, left: None, nested: 0 });
    }

    /// Takes note of a reached exit instruction, which counts itself.
    pub(super) fn leave(&mut self, name: &str, count: u64, calls: &mut Finished) {
        if !self.0.iter().any(|frame| frame.name == name) {
            return;
        }
        while self.0.last().is_some_and(|top| top.name != name) {
            self.close_top(calls);
        }
        if let Some(top) = self.0.last_mut() {
            top.left = Some(count + 1);
        }
    }

    /// Ends every call under way.
    pub(super) fn close_all(&mut self, calls: &mut Finished) {
        while !self.0.is_empty() {
            self.close_top(calls);
        }
    }

    /// Ends the innermost call. A call that never reached an exit is not recorded.
    fn close_top(&mut self, calls: &mut Finished) {
        let Some(frame) = self.0.pop() else { return };
        let Some(left) = frame.left else { return };
        let inclusive = left - frame.entered;
        if let Some(outer) = self.0.last_mut() {
            outer.nested += inclusive;
        }
        let instructions = (inclusive - frame.nested.min(inclusive)) as u32;
        let call = Call { at_ns: frame.at_ns, before: frame.entered, instructions };
        // A look-up by name comes first: no name is to be copied at the rate of steps.
        match calls.get_mut(&frame.name) {
            Some(calls) => calls.push(call),
            None => drop(calls.insert(frame.name, vec![call])),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn own(calls: &Finished, name: &str) -> Vec<u32> {
        calls[name].iter().map(|call| call.instructions).collect()
    }

    #[test]
    fn an_interrupted_call_counts_only_its_own_instructions() {
        let (mut stack, mut calls) = (CallStack::default(), Finished::new());
        stack.enter("outer", 1, 100, &mut calls);
        stack.enter("inner", 2, 110, &mut calls);
        stack.leave("inner", 119, &mut calls);
        stack.leave("outer", 129, &mut calls);
        // The next call closes both ended calls.
        stack.enter("outer", 3, 200, &mut calls);
        assert_eq!(own(&calls, "inner"), [10]);
        assert_eq!(calls["outer"], [Call { at_ns: 1, before: 100, instructions: 20 }]);
    }

    #[test]
    fn an_exit_that_was_not_taken_does_not_end_the_call() {
        let (mut stack, mut calls) = (CallStack::default(), Finished::new());
        stack.enter("f", 0, 0, &mut calls);
        stack.leave("f", 4, &mut calls);
        stack.leave("f", 9, &mut calls);
        stack.enter("f", 0, 50, &mut calls);
        assert_eq!(own(&calls, "f"), [10]);
    }
}

//! The stack: operands, variables and arguments, each with its use and its name.

use super::Memory;
use crate::value::{self, Value};

/// Use of a place on the stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Operand of an expression.
    Operand,
    /// Variable of the template, by the place of its name.
    Variable,
    /// Argument that is given by its name.
    Keyword,
    /// Argument whose elements are arguments.
    Spread,
    /// Argument whose members are arguments with names.
    SpreadNamed,
}

/// Length of a place on the stack: use, name, value.
const SLOT: usize = 3 + value::SIZE;

impl Memory<'_> {
    /// Number of places on the stack.
    pub fn depth(&self) -> usize {
        self.pool.saturating_sub(self.low) / SLOT
    }

    fn slot(&self, index: usize) -> usize {
        self.pool.saturating_sub((index + 1) * SLOT)
    }

    /// Puts a value on the stack.
    #[inline(never)]
    pub fn push(&mut self, value: Value) {
        self.push_named(Use::Operand, 0, value);
    }

    /// Puts a variable or an argument with its name on the stack.
    #[inline(never)]
    pub fn push_named(&mut self, kind: Use, name: u16, value: Value) {
        if SLOT > self.low.saturating_sub(self.top) {
            self.is_full = true;
            return;
        }
        self.low -= SLOT;
        let low = self.low;
        self.set_byte(low, kind as u8);
        self.set_word(low + 1, name);
        self.set_value(low + 3, value);
    }

    /// Takes the last value from the stack.
    #[inline(never)]
    pub fn pop(&mut self) -> Value {
        let value = self.value(self.low + 3);
        self.low = (self.low + SLOT).min(self.pool);
        value
    }

    /// Takes values from the stack until it has so many.
    #[inline(never)]
    pub fn cut(&mut self, depth: usize) {
        self.low = self.pool.saturating_sub(depth * SLOT);
    }

    /// A value on the stack, counted from its start.
    #[inline(never)]
    pub fn at(&self, index: usize) -> Value {
        self.value(self.slot(index) + 3)
    }

    /// Writes a value on the stack.
    #[inline(never)]
    pub fn set_at(&mut self, index: usize, value: Value) {
        self.set_value(self.slot(index) + 3, value);
    }

    /// Use of a place on the stack.
    pub fn use_at(&self, index: usize) -> Use {
        const USES: [Use; 5] = [Use::Operand, Use::Variable, Use::Keyword, Use::Spread, Use::SpreadNamed];
        USES.get(usize::from(self.byte(self.slot(index)))).copied().unwrap_or(Use::Operand)
    }

    /// The name of a place on the stack, if it is used so.
    #[inline(never)]
    pub fn name_at(&self, index: usize, kind: Use) -> Option<u16> {
        let slot = self.slot(index);
        (self.byte(slot) == kind as u8).then(|| self.word(slot + 1))
    }

    /// Makes an argument of the last value.
    pub fn name_last(&mut self, kind: Use, name: u16) {
        self.set_byte(self.low, kind as u8);
        self.set_word(self.low + 1, name);
    }
}

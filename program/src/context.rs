//! What a block is read with beside the program's own state, and what it comes to.

use units::AxisSet;

use crate::action::{Action, Function};
use crate::dialect::Dialect;
use crate::fault::Fault;
use crate::words::Words;

/// What must be known of the machine to say what a block means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Facts {
    /// Axes that are homed.
    pub homed: AxisSet,
    /// Axes that have a switch to home with.
    pub can_home: AxisSet,
}

impl Facts {
    /// Every axis that can be homed is.
    #[must_use]
    pub const fn all_homed(self) -> bool {
        self.homed.has_all(self.can_home)
    }
}

/// What a block means.
#[derive(Clone, Copy, Debug)]
pub enum Meaning<'b> {
    /// It changed how later words are read; the machine has nothing to do.
    Nothing,
    /// This is to be done, then what [`crate::Interpreter::next_action`] gives.
    Action(Action<'b>),
    /// It is accepted and not carried out.
    PassedOver,
    /// Nobody knows this code.
    Unknown,
}

pub(crate) const NOTHING: Result<Meaning<'static>, Fault> = Ok(Meaning::Nothing);

/// What a handler of a code has to go by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Context<'b> {
    pub words: Words<'b>,
    pub facts: Facts,
    pub dialect: Dialect,
    pub function: Option<Function>,
}

impl<'b> Context<'b> {
    /// The machine does it, as the row of the table says.
    pub const fn function(&self) -> Meaning<'b> {
        match self.function {
            Some(function) => Meaning::Action(Action::Function(function, self.words)),
            None => Meaning::Unknown,
        }
    }
}

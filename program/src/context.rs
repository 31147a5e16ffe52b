//! Input of reading a block beside the program's own state, and the result.

use units::AxisSet;

use crate::action::Action;
use crate::fault::Fault;
use crate::function::Function;
use crate::words::Words;
use gcode::Dialect;

/// Facts about the machine that the meaning of a block depends on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Facts {
    /// Axes that are homed.
    pub homed: AxisSet,
    /// Axes that have an end stop to home with.
    pub can_home: AxisSet,
    /// Height of the tool over the bed as the probe's contact closes, mm.
    pub probe_height: f64,
}

impl Facts {
    /// Whether every axis that can be homed is homed.
    #[must_use]
    pub const fn all_homed(self) -> bool {
        self.homed.has_all(self.can_home)
    }
}

/// Result of reading a block.
#[derive(Clone, Copy, Debug)]
pub enum Meaning<'b> {
    /// No action: the block only changed how later words are read.
    Nothing,
    /// An action, followed by the actions that [`crate::Interpreter::next_action`] returns.
    Action(Action<'b>),
    /// Accepted code that is not carried out.
    PassedOver,
    /// Code that neither the table nor the configuration knows.
    Unknown,
}

pub(crate) const NOTHING: Result<Meaning<'static>, Fault> = Ok(Meaning::Nothing);

/// Arguments of a code's handler.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Context<'b> {
    pub words: Words<'b>,
    pub facts: Facts,
    pub dialect: Dialect,
    pub function: Option<Function>,
}

impl<'b> Context<'b> {
    /// Returns the machine function of the code's row as the meaning.
    pub const fn function(&self) -> Meaning<'b> {
        match self.function {
            Some(function) => Meaning::Action(Action::Function(function, self.words)),
            None => Meaning::Unknown,
        }
    }
}

//! Motor positions: whole steps as the driver counts them, and the fixed-point position between steps.

use fixed::types::I40F24;

/// Position of a motor in whole (micro)steps from where counting began.
pub type StepCount = i32;

/// Position of a motor between steps: 40 bits of whole steps, 24 of fraction. Exact to add, equal on every
/// machine.
pub type StepPosition = I40F24;

/// Direction in which a motor turns. `Forward` counts up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum Direction {
    Forward,
    Backward,
}

impl Direction {
    /// Returns the change of a [`StepCount`] by a step.
    #[must_use]
    pub const fn sign(self) -> StepCount {
        match self {
            Self::Forward => 1,
            Self::Backward => -1,
        }
    }
}

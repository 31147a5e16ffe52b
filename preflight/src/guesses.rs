//! Faults that may be none when the job comes to them.

use super::finding::{Kind, Severity};
use super::state::Preflight;

impl Preflight<'_> {
    /// Returns the kind that a fault is told as: what may be otherwise in the job itself stops none.
    pub(super) fn kind_here(&self, kind: Kind) -> Kind {
        let is_about_state = match kind {
            Kind::MustHome | Kind::TooCold => true,
            Kind::OutOfTravel | Kind::Unreachable => !self.program.modal().absolute,
            _ => false,
        };
        let is_unsure = self.is_guess || self.guesses && is_about_state;
        if is_unsure && kind.severity() == Severity::Stop { Kind::Unforeseen } else { kind }
    }
}

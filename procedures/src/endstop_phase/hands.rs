//! The machine in the hands of a sequence that notes the motors' phases.

use base::hands::Hands;

use super::records::EndstopPhases;

/// The machine in the hands of a sequence that closes switches: homing, and whatever homes.
pub trait PhaseHands<'c>: Hands<'c> {
    /// Returns the phases that motors have at their switches.
    fn phases(&mut self) -> &mut EndstopPhases;

    /// Whether a template of the printer.cfg stands for G28.
    fn homes_by_template(&self) -> bool;
}

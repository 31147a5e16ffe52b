//! The machine in the hands of a sequence that probes.

use super::delta_records::DeltaRecords;
use super::deployment_state::Deployment;
use crate::endstop_phase::PhaseHands;

/// The machine in the hands of a sequence that probes: probing, leveling, alignment.
pub trait ProbeHands<'c>: PhaseHands<'c> {
    /// Returns the measurements made of a delta.
    fn delta_records(&mut self) -> &mut DeltaRecords;

    /// Returns the probe's state, out or stowed.
    fn deployment(&mut self) -> &mut Deployment;
}

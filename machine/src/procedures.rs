//! Records that sequences keep from one to the next.

use crate::endstop_phase::EndstopPhases;
use crate::hands;
use crate::paper::Paper;
use crate::probing::{DeltaRecords, Deployment};

/// The machine in the hands of a sequence that keeps records: homing, probing, alignment.
pub trait Hands<'c>: hands::Hands<'c> {
    /// Returns the measurements made of a delta.
    fn delta_records(&mut self) -> &mut DeltaRecords;

    /// Returns the phases that motors have at their switches.
    fn phases(&mut self) -> &mut EndstopPhases;

    // --- the probe ---

    /// Returns the paper test that is under way.
    fn paper(&mut self) -> &mut Paper;

    /// Returns the probe's state, out or stowed.
    fn deployment(&mut self) -> &mut Deployment;
}

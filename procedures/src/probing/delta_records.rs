//! Records of a delta since it was switched on: touches of its bed, distances on printed parts.

use heapless::Vec;

use super::calibration_print::CalibrationPrint;
use super::delta_fit::{Distance, Evidence, Ways};

/// Greatest number of touches: five rounds of the most places.
pub(super) const MOST_TOUCHES: usize = 65;
/// Greatest number of distances.
pub(super) const MOST_DISTANCES: usize = 24;

/// Records of measurements. A calibration writes the touches, M665.1 the distances.
#[derive(Clone, Debug, Default)]
pub struct DeltaRecords {
    pub(super) touches: Vec<Ways, MOST_TOUCHES>,
    pub(super) distances: Vec<Distance, MOST_DISTANCES>,
    /// Lengths of the calibration print that M665.4 has kept.
    pub(super) print: CalibrationPrint,
}

impl DeltaRecords {
    /// Returns the last `count` touches.
    pub(super) fn touches_of_last_round(&self, count: usize) -> &[Ways] {
        self.touches.get(self.touches.len().saturating_sub(count)..).unwrap_or(&[])
    }

    pub(super) fn evidence(&self) -> Evidence<'_> {
        Evidence { touches: &self.touches, distances: &self.distances }
    }
}

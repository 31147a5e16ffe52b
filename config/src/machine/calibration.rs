//! Calibration of the machine's geometry by probing.

use units::Mm;

/// `[delta calibration strategy]`
#[derive(Clone, Copy, Debug, Default)]
pub struct DeltaCalibrationConfig {
    /// `[zprobe] calibration` asks for it.
    pub enable: bool,
    /// Distance of the probed points from the middle.
    pub radius: Mm,
    /// Height from which the bed is searched for.
    pub initial_height: Mm,
    /// Spread of the points' heights that is good enough.
    pub tolerance: Mm,
}

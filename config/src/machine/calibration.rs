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
    /// How many numbers are found: 3, 4, 6, 7 or 9.
    pub factors: u8,
    /// Spread of the points' heights that is good enough.
    pub tolerance: Mm,
}

/// `[z thermal adjust]`
#[derive(Clone, Debug, Default)]
pub struct ZThermalConfig {
    /// The temperature control whose sensor is on the frame; empty: none.
    pub sensor: super::Name,
    /// By how much the tool comes away from the bed for each degree, mm.
    pub coefficient: f64,
    /// Readings are smoothed over so long, s.
    pub smooth_s: f64,
    /// Z is shifted by no more.
    pub max_adjust: Mm,
}

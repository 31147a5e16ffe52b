//! Settings for calibration of the machine's geometry.

use units::Mm;

/// Section `[delta calibration strategy]`.
#[derive(Clone, Copy, Debug, Default)]
pub struct DeltaCalibrationConfig {
    /// Whether `[zprobe] calibration` asks for the calibration.
    pub enable: bool,
    /// Distance of the probed points from the middle.
    pub radius: Mm,
    /// Height from which the search for the bed begins.
    pub initial_height: Mm,
    /// Number of calibrated parameters: 3, 4, 6, 7 or 9.
    pub factors: u8,
    /// Spread of the points' heights at which the calibration ends.
    pub tolerance: Mm,
}

/// Section `[z thermal adjust]`: growth of the frame.
#[derive(Clone, Debug, Default)]
pub struct ZThermalConfig {
    /// Name of the temperature control whose sensor is on the frame; empty: none.
    pub sensor: super::Name,
    /// Growth of the distance between tool and bed per degree, mm.
    pub coefficient: f64,
    /// Time constant of the smoothing of readings, s.
    pub smooth_s: f64,
    /// Greatest shift of Z.
    pub max_adjust: Mm,
}

//! Amperes to current scale. Peak current, the RMS value of the datasheets times the square root of 2:
//!
//! - TMC2130, "Selecting sense resistors": (`CS` + 1) / 32 * `V_FS` / (sense resistor + 20 mOhm), `V_FS`
//!   being 0.32 V, or 0.18 V with `vsense`.
//! - TMC2208 and TMC2209, chapter 8: the same with 0.325 V and 0.18 V.
//! - TMC5160, "Selecting sense resistors": `GLOBALSCALER` / 256 * (`CS` + 1) / 32 * 0.325 V / sense resistor.
//! - TMC2240, "Setting the motor current": `GLOBALSCALER` / 256 * (`CS` + 1) / 32 * `K_IFS` / reference
//!   resistor, `K_IFS` being 11.75, 24 or 36 A kOhm by `CURRENT_RANGE`.

use super::StealthChip;
use crate::CurrentFit;
use units::{Amps, Ohms};

const SCALE_STEPS: f32 = 32.0;
const HIGHEST_CS: u8 = 31;
/// Below half scale microsteps lose accuracy ("IRUN 16 to 31 for best microstep performance").
const LOWEST_GOOD_CS: u8 = 16;
/// `GLOBALSCALER` of full scale, written as 0, and its least working value.
const FULL_SCALER: u16 = 256;
const LEAST_SCALER: u16 = 32;
/// Resistance between bridge and sense resistor inside a chip with internal bridges, Ohm.
const INTERNAL_OHMS: f32 = 0.020;

/// Fields of the current setting. Fields that a chip does not have are ignored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StealthCurrent {
    /// `IRUN`, 0 to 31.
    pub cs: u8,
    /// `vsense` of a chip without GLOBALSCALER: the lower full-scale voltage.
    pub low_range: bool,
    /// `GLOBALSCALER`, 32 to 256.
    pub scaler: u16,
    /// `CURRENT_RANGE` of a TMC2240, 0 to 2.
    pub range: u8,
    /// Peak current of these fields.
    pub actual: Amps,
    /// Match with the requested current.
    pub fit: CurrentFit,
}

impl StealthChip {
    /// Peak current at full scale. The resistor is the sense resistor, or the reference resistor of a
    /// TMC2240.
    #[must_use]
    pub fn full_scale(self, resistor: Ohms, low_range: bool, range: u8) -> Amps {
        Amps(match self {
            Self::Tmc2130 => (if low_range { 0.18 } else { 0.32 }) / (resistor.0 + INTERNAL_OHMS),
            Self::Tmc2208 | Self::Tmc2209 => (if low_range { 0.18 } else { 0.325 }) / (resistor.0 + INTERNAL_OHMS),
            Self::Tmc5160 => 0.325 / resistor.0,
            Self::Tmc2240 => {
                let volts = match range {
                    0 => 11_750.0,
                    1 => 24_000.0,
                    _ => 36_000.0,
                };
                volts / resistor.0
            }
        })
    }

    /// Returns the highest peak current with this resistor.
    #[must_use]
    pub fn most(self, resistor: Ohms) -> Amps {
        self.full_scale(resistor, false, 2)
    }
}

/// Returns the nearest setting to a peak current. A TMC2240's range is `least_range` or the next that is
/// enough.
#[must_use]
pub fn stealth_current(chip: StealthChip, resistor: Ohms, peak: Amps, least_range: u8) -> StealthCurrent {
    let low_range =
        !chip.has_global_scaler() && scale(peak, chip.full_scale(resistor, true, 0)) <= f32::from(HIGHEST_CS) + 0.5;
    let range = (least_range..2).find(|range| chip.full_scale(resistor, false, *range) >= peak).unwrap_or(2);
    let full = chip.full_scale(resistor, low_range, range);
    let scaler = if chip.has_global_scaler() { scaler(peak, full) } else { FULL_SCALER };
    let scaled = Amps(full.0 * f32::from(scaler) / f32::from(FULL_SCALER));
    let exact = scale(peak, scaled);
    // A float to integer cast saturates, and turns NaN into 0.
    let cs = ((exact + 0.5) as u8).min(HIGHEST_CS);
    let actual = Amps(scaled.0 * (f32::from(cs) + 1.0) / SCALE_STEPS);
    let step = if chip.has_global_scaler() { full.0 / f32::from(FULL_SCALER) } else { full.0 / SCALE_STEPS };
    let fit = if peak.0 > actual.0 + 0.501 * step && cs == HIGHEST_CS {
        CurrentFit::Limited
    } else if cs < LOWEST_GOOD_CS {
        CurrentFit::Coarse
    } else {
        CurrentFit::Good
    };
    StealthCurrent { cs, low_range, scaler, range, actual, fit }
}

/// Returns the exact `CS`, before rounding.
fn scale(peak: Amps, full: Amps) -> f32 {
    SCALE_STEPS * peak.0 / full.0 - 1.0
}

/// Returns the scaler with which all of the current scale is used, if possible.
fn scaler(peak: Amps, full: Amps) -> u16 {
    ((f32::from(FULL_SCALER) * peak.0 / full.0 + 0.5) as u16).clamp(LEAST_SCALER, FULL_SCALER)
}

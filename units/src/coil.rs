//! Coils of motors, and choppers that regulate their current.

use crate::{Amps, Ohms};

/// Data of a motor's coil, from the motor's data sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coil {
    /// Resistance of the coil.
    pub resistance: Ohms,
    /// Inductance of the coil, henry.
    pub henries: f32,
}

/// Computed chopper settings, for regulating the current of a coil, with the reasons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChopperFit {
    /// Slow decay phase, as the chip counts it (`TOFF`).
    pub off_time: u8,
    /// Blanking time, clocks, unchanged.
    pub blank_clocks: u8,
    /// Hysteresis at the start, on top of the end value (`HSTRT` + 1).
    pub hysteresis_start: u8,
    /// Hysteresis end value, in the chip's units (`HEND` - 3).
    pub hysteresis_end: i8,
    /// Sum of start and end that would be needed.
    pub needed: f32,
    /// Time of a slow decay, s.
    pub off_s: f32,
    /// Blanking time in s.
    pub blank_s: f32,
    /// Rise of the current while it is not measured.
    pub rise: Amps,
    /// Fall of the current in the two slow decays of a cycle.
    pub fall: Amps,
}

//! Sensors behind a converter chip on an SPI bus.

use crate::pin::Pin;
use units::{Celsius, Ohms};

/// Type of a thermocouple.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum ThermocoupleType {
    B,
    E,
    J,
    #[default]
    K,
    N,
    R,
    S,
    T,
}

impl ThermocoupleType {
    /// All types, in the order of [`Self::WORDS`].
    pub const ALL: [Self; 8] = [Self::B, Self::E, Self::J, Self::K, Self::N, Self::R, Self::S, Self::T];
    /// Words for the types in the file, in the order of [`Self::ALL`].
    pub const WORDS: [&'static str; 8] = ["B", "E", "J", "K", "N", "R", "S", "T"];

    /// Returns the highest temperature of the type in a MAX31856 (its datasheet, table 1).
    #[must_use]
    pub const fn highest(self) -> Celsius {
        Celsius(match self {
            Self::B => 1_820.0,
            Self::E => 1_000.0,
            Self::J => 1_200.0,
            Self::K => 1_372.0,
            Self::N => 1_300.0,
            Self::R | Self::S => 1_768.0,
            Self::T => 400.0,
        })
    }
}

/// Connection and settings of a converter chip.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpiSensorConfig {
    /// SPI bus: 0 is SPI1, 1 is SPI4.
    pub channel: Option<u8>,
    /// Chip select output of the converter chip.
    pub select_pin: Option<Pin>,
    /// Thermocouple type, for a MAX31856.
    pub thermocouple: ThermocoupleType,
    /// Number of readings (MAX31855) or samples (MAX31856) that are averaged: 1, 2, 4, 8, 16.
    pub averaging: u8,
    /// Whether the filter of a MAX31856 or MAX31865 suppresses mains of 60 Hz instead of 50 Hz.
    pub mains_60_hz: bool,
    /// Wires of the sensor, 2 to 4, for a MAX31865.
    pub rtd_wires: u8,
    /// Resistance of the sensor at 0 C, for a MAX31865.
    pub rtd_nominal: Ohms,
    /// Reference resistor on the board of a MAX31865.
    pub rtd_reference: Ohms,
}

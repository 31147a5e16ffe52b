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
    /// In the order of [`Self::WORDS`].
    pub const ALL: [Self; 8] = [Self::B, Self::E, Self::J, Self::K, Self::N, Self::R, Self::S, Self::T];
    /// What the file calls them.
    pub const WORDS: [&'static str; 8] = ["B", "E", "J", "K", "N", "R", "S", "T"];

    /// What a MAX31856 reads of it at most (its datasheet, table 1).
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

/// How a converter chip is connected and set.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpiSensorConfig {
    /// SPI bus: 0 is SPI1, 1 is SPI4.
    pub channel: Option<u8>,
    /// Chip select.
    pub select_pin: Option<Pin>,
    /// Of a MAX31856: what is connected.
    pub thermocouple: ThermocoupleType,
    /// Readings of a MAX31855, samples of a MAX31856 that make one: 1, 2, 4, 8, 16.
    pub averaging: u8,
    /// Of a MAX31856 or MAX31865: its filter suppresses mains of 60 Hz instead of 50 Hz.
    pub mains_60_hz: bool,
    /// Of a MAX31865: wires of the sensor, 2 to 4.
    pub rtd_wires: u8,
    /// Of a MAX31865: the sensor at 0 C.
    pub rtd_nominal: Ohms,
    /// Of a MAX31865: the reference resistor on the chip's board.
    pub rtd_reference: Ohms,
}

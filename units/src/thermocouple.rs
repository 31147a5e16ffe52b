//! Types of thermocouples, as settings and converter chips name them.

use crate::Celsius;

/// Type of a thermocouple; the numbers are those of a MAX31856 (its datasheet, register CR1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum Thermocouple {
    B = 0,
    E = 1,
    J = 2,
    #[default]
    K = 3,
    N = 4,
    R = 5,
    S = 6,
    T = 7,
}

impl Thermocouple {
    /// All types, in the order of [`Self::WORDS`].
    pub const ALL: &'static [Self] = &[Self::B, Self::E, Self::J, Self::K, Self::N, Self::R, Self::S, Self::T];
    /// Letters of the types, in the order of [`Self::ALL`].
    pub const WORDS: &'static [&'static str] = &["B", "E", "J", "K", "N", "R", "S", "T"];

    /// Returns the range that a MAX31856 linearises, C (its datasheet, table 1).
    #[must_use]
    pub const fn range(self) -> [f32; 2] {
        match self {
            Self::B => [250.0, 1_820.0],
            Self::E => [-200.0, 1_000.0],
            Self::J => [-210.0, 1_200.0],
            Self::K => [-200.0, 1_372.0],
            Self::N => [-200.0, 1_300.0],
            Self::R | Self::S => [-50.0, 1_768.0],
            Self::T => [-200.0, 400.0],
        }
    }

    /// Returns the highest temperature that a MAX31856 linearises.
    #[must_use]
    pub const fn highest(self) -> Celsius {
        let [_, highest] = self.range();
        Celsius(highest)
    }
}

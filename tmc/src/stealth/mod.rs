//! The chips with stealthChop: TMC2130, TMC5160 and TMC2240 over SPI, TMC2208 and TMC2209 over a single-wire
//! UART. All are on external driver boards, take STEP and DIR, and share one map of 32-bit registers that can
//! be read.
//!
//! | | TMC2130 | TMC5160 | TMC2240 | TMC2208 | TMC2209 |
//! |---|---|---|---|---|---|
//! | bus | SPI | SPI | SPI | UART, one driver | UART, up to four |
//! | bridges | inside | external MOSFETs | inside | inside | inside |
//! | full scale | 0.32 V, 0.18 V (a) | 0.325 V (b) | by CURRENT_RANGE (b, c) | 0.325 V, 0.18 V (a) | same |
//! | short to supply told | no | yes | yes | yes | yes |
//! | GSTAT cleared by | reading | writing ones | writing ones | writing ones | writing ones |
//! | load | stallGuard2, in spreadCycle | stallGuard2 | stallGuard2 | none | stallGuard4, in stealthChop |
//!
//! (a) across the sense resistor and 20 mOhm; (b) times GLOBALSCALER / 256; (c) and a reference resistor.
//!
//! TMC2202, TMC2220, TMC2224 and TMC2225 have the registers of a TMC2208, TMC2226 those of a TMC2209, TMC2160
//! those of a TMC5160.
//!
//! Sources: TMC2130 datasheet Rev. 1.10, TMC5160 datasheet Rev. 1.14, TMC2240 datasheet Rev. 1: chapters "SPI
//! interface", "Register mapping" and "Selecting sense resistors" ("Setting the motor current"); TMC220x and
//! TMC222x datasheet Rev. 1.02, TMC2209 datasheet Rev. 1.03 and 1.09, chapters 4 "UART single wire
//! interface", 5 "Register map" and 8 "Selecting sense resistors".

mod bus;
mod current;
mod driver;
pub mod register;
mod search;
mod settings;
mod status;
mod wire;

pub use bus::{RegisterBus, SpiRegisters};
pub use current::StealthCurrent;
pub use driver::StealthDriver;
pub use settings::StealthSettings;
pub use status::StealthStatus;
pub use wire::{SingleWire, WireFault, WireRegisters};

use crate::BlankTime;
use register::Register;

/// Type of a stealthChop driver chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StealthChip {
    /// Bridges inside, up to 2.5 A peak.
    Tmc2130,
    /// External MOSFETs, current scaled by GLOBALSCALER.
    Tmc5160,
    /// Bridges inside, up to 3 A peak, current measured without sense resistors.
    Tmc2240,
    /// On a UART, without load measurement.
    Tmc2208,
    /// On a UART, up to 2.8 A peak.
    Tmc2209,
}

/// Method of measuring the motor's load.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadMeasurement {
    /// No load measurement.
    None,
    /// While spreadCycle drives; the threshold `SGT` shifts the reading, and 0 is a stall.
    StallGuard2,
    /// While stealthChop drives; up to twice the threshold `SGTHRS` is a stall.
    StallGuard4,
}

impl LoadMeasurement {
    /// Returns the range of stall thresholds.
    #[must_use]
    pub const fn thresholds(self) -> core::ops::RangeInclusive<i16> {
        match self {
            Self::StallGuard4 => 0..=255,
            _ => -64..=63,
        }
    }
}

impl StealthChip {
    /// All supported chips.
    pub const ALL: [Self; 5] = [Self::Tmc2130, Self::Tmc5160, Self::Tmc2240, Self::Tmc2208, Self::Tmc2209];

    /// Returns the chip's name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tmc2130 => "TMC2130",
            Self::Tmc5160 => "TMC5160",
            Self::Tmc2240 => "TMC2240",
            Self::Tmc2208 => "TMC2208",
            Self::Tmc2209 => "TMC2209",
        }
    }

    /// Returns `VERSION`, bits 31 to 24 of IOIN, by which a chip and its type are recognised.
    #[must_use]
    pub const fn version(self) -> u32 {
        match self {
            Self::Tmc2130 => 0x11,
            Self::Tmc5160 => 0x30,
            Self::Tmc2240 => 0x40,
            Self::Tmc2208 => 0x20,
            Self::Tmc2209 => 0x21,
        }
    }

    /// Returns the typical frequency of the internal clock, Hz, the unit of `TSTEP`.
    #[must_use]
    pub const fn clock_hz(self) -> f32 {
        match self {
            Self::Tmc2130 => 13.2e6,
            Self::Tmc2240 => 12.5e6,
            Self::Tmc5160 | Self::Tmc2208 | Self::Tmc2209 => 12.0e6,
        }
    }

    /// Returns whether the chip is on a UART, with the register layout of [`register::wire`].
    #[must_use]
    pub const fn is_on_wire(self) -> bool {
        matches!(self, Self::Tmc2208 | Self::Tmc2209)
    }

    /// Returns whether GLOBALSCALER scales the chip's current, rather than VSENSE.
    #[must_use]
    pub const fn has_global_scaler(self) -> bool {
        matches!(self, Self::Tmc5160 | Self::Tmc2240)
    }

    /// Returns the method of load measurement.
    #[must_use]
    pub const fn load(self) -> LoadMeasurement {
        match self {
            Self::Tmc2208 => LoadMeasurement::None,
            Self::Tmc2209 => LoadMeasurement::StallGuard4,
            _ => LoadMeasurement::StallGuard2,
        }
    }

    /// Returns the comparator blanking, in chip clocks.
    #[must_use]
    pub const fn blank_clocks(self, time: BlankTime) -> u8 {
        match (self.is_on_wire(), time) {
            (true, BlankTime::Clocks36) => 32,
            (true, BlankTime::Clocks54) => 40,
            _ => time.clocks(),
        }
    }

    /// Converts the blanking from chip clocks; only the four values of the chip.
    #[must_use]
    pub fn blank_time(self, clocks: u8) -> Option<BlankTime> {
        use BlankTime::{Clocks16, Clocks24, Clocks36, Clocks54};
        [Clocks16, Clocks24, Clocks36, Clocks54].into_iter().find(|time| self.blank_clocks(*time) == clocks)
    }

    /// Returns the register that holds the inputs and the version.
    pub(crate) const fn inputs(self) -> Register {
        if self.is_on_wire() { register::wire::IOIN } else { register::IOIN }
    }

    /// Returns PWMCONF after power-up: stealthChop finds its amplitude by itself (`pwm_autoscale`, and
    /// `pwm_autograd` if the chip has it).
    pub(crate) const fn pwmconf(self) -> u32 {
        match self {
            Self::Tmc2130 => 0x0005_0480,
            Self::Tmc5160 => 0xC40C_001E,
            Self::Tmc2240 => 0xC40C_001D,
            Self::Tmc2208 | Self::Tmc2209 => 0xC10D_0024,
        }
    }
}

/// `TSTEP` at a speed: clocks between two steps of 1/256, for a chip that runs with its internal clock. The
/// thresholds TPWMTHRS and TCOOLTHRS are such times. 20 bits; standstill is the longest.
#[must_use]
pub fn step_time(chip: StealthChip, full_steps_per_s: f32) -> u32 {
    // A float to integer cast saturates, and turns NaN into 0.
    ((chip.clock_hz() / (full_steps_per_s * 256.0) + 0.5) as u32).min(LONGEST_STEP_TIME)
}

/// The time between two steps at standstill: a threshold that every speed is above.
pub const LONGEST_STEP_TIME: u32 = (1 << 20) - 1;

#[cfg(test)]
mod tests;

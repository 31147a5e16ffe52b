//! The chips with stealthChop: TMC2130, TMC5160 and TMC2240 over SPI. They are on driver boards outside, take
//! STEP and DIR, and share one map of 32-bit registers that can be read.
//!
//! | | TMC2130 | TMC5160 | TMC2240 |
//! |---|---|---|---|
//! | bridges | inside | external MOSFETs | inside |
//! | full scale | 0.32 V or 0.18 V across the sense resistor and 20 mOhm | 0.325 V, times GLOBALSCALER / 256 | by CURRENT_RANGE and a reference resistor, times GLOBALSCALER / 256 |
//! | short to supply told | no | yes | yes |
//! | GSTAT | cleared by reading | cleared by writing ones | cleared by writing ones |
//!
//! Sources: TMC2130 datasheet Rev. 1.10, TMC5160 datasheet Rev. 1.14, TMC2240 datasheet Rev. 1: chapters "SPI
//! interface", "Register mapping" and "Selecting sense resistors" ("Setting the motor current").

mod bus;
mod current;
mod driver;
pub mod register;
mod settings;
mod status;

pub use bus::{RegisterBus, SpiRegisters};
pub use current::StealthCurrent;
pub use driver::StealthDriver;
pub use settings::StealthSettings;
pub use status::StealthStatus;

/// Which chip it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StealthChip {
    /// Bridges inside, up to 2.5 A peak.
    Tmc2130,
    /// External MOSFETs.
    Tmc5160,
    /// Bridges inside, up to 3 A peak, current measured without sense resistors.
    Tmc2240,
}

impl StealthChip {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Tmc2130, Self::Tmc5160, Self::Tmc2240];

    /// The chip's name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tmc2130 => "TMC2130",
            Self::Tmc5160 => "TMC5160",
            Self::Tmc2240 => "TMC2240",
        }
    }

    /// `VERSION`, bits 31 to 24 of IOIN: tells that a chip answers, and which.
    #[must_use]
    pub const fn version(self) -> u32 {
        match self {
            Self::Tmc2130 => 0x11,
            Self::Tmc5160 => 0x30,
            Self::Tmc2240 => 0x40,
        }
    }

    /// Frequency of the internal clock, Hz, typical: what `TSTEP` counts.
    #[must_use]
    pub const fn clock_hz(self) -> f32 {
        match self {
            Self::Tmc2130 => 13.2e6,
            Self::Tmc5160 => 12.0e6,
            Self::Tmc2240 => 12.5e6,
        }
    }

    /// GLOBALSCALER scales its current, rather than VSENSE.
    #[must_use]
    pub const fn has_global_scaler(self) -> bool {
        !matches!(self, Self::Tmc2130)
    }

    /// PWMCONF after power-up: stealthChop finds its amplitude by itself (`pwm_autoscale`, and
    /// `pwm_autograd` where the chip has it).
    pub(crate) const fn pwmconf(self) -> u32 {
        match self {
            Self::Tmc2130 => 0x0005_0480,
            Self::Tmc5160 => 0xC40C_001E,
            Self::Tmc2240 => 0xC40C_001D,
        }
    }
}

/// `TSTEP` at a speed: clocks between two steps of 1/256, for a chip that runs with its internal clock. The
/// thresholds TPWMTHRS and TCOOLTHRS are such times. 20 bits; standstill is the longest.
#[must_use]
pub fn step_time(chip: StealthChip, full_steps_per_s: f32) -> u32 {
    const LONGEST: u32 = (1 << 20) - 1;
    // A float to integer cast saturates, and takes a number that is none as 0.
    ((chip.clock_hz() / (full_steps_per_s * 256.0) + 0.5) as u32).min(LONGEST)
}

#[cfg(test)]
mod tests;

//! Trinamic stepper motor drivers: TMC2590 and TMC2660 on the board over SPI, and in [`stealth`] the chips of
//! external driver boards.
//!
//! [`register`] lists the five write-only registers and the answer, every field under its datasheet name.
//! [`Driver`] offers the settings: amperes, microsteps, chopper, and the chip's state. The two chips share
//! one register map; [`Chip`] holds their differences.
//!
//! | | TMC2590 | TMC2660 |
//! |---|---|---|
//! | bridges | external MOSFETs | inside |
//! | sense voltage at full scale | 325 mV or 173 mV | 310 mV or 165 mV |
//! | full diagnostics (`RDSEL` = %11) | yes | no |
//!
//! Sources: TMC2590 datasheet V1.0 (2019-FEB-22) section 7, TMC2660 datasheet Rev. 1.05 (2016-JUL-14)
//! section 6.
//!
//! ```
//! # use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
//! # struct Bus;
//! # impl ErrorType for Bus { type Error = core::convert::Infallible; }
//! # impl SpiDevice for Bus {
//! #     fn transaction(&mut self, work: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
//! #         for step in work { if let Operation::TransferInPlace(frame) = step {
//! frame.copy_from_slice(b"\x00\x08\x05"); } }
//! #         Ok(())
//! #     }
//! # }
//! use tmc::{Chip, Driver, Microsteps, StepInput};
//! use units::{Amps, Ohms};
//!
//! # let spi = Bus;
//! let mut driver = Driver::new(spi, Chip::Tmc2660, Ohms(0.1))?;
//! driver.start()?; // bridges still off
//! driver.set_current(Amps(1.5))?;
//! driver.set_step_input(StepInput { microsteps: Microsteps::M16, double_edge: true, interpolation: true })?;
//! driver.enable()?;
//! # Ok::<(), tmc::Error<core::convert::Infallible>>(())
//! ```
#![cfg_attr(not(test), no_std)]

mod chopper;
mod current;
mod driver;
pub mod register;
mod status;
pub mod stealth;

pub use chopper::{BlankTime, Chopper, CoolStep, HysteresisDecrement, Regulated, SettingError};
pub use current::{CurrentFit, CurrentSetting, current_setting};
pub use driver::{Driver, Error, Microsteps, StallGuard, StepInput};
pub use status::{Diagnostics, ReadSelect, Reading, Status, Temperature};

use embedded_hal::spi;
use units::Ohms;

/// SPI mode of the chips: clock idles high, data is taken on the rising edge (TMC2590 datasheet section 7.2).
pub const SPI_MODE: spi::Mode = spi::MODE_3;
/// SPI clock that is safe with the internal oscillator at its slowest: below a quarter of 10 MHz with a wide
/// margin.
pub const SPI_CLOCK_HZ: u32 = 500_000;

/// Type of the driver chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chip {
    /// External MOSFETs, full diagnostics.
    Tmc2590,
    /// Internal MOSFETs, no full diagnostics.
    Tmc2660,
}

impl Chip {
    /// Returns the sense resistor fitted on the Smoothieboard v2 Prime.
    #[must_use]
    pub const fn default_sense_resistor(self) -> Ohms {
        match self {
            Self::Tmc2590 => Ohms(0.050),
            Self::Tmc2660 => Ohms(0.100),
        }
    }

    /// Returns the default strength of the gate drive, 0 the gentlest.
    ///
    /// A TMC2590 drives the board's Si4542DY pairs, whose gates take few nanocoulombs. The data sheet calls
    /// `SLPH` = `SLPL` = 3 with `SLP2` clear "medium" (section 7.11, strength 3 of 7 in section 7.9: 36 mA
    /// and 42 mA); the maker's own code starts with this strength (TMC-API, DRVCONF EF040), as do these
    /// boards. The MOSFETs inside a TMC2660 run with the gentlest slopes, on these boards and on others with
    /// that chip.
    #[must_use]
    pub const fn default_gate_drive(self) -> u8 {
        match self {
            Self::Tmc2590 => 3,
            Self::Tmc2660 => 0,
        }
    }

    /// Returns the greatest strength of the gate drive: three bits (`SLP2` above `SLPH` or `SLPL`), or two.
    #[must_use]
    pub const fn strongest_gate_drive(self) -> u8 {
        match self {
            Self::Tmc2590 => 7,
            Self::Tmc2660 => 3,
        }
    }

    /// Returns the chip's name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tmc2590 => "TMC2590",
            Self::Tmc2660 => "TMC2660",
        }
    }
}

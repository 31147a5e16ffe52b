//! Peripherals of the STM32H745 that the emulator lacks or models for another part.

pub mod ethernet;
pub mod fmc;
pub mod iwdg;
pub mod otg;
pub mod pwr;
pub mod rtc;
pub mod sdmmc;

mod rtc_calendar;
mod sdmmc_flags;

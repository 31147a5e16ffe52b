//! An emulated Smoothieboard v2 Prime that runs an unmodified firmware image, with the simulated machine of
//! the `sim` crate on its pins.
//!
//! The microcontroller is the `rigless` crate's STM32H743 with what makes it the board's STM32H745, and with
//! the peripherals that crate lacks ([`peripherals`]). [`board`] solders the rest to it. [`vm`] runs an image
//! on it, one span of virtual time after another, and lends everything in between to the caller.
//!
//! All models come from the reference manual (RM0399), the chips' datasheets and the board's schematic, never
//! from the needs of a single firmware: other images for this board run as well.

pub mod board;
pub mod complaints;
pub mod console;
pub mod factory;
pub mod flash_journal;
pub mod image;
pub mod instruments;
pub mod mcu;
pub mod net_desk;
pub mod peripherals;
pub mod pin_state;
pub mod pins;
pub mod rtt;
pub mod sd_image;
pub mod typed;
pub mod usb_desk;
pub mod vm;

mod clock_modes;
mod drivers;
mod outputs;
mod timer_outputs;
mod translations;

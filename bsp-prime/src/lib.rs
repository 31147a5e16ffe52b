//! The Smoothieboard v2 Prime (STM32H745XI, Cortex-M7 at 400 MHz): clocks, memory, pins by role, timers and
//! buses.
//!
//! [`Board::take`] brings the board up in the one safe order, every output off before anything else, and
//! gives back a struct of roles. Pins that a configuration names are handed out by [`pins::Pins`], which
//! knows who owns what. Nothing here waits without a bound, and nothing here knows what a heater or an axis
//! means.
//!
//! `stm32h7xx-hal` sets up the supply and the clock tree; what it does not offer (scans, rings, latches,
//! IDMA, placement) is done on the registers, each with the section of the reference manual RM0399
//! (revision 4) that says so.
#![no_std]
#![allow(unsafe_code, reason = "the board package is where registers, linker symbols and the MPU are reached")]

pub mod adc;
pub mod board;
pub mod boot_request;
pub mod boot_stage;
pub mod byte_ring;
pub mod clocks;
mod copy;
pub mod dma;
pub mod ethernet;
pub mod factory;
pub mod flash;
pub mod fpu;
pub mod identity;
pub mod kept;
pub mod laser;
pub mod last_words;
pub mod led_strip;
#[cfg(feature = "rtt")]
pub mod log;
pub mod memory;
pub mod pins;
pub mod pwm;
pub mod random;
pub mod rtc;
#[cfg(feature = "rtt")]
pub mod rtt;
pub mod sd;
mod silicon;
pub mod single_wire;
pub mod spi;
pub mod step_engine;
mod supply;
pub mod thread_stack;
pub mod time;
pub mod trigger;
pub mod uart;
pub mod usb;
pub mod wait;
pub mod watchdog;

pub use board::{Board, BoardError};
pub use stm32h7xx_hal::pac;

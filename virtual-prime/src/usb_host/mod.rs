//! A USB host beside the board: what a personal computer does to the device at the other end of the cable, at
//! full speed and in virtual time.
//!
//! [`controller`] makes transactions out of transfers and hands them to whoever implements
//! [`wire::Function`]; it knows nothing of the emulator.

pub mod controller;
pub mod transfer;
pub mod wire;

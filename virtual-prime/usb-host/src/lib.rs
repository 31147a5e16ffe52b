//! A USB host: what a personal computer does to the device at the other end of the cable, at full speed and
//! in virtual time. Knows nothing of the emulator.
//!
//! [`controller`] makes transactions out of transfers and hands them to whoever implements
//! [`wire::Function`].
//!
//! [`hub`] looks after the port for somebody who commands it from elsewhere: [`remote`] lets another computer
//! do that over TCP, by [`usbredir`] or [`usbip`].

pub mod controller;
pub mod descriptors;
pub mod hub;
#[cfg(test)]
mod mock;
pub mod remote;
pub mod request;
pub mod transfer;
pub mod usbip;
pub mod usbredir;
pub mod wire;

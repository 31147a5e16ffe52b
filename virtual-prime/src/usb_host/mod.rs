//! A USB host beside the board: what a personal computer does to the device at the other end of the cable, at
//! full speed and in virtual time.
//!
//! [`controller`] makes transactions out of transfers and hands them to whoever implements
//! [`wire::Function`]; it knows nothing of the emulator. [`desk`] is the host for tests: it plugs in,
//! enumerates, and waits for transfers. [`cdc`], [`bulk_only`], [`scsi`] and [`dfu`] speak the classes.
//!
//! [`hub`] looks after the port for somebody who commands it from elsewhere: [`remote`] lets another computer
//! do that over TCP, by [`usbredir`] or [`usbip`].

pub mod bulk_only;
pub mod cdc;
pub mod controller;
pub mod descriptors;
pub mod desk;
pub mod dfu;
pub mod hub;
#[cfg(test)]
mod mock;
pub mod remote;
pub mod request;
pub mod scsi;
pub mod transfer;
pub mod usbip;
pub mod usbredir;
pub mod wire;

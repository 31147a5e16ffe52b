//! The board as a USB device: two serial ports, the card as a disk, the entry to the firmware download; and,
//! for the boot stage, the download itself.
//!
//! The crate is generic over the bus trait of `usb-device`, which implements chapter 9 of the USB 2.0
//! specification. Connections of ports, disk and download are passed in: [`Line`], [`Medium`], [`Detach`],
//! [`Firmware`]. No code here waits or allocates: the owner of the controller's interrupt calls
//! [`Composite::run`], which does a bounded piece of work.
//!
//! Controller, machine and card are outside this crate.
#![cfg_attr(not(test), no_std)]

mod cdc;
mod composite;
mod dfu;
mod guarded;
mod identity;
mod microsoft;
mod standard;
mod storage;
#[cfg(test)]
mod testing;

pub use cdc::{Line, SerialPort};
pub use composite::{Composite, Functions, Held, Presence};
pub use dfu::{Detach, DfuRuntime, DownloadDevice, Firmware, Refused, TRANSFER_BYTES};
pub use guarded::Guarded;
pub use identity::{MANUFACTURER, PRODUCT, PRODUCT_NAME, SerialNumber, VENDOR};
pub use storage::{BLOCK_BYTES, Fault, Half, MassStorage, Medium, Progress, State};
pub use usb_device::bus::{UsbBus, UsbBusAllocator};

/// Longest packet of a bulk or control endpoint at full speed (USB 2.0 sections 5.5.3 and 5.8.3).
pub const PACKET_BYTES: usize = 64;

/// Packets of the host that an endpoint of the controller holds, acknowledged and not fetched.
pub const PACKETS_HELD: usize = 2;

//! What the board is as a USB device: two serial ports, the card as a disk, the way into the firmware
//! download; and, for the boot stage, the download itself.
//!
//! Everything here is over the bus trait of `usb-device`, which does what chapter 9 of the USB 2.0
//! specification asks of any device. What is connected to a port, a disk or a download is handed in:
//! [`Line`], [`Medium`], [`Detach`], [`Firmware`]. Nothing waits and nothing allocates: whoever has the
//! controller's interrupt calls [`Composite::run`], which does a bounded piece of work.
//!
//! What this crate does not know: the controller, the machine, the card.
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

/// The longest packet of a bulk or control endpoint at full speed (USB 2.0 sections 5.5.3 and 5.8.3).
pub const PACKET_BYTES: usize = 64;

/// Packets of the host that an endpoint of the controller holds, acknowledged and not fetched.
pub const PACKETS_HELD: usize = 2;

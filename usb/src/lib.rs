//! What the board is as a USB device: two serial ports, the card as a disk, the way into the firmware
//! download; and, for the boot stage, the download itself.
//!
//! Everything here is over the bus trait of `usb-device`, which does what chapter 9 of the USB 2.0
//! specification asks of any device. What a port is connected to is handed in: [`Line`]. Nothing waits and
//! nothing allocates.
//!
//! What this crate does not know: the controller, the machine, the card.
#![cfg_attr(not(test), no_std)]

mod cdc;
mod guarded;
mod identity;
mod standard;
mod storage;

pub use cdc::{Line, LineCoding, Parity, SerialPort, StopBits};
pub use guarded::Guarded;
pub use identity::{MANUFACTURER, PRODUCT, PRODUCT_NAME, SerialNumber, VENDOR};
pub use storage::{BLOCK_BYTES, Fault, Half, MassStorage, Medium, Progress, State};
pub use usb_device::bus::{UsbBus, UsbBusAllocator};

/// The longest packet of a bulk or control endpoint at full speed (USB 2.0 sections 5.5.3 and 5.8.3).
pub const PACKET_BYTES: usize = 64;

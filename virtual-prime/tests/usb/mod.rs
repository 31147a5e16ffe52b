//! The USB socket: the model and the host, tested by two images that are not ours, and by our own image.
//! `echo` is a serial port made of other people's crates, `registers` a device of register accesses alone,
//! driven by interrupts.

mod disk;
mod download;
mod echo;
mod fuzz;
mod load;
mod ports;
mod raster;
mod registers;
mod remote;
mod replug;
mod table;
mod velvet;

use sim::world::WorldConfig;
use virtual_prime::board::PrimeBoard;
use virtual_prime::usb_desk::{Desk, Device, UsbHost};

use crate::common::{Bench, MS, boot_on};

/// A board that runs a test image, and a host that is not plugged in.
fn boot(name: &str) -> (Bench, UsbHost) {
    let board = PrimeBoard::new(WorldConfig::default()).expect("the board's tables are right");
    (boot_on(name, board), UsbHost::new())
}

/// Plugs in and enumerates.
#[track_caller]
fn enumerate(desk: &mut Desk<'_>) -> Device {
    desk.plug();
    desk.enumerate().expect("the image is a USB device")
}

/// Asserts that the board has no complaints.
#[track_caller]
fn assert_clean(bench: &mut Bench) {
    assert_eq!(bench.vm.complaints(), Vec::<String>::new());
}

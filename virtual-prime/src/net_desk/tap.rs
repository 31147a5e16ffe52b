//! A TAP device of Linux at the other end of the cable: the board is on this computer's network.

use std::io;

use smoltcp::phy::{Device, RxToken, TxToken};
use smoltcp::time::Instant;

use crate::peripherals::ethernet::Wire;
use crate::vm::Vm;

/// Device that only Linux has; elsewhere one that moves nothing takes its place and is never opened.
#[cfg(target_os = "linux")]
type Interface = smoltcp::phy::TunTapInterface;
#[cfg(not(target_os = "linux"))]
type Interface = super::port::Port;

/// Frames that are taken from the device at once.
const BATCH: usize = 64;

/// The device.
pub struct Tap(Interface);

impl Tap {
    /// Opens a device. With one that `ip tuntap` has made for the user no rights are needed.
    ///
    /// # Errors
    /// When it cannot be opened, and on systems other than Linux.
    #[cfg(target_os = "linux")]
    pub fn open(name: &str) -> io::Result<Self> {
        Interface::new(name, smoltcp::phy::Medium::Ethernet).map(Self)
    }

    /// Opens a device.
    ///
    /// # Errors
    /// Always: only Linux has one.
    #[cfg(not(target_os = "linux"))]
    pub fn open(_: &str) -> io::Result<Self> {
        Err(io::ErrorKind::Unsupported.into())
    }

    /// Carries frames both ways, at the instant at which the board is held.
    pub fn serve(&mut self, vm: &mut Vm) {
        for frame in super::wire(vm, Wire::take_all).unwrap_or_default() {
            if let Some(room) = self.0.transmit(Instant::ZERO) {
                room.consume(frame.bytes.len(), |bytes| bytes.copy_from_slice(&frame.bytes));
            }
        }
        let mut frames = Vec::new();
        while frames.len() < BATCH
            && let Some((frame, _)) = self.0.receive(Instant::ZERO)
        {
            frames.push(frame.consume(<[u8]>::to_vec));
        }
        if !frames.is_empty() {
            super::wire(vm, move |wire| frames.iter().for_each(|frame| wire.put(frame)));
        }
    }
}

//! The lines to a host: the debug console's port and the USB socket. Whoever last sent a whole block gets the
//! answers.
//!
//! Bytes go through a ring each way. A ring from the host holds more than a host sends without an answer, and
//! is emptied by idle alone.

use bsp_prime::byte_ring::ByteRing;
use bsp_prime::uart::UartPort;
use klipper::{Framer, Incoming};

use crate::usb;

/// Size of the port's ring, bytes.
const FROM_UART_BYTES: usize = 2048;

/// Bytes that came in at the debug console's port.
pub static FROM_UART: ByteRing<FROM_UART_BYTES> = ByteRing::new();

/// A way to the host.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Way {
    Uart,
    Usb,
}

/// The lines, for idle.
pub struct Lines {
    uart: UartPort,
    framers: [(Way, Framer); 2],
    /// Line that the answers go to.
    speaker: Option<Way>,
}

impl Lines {
    /// Creates the lines, on which nobody has spoken.
    pub const fn new(uart: UartPort) -> Self {
        Self { uart, framers: [(Way::Uart, Framer::new()), (Way::Usb, Framer::new())], speaker: None }
    }

    /// Takes bytes up to the next block, or up to something that is none. What is damaged counts only on the
    /// line that the host speaks on: at the other one it may be anything.
    pub fn next(&mut self) -> Option<Incoming> {
        for (way, framer) in &mut self.framers {
            let ring = match way {
                Way::Uart => &FROM_UART,
                Way::Usb => usb::from_host(),
            };
            while let Some(byte) = ring.pop() {
                match framer.take(byte) {
                    Some(Incoming::Block(block)) => {
                        self.speaker = Some(*way);
                        return Some(Incoming::Block(block));
                    }
                    Some(Incoming::Damaged) if self.speaker == Some(*way) => return Some(Incoming::Damaged),
                    Some(Incoming::Damaged) | None => {}
                }
            }
        }
        None
    }

    /// Returns how many bytes for the host a write takes. Without a host it takes all, which are lost.
    pub fn room(&self) -> usize {
        match self.speaker {
            Some(Way::Uart) => self.uart.room(),
            Some(Way::Usb) => usb::room(),
            None => usize::MAX,
        }
    }

    /// Sends bytes for which there is room.
    pub fn write(&mut self, bytes: &[u8]) {
        match self.speaker {
            Some(Way::Uart) => {
                self.uart.write(bytes);
            }
            Some(Way::Usb) => usb::write(bytes),
            None => {}
        }
    }

    /// Whether everything that was written is on its way.
    pub fn is_drained(&self) -> bool {
        match self.speaker {
            Some(Way::Uart) => self.uart.is_drained(),
            Some(Way::Usb) => usb::is_drained(),
            None => true,
        }
    }
}

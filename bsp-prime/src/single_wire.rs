//! An auxiliary UART as a single-wire line: TX leads over a resistor (1 kOhm) to the wire, RX is on it, so
//! that the port hears its own output, and others can pull the wire against the resistor.
//!
//! The port's half-duplex mode (HDSEL, RM0399 section 51.5.15) would spare a pin and the resistor. But its
//! output then is open drain, and the wires that this is for have nothing that pulls them up but the chip's
//! own 40 kOhm, which is too slow; and without an echo a broken wire looks like one on which nobody answers.
//!
//! No interrupts: the caller waits for the answer, at most for the limit stated here. All handles of a port
//! belong to one owner; a flag turns a breach of that into an error.

use core::sync::atomic::{AtomicBool, Ordering};

use stm32h7xx_hal::pac;

use crate::uart::{Frame, PortName, UartPort};
use crate::wait;

/// Bits a second: a fourth of the least limit of the chips on such lines, quick enough that a status takes
/// less than two milliseconds.
pub const BAUD: u32 = 250_000;
/// Idle time before a datagram, sixteen bit times: a chip that lost synchronisation listens again after
/// twelve.
const IDLE_US: u32 = 64;
/// Limit of the wait for the echo, and again for the answer: eight bytes and the delay before them take half
/// a millisecond. Ten times that.
const LIMIT_US: u32 = 5_000;
/// Size of the port's FIFO in bytes (RM0399 section 51.5.4).
const FIFO_BYTES: usize = 16;

/// An exchange is under way, for each port. Never found set as long as all handles belong to one owner.
static BUSY: [AtomicBool; 3] = [const { AtomicBool::new(false) }; 3];

/// Failure of an exchange on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireError {
    /// Not all bytes sent came back as an echo.
    NoEcho,
    /// The echo differs from the bytes sent, or is garbled.
    Disturbed,
    /// No answer, or not all of it.
    NoAnswer,
    /// More bytes than the FIFO holds, or two owners at once.
    Misused,
}

/// Handle of a port in use as a single-wire line.
#[derive(Debug)]
pub struct SingleWireLine {
    name: PortName,
}

impl UartPort {
    /// Opens the port as a single-wire line. Call once; its interrupt has nothing to do from then on.
    pub fn open_single_wire(&mut self) {
        self.open(BAUD, Frame::PLAIN);
        // SAFETY: the port's interrupt, its only other user, has nothing to send, and nothing is received
        // yet.
        let uart = unsafe { &*self.name().registers() };
        // RM0399 section 51.8.1, USART_CR1: RXNEIE may be changed at any time.
        uart.cr1.modify(|_, w| w.rxneie().clear_bit());
    }

    /// Returns a handle of this port, once [`Self::open_single_wire`] has been called.
    #[must_use]
    pub const fn line(&self) -> SingleWireLine {
        SingleWireLine { name: self.name() }
    }
}

impl SingleWireLine {
    /// Sends, takes the echo off the line, and waits for as many bytes as `answer` holds.
    ///
    /// # Errors
    /// What did not come.
    pub fn exchange(&mut self, bytes: &[u8], answer: &mut [u8]) -> Result<(), WireError> {
        let Some(busy) = BUSY.get(self.name as usize).filter(|_| bytes.len() <= FIFO_BYTES) else {
            return Err(WireError::Misused);
        };
        if busy.swap(true, Ordering::Acquire) {
            return Err(WireError::Misused);
        }
        // SAFETY: `BUSY` lets one exchange at a time in, and the port's interrupt is off.
        let done = exchange(unsafe { &*self.name.registers() }, bytes, answer);
        busy.store(false, Ordering::Release);
        done
    }
}

fn exchange(uart: &pac::usart1::RegisterBlock, bytes: &[u8], answer: &mut [u8]) -> Result<(), WireError> {
    wait::pause(IDLE_US);
    // RM0399 section 51.8.8, USART_RQR: RXFRQ empties the receiver, whose bytes answer no request.
    uart.rqr.write(|w| w.rxfrq().set_bit());
    uart.icr.write(|w| w.orecf().set_bit().fecf().set_bit().ncf().set_bit());
    for byte in bytes {
        uart.tdr.write(|w| w.tdr().bits(u16::from(*byte)));
    }
    let mut echo = [0; FIFO_BYTES];
    let echo = echo.get_mut(..bytes.len()).ok_or(WireError::Misused)?;
    if receive(uart, echo) < bytes.len() {
        return Err(WireError::NoEcho);
    }
    if *echo != *bytes {
        return Err(WireError::Disturbed);
    }
    if receive(uart, answer) < answer.len() {
        return Err(WireError::NoAnswer);
    }
    let status = uart.isr.read();
    let is_garbled = status.ore().bit_is_set() || status.fe().bit_is_set() || status.nf().bit_is_set();
    if is_garbled { Err(WireError::Disturbed) } else { Ok(()) }
}

/// Takes so many bytes off the line; returns the number that came in time.
fn receive(uart: &pac::usart1::RegisterBlock, into: &mut [u8]) -> usize {
    let mut count = 0;
    // The number of bytes received shows whether the wait timed out.
    let _timed_out = wait::until(LIMIT_US, || {
        while let Some(place) = into.get_mut(count) {
            if uart.isr.read().rxne().bit_is_clear() {
                return false;
            }
            *place = uart.rdr.read().rdr().bits() as u8;
            count += 1;
        }
        true
    });
    count
}

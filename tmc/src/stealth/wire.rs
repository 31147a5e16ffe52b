//! Registers over the single-wire UART: TMC2209 datasheet Rev. 1.03, chapter 4.
//!
//! A datagram begins with a byte by which the chip learns the baud rate, and ends with a check sum. To a
//! request the chip answers after a while, on the same wire. A write is not answered; the chip counts those
//! that arrive, so the counter is read after each.

use super::bus::RegisterBus;
use super::register::wire;
use crate::Error;

/// "sync + reserved", the least significant bit first on the wire: 1010 tells the bit time.
const SYNC: u8 = 0x05;
/// Bit in the address of a datagram that writes.
const WRITE: u8 = 0x80;
/// Address of the master, to which answers go.
const MASTER: u8 = 0xFF;
/// Number of tries before a datagram counts as lost.
const TRIES: u32 = 3;

/// Serial line of 8 bits, no parity, one stop bit, that receives its own output: the output leads to the wire
/// through a resistor, the input is on the wire.
pub trait SingleWire {
    /// Error of the serial port.
    type Error: core::fmt::Debug;

    /// Waits until the line has been idle for at least twelve bit times, after which a chip that has lost its
    /// way listens again; sends the datagram, takes its echo off the line, and waits for an answer, if one is
    /// wanted. Every wait is bounded.
    ///
    /// # Errors
    /// The bytes that did not come, or came back changed.
    fn exchange(&mut self, datagram: &[u8], answer: &mut [u8]) -> Result<(), WireFault<Self::Error>>;
}

/// Failure of an exchange on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireFault<E> {
    /// The port itself failed.
    Port(E),
    /// Not even the echo came back: output and input are not on one wire.
    NoEcho,
    /// The echo differs from the bytes sent.
    Disturbed,
    /// The echo came back, but no answer.
    NoAnswer,
}

/// The check sum of a datagram: CRC8-ATM, polynomial x^8 + x^2 + x + 1, each byte's least significant bit
/// first (section 4.2).
fn check_sum(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |crc, byte| {
        (0..8).fold(crc, |crc: u8, bit| {
            let differs = (crc >> 7 ^ byte >> bit) & 1;
            (crc << 1) ^ (differs * 0x07)
        })
    })
}

/// The registers of a chip on such a line, by its address: 0 to 3 with a TMC2209, as its pins MS1 and MS2
/// say; 0 with a TMC2208.
#[derive(Debug)]
pub struct WireRegisters<LINE> {
    line: LINE,
    address: u8,
    /// Last value of IFCNT.
    count: Option<u8>,
}

impl<LINE: SingleWire> WireRegisters<LINE> {
    /// Creates access to the chip with this address.
    pub const fn new(line: LINE, address: u8) -> Self {
        Self { line, address, count: None }
    }

    fn ask(&mut self, register: u8) -> Result<u32, Error<LINE::Error>> {
        let mut wrong = Error::Absent;
        for _ in 0..TRIES {
            match self.ask_once(register) {
                Ok(value) => return Ok(value),
                Err(error) => wrong = error,
            }
        }
        Err(wrong)
    }

    fn ask_once(&mut self, register: u8) -> Result<u32, Error<LINE::Error>> {
        let mut request = [SYNC, self.address, register, 0];
        seal(&mut request);
        let mut answer = [0; 8];
        self.line.exchange(&request, &mut answer).map_err(fault)?;
        let [sync, master, from, data @ .., sum] = answer;
        let value = u32::from_be_bytes(data);
        let [sealed @ .., _] = &answer;
        let is_sound = sync & 0xF == SYNC && master == MASTER && from == register && check_sum(sealed) == sum;
        if is_sound { Ok(value) } else { Err(Error::WrongAnswer(value)) }
    }

    fn counter(&mut self) -> Result<u8, Error<LINE::Error>> {
        self.ask(wire::IFCNT.address).map(|count| count as u8)
    }
}

/// Puts the check sum in its place.
fn seal(datagram: &mut [u8]) {
    if let [bytes @ .., sum] = datagram {
        *sum = check_sum(bytes);
    }
}

fn fault<E>(fault: WireFault<E>) -> Error<E> {
    match fault {
        WireFault::Port(error) => Error::Bus(error),
        WireFault::NoEcho => Error::NoEcho,
        WireFault::Disturbed => Error::WrongAnswer(0),
        WireFault::NoAnswer => Error::Absent,
    }
}

impl<LINE: SingleWire> RegisterBus for WireRegisters<LINE> {
    type Error = LINE::Error;

    fn read<const N: usize>(&mut self, addresses: [u8; N]) -> Result<[u32; N], Error<LINE::Error>> {
        let mut values = [0; N];
        for (value, address) in values.iter_mut().zip(addresses) {
            *value = self.ask(address)?;
        }
        Ok(values)
    }

    /// The counter shows whether the write arrived. A write counted twice was sent twice, which harms no
    /// register.
    fn write(&mut self, address: u8, value: u32) -> Result<(), Error<LINE::Error>> {
        let [a, b, c, d] = value.to_be_bytes();
        let mut datagram = [SYNC, self.address, address | WRITE, a, b, c, d, 0];
        seal(&mut datagram);
        let mut before = match self.count {
            Some(count) => count,
            None => self.counter()?,
        };
        // The counter is unknown until it has been read again.
        self.count = None;
        for _ in 0..TRIES {
            self.line.exchange(&datagram, &mut []).or_else(|error| match error {
                // The counter shows whether the chip received the write.
                WireFault::Disturbed => Ok(()),
                error => Err(fault(error)),
            })?;
            let after = self.counter()?;
            if after == before.wrapping_add(1) {
                self.count = Some(after);
                return Ok(());
            }
            before = after;
        }
        Err(Error::WrongAnswer(u32::from(before)))
    }
}

#[cfg(test)]
mod tests;

//! I2C by two open-drain pins (UM10204, "I2C-bus specification and user manual", section 3).

use crate::board::{Board, Wire};
use crate::numbers::I2C_STATUS;
use crate::objects::spi::Bytes;

/// Outcome of a transfer: the numbers of the dictionary's enumeration `i2c_bus_status`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Status {
    /// All bytes were acknowledged.
    Success = 0,
    /// A byte behind the address was not.
    Nack = 1,
    /// The clock was held low for too long.
    Timeout = 2,
    /// The address was not acknowledged.
    StartNack = 3,
    /// The address was not acknowledged where bytes were to be read.
    StartReadNack = 4,
}

// Each has its name in the dictionary.
const _: () = assert!(I2C_STATUS.len() == Status::StartReadNack as usize + 1);

/// A chip holds the clock low for at most so many half periods: at 100 kHz 5 ms.
const MOST_STRETCHED: u32 = 1000;

/// A chip at two pins.
pub struct I2c<B: Board> {
    /// The line SCL.
    pub clock: B::Wire,
    /// The line SDA.
    pub data: B::Wire,
    /// Length of half a period of the clock, ticks.
    pub pulse_ticks: u32,
    /// Address of seven bits.
    pub address: u8,
}

impl<B: Board> I2c<B> {
    /// Writes bytes, then reads so many.
    ///
    /// # Errors
    /// The first byte that was not acknowledged, or a clock that was held low.
    pub fn transfer(&mut self, write: &[u8], read_length: usize) -> Result<Bytes, Status> {
        let outcome = self.exchange(write, read_length);
        self.stop();
        outcome
    }

    fn exchange(&mut self, write: &[u8], read_length: usize) -> Result<Bytes, Status> {
        let mut read = Bytes::new();
        if !write.is_empty() || read_length == 0 {
            self.start();
            self.put(self.address << 1, Status::StartNack)?;
            write.iter().try_for_each(|byte| self.put(*byte, Status::Nack))?;
        }
        if read_length > 0 {
            self.start();
            self.put(self.address << 1 | 1, Status::StartReadNack)?;
            for left in (0..read_length.min(read.capacity())).rev() {
                let byte = self.get(left > 0)?;
                // There is room: see the loop's bound.
                let _fits = read.push(byte);
            }
        }
        Ok(read)
    }

    fn wait(&self) {
        B::pause(self.pulse_ticks);
    }

    /// Data falls while the clock is high. After bytes both are made high first.
    fn start(&mut self) {
        self.data.set(true);
        self.wait();
        self.clock.set(true);
        self.wait();
        self.data.set(false);
        self.wait();
        self.clock.set(false);
    }

    /// Data rises while the clock is high.
    fn stop(&mut self) {
        self.data.set(false);
        self.wait();
        self.clock.set(true);
        self.wait();
        self.data.set(true);
        self.wait();
    }

    /// A pulse of the clock. Returns the level of the data in it.
    fn pulse(&mut self) -> Result<bool, Status> {
        self.wait();
        self.clock.set(true);
        let mut stretched = 0;
        while !self.clock.is_high() {
            self.wait();
            stretched += 1;
            if stretched > MOST_STRETCHED {
                return Err(Status::Timeout);
            }
        }
        self.wait();
        let level = self.data.is_high();
        self.clock.set(false);
        Ok(level)
    }

    fn put(&mut self, byte: u8, refused: Status) -> Result<(), Status> {
        for bit in (0..8).rev() {
            self.data.set(byte >> bit & 1 != 0);
            self.pulse()?;
        }
        self.data.set(true);
        if self.pulse()? { Err(refused) } else { Ok(()) }
    }

    fn get(&mut self, acknowledges: bool) -> Result<u8, Status> {
        self.data.set(true);
        let mut byte = 0;
        for _ in 0..8 {
            byte = byte << 1 | u8::from(self.pulse()?);
        }
        self.data.set(!acknowledges);
        self.pulse()?;
        Ok(byte)
    }
}

//! The motor drivers' bus: SPI4 (PE12, PE5, PE6), mode 3, one chip select per driver, as embedded-hal
//! `SpiDevice`s.
//!
//! A frame of up to 8 bytes goes through the hardware FIFO whole; the only wait is for its end, and it is
//! bounded. All devices belong to one owner, so the bus needs no lock; a flag turns a breach of that into an
//! error instead of a garbled frame.

use core::sync::atomic::{AtomicBool, Ordering};

use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
use stm32h7xx_hal::pac;

use crate::pins::{self, Mode, Output, PinName, Pull, Speed};
use crate::wait;

/// Bytes the FIFO holds (RM0399 section 53.3, SPI4: 8 bytes).
const FIFO_BYTES: usize = 8;
/// At 391 kHz eight bytes take 164 us; ten times that.
const FRAME_LIMIT_US: u32 = 1_600;
/// Longer than one bus clock (2.6 us), within which a new start after the end of a frame may stall (errata
/// ES0445, "Master data transfer stall").
const SELECT_PAUSE_US: u32 = 3;

/// What can go wrong on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpiError {
    /// The frame did not end in time.
    NotResponding,
    /// More bytes than the FIFO holds.
    TooLong,
    /// Another transaction is under way: two owners use the bus at once.
    Busy,
}

impl embedded_hal::spi::Error for SpiError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

/// A transaction is under way. Never found set as long as all devices belong to one owner.
static BUSY: AtomicBool = AtomicBool::new(false);

/// The bus, set up; makes devices.
#[derive(Debug)]
pub struct MotorBus(());

impl MotorBus {
    pub(crate) fn new(spi: pac::SPI4) -> Self {
        // The board pulls the selects up; until they are claimed they are inputs, so no driver listens.
        for (port, number) in [('E', 12), ('E', 5), ('E', 6)] {
            pins::configure(PinName::new(port, number), Mode::Alternate(5, Speed::Low), Pull::Up, false);
        }
        // RM0399 section 53.11: kernel clock 100 MHz / 256 = 391 kHz, the rate these boards have always been
        // run at; 8 bits, master, mode 3, chip select by software, pins kept while disabled.
        spi.cfg1.write(|w| w.mbr().bits(0b111).dsize().bits(7));
        spi.cr1.write(|w| w.ssi().set_bit());
        spi.cfg2.write(|w| w.master().set_bit().cpol().set_bit().cpha().set_bit().ssm().set_bit().afcntr().set_bit());
        Self(())
    }

    /// The driver behind this chip select, which must be an output that is off when not selected.
    #[must_use]
    pub fn device(&self, select: Output) -> MotorDevice {
        MotorDevice { select }
    }
}

/// One driver on the bus.
#[derive(Debug)]
pub struct MotorDevice {
    select: Output,
}

fn registers() -> &'static pac::spi1::RegisterBlock {
    // SAFETY: SPI4 is this module's alone, and `BUSY` lets one transaction at a time in.
    unsafe { &*pac::SPI4::ptr() }
}

fn exchange(words: &mut [u8]) -> Result<(), SpiError> {
    if words.len() > FIFO_BYTES {
        return Err(SpiError::TooLong);
    }
    let spi = registers();
    spi.cr2.write(|w| w.tsize().bits(words.len() as u16));
    spi.cr1.modify(|_, w| w.spe().set_bit());
    for &word in words.iter() {
        write_byte(spi, word);
    }
    spi.cr1.modify(|_, w| w.cstart().set_bit());
    let ended = wait::until(FRAME_LIMIT_US, || spi.sr.read().eot().bit_is_set());
    if ended.is_ok() {
        for word in words.iter_mut() {
            *word = read_byte(spi);
        }
    }
    // RM0399 section 53.4.9: clearing SPE flushes both FIFOs, so a failed frame leaves nothing behind.
    spi.cr1.modify(|_, w| w.spe().clear_bit());
    spi.ifcr.write(|w| w.eotc().set_bit().txtfc().set_bit().ovrc().set_bit().udrc().set_bit());
    ended.map_err(|_| SpiError::NotResponding)
}

/// One byte into the FIFO: the width of the access is the number of bytes (RM0399 section 53.11.9).
fn write_byte(spi: &pac::spi1::RegisterBlock, byte: u8) {
    // SAFETY: a byte store to the transmit register of a peripheral this module owns.
    unsafe { spi.txdr.as_ptr().cast::<u8>().write_volatile(byte) };
}

/// One byte from the FIFO.
fn read_byte(spi: &pac::spi1::RegisterBlock) -> u8 {
    // SAFETY: a byte load from the receive register of a peripheral this module owns.
    unsafe { spi.rxdr.as_ptr().cast_const().cast::<u8>().read_volatile() }
}

fn operate(operation: &mut Operation<'_, u8>) -> Result<(), SpiError> {
    match operation {
        Operation::TransferInPlace(words) => exchange(words),
        Operation::Read(words) => {
            words.fill(0);
            exchange(words)
        }
        Operation::Write(words) => {
            let mut copy = [0; FIFO_BYTES];
            let part = copy.get_mut(..words.len()).ok_or(SpiError::TooLong)?;
            part.copy_from_slice(words);
            exchange(part)
        }
        Operation::Transfer(read, write) => {
            let length = read.len().max(write.len());
            let mut copy = [0; FIFO_BYTES];
            let part = copy.get_mut(..length).ok_or(SpiError::TooLong)?;
            part.iter_mut().zip(write.iter()).for_each(|(to, from)| *to = *from);
            exchange(part)?;
            read.iter_mut().zip(part.iter()).for_each(|(to, from)| *to = *from);
            Ok(())
        }
        Operation::DelayNs(pause_ns) => {
            wait::pause(pause_ns.div_ceil(1000));
            Ok(())
        }
    }
}

impl ErrorType for MotorDevice {
    type Error = SpiError;
}

impl SpiDevice for MotorDevice {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), SpiError> {
        if BUSY.swap(true, Ordering::Acquire) {
            return Err(SpiError::Busy);
        }
        self.select.set(true);
        wait::pause(SELECT_PAUSE_US);
        let result = operations.iter_mut().try_for_each(operate);
        self.select.set(false);
        BUSY.store(false, Ordering::Release);
        result
    }
}

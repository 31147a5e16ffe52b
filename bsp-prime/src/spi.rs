//! The SPI buses, one chip select per chip, as embedded-hal `SpiDevice`s: SPI4 (PE12, PE5, PE6) of the motor
//! drivers and of what is on the header beside them, SPI1 (PA5, PA6, PB5) on a header.
//!
//! A frame of up to 8 bytes goes through the hardware FIFO whole; the only wait is for its end, and it is
//! bounded. All devices belong to one owner, so no bus needs a lock; a flag turns a breach of that into an
//! error instead of a garbled frame. Chips of one bus may want different clocks: each transaction sets its
//! own, while no chip is selected.

use core::sync::atomic::{AtomicBool, Ordering};

use embedded_hal::spi::{ErrorKind, ErrorType, MODE_3, Mode, Operation, Phase, Polarity, SpiDevice};
use stm32h7xx_hal::pac;

use crate::pins::{self, Output, PinName, Pins, Pull, Speed};
use crate::wait;

/// Bytes that the FIFO of SPI4 holds (RM0399 section 53.3: 8 bytes; SPI1 has 16).
const FIFO_BYTES: usize = 8;
/// Limit of a frame: eight bytes take 164 us at 391 kHz; ten times that.
const FRAME_LIMIT_US: u32 = 1_600;
/// Longer than one bus clock (2.6 us), within which a new start after the end of a frame may stall (errata
/// ES0445, "Master data transfer stall").
const SELECT_PAUSE_US: u32 = 3;
/// A select is high for longer than this between two transactions (MAX31856 and MAX31865 data sheets, tCWH:
/// 400 ns).
const DESELECT_PAUSE_US: u32 = 1;
/// The bus clock is the kernel clock by 256 at most, in eight powers of two (RM0399 section 53.11.3, MBR).
const SLOWEST: u8 = 0b111;

/// Failure of an SPI transfer.
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

/// SPI bus of the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bus {
    Spi1,
    Spi4,
}

/// A transaction is under way. Never found set as long as all devices belong to one owner.
static BUSY: [AtomicBool; 2] = [const { AtomicBool::new(false) }; 2];

impl Bus {
    fn registers(self) -> &'static pac::spi1::RegisterBlock {
        // SAFETY: SPI1 and SPI4 are this module's alone, and `BUSY` lets one transaction at a time in. Both
        // have the same registers (RM0399 section 53.11).
        unsafe {
            match self {
                Self::Spi1 => &*pac::SPI1::ptr(),
                Self::Spi4 => &*pac::SPI4::ptr(),
            }
        }
    }

    const fn busy(self) -> &'static AtomicBool {
        match self {
            Self::Spi1 => &BUSY[0],
            Self::Spi4 => &BUSY[1],
        }
    }

    /// Returns SCK, MISO and MOSI (alternate function 5).
    const fn pins(self) -> [PinName; 3] {
        match self {
            Self::Spi1 => [PinName::new('A', 5), PinName::new('A', 6), PinName::new('B', 5)],
            Self::Spi4 => [PinName::new('E', 12), PinName::new('E', 5), PinName::new('E', 6)],
        }
    }

    /// Kernel clock: PLL1 Q for SPI1 (RM0399 section 9.7.17, RCC_D2CCIP1R: SPI123SEL is 0 after reset), the
    /// bus clock of APB2 for SPI4 (SPI45SEL is 0 after reset).
    const fn kernel_hz(self) -> u32 {
        match self {
            Self::Spi1 => crate::clocks::SDMMC_KERNEL_HZ,
            Self::Spi4 => crate::clocks::PCLK_HZ,
        }
    }

    /// Sets up the bus's pins and the settings that all its chips share.
    fn set_up(self, link: Link) {
        for pin in self.pins() {
            pins::configure(pin, pins::Mode::Alternate(5, Speed::Low), Pull::Up, false);
        }
        // RM0399 section 53.11.1: the select input is held high by software, so a master stays one.
        self.registers().cr1.write(|w| w.ssi().set_bit());
        link.apply(self.registers());
    }
}

/// Clock settings of a chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Link {
    mode: Mode,
    /// Register field MBR: the kernel clock is divided by two to the power of one more.
    divider: u8,
}

impl Link {
    /// Clock of the motor drivers: 100 MHz / 256 = 391 kHz, the rate these boards have always been run at.
    const MOTORS: Self = Self { mode: MODE_3, divider: SLOWEST };

    /// Returns the fastest clock that is not above `most_hz`, or the slowest there is.
    const fn at_most(bus: Bus, mode: Mode, most_hz: u32) -> Self {
        let mut divider = 0;
        while divider < SLOWEST && bus.kernel_hz() >> (divider + 1) > most_hz {
            divider += 1;
        }
        Self { mode, divider }
    }

    /// Sets the clock, while the bus is off and no chip is selected; does nothing if it is set already. Words
    /// of 8 bits, master, chip select by software, pins kept while disabled.
    fn apply(self, spi: &pac::spi1::RegisterBlock) {
        let (polarity, phase) = (self.mode.polarity, self.mode.phase);
        let (high, second) = (polarity == Polarity::IdleHigh, phase == Phase::CaptureOnSecondTransition);
        let (rate, wave) = (spi.cfg1.read(), spi.cfg2.read());
        let is_set = wave.master().bit_is_set()
            && rate.mbr().bits() == self.divider
            && wave.cpol().bit_is_set() == high
            && wave.cpha().bit_is_set() == second;
        if is_set {
            return;
        }
        // RM0399 sections 53.11.3 and 53.11.4: both take a write only while SPE is clear, which it is
        // between frames.
        spi.cfg1.write(|w| w.mbr().bits(self.divider).dsize().bits(7));
        spi.cfg2.write(|w| w.master().set_bit().cpol().bit(high).cpha().bit(second).ssm().set_bit().afcntr().set_bit());
        // The clock line goes to its level of rest (AFCNTR) before a select can follow.
        let _settled = spi.cfg2.read();
        wait::pause(DESELECT_PAUSE_US);
    }
}

/// The buses, of which SPI4 is set up; makes devices.
#[derive(Debug)]
pub struct SpiBuses {
    spi1_is_set_up: bool,
}

impl SpiBuses {
    pub(crate) fn new(_: pac::SPI1, _: pac::SPI4) -> Self {
        // The board pulls the selects up; until they are claimed they are inputs, so no driver listens.
        Bus::Spi4.set_up(Link::MOTORS);
        Self { spi1_is_set_up: false }
    }

    /// The driver behind this chip select, which must be an output that is off when not selected.
    #[must_use]
    pub const fn motor_driver(&self, select: Output) -> SpiChip {
        SpiChip { bus: Bus::Spi4, link: Link::MOTORS, select: Some(select) }
    }

    /// Another chip, on SPI1 (channel 0) or SPI4 (channel 1), whose clock has this mode and is no faster. The
    /// first one on SPI1 claims that bus's pins for `owner`. A chip without a select line is always selected.
    /// None when there is no such channel.
    ///
    /// # Errors
    /// [`pins::PinError`] when a pin of SPI1 has another owner.
    pub fn chip(
        &mut self,
        channel: u8,
        (mode, most_hz): (Mode, u32),
        select: Option<Output>,
        pins: &mut Pins,
        owner: &str,
    ) -> Result<Option<SpiChip>, pins::PinError> {
        let bus = match channel {
            0 => Bus::Spi1,
            1 => Bus::Spi4,
            _ => return Ok(None),
        };
        let link = Link::at_most(bus, mode, most_hz);
        if bus == Bus::Spi1 && !self.spi1_is_set_up {
            for pin in bus.pins() {
                pins.claim(pin, owner)?;
            }
            bus.set_up(link);
            self.spi1_is_set_up = true;
        }
        Ok(Some(SpiChip { bus, link, select }))
    }
}

/// Device on a bus, behind its chip select.
#[derive(Debug)]
pub struct SpiChip {
    bus: Bus,
    link: Link,
    select: Option<Output>,
}

impl SpiChip {
    /// Exchanges bytes in place, any number of them, in frames between which the chip stays selected.
    ///
    /// # Errors
    /// [`SpiError`]; the bytes of later frames are as they were.
    pub fn exchange(&mut self, bytes: &mut [u8]) -> Result<(), SpiError> {
        self.while_selected(|spi| bytes.chunks_mut(FIFO_BYTES).try_for_each(|frame| exchange(spi, frame)))
    }

    /// Does this while the chip is selected, with its clock.
    fn while_selected(
        &mut self,
        work: impl FnOnce(&pac::spi1::RegisterBlock) -> Result<(), SpiError>,
    ) -> Result<(), SpiError> {
        let (spi, busy) = (self.bus.registers(), self.bus.busy());
        if busy.swap(true, Ordering::Acquire) {
            return Err(SpiError::Busy);
        }
        self.link.apply(spi);
        self.select(true);
        let result = work(spi);
        self.select(false);
        wait::pause(DESELECT_PAUSE_US);
        busy.store(false, Ordering::Release);
        result
    }

    fn select(&mut self, is_selected: bool) {
        if let Some(select) = &mut self.select {
            select.set(is_selected);
        }
    }
}

fn exchange(spi: &pac::spi1::RegisterBlock, words: &mut [u8]) -> Result<(), SpiError> {
    if words.len() > FIFO_BYTES {
        return Err(SpiError::TooLong);
    }
    wait::pause(SELECT_PAUSE_US);
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

/// Writes a byte into the FIFO: the width of the access is the number of bytes (RM0399 section 53.11.9).
fn write_byte(spi: &pac::spi1::RegisterBlock, byte: u8) {
    // SAFETY: a byte store to the transmit register of a peripheral this module owns.
    unsafe { spi.txdr.as_ptr().cast::<u8>().write_volatile(byte) };
}

/// Reads a byte from the FIFO.
fn read_byte(spi: &pac::spi1::RegisterBlock) -> u8 {
    // SAFETY: a byte load from the receive register of a peripheral this module owns.
    unsafe { spi.rxdr.as_ptr().cast_const().cast::<u8>().read_volatile() }
}

fn operate(spi: &pac::spi1::RegisterBlock, operation: &mut Operation<'_, u8>) -> Result<(), SpiError> {
    match operation {
        Operation::TransferInPlace(words) => exchange(spi, words),
        Operation::Read(words) => {
            words.fill(0);
            exchange(spi, words)
        }
        Operation::Write(words) => {
            let mut copy = [0; FIFO_BYTES];
            let part = copy.get_mut(..words.len()).ok_or(SpiError::TooLong)?;
            part.copy_from_slice(words);
            exchange(spi, part)
        }
        Operation::Transfer(read, write) => {
            let length = read.len().max(write.len());
            let mut copy = [0; FIFO_BYTES];
            let part = copy.get_mut(..length).ok_or(SpiError::TooLong)?;
            part.iter_mut().zip(write.iter()).for_each(|(to, from)| *to = *from);
            exchange(spi, part)?;
            read.iter_mut().zip(part.iter()).for_each(|(to, from)| *to = *from);
            Ok(())
        }
        Operation::DelayNs(pause_ns) => {
            wait::pause(pause_ns.div_ceil(1000));
            Ok(())
        }
    }
}

impl ErrorType for SpiChip {
    type Error = SpiError;
}

impl SpiDevice for SpiChip {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), SpiError> {
        self.while_selected(|spi| operations.iter_mut().try_for_each(|operation| operate(spi, operation)))
    }
}

//! Bus of an external driver's chip: SPI or a single-wire UART.

use embedded_hal::spi::SpiDevice;
use tmc::Error;
use tmc::stealth::{RegisterBus, SingleWire, SpiRegisters, WireRegisters};

/// Registers of an external driver.
#[derive(Debug)]
pub enum OutsideBus<SPI, LINE> {
    /// Behind a chip select on SPI.
    Spi(SpiRegisters<SPI>),
    /// Behind an address on a UART.
    Wire(WireRegisters<LINE>),
}

/// The bus itself failed; its own error is dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusFailed;

fn any<E>(error: Error<E>) -> Error<BusFailed> {
    match error {
        Error::Bus(_) => Error::Bus(BusFailed),
        Error::Absent => Error::Absent,
        Error::NoEcho => Error::NoEcho,
        Error::WrongAnswer(answer) => Error::WrongAnswer(answer),
        Error::Reset => Error::Reset,
        Error::Setting(setting) => Error::Setting(setting),
    }
}

impl<SPI: SpiDevice, LINE: SingleWire> RegisterBus for OutsideBus<SPI, LINE> {
    type Error = BusFailed;

    fn read<const N: usize>(&mut self, addresses: [u8; N]) -> Result<[u32; N], Error<BusFailed>> {
        match self {
            Self::Spi(bus) => bus.read(addresses).map_err(any),
            Self::Wire(bus) => bus.read(addresses).map_err(any),
        }
    }

    fn write(&mut self, address: u8, value: u32) -> Result<(), Error<BusFailed>> {
        match self {
            Self::Spi(bus) => bus.write(address, value).map_err(any),
            Self::Wire(bus) => bus.write(address, value).map_err(any),
        }
    }
}

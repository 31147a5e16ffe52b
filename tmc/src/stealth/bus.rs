//! Registers over SPI: datagrams of 40 bits, an address and 32 bits of data, most significant bit first ("SPI
//! datagram structure"). The chip answers with a status byte and the data that the previous datagram asked
//! for.

use crate::Error;
use embedded_hal::spi::SpiDevice;

/// Bit in the address of a datagram that writes.
const WRITE: u8 = 0x80;
/// Bytes of a datagram: an address, and 32 bits of data.
const DATAGRAM_BYTES: usize = 5;

/// Access to a chip's registers over any bus.
pub trait RegisterBus {
    /// Error of the bus.
    type Error: core::fmt::Debug;

    /// Reads registers, one after the other. At least one of them must never be 0, so that a dead line can be
    /// told from an answer.
    ///
    /// # Errors
    /// Bus errors; [`Error::Absent`] when nobody answers.
    fn read<const N: usize>(&mut self, addresses: [u8; N]) -> Result<[u32; N], Error<Self::Error>>;

    /// Writes a register. The next reading shows whether it arrived.
    ///
    /// # Errors
    /// Bus errors.
    fn write(&mut self, address: u8, value: u32) -> Result<(), Error<Self::Error>>;
}

/// The registers of a chip with a select of its own, on a bus in [`crate::SPI_MODE`]. At most 4 MHz.
#[derive(Debug)]
pub struct SpiRegisters<SPI>(pub SPI);

impl<SPI: SpiDevice> SpiRegisters<SPI> {
    /// Exchanges one datagram; returns the 32 bits behind the status byte, `None` if all bits were alike, as
    /// nothing drives the line.
    fn exchange(&mut self, address: u8, value: u32) -> Result<Option<u32>, Error<SPI::Error>> {
        let [a, b, c, d] = value.to_be_bytes();
        let mut datagram: [u8; DATAGRAM_BYTES] = [address, a, b, c, d];
        self.0.transfer_in_place(&mut datagram).map_err(Error::Bus)?;
        let is_dead = datagram == [0; DATAGRAM_BYTES] || datagram == [0xFF; DATAGRAM_BYTES];
        let [_status, data @ ..] = datagram;
        Ok((!is_dead).then_some(u32::from_be_bytes(data)))
    }
}

impl<SPI: SpiDevice> RegisterBus for SpiRegisters<SPI> {
    type Error = SPI::Error;

    fn read<const N: usize>(&mut self, addresses: [u8; N]) -> Result<[u32; N], Error<SPI::Error>> {
        let (mut values, mut answers) = ([0; N], false);
        // Each datagram brings the answer to the one before; the last one asks for nothing new.
        let (mut asked, mut last) = (None, 0);
        for (place, address) in addresses.into_iter().enumerate() {
            self.take(address, asked, &mut values, &mut answers)?;
            (asked, last) = (Some(place), address);
        }
        self.take(last, asked, &mut values, &mut answers)?;
        if answers { Ok(values) } else { Err(Error::Absent) }
    }

    fn write(&mut self, address: u8, value: u32) -> Result<(), Error<SPI::Error>> {
        self.exchange(address | WRITE, value).map(drop)
    }
}

impl<SPI: SpiDevice> SpiRegisters<SPI> {
    fn take(
        &mut self,
        address: u8,
        asked: Option<usize>,
        values: &mut [u32],
        answers: &mut bool,
    ) -> Result<(), Error<SPI::Error>> {
        let answer = self.exchange(address, 0)?;
        let Some(place) = asked.and_then(|place| values.get_mut(place)) else { return Ok(()) };
        *place = answer.unwrap_or(0);
        *answers |= answer.is_some();
        Ok(())
    }
}

//! Current and load measurement during a search for a motor stall, and their restoration.

use super::{Driver, Error, StallGuard};
use embedded_hal::spi::SpiDevice;
use units::Amps;

impl<SPI: SpiDevice> Driver<SPI> {
    /// Sets the load measurement and, if given, the peak current, with coolStep off, as a change of the
    /// current would disturb the measurement. The earlier settings are kept for [`Self::end_search`].
    ///
    /// # Errors
    /// [`Error::Setting`] for a threshold out of range, else as [`Self::status`].
    pub fn begin_search(&mut self, stall_guard: StallGuard, peak: Option<Amps>) -> Result<(), Error<SPI::Error>> {
        let now = (self.run, self.registers.sgcsconf, self.registers.smarten);
        self.before_search.get_or_insert(now);
        self.set_cool_step(None)?;
        if let Some(peak) = peak {
            self.set_current(peak)?;
        }
        self.set_stall_guard(stall_guard)
    }

    /// Restores the settings from before [`Self::begin_search`]; does nothing without a search. The copy of
    /// the registers has them whether or not the chip answers; a silent chip gets them with the next
    /// [`Self::enable`].
    ///
    /// # Errors
    /// As [`Self::status`].
    pub fn end_search(&mut self) -> Result<(), Error<SPI::Error>> {
        let Some((run, sgcsconf, smarten)) = self.before_search.take() else { return Ok(()) };
        self.run = run;
        (self.registers.sgcsconf, self.registers.smarten) = (sgcsconf, smarten);
        let done = self.write_current().and(self.write(smarten.word()).map(drop));
        self.is_stale = done.is_err();
        done
    }
}

//! Detection of a chip that lost its settings. TMC2590 and TMC2660 have no flag for a reset, as other
//! families do: a dip of the supply on the chip alone leaves all registers 0, which shows in the answers.
//!
//! - A TMC2590 is set to show all its detectors (`RDSEL` = %11), and answers in no other format. After
//!   a reset `RDSEL` is %00, whose answers have %00 in bits 9 and 8 (data sheet, section 7.10). So the word
//!   that asks must not go to DRVCONF, which would select the detectors again.
//! - A TMC2660 has one format for all readings, but can show the current scale in force: with `RDSEL` = %10
//!   `SE` is `CS`, lowered by coolStep to a half or a quarter at least (data sheet, sections 6.7 and 6.10),
//!   and 0 after a reset. If the scale may fall to 0 by itself, nothing can be told.

use super::{Driver, Error};
use crate::register::{SgCsConf, SmartEn};
use crate::status::{ReadSelect, Reading, Status};
use embedded_hal::spi::SpiDevice;

/// Registers that determine the current scale, as last sent.
#[derive(Clone, Copy, Debug)]
pub(super) struct SentCurrent {
    scale: SgCsConf,
    cool_step: SmartEn,
}

impl Default for SentCurrent {
    fn default() -> Self {
        Self { scale: SgCsConf::RESET, cool_step: SmartEn::RESET }
    }
}

impl SentCurrent {
    /// Notes the current scale or coolStep setting in a word that was sent.
    pub(super) const fn note(&mut self, word: u32) {
        if let Some(register) = SgCsConf::from_word(word) {
            self.scale = register;
        } else if let Some(register) = SmartEn::from_word(word) {
            self.cool_step = register;
        }
    }

    /// Returns the least current scale that a chip with these settings regulates to.
    const fn least_scale(self) -> u32 {
        match (self.cool_step.semin(), self.cool_step.seimin()) {
            (0, _) => self.scale.cs(),
            (_, 0) => self.scale.cs() / 2,
            _ => self.scale.cs() / 4,
        }
    }
}

/// Mask of bits 9 and 8 of an answer: ones when the answer shows all detectors.
const FORMAT: u32 = 0b11 << 8;

impl<SPI: SpiDevice> Driver<SPI> {
    /// Sends one word and decodes the answer.
    pub(super) fn exchange(&mut self, word: u32) -> Result<Status, Error<SPI::Error>> {
        let shown = self.shown;
        let answer = self.transfer(word)?;
        if let Some(status) = Status::decode(answer >> 4, shown) {
            return Ok(status);
        }
        // A single disturbed bit leaves the other one set.
        if shown == ReadSelect::Diagnostics && answer >> 4 & FORMAT == 0 {
            self.is_reset = true;
            return Err(Error::Reset);
        }
        Err(Error::WrongAnswer(answer))
    }

    /// Returns the status of a TMC2590, or a reset found by its format.
    pub(super) fn look_at_format(&mut self) -> Result<Status, Error<SPI::Error>> {
        let was_reset = self.is_reset;
        let status = self.exchange(self.registers.smarten.word());
        // Earlier words may have selected the detectors again.
        if was_reset && status.is_ok() { Err(Error::Reset) } else { status }
    }

    /// Returns the status of a TMC2660, or a reset found by its current scale. A scale of 0 is read twice, as
    /// it may come from a disturbed bit of a scale with a single bit.
    pub(super) fn look_at_scale(&mut self) -> Result<Status, Error<SPI::Error>> {
        let (status, scale) = self.read_scale()?;
        if !self.is_reset && self.sent.least_scale() > 0 && scale == 0 {
            self.is_reset = self.read_scale()?.1 == 0;
        }
        if self.is_reset { Err(Error::Reset) } else { Ok(status) }
    }

    fn read_scale(&mut self) -> Result<(Status, u8), Error<SPI::Error>> {
        let usual = self.registers.drvconf;
        self.exchange(usual.with_rdsel(ReadSelect::StallGuardAndCurrent as u32).word())?;
        let status = self.exchange(usual.word())?;
        match status.reading {
            Reading::StallGuardAndCurrent { current_scale, .. } => Ok((status, current_scale)),
            _ => Err(Error::WrongAnswer(status.raw)),
        }
    }
}

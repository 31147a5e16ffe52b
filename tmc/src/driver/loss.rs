//! Whether the chip still has its settings. These chips have no flag for a reset, as other families do: a dip
//! of the supply on the chip alone leaves them with all registers 0, which shows in what they answer.
//!
//! - A TMC2590 is set to show all its detectors (`RDSEL` = %11), and answers in no other format. One that was
//!   reset has `RDSEL` = %00, whose answers have %00 in bits 9 and 8 (data sheet, section 7.10). So the word
//!   that asks must be none to DRVCONF, which would select the detectors again.
//! - A TMC2660 has the same format for all it can show. But it can show the current scale that it regulates
//!   to: with `RDSEL` = %10 `SE` is `CS`, or less of it by coolStep, to a half or a quarter (data sheet,
//!   sections 6.7 and 6.10). After a reset it is 0. A scale whose least is 0 tells nothing.

use super::{Driver, Error};
use crate::register::{SgCsConf, SmartEn};
use crate::status::{ReadSelect, Reading, Status};
use embedded_hal::spi::SpiDevice;

/// The registers that the current scale comes from, as they were last sent.
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
    /// This word was sent.
    pub(super) const fn note(&mut self, word: u32) {
        if let Some(register) = SgCsConf::from_word(word) {
            self.scale = register;
        } else if let Some(register) = SmartEn::from_word(word) {
            self.cool_step = register;
        }
    }

    /// The least that a chip that has them regulates to.
    const fn least_scale(self) -> u32 {
        match (self.cool_step.semin(), self.cool_step.seimin()) {
            (0, _) => self.scale.cs(),
            (_, 0) => self.scale.cs() / 2,
            _ => self.scale.cs() / 4,
        }
    }
}

/// Bits 9 and 8 of an answer with all detectors, which has ones there, and of every other.
const FORMAT: u32 = 0b11 << 8;

impl<SPI: SpiDevice> Driver<SPI> {
    /// One word and its answer.
    pub(super) fn exchange(&mut self, word: u32) -> Result<Status, Error<SPI::Error>> {
        let shown = self.shown;
        let answer = self.transfer(word)?;
        if let Some(status) = Status::decode(answer >> 4, shown) {
            return Ok(status);
        }
        // A disturbed bit leaves the other one.
        if shown == ReadSelect::Diagnostics && answer >> 4 & FORMAT == 0 {
            self.is_reset = true;
            return Err(Error::Reset);
        }
        Err(Error::WrongAnswer(answer))
    }

    /// The status of a TMC2590, and what its format says.
    pub(super) fn look_at_format(&mut self) -> Result<Status, Error<SPI::Error>> {
        let was_reset = self.is_reset;
        let status = self.exchange(self.registers.smarten.word());
        // Words of before may have selected the detectors again.
        if was_reset && status.is_ok() { Err(Error::Reset) } else { status }
    }

    /// The status of a TMC2660, and what its current scale says. A scale of 0 is looked at twice, for it may
    /// be a disturbed bit of one that has no other.
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

//! Access to the SD card by calls that wait.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

use card::fat::Blocks;
use card::sd::{Block, CardInfo, Read, SdError, State};
use stm32h7xx_hal::pac;

use super::{CardService, Controller};
use crate::time;

/// Static memory of the card service, outside the DTCM, which is for motion.
struct Home(UnsafeCell<MaybeUninit<CardService>>);

// SAFETY: it is reached through the one reference that `into_service` gives.
unsafe impl Sync for Home {}

#[unsafe(link_section = ".axisram")]
static HOME: Home = Home(UnsafeCell::new(MaybeUninit::uninit()));

/// Card accessed by calls that wait. Each call ends within some seconds at worst, as every command has its
/// bound.
pub struct SdCard(CardService);

impl SdCard {
    pub(crate) fn new(registers: pac::SDMMC1) -> Self {
        Self(CardService::new(Controller::new(registers)))
    }

    /// Turns the card into a service, moved on by the controller's interrupt.
    #[must_use]
    pub fn into_service(self) -> &'static mut CardService {
        // SAFETY: there is one controller, so one card, and this takes it: nobody else has a reference.
        unsafe { (*HOME.0.get()).write(self.0) }
    }

    /// Identifies the card; to be repeated after a change of cards. Takes some milliseconds, with a card that
    /// is slow to start up to a second.
    ///
    /// # Errors
    /// [`SdError`].
    pub fn identify(&mut self) -> Result<CardInfo, SdError> {
        self.0.identify();
        loop {
            self.0.advance(time::now().0);
            match self.0.state() {
                State::Ready(card) => return Ok(card),
                State::Absent(error) => return Err(error),
                State::Identifying => {}
            }
        }
    }

    /// Reads a block from the card.
    ///
    /// # Errors
    /// [`SdError`].
    pub fn read(&mut self, number: u32, block: &mut Block) -> Result<(), SdError> {
        while self.0.read(number, block)? == Read::NotYet {
            self.0.advance(time::now().0);
        }
        Ok(())
    }

    /// Writes a block, and waits until it is on the card.
    ///
    /// # Errors
    /// [`SdError`].
    pub fn write(&mut self, number: u32, block: &Block) -> Result<(), SdError> {
        while !self.0.write(number, block)? {
            self.0.advance(time::now().0);
        }
        loop {
            self.0.advance(time::now().0);
            match self.0.is_kept() {
                Ok(true) => return Ok(()),
                Ok(false) => {}
                Err(error) => {
                    self.0.forgive();
                    return Err(error);
                }
            }
        }
    }

    /// Returns the number of blocks that the card reports.
    #[must_use]
    pub const fn blocks(&self) -> Option<u32> {
        match self.0.state() {
            State::Ready(card) => Some(card.blocks),
            _ => None,
        }
    }
}

impl Blocks for SdCard {
    type Error = SdError;

    fn read(&mut self, number: u32, block: &mut Block) -> Result<(), SdError> {
        Self::read(self, number, block)
    }

    fn write(&mut self, number: u32, block: &Block) -> Result<(), SdError> {
        Self::write(self, number, block)
    }
}

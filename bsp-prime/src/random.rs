//! Random numbers of the chip (RNG, RM0399 chapter 35): for what nobody may guess, as salts and the numbers
//! with which connections begin.
//!
//! The generator and its 48 MHz oscillator run only while somebody asks.

use cortex_m::peripheral::DWT;
use stm32h7xx_hal::pac;

use crate::wait;

/// Limit of the oscillator's start, and of each word: some microseconds are usual.
const LIMIT_US: u32 = 1_000;

/// The generator, at rest.
pub struct RandomWords(pac::RNG);

impl RandomWords {
    pub(crate) const fn new(generator: pac::RNG) -> Self {
        Self(generator)
    }

    /// Returns random words. Takes some microseconds, a millisecond a word at the most.
    ///
    /// Should the generator not work, the words are made of the core's cycle counter and the chip's id, which
    /// a stranger in the network cannot know well.
    #[must_use]
    pub fn take<const N: usize>(&mut self) -> [u32; N] {
        self.wake(true);
        let mut words = [0; N];
        for (place, word) in words.iter_mut().enumerate() {
            *word = self.word().unwrap_or_else(|| spare(place as u32));
        }
        self.wake(false);
        words
    }

    fn word(&self) -> Option<u32> {
        let is_ready = || self.0.sr.read().drdy().bit_is_set();
        wait::until(LIMIT_US, is_ready).ok()?;
        let has_error = self.0.sr.read().secs().bit_is_set() || self.0.sr.read().cecs().bit_is_set();
        // RM0399 section 35.7.3: a word of zero is an error as well.
        Some(self.0.dr.read().bits()).filter(|word| *word != 0 && !has_error)
    }

    /// Switches the generator and its clocks on, or off.
    fn wake(&self, on: bool) {
        // SAFETY: RCC_CR and RCC_AHB2ENR are changed by others only at the start, before there is a task;
        // here by the executor alone.
        let rcc = unsafe { &*pac::RCC::ptr() };
        if on {
            // RM0399 section 9.7.2, RCC_CR: HSI48ON, HSI48RDY. RNGSEL of RCC_D2CCIP2R is HSI48 after reset.
            rcc.cr.modify(|_, w| w.hsi48on().on());
            // Without its clock the generator says so, and every word is a spare one.
            let _ticks = wait::until(LIMIT_US, || rcc.cr.read().hsi48rdy().is_ready());
            rcc.ahb2enr.modify(|_, w| w.rngen().enabled());
            let _effective = rcc.ahb2enr.read();
        }
        // RM0399 section 35.7.1, RNG_CR: RNGEN, with the clock error detection.
        self.0.cr.modify(|_, w| w.rngen().bit(on));
        if !on {
            rcc.ahb2enr.modify(|_, w| w.rngen().disabled());
            rcc.cr.modify(|_, w| w.hsi48on().off());
        }
    }
}

/// Returns a word for one that the generator did not make.
fn spare(place: u32) -> u32 {
    let id = crate::identity::unique_id();
    let mixed =
        id.iter().fold(DWT::cycle_count(), |mixed, word| (mixed ^ word).wrapping_mul(0x9E37_79B1).rotate_left(13));
    mixed ^ place.wrapping_mul(0x85EB_CA6B)
}

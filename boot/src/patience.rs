//! Flash with watchdog: the watchdog is fed with every word written, of which an image has only so many, and
//! with every file that is checked, of which there are few; and the LEDs count.

use bsp_prime::flash::BoardFlash;
use bsp_prime::pins::Output;
use bsp_prime::watchdog::Watchdog;
use update::{Failed, Flash, Sector, Unreadable, Word};

/// Words between two steps of the LED count: 64 KiB.
const STEP: u32 = 2048;

/// Flash with the watchdog and the LEDs that show the progress.
pub struct Patience {
    flash: BoardFlash,
    watchdog: Watchdog,
    leds: [Output; 4],
    written: u32,
}

impl Patience {
    /// Creates the wrapper, with no words written so far.
    pub fn new(flash: BoardFlash, watchdog: Watchdog, leds: [Output; 4]) -> Self {
        Self { flash, watchdog, leds, written: 0 }
    }

    /// Feeds the watchdog: waits for a person or a card have a bound of their own, or are to last for ever.
    pub fn feed(&mut self) {
        self.watchdog.feed();
    }

    /// Shows a number from 0 to 15 on the LEDs.
    pub fn show(&mut self, number: u32) {
        for (bit, led) in self.leds.iter_mut().enumerate() {
            led.set(number >> bit & 1 != 0);
        }
    }
}

impl Flash for Patience {
    fn read(&mut self, at: u32) -> Result<Word, Unreadable> {
        self.flash.read(at)
    }

    fn read_into(&mut self, at: u32, into: &mut [u8]) -> Result<(), Unreadable> {
        self.flash.read_into(at, into)
    }

    fn program(&mut self, at: u32, word: &Word) -> Result<(), Failed> {
        self.feed();
        self.written = self.written.wrapping_add(1);
        if self.written.is_multiple_of(STEP) {
            self.show(self.written / STEP);
        }
        self.flash.program(at, word)
    }

    fn feed_watchdog(&mut self) {
        self.feed();
    }

    fn erase(&mut self, sector: Sector) -> Result<(), Failed> {
        self.feed();
        self.flash.erase(sector)
    }
}

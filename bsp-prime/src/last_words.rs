//! The message that a firmware which ends itself leaves for the next start: a line of text in the backup
//! registers of the real-time clock, which a reset leaves alone (RM0399 rev 4 section 49.3.15). Power-on
//! clears them: no coin cell is fitted.

use core::fmt;

use stm32h7xx_hal::pac;

/// The longest text, bytes: nineteen of the 32 registers hold it, after one for its length.
pub const LENGTH: usize = 4 * (REGISTERS - 1);
const REGISTERS: usize = 20;
/// Upper half of the first register where the others hold a text; its length is in the lower half.
const MARK: u32 = 0x4C57_0000;

/// Text of at most [`LENGTH`] bytes; a longer one loses its end.
#[derive(Clone, Copy, Debug)]
pub struct Text {
    bytes: [u8; LENGTH],
    length: usize,
}

impl Text {
    /// Returns an empty text.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: [0; LENGTH], length: 0 }
    }

    /// Returns the text so far, up to the first invalid character.
    #[must_use]
    pub fn as_str(&self) -> &str {
        let bytes = self.bytes.get(..self.length).unwrap_or_default();
        match core::str::from_utf8(bytes) {
            Ok(text) => text,
            Err(flaw) => {
                bytes.get(..flaw.valid_up_to()).and_then(|bytes| core::str::from_utf8(bytes).ok()).unwrap_or("")
            }
        }
    }
}

impl Default for Text {
    fn default() -> Self {
        Self::new()
    }
}

impl fmt::Write for Text {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for (place, byte) in self.bytes.iter_mut().skip(self.length).zip(text.bytes()) {
            *place = byte;
            self.length += 1;
        }
        Ok(())
    }
}

/// Leaves this text for the next start. Works from [`crate::Board::take`] on, which opens the backup domain;
/// before that nothing is kept.
pub fn leave(text: &Text) {
    // SAFETY: written here and in `take`, which runs once and with interrupts off, as this does.
    let registers = unsafe { &(*pac::RTC::ptr()).bkpr };
    let words = text.bytes.chunks_exact(4);
    for (register, word) in registers.iter().skip(1).zip(words) {
        let word = word.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte));
        register.write(|w| w.bits(word));
    }
    // Written last, so that a half-written text is not taken for one.
    registers[0].write(|w| w.bits(MARK | text.length as u32));
}

/// Takes the message of the firmware that last ended itself; the next start finds nothing.
pub(crate) fn take() -> Option<Text> {
    // SAFETY: see `leave`.
    let registers = unsafe { &(*pac::RTC::ptr()).bkpr };
    let first = registers[0].read().bits();
    registers[0].write(|w| w.bits(0));
    let length = (first ^ MARK) as usize;
    if length > LENGTH {
        return None;
    }
    let mut text = Text { length, ..Text::new() };
    for (bytes, register) in text.bytes.chunks_exact_mut(4).zip(registers.iter().skip(1)) {
        bytes.copy_from_slice(&register.read().bits().to_le_bytes());
    }
    Some(text)
}

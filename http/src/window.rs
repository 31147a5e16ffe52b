//! Text that is made again from its beginning at each call, of which a call writes what comes next: no state
//! has to be kept but how much was written.

use core::fmt;

/// Room for text whose first bytes were written before.
#[derive(Debug)]
pub struct Window<'o> {
    room: &'o mut [u8],
    /// Bytes of the text to pass over.
    skip: usize,
    written: usize,
    missed: usize,
}

impl<'o> Window<'o> {
    /// Begins to write into `room` what follows the first `skip` bytes of the text.
    pub const fn new(room: &'o mut [u8], skip: usize) -> Self {
        Self { room, skip, written: 0, missed: 0 }
    }

    /// Counts the bytes of a text.
    pub fn count(make: impl FnOnce(&mut Window<'_>)) -> usize {
        let mut window = Window::new(&mut [], 0);
        make(&mut window);
        window.missed
    }

    /// Adds bytes to the text.
    pub fn put(&mut self, bytes: &[u8]) {
        let passed = self.skip.min(bytes.len());
        self.skip -= passed;
        let bytes = bytes.get(passed..).unwrap_or_default();
        let free = self.room.get_mut(self.written..).unwrap_or_default();
        let count = free.len().min(bytes.len());
        for (place, byte) in free.iter_mut().zip(bytes) {
            *place = *byte;
        }
        self.written += count;
        self.missed += bytes.len() - count;
    }

    /// Adds text to the text.
    pub fn text(&mut self, text: &str) {
        self.put(text.as_bytes());
    }

    /// Adds a decimal number.
    pub fn number(&mut self, number: u64) {
        let mut digits = [0; 20];
        let mut rest = number;
        let mut first = digits.len();
        for (at, place) in digits.iter_mut().enumerate().rev() {
            *place = b'0' + (rest % 10) as u8;
            rest /= 10;
            first = at;
            if rest == 0 {
                break;
            }
        }
        self.put(digits.get(first..).unwrap_or_default());
    }

    /// Adds a number in sixteen hexadecimal digits.
    pub fn hex(&mut self, number: u64) {
        for shift in (0..16).rev() {
            let digit = (number >> (shift * 4) & 15) as u32;
            self.put(&[char::from_digit(digit, 16).map_or(b'0', |digit| digit as u8)]);
        }
    }

    /// Returns how many bytes were written.
    #[must_use]
    pub const fn written(&self) -> usize {
        self.written
    }

    /// Returns whether the text is whole. False also where it ended before what was to be passed over.
    #[must_use]
    pub const fn is_whole(&self) -> bool {
        self.missed == 0 && self.skip == 0
    }
}

impl fmt::Write for Window<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.text(text);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn make(window: &mut Window<'_>) {
        window.text("a=");
        window.number(0);
        window.number(u64::MAX);
        window.put(b"; ");
        window.hex(0x0123_4567_89AB_CDEF);
    }

    const MADE: &[u8] = b"a=018446744073709551615; 0123456789abcdef";

    #[test]
    fn text_is_the_same_in_rooms_of_any_size() {
        assert_eq!(Window::count(make), MADE.len());
        for size in 1..MADE.len() + 2 {
            let mut whole = Vec::new();
            loop {
                let mut room = vec![0; size];
                let mut window = Window::new(&mut room, whole.len());
                make(&mut window);
                let (written, is_whole) = (window.written(), window.is_whole());
                whole.extend_from_slice(&room[..written]);
                assert_eq!(is_whole, whole.len() == MADE.len());
                if is_whole {
                    break;
                }
            }
            assert_eq!(whole, MADE, "{size}");
        }
    }

    #[test]
    fn a_text_that_became_shorter_is_never_whole() {
        let mut room = [0; 8];
        let mut window = Window::new(&mut room, 3);
        window.text("ab");
        assert_eq!((window.written(), window.is_whole()), (0, false));
    }
}

//! UTF-8 in pieces (RFC 3629, section 4).

/// Check of text that comes in pieces, which may end in the middle of a character.
#[derive(Clone, Debug)]
pub struct Utf8 {
    /// Bytes that the character still has to have.
    missing: u8,
    /// Least and greatest value of the next of them.
    low: u8,
    high: u8,
}

impl Utf8 {
    /// Makes a check for a text that begins.
    #[must_use]
    pub const fn new() -> Self {
        Self { missing: 0, low: 0x80, high: 0xBF }
    }

    /// Returns whether the text may end here.
    #[must_use]
    pub const fn is_whole(&self) -> bool {
        self.missing == 0
    }

    /// Takes the next byte. False if no text goes on like this.
    pub const fn push(&mut self, byte: u8) -> bool {
        if self.missing > 0 {
            let fits = self.low <= byte && byte <= self.high;
            self.missing -= 1;
            (self.low, self.high) = (0x80, 0xBF);
            return fits;
        }
        // Neither more bytes than needed, nor surrogates, nor values above 10FFFF.
        (self.missing, self.low, self.high) = match byte {
            0..=0x7F => (0, 0x80, 0xBF),
            0xC2..=0xDF => (1, 0x80, 0xBF),
            0xE0 => (2, 0xA0, 0xBF),
            0xED => (2, 0x80, 0x9F),
            0xE1..=0xEF => (2, 0x80, 0xBF),
            0xF0 => (3, 0x90, 0xBF),
            0xF1..=0xF3 => (3, 0x80, 0xBF),
            0xF4 => (3, 0x80, 0x8F),
            _ => return false,
        };
        true
    }

    /// Takes the next bytes. False if no text goes on like this.
    pub fn push_all(&mut self, bytes: &[u8]) -> bool {
        bytes.iter().all(|byte| self.push(*byte))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_agrees_with_the_library_on_every_short_text() {
        let edges = [0, 0x7F, 0x80, 0x8F, 0x90, 0x9F, 0xA0, 0xBF, 0xC0, 0xC1, 0xC2, 0xDF, 0xE0, 0xE1, 0xEC, 0xED, 0xEE];
        let edges: Vec<u8> = edges.into_iter().chain([0xEF, 0xF0, 0xF1, 0xF3, 0xF4, 0xF5, 0xFF]).collect();
        let count = edges.len();
        for number in 0..count.pow(4) {
            let text = [number, number / count, number / count.pow(2), number / count.pow(3)];
            let text = text.map(|place| edges[place % count]);
            let mut check = Utf8::new();
            let is_text = check.push_all(&text) && check.is_whole();
            assert_eq!(is_text, std::str::from_utf8(&text).is_ok(), "{text:x?}");
        }
    }
}

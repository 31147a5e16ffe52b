//! Text in an event.

use core::fmt::{self, Write};

/// Length of the longest text, bytes: the room of a slot beside two numbers.
pub const TEXT_BYTES: usize = 100;

/// A line of text; a longer text loses its end.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Text(heapless::String<TEXT_BYTES, u8>);

impl Text {
    /// Formats the first line of the words, as far as it fits.
    #[must_use]
    pub fn new(words: fmt::Arguments<'_>) -> Self {
        let mut line = FirstLine { text: Self::default(), ended: false };
        // The line takes everything and cuts the rest, so writing cannot fail.
        let _cut = line.write_fmt(words);
        line.text
    }

    /// Returns the whole text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        self.0.as_str()
    }
}

impl From<&str> for Text {
    fn from(text: &str) -> Self {
        Self::new(format_args!("{text}"))
    }
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Text {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=str}", self.as_str());
    }
}

struct FirstLine {
    text: Text,
    ended: bool,
}

impl Write for FirstLine {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for letter in text.chars() {
            self.ended |= letter == '\n';
            if self.ended || self.text.0.push(letter).is_err() {
                self.ended = true;
                break;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_the_first_line_and_no_longer_than_there_is_room_for() {
        assert_eq!(Text::new(format_args!("{} is off\nHALT asserted\n", "vmotor")).as_str(), "vmotor is off");
        let long = "x".repeat(TEXT_BYTES - 1) + "é and more";
        assert_eq!(Text::from(long.as_str()).as_str(), "x".repeat(TEXT_BYTES - 1), "no letter is cut in two");
    }
}

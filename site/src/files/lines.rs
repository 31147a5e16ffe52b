//! Lines of a file, some at a time, while the card is at rest. Nothing of the file is kept: what was not a
//! whole line is read again.

use base::ports::{FileHandle, Storage, StorageError};

/// Longest beginning of a line that is looked at.
const LINE_BYTES: usize = 192;
/// Bytes that are read in one go.
const MOST_BYTES: u32 = 2_048;

/// Progress of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// More is to be read.
    Open,
    /// The line that was looked for has come, and what follows it is next.
    Found,
    /// The end was reached.
    End,
}

/// Lines of a file.
#[derive(Clone, Copy, Debug)]
pub struct Lines {
    /// File that is read.
    pub file: FileHandle,
    /// Place of what comes next, and of the end.
    pub at: u32,
    pub end: u32,
    /// Whether what comes next is the rest of a line.
    pub is_inside: bool,
}

impl Lines {
    /// Begins at the beginning of a file, and ends at this place.
    #[must_use]
    pub const fn new(file: FileHandle, end: u32) -> Self {
        Self { file, at: 0, end, is_inside: false }
    }

    /// Shows the next lines to `look`, without their ends, until it says that one is the line that it looks
    /// for. The card is to be at rest: it is waited for, for as long as a read of eight blocks takes.
    ///
    /// # Errors
    /// Those of the card.
    pub fn go_on(
        &mut self,
        card: &mut impl Storage,
        mut look: impl FnMut(&[u8]) -> bool,
    ) -> Result<Search, StorageError> {
        let stop = self.at.saturating_add(MOST_BYTES);
        let mut room = [0; LINE_BYTES];
        while self.at < self.end {
            if self.at >= stop {
                return Ok(Search::Open);
            }
            card.seek(self.file, self.at)?;
            let count = fill(self.file, &mut room, card)?;
            let mut rest = room.get(..count).unwrap_or_default();
            if rest.is_empty() {
                break;
            }
            while let Some(length) = rest.iter().position(|byte| *byte == b'\n') {
                let (line, behind) = rest.split_at_checked(length).unwrap_or_default();
                rest = behind.get(1..).unwrap_or_default();
                self.at += length as u32 + 1;
                if !core::mem::take(&mut self.is_inside) && look(line) {
                    return Ok(Search::Found);
                }
            }
            // The file's last line may have no end; one that fills the room is too long.
            let is_last = count < LINE_BYTES;
            if is_last || rest.len() == LINE_BYTES {
                self.at += rest.len() as u32;
                if !core::mem::replace(&mut self.is_inside, !is_last) && !rest.is_empty() && look(rest) {
                    return Ok(Search::Found);
                }
            }
        }
        Ok(Search::End)
    }
}

/// Reads bytes: all that there is room for, fewer at the file's end.
fn fill(file: FileHandle, room: &mut [u8], card: &mut impl Storage) -> Result<usize, StorageError> {
    let mut count = 0;
    while let Some(free) = room.get_mut(count..).filter(|free| !free.is_empty()) {
        match card.read(file, free)? {
            0 => break,
            read => count += read,
        }
    }
    Ok(count)
}

#[cfg(test)]
mod tests {
    use base::bench::Card;
    use base::ports::OpenMode;

    use super::*;

    fn lines(text: &str) -> Vec<String> {
        let mut card = Card::with(&[("/sd/a.g", text)]);
        let file = card.open("/sd/a.g", OpenMode::Beside).unwrap();
        let (mut lines, mut all) = (Lines::new(file, text.len() as u32), Vec::new());
        while lines
            .go_on(&mut card, |line| {
                all.push(String::from_utf8(line.to_vec()).unwrap());
                line == b"stop"
            })
            .unwrap()
            != Search::End
        {}
        all
    }

    #[test]
    fn lines_are_shown_once_and_whole_but_for_long_ones() {
        let text: String = (0..400).map(|number| format!("G1 X{number}\n")).collect();
        assert_eq!(lines(&text), text.lines().collect::<Vec<_>>());
        assert_eq!(lines("a\n\nstop\nb"), ["a", "", "stop", "b"]);
        let long = "x".repeat(1_000);
        assert_eq!(lines(&format!("a\n{long}\nb\n")), ["a", &long[..LINE_BYTES], "b"]);
        assert!(lines("").is_empty());
    }
}

//! The lines of a file that is being played.

use core::fmt::Write as _;

use base::paths::Path;
use base::ports::{FileHandle, Storage, StorageError};
use base::sessions::LineBytes;
use gcode::{Gathered, LineBuffer};
use program::{Dialect, Place};

use super::outline;

/// Bytes read from the card at a time: one sector.
const CHUNK: usize = 512;

/// Greatest number of files that wait for each other's subroutines.
pub const MOST_CALLERS: usize = 3;
/// Refusal of calls that are deeper.
pub const TOO_DEEP: &str = "files call each other more than 3 deep";

/// Result of reading from the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// A line has been read.
    Line,
    /// A line that is longer than any may be.
    TooLong,
    /// Nothing: the file's dialect is looked for.
    Nothing,
    /// Nothing: the card has not brought the line yet.
    NotYet,
    /// The dialect that the file states.
    Dialect(Dialect),
    /// The end of the file.
    End,
    /// Nothing: the file cannot be read, for this reason.
    Failed(&'static str),
}

/// A file, line by line.
#[derive(Debug)]
pub struct FileLines {
    file: FileHandle,
    /// Chunk that was read last, `filled` bytes of it. In place: the card's data goes where it stays.
    chunk: [u8; CHUNK],
    filled: usize,
    /// Offset of the chunk in the file, bytes.
    chunk_at: u32,
    next: usize,
    gathering: LineBuffer,
    /// Number of bytes handed to lines so far.
    read: u32,
    /// Number of line ends seen so far.
    ends: u32,
    /// Every line has been handed out.
    at_end: bool,
}

impl FileLines {
    /// Begins at the file's beginning.
    pub const fn new(file: FileHandle) -> Self {
        let gathering = LineBuffer::new();
        Self { file, chunk: [0; CHUNK], filled: 0, chunk_at: 0, next: 0, gathering, read: 0, ends: 0, at_end: false }
    }

    /// Begins a file that is played, and so read ahead.
    pub fn played(file: FileHandle, storage: &mut impl Storage) -> Self {
        storage.read_ahead(file);
        Self::new(file)
    }

    /// Returns the open file.
    pub const fn file(&self) -> FileHandle {
        self.file
    }

    /// Returns the number of bytes handed to lines so far.
    pub const fn read(&self) -> u32 {
        self.read
    }

    /// Returns the number of the line that was given last, from 1.
    pub const fn number(&self) -> u32 {
        // The last line of a file may have no end.
        self.ends + self.at_end as u32
    }

    /// Reads the next line of the file.
    pub fn next(&mut self, storage: &mut impl Storage, line: &mut LineBytes) -> Next {
        let begins = self.read;
        let next = self.gather(storage, line);
        if !matches!(next, Next::TooLong) {
            return next;
        }
        let next = cut(self.gathering.beginning(), line);
        if matches!(next, Next::Line) && !line.trim_ascii_start().starts_with(b";") {
            self.shorten_outline(begins, storage, line);
        }
        next
    }

    /// Replaces the outline of a definition that is too long by the rectangle around it, which alone is used;
    /// it is read once more for that. The next read notices a card that does not answer now.
    #[cold]
    fn shorten_outline(&self, begins: u32, storage: &mut impl Storage, line: &mut LineBytes) {
        let around = outline::around(storage, self.file, begins..self.read);
        let _ = storage.seek(self.file, self.chunk_at.saturating_add(self.filled as u32));
        if let (Ok(Some(around)), Ok(text)) = (around, core::str::from_utf8(line))
            && let Some(shorter) = outline::shortened(text, around)
        {
            *line = shorter;
        }
    }

    /// Returns the next line of the chunk at hand. `None`: more has to be read first ([`Self::fill`]).
    pub fn next_at_hand(&mut self, line: &mut LineBytes) -> Option<Next> {
        let next = if self.at_end { Some(Next::End) } else { self.gather_at_hand(line) };
        if matches!(next, Some(Next::TooLong)) { Some(cut(self.gathering.beginning(), line)) } else { next }
    }

    /// Hands out the rest at hand as the file's last line, which may have no end.
    pub fn last(&mut self, line: &mut LineBytes) -> Next {
        self.at_end = true;
        self.gathering.finish().map_or(Next::End, |gathered| handed_out(gathered, line))
    }

    fn gather_at_hand(&mut self, line: &mut LineBytes) -> Option<Next> {
        if self.gathering.is_empty() && self.take_whole(line) {
            return Some(Next::Line);
        }
        while let Some(rest) = self.chunk.get(self.next..self.filled).filter(|rest| !rest.is_empty()) {
            let run = self.gathering.push_run(rest);
            let special = rest.get(run).copied();
            let taken = run + usize::from(special.is_some());
            self.next += taken;
            self.read = self.read.saturating_add(taken as u32);
            self.ends += u32::from(special == Some(b'\n'));
            if let Some(gathered) = special.and_then(|byte| self.gathering.push(byte)) {
                return Some(handed_out(gathered, line));
            }
        }
        None
    }

    /// Copies the next line, if it is whole in the chunk and plain: as nearly all are.
    #[inline(always)]
    fn take_whole(&mut self, line: &mut LineBytes) -> bool {
        let rest = self.chunk.get(self.next..self.filled).unwrap_or(&[]);
        let Some(whole) = gcode::plain_line(rest) else { return false };
        if !Gathered::Line(whole).copy_to(line) {
            return false;
        }
        let taken = whole.len() + 1;
        self.next += taken;
        self.read = self.read.saturating_add(taken as u32);
        self.ends += 1;
        true
    }

    fn gather(&mut self, storage: &mut impl Storage, line: &mut LineBytes) -> Next {
        if self.at_end {
            return Next::End;
        }
        loop {
            if let Some(next) = self.gather_at_hand(line) {
                return next;
            }
            if !storage.is_at_hand(self.file) {
                return Next::NotYet;
            }
            match self.fill(storage) {
                Ok(true) => {}
                Ok(false) => return self.last(line),
                Err(error) => return Next::Failed(error.text()),
            }
        }
    }

    /// Reads the next chunk. False at the end of the file.
    pub fn fill(&mut self, storage: &mut impl Storage) -> Result<bool, StorageError> {
        let mut chunk = [0; CHUNK];
        let filled = storage.read(self.file, &mut chunk)?.min(CHUNK);
        // The old chunk stays until the read has succeeded: see `take_up`.
        self.chunk_at = self.chunk_at.saturating_add(self.filled as u32);
        (self.chunk, self.next, self.filled) = (chunk, 0, filled);
        Ok(self.filled > 0)
    }

    /// Returns the place between the line that was given last and the next one.
    pub const fn place(&self) -> Place {
        Place { offset: self.read, line: self.ends }
    }

    /// Whether going on from this place needs nothing to be read.
    pub fn is_at_hand(&self, place: Place) -> bool {
        place.offset.checked_sub(self.chunk_at).is_some_and(|offset| (offset as usize) < self.filled)
    }

    /// Goes on from a place that [`is_at_hand`](Self::is_at_hand).
    pub const fn go_to_at_hand(&mut self, place: Place) {
        self.next = place.offset.saturating_sub(self.chunk_at) as usize;
        self.gathering = LineBuffer::new();
        (self.read, self.ends, self.at_end) = (place.offset, place.line, false);
    }

    /// Goes on from a place between two lines. A chunk at hand is not read again: loops are mostly short.
    pub fn go_to(&mut self, place: Place, storage: &mut impl Storage) -> Result<(), StorageError> {
        if !self.is_at_hand(place) {
            storage.seek(self.file, place.offset)?;
            (self.chunk_at, self.filled) = (place.offset, 0);
        }
        self.go_to_at_hand(place);
        Ok(())
    }

    /// Goes on from this place with the same file, opened again on a card that was put back.
    ///
    /// # Errors
    /// When the card does not answer.
    pub fn take_up(
        &mut self,
        file: FileHandle,
        place: Place,
        storage: &mut impl Storage,
    ) -> Result<bool, StorageError> {
        let mut chunk = [0; CHUNK];
        storage.seek(file, self.chunk_at)?;
        let count = if self.filled == 0 { 0 } else { storage.read(file, &mut chunk)? };
        if chunk.get(..count.min(self.filled)) != self.chunk.get(..self.filled) {
            return Ok(false);
        }
        (self.file, self.filled, self.next) = (file, 0, 0);
        self.go_to(place, storage).map(|()| true)
    }

    /// Whether nothing more is to be read.
    pub const fn is_at_end(&self) -> bool {
        self.at_end
    }

    /// Ends the reading of lines.
    pub const fn end(&mut self) {
        self.at_end = true;
    }

    /// Begins at the file's beginning again.
    pub fn restart(&mut self, storage: &mut impl Storage) -> Result<(), StorageError> {
        *self = Self::new(self.file);
        storage.seek(self.file, 0)
    }
}

fn handed_out(gathered: Gathered<'_>, line: &mut LineBytes) -> Next {
    if gathered.copy_to(line) { Next::Line } else { Next::TooLong }
}

/// Cuts a line that was too long to its beginning. A comment loses nothing that counts, slicers write their
/// settings in some of kilobytes; and the definition of an object only its outline.
#[cold]
fn cut(beginning: &[u8], line: &mut LineBytes) -> Next {
    const OUTLINED: &[u8] = b"EXCLUDE_OBJECT_DEFINE ";
    let text = beginning.trim_ascii_start();
    let is_outlined = text.get(..OUTLINED.len()).is_some_and(|start| start.eq_ignore_ascii_case(OUTLINED));
    if text.starts_with(b";") || is_outlined { handed_out(Gathered::Line(beginning), line) } else { Next::TooLong }
}

/// Returns the path of a subroutine's file; empty, which no file is, when that does not fit.
pub fn sub_path(folder: &str, name: &str) -> Path {
    let mut path = Path::new();
    if write!(path, "{folder}/{name}.ngc").is_err() {
        path.clear();
    }
    path
}

/// Whether a line is a comment or empty: no moves are made for it.
pub fn is_comment(line: &[u8]) -> bool {
    // Nearly every line begins with a letter.
    !line.first().is_some_and(u8::is_ascii_alphabetic)
        && matches!(line.trim_ascii_start().first(), None | Some(b';' | b'%'))
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::bench::Card;
    use base::ports::OpenMode;

    fn open(card: &mut Card, text: &str) -> FileLines {
        card.put("/sd/a.g", text.as_bytes());
        FileLines::new(card.open("/sd/a.g", OpenMode::Read).unwrap())
    }

    /// Every line with its number and the offset of its end.
    fn all(lines: &mut FileLines, card: &mut Card) -> Vec<(String, u32, u32)> {
        let (mut line, mut all) = (LineBytes::new(), Vec::new());
        loop {
            match lines.next(card, &mut line) {
                Next::Line => {
                    all.push((String::from_utf8(line.to_vec()).unwrap(), lines.number(), lines.read()));
                }
                Next::TooLong => all.push(("too long".into(), lines.number(), lines.read())),
                Next::End => return all,
                other => panic!("{other:?}"),
            }
        }
    }

    #[test]
    fn lines_have_their_numbers_and_offsets_whatever_ends_them() {
        let mut card = Card::default();
        let mut lines = open(&mut card, "G28\nG1 X1\n\nG1 X2");
        let expected = [("G28", 1, 4), ("G1 X1", 2, 10), ("", 3, 11), ("G1 X2", 4, 16)];
        let expected = expected.map(|(text, number, offset)| (text.to_owned(), number, offset));
        assert_eq!(all(&mut lines, &mut card), expected);
        assert_eq!(lines.next(&mut card, &mut LineBytes::new()), Next::End);
        lines.restart(&mut card).unwrap();
        assert_eq!(all(&mut lines, &mut card), expected);
    }

    #[test]
    fn lines_longer_than_a_chunk_together_and_one_that_is_too_long() {
        let text = format!("{}\n{}\nG28\n", "x".repeat(255), "y".repeat(700)).repeat(3);
        let mut card = Card::default();
        let mut lines = open(&mut card, &text);
        let all = all(&mut lines, &mut card);
        let kinds: Vec<_> = all.iter().map(|(text, ..)| text.len()).collect();
        assert_eq!(kinds, [255, 8, 3, 255, 8, 3, 255, 8, 3]);
        assert_eq!((all[7].1, lines.read()), (8, text.len() as u32));
    }

    #[test]
    fn long_comments_lose_their_ends_and_outlines_become_rectangles() {
        let mut card = Card::default();
        let comment = format!("  ; start_gcode = {}", "G28\\n".repeat(500));
        let outline = format!("EXCLUDE_OBJECT_DEFINE NAME=a POLYGON=[{}[1,1]]", "[100.5,100.5],".repeat(60));
        let mut lines = open(&mut card, &format!("{comment}\nG1 X1\n{outline}\nG1 {comment}"));
        let all = all(&mut lines, &mut card);
        let kinds: Vec<_> = all.iter().map(|(text, number, _)| (text.len(), *number)).collect();
        assert_eq!(kinds, [(255, 1), (5, 2), (70, 3), (8, 4)], "the last is no comment from its beginning");
        assert_eq!(all[0].0.as_str(), &comment[..255]);
        let around = "EXCLUDE_OBJECT_DEFINE NAME=a POLYGON=[[1.000,1.000],[100.500,100.500]]";
        assert_eq!(all[2].0, around, "what is used of an outline is the rectangle around it");
        assert_eq!(all[3].0, "too long");
    }

    #[test]
    fn a_place_is_come_back_to_from_anywhere() {
        let text: String = (0..200).map(|line| format!("G1 X{line}\n")).collect();
        let mut card = Card::default();
        let mut lines = open(&mut card, &text);
        let (mut line, mut places) = (LineBytes::new(), Vec::new());
        for _ in 0..200 {
            places.push(lines.place());
            assert_eq!(lines.next(&mut card, &mut line), Next::Line);
        }
        for number in [0, 1, 199, 30, 31, 120, 0, 198] {
            lines.go_to(places[number], &mut card).unwrap();
            assert_eq!(lines.next(&mut card, &mut line), Next::Line);
            assert_eq!(line, format!("G1 X{number}").as_bytes());
            assert_eq!(lines.number(), number as u32 + 1);
        }
        assert_eq!(lines.next(&mut card, &mut line), Next::Line);
        assert_eq!(lines.next(&mut card, &mut line), Next::End);
        lines.go_to(places[199], &mut card).unwrap();
        assert_eq!(lines.next(&mut card, &mut line), Next::Line);
        lines.end();
        assert_eq!(lines.next(&mut card, &mut line), Next::End);
    }

    #[test]
    fn a_card_that_fails_says_why() {
        let mut card = Card::default();
        let mut lines = open(&mut card, "G28\n");
        card.fails = true;
        let said = lines.next(&mut card, &mut LineBytes::new());
        assert_eq!(said, Next::Failed("the SD card reports a read or write error"));
    }
}

//! A picture out of a file's comments: found, then decoded from Base64 (RFC 4648, section 4) as it goes.

use base::ports::{FileHandle, OpenMode, Storage, StorageError};
use http::Made;

use super::lines::{Lines, Search};
use super::metadata::Thumbnail;

/// Bytes of a file's beginning in which pictures are looked for.
const MOST_BYTES: u32 = 1_024 * 1_024;
/// Bytes of the card's blocks, and bytes that are read together.
const BLOCK: usize = 512;
const PIECE: usize = 128;

/// Picture on its way to a visitor.
#[derive(Debug)]
pub struct Picture {
    lines: Lines,
    width: u16,
    height: u16,
    is_jpeg: bool,
    /// Characters that are left, once it was found.
    left: Option<u32>,
    /// Bits that are no whole byte yet, and their number.
    bits: u16,
    count: u8,
}

/// Splits the path of a picture: that of its file, and what picture it is. `a/.thumbs/b.gcode-64x48.png` is
/// one of `a/b.gcode`.
#[must_use]
pub fn parts(path: &str) -> Option<(&str, &str, (u16, u16, bool))> {
    let (folder, name) = path.rsplit_once(".thumbs/")?;
    if !(folder.is_empty() || folder.ends_with('/')) {
        return None;
    }
    let (name, ending) = name.rsplit_once('.')?;
    let (name, size) = name.rsplit_once('-')?;
    let (width, height) = size.split_once('x')?;
    let is_jpeg = match ending {
        "jpg" => true,
        "png" => false,
        _ => return None,
    };
    Some((folder, name, (width.parse().ok()?, height.parse().ok()?, is_jpeg)))
}

impl Picture {
    /// Begins to look for a picture of this width, height and kind.
    ///
    /// # Errors
    /// Those of the card.
    pub fn begin(
        path: &str,
        (width, height, is_jpeg): (u16, u16, bool),
        card: &mut impl Storage,
    ) -> Result<Self, StorageError> {
        let lines = Lines::new(card.open(path, OpenMode::Beside)?, MOST_BYTES);
        Ok(Self { lines, width, height, is_jpeg, left: None, bits: 0, count: 0 })
    }

    /// Returns the file that is searched.
    #[must_use]
    pub const fn file(&self) -> FileHandle {
        self.lines.file
    }

    /// Returns the content type.
    #[must_use]
    pub const fn content_type(&self) -> &'static str {
        if self.is_jpeg { "image/jpeg" } else { "image/png" }
    }

    /// Looks for the picture, while the card is at rest. None while it goes on; then whether it is there.
    pub fn find(&mut self, card: &mut impl Storage) -> Option<bool> {
        let Self { lines, width, height, is_jpeg, left, .. } = self;
        let search = lines.go_on(card, |line| {
            let is_it = |found: &Thumbnail| (found.width, found.height, found.is_jpeg) == (*width, *height, *is_jpeg);
            *left = Thumbnail::read(line).filter(is_it).map(|found| found.length);
            left.is_some()
        });
        match search {
            Ok(Search::Open) => None,
            Ok(Search::Found) => Some(card.seek(lines.file, lines.at).is_ok()),
            Ok(Search::End) | Err(_) => Some(false),
        }
    }

    /// Makes the next piece.
    pub fn make(&mut self, room: &mut [u8], card: &mut impl Storage) -> Made {
        let mut used = 0;
        while let Some(left) = self.left.filter(|left| *left > 0 && used < room.len()) {
            let mut piece = [0; PIECE];
            // A read within one block, as the next one may have to be waited for.
            let in_block = BLOCK - self.lines.at as usize % BLOCK;
            let piece = piece.get_mut(..in_block.min(PIECE)).unwrap_or_default();
            if !card.is_at_hand(self.lines.file) {
                return Made::Part(used);
            }
            let read = card.read(self.lines.file, piece);
            let Some(count) = read.ok().filter(|count| *count > 0) else { return Made::Failed };
            let mut left = left;
            for byte in piece.get(..count).unwrap_or_default() {
                if left == 0 || used == room.len() {
                    break;
                }
                self.lines.at += 1;
                match value(*byte) {
                    Some(value) => {
                        left -= 1;
                        used += self.add(value, room.get_mut(used..).unwrap_or_default());
                    }
                    None if *byte == b'=' => left -= 1,
                    // Ends of lines, and what makes comments of them.
                    None => {}
                }
            }
            self.left = Some(left);
            if card.seek(self.lines.file, self.lines.at).is_err() {
                return Made::Failed;
            }
        }
        if self.left == Some(0) { Made::Last(used) } else { Made::Part(used) }
    }

    /// Adds six bits. Returns how many bytes they have completed.
    fn add(&mut self, value: u8, room: &mut [u8]) -> usize {
        self.bits = self.bits << 6 | u16::from(value);
        self.count += 6;
        if self.count < 8 {
            return 0;
        }
        self.count -= 8;
        if let Some(place) = room.first_mut() {
            *place = (self.bits >> self.count) as u8;
        }
        1
    }
}

/// Returns the six bits that a character stands for.
const fn value(byte: u8) -> Option<u8> {
    Some(match byte {
        b'A'..=b'Z' => byte - b'A',
        b'a'..=b'z' => byte - b'a' + 26,
        b'0'..=b'9' => byte - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_of_pictures_name_their_file_and_size() {
        assert_eq!(parts(".thumbs/a-b.gcode-64x48.png"), Some(("", "a-b.gcode", (64, 48, false))));
        assert_eq!(parts("x/y/.thumbs/b.g-300x300.jpg"), Some(("x/y/", "b.g", (300, 300, true))));
        for path in ["a.gcode", ".thumbs/a.gcode", ".thumbs/a-64.png", ".thumbs/a-64x64.gif", "x.thumbs/a-6x6.png"] {
            assert_eq!(parts(path), None, "{path}");
        }
    }
}

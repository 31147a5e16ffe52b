//! A file of the card on its way to a visitor.

use base::ports::{FileHandle, OpenMode, Storage, StorageError};
use http::{EntityTag, Extent, Made, Request, Response, Selection, Status};

use super::refusal::Refusal;

/// Bytes of the card's blocks.
const BLOCK: usize = 512;

/// File that is read, as far as it is out.
#[derive(Debug)]
pub struct Reading {
    file: FileHandle,
    at: u32,
    left: u32,
    /// Whether the visitor is to save the file rather than look at it.
    pub is_attachment: bool,
}

impl Reading {
    /// Opens the file that a request asks for. Returns the head of the answer, and what makes its body.
    ///
    /// # Errors
    /// Those of the card, and that it is a folder.
    pub fn begin(
        path: &str,
        content_type: &'static str,
        is_attachment: bool,
        request: &Request<'_>,
        card: &mut impl Storage,
    ) -> Result<(Response, Option<Self>), Refusal> {
        let facts = card.facts(path)?;
        if facts.is_directory {
            return Err(Refusal::new(Status::NotFound, "this is a folder"));
        }
        let mut whole = Response::of(Status::Ok, content_type, Extent::Open);
        whole.tag = Some(EntityTag(facts.tag));
        whole.cache = http::Cache::Ask;
        let selection = Selection::of(request, whole.tag, u64::from(facts.size_bytes));
        let response = selection.answer(whole, u64::from(facts.size_bytes));
        let (at, left) = match selection {
            Selection::Whole => (0, facts.size_bytes),
            Selection::Part(part) => (part.first as u32, (part.last - part.first + 1) as u32),
            Selection::NotModified | Selection::Unsatisfiable => return Ok((response, None)),
        };
        let file = card.open(path, OpenMode::Beside)?;
        card.seek(file, at)?;
        Ok((response, Some(Self { file, at, left, is_attachment })))
    }

    /// Makes the next piece, of what takes no waiting for the card.
    pub fn make(&mut self, room: &mut [u8], card: &mut impl Storage) -> Made {
        let mut used = 0;
        while self.left > 0 {
            let free = room.get_mut(used..).unwrap_or_default();
            let in_block = BLOCK - self.at as usize % BLOCK;
            let most = free.len().min(in_block).min(self.left as usize);
            let Some(piece) = free.get_mut(..most).filter(|piece| !piece.is_empty()) else { break };
            if !card.is_at_hand(self.file) {
                break;
            }
            match card.read(self.file, piece) {
                // The file has changed, or the card is gone.
                Ok(0) | Err(_) => return Made::Failed,
                Ok(count) => {
                    used += count;
                    self.at += count as u32;
                    self.left -= count as u32;
                }
            }
        }
        if self.left == 0 { Made::Last(used) } else { Made::Part(used) }
    }

    /// Closes the file that was read.
    pub fn end(self, card: &mut impl Storage) {
        // A file that was only read has nothing to lose.
        let _: Result<(), StorageError> = card.close(self.file);
    }
}

/// Returns the content type of a file by the end of its name.
#[must_use]
pub fn type_of(path: &str) -> &'static str {
    const TYPES: [(&str, &str); 13] = [
        ("html", "text/html; charset=utf-8"),
        ("js", "text/javascript; charset=utf-8"),
        ("css", "text/css; charset=utf-8"),
        ("json", "application/json"),
        ("txt", "text/plain; charset=utf-8"),
        ("svg", "image/svg+xml"),
        ("png", "image/png"),
        ("jpg", "image/jpeg"),
        ("webp", "image/webp"),
        ("ico", "image/x-icon"),
        ("woff2", "font/woff2"),
        ("wasm", "application/wasm"),
        ("webmanifest", "application/manifest+json"),
    ];
    let end = path.rsplit_once('.').map_or("", |(_, end)| end);
    TYPES.iter().find(|(known, _)| end.eq_ignore_ascii_case(known)).map_or("application/octet-stream", |row| row.1)
}

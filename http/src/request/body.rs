//! Body of a request out of its framing (RFC 9112, sections 6 and 7): known length, or chunks.

use crate::limits::{CHUNK_LINE_BYTES, TRAILER_BYTES};
use crate::status::Status;

/// Length of a body, where it is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// So many bytes; 0 where there is no body.
    Known(u64),
    /// As long as chunks come.
    Chunked,
}

/// Place in the framing of chunks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// Digits of a chunk's size.
    Size {
        digits: u8,
    },
    /// Extension behind the size.
    Extension,
    /// Line feed behind a size.
    SizeEnd,
    Data,
    /// Carriage return behind the data.
    DataReturn,
    /// Line feed behind the data.
    DataEnd,
    /// Beginning of a line behind the last chunk.
    TrailerLine,
    Trailer,
    /// Line feed of a line of the trailer.
    TrailerEnd,
    /// Line feed of the empty line, the last byte of all.
    LastEnd,
}

/// Part of a body that was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece {
    /// Number of bytes of framing in front of it.
    pub skipped: usize,
    /// Number of bytes of the body.
    pub bytes: usize,
}

/// Decoder of a body.
#[derive(Clone, Debug)]
pub struct BodyDecoder {
    place: Place,
    /// Bytes left of the chunk, or of the body.
    left: u64,
    /// Bytes of the line, or of the trailer.
    line: u16,
    is_chunked: bool,
    is_over: bool,
    /// Bytes that may still come.
    allowed: u64,
}

impl BodyDecoder {
    /// Makes a decoder for a body that begins.
    #[must_use]
    pub const fn new(length: Length, allowed: u64) -> Self {
        let (left, is_chunked) = match length {
            Length::Known(length) => (length, false),
            Length::Chunked => (0, true),
        };
        let is_over = !is_chunked && left == 0;
        Self { place: Place::Size { digits: 0 }, left, line: 0, is_chunked, is_over, allowed }
    }

    /// Returns whether the body has ended.
    #[must_use]
    pub const fn is_over(&self) -> bool {
        self.is_over
    }

    /// Returns how many bytes are to come; none where chunks say it one by one.
    #[must_use]
    pub const fn left(&self) -> Option<u64> {
        if self.is_chunked { None } else { Some(self.left) }
    }

    /// Sets how many bytes may still come. False if more are announced already.
    pub const fn allow(&mut self, bytes: u64) -> bool {
        self.allowed = bytes;
        self.fits()
    }

    /// Returns whether what is announced is allowed. Chunks announce nothing before their sizes are whole.
    #[must_use]
    pub const fn fits(&self) -> bool {
        self.is_chunked || self.left <= self.allowed
    }

    /// Takes the next piece of the body: framing, then bytes of the body up to the next framing.
    ///
    /// # Errors
    /// The framing is broken, or the body too long.
    pub fn take(&mut self, bytes: &[u8]) -> Result<Piece, Status> {
        let mut skipped = 0;
        if self.is_chunked {
            while !self.is_over && self.place != Place::Data {
                let Some(&byte) = bytes.get(skipped) else { break };
                self.frame(byte)?;
                skipped += 1;
            }
        }
        let mut taken = 0;
        if !self.is_over && (self.place == Place::Data || !self.is_chunked) {
            let here = bytes.len() - skipped;
            taken = usize::try_from(self.left).unwrap_or(usize::MAX).min(here);
            self.left -= taken as u64;
            self.allowed = self.allowed.checked_sub(taken as u64).ok_or(Status::ContentTooLarge)?;
            if self.left == 0 && self.is_chunked {
                self.place = Place::DataReturn;
            } else if self.left == 0 {
                self.is_over = true;
            }
        }
        Ok(Piece { skipped, bytes: taken })
    }

    /// Takes a byte of the framing.
    fn frame(&mut self, byte: u8) -> Result<(), Status> {
        self.line += 1;
        self.place = match (self.place, byte) {
            (Place::Size { digits: 1.. }, b'\r') | (Place::Extension, b'\r') => Place::SizeEnd,
            (Place::Size { digits: 1.. }, b';') => Place::Extension,
            (Place::Size { digits }, byte) => self.digit(digits, byte)?,
            (Place::Extension, b'\t' | b' '..=b'~') if self.line <= CHUNK_LINE_BYTES => Place::Extension,
            (Place::SizeEnd, b'\n') => self.begin()?,
            (Place::DataReturn, b'\r') => Place::DataEnd,
            (Place::DataEnd, b'\n') => {
                self.line = 0;
                Place::Size { digits: 0 }
            }
            (Place::TrailerLine, b'\r') => Place::LastEnd,
            (Place::Trailer, b'\r') => Place::TrailerEnd,
            (Place::TrailerLine, b'!'..=b'~') | (Place::Trailer, b'\t' | b' '..=b'~' | 0x80..)
                if self.line <= TRAILER_BYTES =>
            {
                Place::Trailer
            }
            (Place::TrailerLine | Place::Trailer, _) if self.line > TRAILER_BYTES => {
                return Err(Status::RequestHeaderFieldsTooLarge);
            }
            (Place::TrailerEnd, b'\n') => Place::TrailerLine,
            (Place::LastEnd, b'\n') => {
                self.is_over = true;
                Place::LastEnd
            }
            _ => return Err(Status::BadRequest),
        };
        Ok(())
    }

    fn digit(&mut self, digits: u8, byte: u8) -> Result<Place, Status> {
        let value = char::from(byte).to_digit(16).ok_or(Status::BadRequest)?;
        if digits >= 8 {
            return Err(Status::BadRequest);
        }
        self.left = self.left << 4 | u64::from(value);
        Ok(Place::Size { digits: digits + 1 })
    }

    /// Begins a chunk whose size is known.
    fn begin(&mut self) -> Result<Place, Status> {
        self.line = 0;
        match self.left {
            0 => Ok(Place::TrailerLine),
            left if left > self.allowed => Err(Status::ContentTooLarge),
            _ => Ok(Place::Data),
        }
    }
}

//! Parts of a form out of bytes in pieces of any size (RFC 2046, section 5.1).

use super::disposition::{self, Disposition};
use crate::limits::{BOUNDARY_BYTES, PART_LINE_BYTES, PART_LINES, PARTS, PREAMBLE_BYTES};

/// Bytes that stand before a boundary.
const BEFORE: &[u8] = b"\r\n--";
/// Longest boundary with what stands before it.
const DELIMITER: usize = BEFORE.len() + BOUNDARY_BYTES;

/// Something of a form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item<'i> {
    /// Beginning of a part.
    Part {
        /// Name of the field.
        name: &'i str,
        /// Name of the file, where it is one: without folders, but otherwise as it was sent.
        file_name: Option<&'i str>,
    },
    /// Bytes of the part.
    Data(&'i [u8]),
    /// The part is whole.
    EndPart,
    /// The form is whole. What follows counts for nothing.
    End,
}

/// Reason why a form is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// There is no boundary, or none that can be.
    Boundary,
    /// A part is malformed.
    Part,
    /// Something is beyond its limit.
    TooLong,
    /// The form ended before its last boundary.
    Short,
}

/// Place in a form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// Before the first boundary.
    Preamble,
    /// Right behind a boundary.
    Behind,
    /// Behind a boundary and the first of the two signs that end the form.
    Dash,
    /// Spaces behind a boundary.
    Padding,
    /// Line feed behind a boundary.
    PaddingEnd,
    /// Header line of a part.
    Line,
    /// Line feed of a header line.
    LineEnd,
    Data,
    /// Bytes that were taken for the beginning of a delimiter, so many of them: they are data.
    Again(u8),
    Over,
    Broken(Error),
}

/// Reader of a form: 500 bytes.
#[derive(Clone, Debug)]
pub struct Multipart {
    place: Place,
    delimiter: [u8; DELIMITER],
    delimiter_bytes: u8,
    /// Bytes of the delimiter that have come.
    matched: u8,
    /// Header line, or the one that says what the part is.
    line: [u8; PART_LINE_BYTES],
    line_bytes: u16,
    disposition: Option<Disposition>,
    lines: u8,
    parts: u8,
    preamble: u16,
}

/// Something that ends with a byte.
enum End {
    /// Header lines of a part.
    Head,
    Part,
    Form,
}

impl Multipart {
    /// Begins a form whose request has this `Content-Type`.
    ///
    /// # Errors
    /// The type is another one, or without a boundary.
    pub fn new(content_type: &str) -> Result<Self, Error> {
        let boundary = boundary(content_type).ok_or(Error::Boundary)?;
        let mut delimiter = [0; DELIMITER];
        for (place, byte) in delimiter.iter_mut().zip(BEFORE.iter().chain(boundary.as_bytes())) {
            *place = *byte;
        }
        Ok(Self {
            place: Place::Preamble,
            delimiter,
            delimiter_bytes: (BEFORE.len() + boundary.len()) as u8,
            // The first boundary may be the first thing of all: as if an end of line came before it.
            matched: 2,
            line: [0; PART_LINE_BYTES],
            line_bytes: 0,
            disposition: None,
            lines: 0,
            parts: 0,
            preamble: 0,
        })
    }

    /// Returns the next thing, and takes its bytes from `input`. None when there are no more bytes.
    ///
    /// # Errors
    /// The form is not taken; this stays so.
    pub fn next<'s, 'i: 's>(&'s mut self, input: &mut &'i [u8]) -> Result<Option<Item<'s>>, Error> {
        loop {
            match self.place {
                Place::Broken(error) => return Err(error),
                Place::Over => {
                    *input = &[];
                    return Ok(None);
                }
                Place::Data if self.matched == 0 => {
                    let count = input.iter().take_while(|byte| **byte != b'\r').count();
                    if count > 0 {
                        let (data, rest) = input.split_at_checked(count).unwrap_or_default();
                        *input = rest;
                        return Ok(Some(Item::Data(data)));
                    }
                }
                Place::Again(count) => {
                    self.place = Place::Data;
                    return Ok(self.delimiter.get(..usize::from(count)).map(Item::Data));
                }
                _ => {}
            }
            let Some((byte, rest)) = input.split_first() else { return Ok(None) };
            let end = match self.step(*byte) {
                Ok((takes, end)) => {
                    if takes {
                        *input = rest;
                    }
                    end
                }
                Err(error) => {
                    self.place = Place::Broken(error);
                    return Err(error);
                }
            };
            match end {
                Some(End::Head) => return self.part().map(Some),
                Some(End::Part) => return Ok(Some(Item::EndPart)),
                Some(End::Form) => return Ok(Some(Item::End)),
                None => {}
            }
        }
    }

    /// Ends the form, which has to be whole.
    ///
    /// # Errors
    /// It is not whole.
    pub fn finish(&self) -> Result<(), Error> {
        match self.place {
            Place::Over => Ok(()),
            Place::Broken(error) => Err(error),
            _ => Err(Error::Short),
        }
    }

    /// Takes a byte, unless it has to be looked at again, and says what ends with it.
    fn step(&mut self, byte: u8) -> Result<(bool, Option<End>), Error> {
        let next = match (self.place, byte) {
            (Place::Preamble, _) => self.preamble(byte)?,
            (Place::Data, _) => return Ok(self.data(byte)),
            (Place::Behind, b'-') => Place::Dash,
            (Place::Dash, b'-') => {
                self.place = Place::Over;
                return Ok((true, Some(End::Form)));
            }
            (Place::Behind | Place::Padding, b' ' | b'\t') => Place::Padding,
            (Place::Behind | Place::Padding, b'\r') => Place::PaddingEnd,
            (Place::PaddingEnd, b'\n') => self.begin_part()?,
            (Place::Line, b'\r') => Place::LineEnd,
            (Place::Line, b'\t' | b' '..=b'~' | 0x80..) => self.push(byte)?,
            (Place::LineEnd, b'\n') if self.line_bytes == 0 => {
                self.place = Place::Data;
                return if self.disposition.is_some() { Ok((true, Some(End::Head))) } else { Err(Error::Part) };
            }
            (Place::LineEnd, b'\n') => self.end_line()?,
            _ => return Err(Error::Part),
        };
        self.place = next;
        Ok((true, None))
    }

    /// Returns whether the byte is the next one of the delimiter.
    fn matches(&self, byte: u8) -> bool {
        self.delimiter.get(usize::from(self.matched)) == Some(&byte)
    }

    /// Notes that the next byte of the delimiter has come. True if it was the last one.
    const fn advance(&mut self) -> bool {
        self.matched += 1;
        let is_whole = self.matched == self.delimiter_bytes;
        if is_whole {
            self.matched = 0;
        }
        is_whole
    }

    fn preamble(&mut self, byte: u8) -> Result<Place, Error> {
        self.preamble += 1;
        if self.preamble > PREAMBLE_BYTES + DELIMITER as u16 {
            return Err(Error::TooLong);
        }
        // A delimiter has no carriage return but its first byte.
        if !self.matches(byte) {
            self.matched = u8::from(byte == b'\r');
        } else if self.advance() {
            return Ok(Place::Behind);
        }
        Ok(Place::Preamble)
    }

    fn data(&mut self, byte: u8) -> (bool, Option<End>) {
        if !self.matches(byte) {
            self.place = Place::Again(core::mem::take(&mut self.matched));
            return (false, None);
        }
        if self.advance() {
            self.place = Place::Behind;
            return (true, Some(End::Part));
        }
        (true, None)
    }

    fn begin_part(&mut self) -> Result<Place, Error> {
        self.parts += 1;
        (self.disposition, self.lines, self.line_bytes) = (None, 0, 0);
        if self.parts > PARTS { Err(Error::TooLong) } else { Ok(Place::Line) }
    }

    /// Takes a byte of a header line. The line that says what the part is stays where it is.
    fn push(&mut self, byte: u8) -> Result<Place, Error> {
        let place = self.line.get_mut(usize::from(self.line_bytes)).ok_or(Error::TooLong)?;
        if self.disposition.is_none() {
            *place = byte;
        }
        self.line_bytes += 1;
        Ok(Place::Line)
    }

    fn end_line(&mut self) -> Result<Place, Error> {
        self.lines += 1;
        if self.lines > PART_LINES {
            return Err(Error::TooLong);
        }
        let line = self.line.get_mut(..usize::from(self.line_bytes)).unwrap_or_default();
        if self.disposition.is_none() && disposition::is_disposition(line) {
            self.disposition = Some(disposition::read(line).ok_or(Error::Part)?);
        }
        self.line_bytes = 0;
        Ok(Place::Line)
    }

    fn part(&self) -> Result<Item<'_>, Error> {
        let names = self.disposition.as_ref().ok_or(Error::Part)?;
        let text = |range: &core::ops::Range<usize>| {
            self.line.get(range.clone()).and_then(|text| core::str::from_utf8(text).ok()).unwrap_or_default()
        };
        Ok(Item::Part { name: text(&names.name), file_name: names.file_name.as_ref().map(text) })
    }
}

/// Returns the boundary that a `Content-Type` names.
fn boundary(content_type: &str) -> Option<&str> {
    let mut parts = content_type.split(';').map(|part| part.trim_ascii());
    if !parts.next()?.eq_ignore_ascii_case("multipart/form-data") {
        return None;
    }
    let (_, value) =
        parts.filter_map(|part| part.split_once('=')).find(|(name, _)| name.eq_ignore_ascii_case("boundary"))?;
    let value = value.strip_prefix('"').map_or(Some(value), |value| value.strip_suffix('"'))?;
    let can_be = |byte: u8| byte.is_ascii_alphanumeric() || b"'()+_,-./:=? ".contains(&byte);
    let is_good = (1..=BOUNDARY_BYTES).contains(&value.len()) && value.bytes().all(can_be) && !value.ends_with(' ');
    is_good.then_some(value)
}

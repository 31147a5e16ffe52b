//! Bodies of answers, made as they go.

use crate::fields::Fields;

/// Outcome of making a piece of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Made {
    /// So many bytes, and more will come; 0 while nothing can be said yet.
    Part(usize),
    /// So many bytes, the last ones.
    Last(usize),
    /// The rest cannot be made: the connection is cut, so that nobody takes the half for the whole.
    Failed,
}

/// Body of an answer, or a message to a WebSocket: made piece by piece, into the room that the socket has.
pub trait Body {
    /// Adds header lines of the answer. Called once for each piece of the head, always with the same lines.
    fn fields(&self, _fields: &mut Fields<'_, '_>) {}

    /// Makes the next piece. Room is for [`crate::limits::BODY_ROOM`] bytes at least, unless the answer's
    /// length is known and less than that is left.
    fn make(&mut self, room: &mut [u8]) -> Made;
}

/// Body without a byte.
#[derive(Clone, Copy, Debug, Default)]
pub struct Empty;

impl Body for Empty {
    fn make(&mut self, _room: &mut [u8]) -> Made {
        Made::Last(0)
    }
}

/// Body whose bytes are all there.
#[derive(Clone, Copy, Debug)]
pub struct Slice<'s> {
    left: &'s [u8],
}

impl<'s> Slice<'s> {
    /// Makes a body of these bytes.
    #[must_use]
    pub const fn new(bytes: &'s [u8]) -> Self {
        Self { left: bytes }
    }
}

impl Body for Slice<'_> {
    fn make(&mut self, room: &mut [u8]) -> Made {
        let count = room.len().min(self.left.len());
        let (now, later) = self.left.split_at_checked(count).unwrap_or_default();
        for (place, byte) in room.iter_mut().zip(now) {
            *place = *byte;
        }
        self.left = later;
        if later.is_empty() { Made::Last(count) } else { Made::Part(count) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slice_is_made_in_pieces_of_any_size() {
        let mut body = Slice::new(b"abcde");
        let mut room = [0; 2];
        assert_eq!((body.make(&mut room), room), (Made::Part(2), *b"ab"));
        assert_eq!((body.make(&mut room), room), (Made::Part(2), *b"cd"));
        assert_eq!((body.make(&mut []), room[0]), (Made::Part(0), b'c'));
        assert_eq!((body.make(&mut room), room[0]), (Made::Last(1), b'e'));
        assert_eq!(Empty.make(&mut room), Made::Last(0));
    }
}

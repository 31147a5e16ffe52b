//! JSON in numbered parts, each made when there is room for it.

use super::writer::Writer;
use crate::body::Made;
use crate::window::Window;

/// Continuation behind a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Another part comes behind it.
    Part,
    /// Nothing: this was the last one.
    End,
    /// The part, which cannot be made yet; nothing of it was written.
    Later,
}

/// Progress of a text that is made in parts: all that has to be kept of it.
///
/// A part may be made several times until it is out. One that fits into [`crate::limits::BODY_ROOM`] bytes
/// goes out whole: its numbers may change at any time. A longer one must be the same each time.
#[derive(Clone, Copy, Debug, Default)]
pub struct Parts {
    part: u32,
    /// Bytes of the part that are out.
    out: u32,
    is_behind: bool,
}

impl Parts {
    /// Begins with part 0.
    #[must_use]
    pub const fn new() -> Self {
        Self { part: 0, out: 0, is_behind: false }
    }

    /// Makes as many parts as there is room for, for [`crate::Body::make`]. `write` writes the part of the
    /// number that it is given.
    pub fn make(&mut self, room: &mut [u8], mut write: impl FnMut(u32, &mut Writer<'_, '_>) -> Next) -> Made {
        let mut used = 0;
        loop {
            let free = room.get_mut(used..).unwrap_or_default();
            if free.is_empty() {
                return Made::Part(used);
            }
            let mut window = Window::new(free, self.out as usize);
            let mut writer = Writer::new(&mut window, self.is_behind);
            let next = write(self.part, &mut writer);
            let is_behind = writer.is_behind();
            let written = window.written();
            if next == Next::Later {
                return Made::Part(used);
            }
            if !window.is_whole() {
                // A part that has become shorter than what is out of it.
                if written == 0 {
                    return Made::Failed;
                }
                if used > 0 {
                    // The next room may be enough for all of it.
                    return Made::Part(used);
                }
                self.out += written as u32;
                return Made::Part(written);
            }
            used += written;
            *self = Self { part: self.part + 1, out: 0, is_behind };
            if next == Next::End {
                return Made::Last(used);
            }
        }
    }
}

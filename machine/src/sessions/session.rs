//! One session.

use core::fmt::{self, Write};

use gcode::{Decoder, Gathered, LineBuffer};
use heapless::{Deque, Vec};
use program::Dialect;
use units::Micros;

use super::{Inbox, LineBytes, Received};
use crate::files::paths::Path;
use crate::ports::{FileHandle, SessionProfile};

/// Output a session can be behind with; more than the longest reply of one line.
const OUTPUT_BYTES: usize = 2_048;
/// With more than this waiting to be sent, a session gets no turn.
const OUTPUT_AHEAD: usize = 512;
/// A status report is only written with less than this waiting.
const STATUS_BACKLOG: usize = 1_024;

/// What a session may do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rights {
    /// Everything.
    #[default]
    Operate,
    /// Ask, and stop the machine in an emergency.
    Watch,
}

/// An answer of many lines, given as fast as they are taken, beside everything else.
#[derive(Clone, Debug)]
pub enum Listing {
    /// Of a directory.
    Directory {
        /// Which.
        path: Path,
        /// Entries given so far.
        seen: usize,
        /// Files, folders and bytes so far.
        sums: (u32, u32, u64),
        /// Only names.
        names_only: bool,
        /// M20 asked, not `ls`.
        for_m20: bool,
    },
    /// Of a file, up to so many lines.
    File {
        /// Which.
        path: Path,
        /// It is open.
        file: FileHandle,
        /// Lines to go.
        lines: u32,
        /// Bytes of a character whose rest has not been read.
        carried: Vec<u8, 4>,
    },
    /// Of a section of config.ini.
    Section {
        /// It is open.
        file: FileHandle,
        /// Its name.
        section: heapless::String<48>,
        /// In that section now.
        inside: bool,
        /// What has been read of a line whose end has not been.
        line: Vec<u8, 320>,
        /// That is its beginning.
        begins: bool,
    },
    /// What M500 would save: the parts from this one on.
    Settings {
        /// The next part.
        part: u8,
    },
    /// The grid's rows, from this one on.
    Grid {
        /// The next row, counted as they are shown; the first one is the heading.
        row: usize,
    },
    /// What `help` says, from this line on.
    Help {
        /// The next line.
        line: usize,
    },
    /// What the drivers of these motors say of themselves.
    Drivers {
        /// One bit each.
        motors: u8,
    },
}

/// One session.
#[derive(Debug)]
pub struct Session {
    gathering: LineBuffer,
    line: Option<LineBytes>,
    output: Deque<u8, OUTPUT_BYTES>,
    /// Line numbers and checksums.
    pub decoder: Decoder,
    /// How its lines are read and answered.
    pub dialect: Dialect,
    /// What it may do.
    pub rights: Rights,
    /// An answer that goes on.
    pub listing: Option<Listing>,
    /// Ctrl-Y was received.
    pub stop_requested: bool,
    /// Its line is being carried out.
    busy: bool,
    /// Its line is a move that found the look-ahead queue full.
    waits_for_room: bool,
    /// Whether its line is a question has been looked at.
    looked_at: bool,
    /// Lines its inbox had no room for, and that are not answered yet.
    lost: u32,
    /// How often somebody came or went, as last seen.
    visits: u32,
    /// Its output was last taken then.
    taken_at: Micros,
}

impl Session {
    pub(super) const fn new() -> Self {
        Self {
            gathering: LineBuffer::new(),
            line: None,
            output: Deque::new(),
            decoder: Decoder::new(),
            dialect: Dialect::Smoothie,
            rights: Rights::Operate,
            listing: None,
            stop_requested: false,
            busy: false,
            waits_for_room: false,
            looked_at: false,
            lost: 0,
            visits: 0,
            taken_at: Micros(0),
        }
    }

    /// Somebody new is at the other end, or nobody.
    pub(super) fn begin(&mut self, profile: &SessionProfile, visits: u32) {
        self.gathering.clear();
        self.line = None;
        self.output.clear();
        self.decoder = Decoder::new();
        self.rights = profile.rights;
        // Whatever it started by hand ends with it.
        self.stop_requested = self.visits != visits && !visits.is_multiple_of(2);
        self.waits_for_room = false;
        self.visits = visits;
    }

    pub(super) const fn visits(&self) -> u32 {
        self.visits
    }

    /// Whether there is anything to do for it beside its line and its output.
    #[must_use]
    pub fn wants_service(&self, inbox: &Inbox) -> bool {
        inbox.has_news()
            || self.visits != inbox.visits()
            || self.listing.is_some()
            || self.lost > 0
            || (self.line.is_some() && !self.looked_at)
    }

    /// Gathers bytes until a line is whole. True when a line was dropped for being too long.
    pub fn gather(&mut self, inbox: &Inbox) -> bool {
        while self.line.is_none() && self.lost == 0 {
            let byte = match inbox.take() {
                Some(Received::Byte(byte)) => byte,
                Some(Received::ForgetLine) => {
                    self.gathering.clear();
                    continue;
                }
                None => {
                    self.lost = inbox.take_lost();
                    return false;
                }
            };
            match self.gathering.push(byte) {
                Some(Gathered::Line(line)) => {
                    self.line = Vec::from_slice(line).ok();
                    self.looked_at = false;
                }
                Some(Gathered::TooLong) => return true,
                None => {}
            }
        }
        false
    }

    /// The line that waits.
    #[must_use]
    pub fn waiting(&self) -> Option<&[u8]> {
        self.line.as_deref()
    }

    /// Whether its line can be carried out: it is whole, the one before has been answered, and there is room
    /// for its answer.
    pub(super) fn is_ready(&self, path_is_full: bool) -> bool {
        self.line.is_some()
            && !self.busy
            && self.listing.is_none()
            && self.output.len() <= OUTPUT_AHEAD
            && !(path_is_full && self.waits_for_room)
    }

    /// Its line, once, when nothing but the machine itself may hold it back: whoever looks at it answers it
    /// if it is a question.
    pub fn line_to_look_at(&mut self) -> Option<&LineBytes> {
        if self.looked_at || !self.is_ready(false) {
            return None;
        }
        self.looked_at = true;
        self.line.as_ref()
    }

    /// Forgets the line that waits: it has been answered.
    pub fn drop_line(&mut self) {
        self.line = None;
    }

    /// Takes the line that waits, to be carried out; [`Self::answered`] ends that.
    pub fn take_line(&mut self) -> Option<LineBytes> {
        let line = self.line.take();
        self.busy |= line.is_some();
        self.waits_for_room = false;
        line
    }

    /// The line that waits is a move that found the look-ahead queue full: it has no turn before there is
    /// room.
    pub const fn wait_for_room(&mut self) {
        self.waits_for_room = true;
    }

    /// The line that was taken has been answered.
    pub const fn answered(&mut self) {
        self.busy = false;
    }

    /// Takes one lost line to be answered as a refused one, so that a sender that counts answers stays in
    /// step. It keeps its place: what came before has been answered, and there is room for the answer.
    pub fn take_lost(&mut self) -> bool {
        let tells = self.lost > 0 && !self.busy && self.line.is_none() && self.output.len() < OUTPUT_BYTES / 2;
        self.lost -= u32::from(tells);
        tells
    }

    /// Drops its unfinished line, as an abort does.
    pub fn clear_line(&mut self) {
        self.gathering.clear();
        self.line = None;
    }

    /// Says something. A text that does not fit whole is left out.
    pub fn say(&mut self, text: fmt::Arguments<'_>) {
        // Writing cannot fail.
        let _ = self.write_fmt(text);
    }

    /// Whether there is room for a status report.
    #[must_use]
    pub fn has_room_for_status(&self) -> bool {
        self.output.len() < STATUS_BACKLOG
    }

    /// Whether there is room for the next piece of a listing.
    #[must_use]
    pub fn has_room_for_listing(&self) -> bool {
        self.output.len() < OUTPUT_AHEAD
    }

    /// Hands output on; what is not taken for so long is forgotten.
    pub(super) fn flush(&mut self, now: Micros, timeout: Micros, mut take: impl FnMut(&[u8]) -> usize) {
        if self.output.is_empty() {
            self.taken_at = now;
            return;
        }
        // Two rounds: the ring's two halves.
        for _ in 0..2 {
            let (front, _) = self.output.as_slices();
            let taken = if front.is_empty() { 0 } else { take(front) };
            for _ in 0..taken {
                self.output.pop_front();
            }
            if taken > 0 {
                self.taken_at = now;
            }
        }
        if now.since(self.taken_at) > timeout {
            self.output.clear();
        }
    }
}

impl Write for Session {
    /// Whole pieces or nothing: a reader that fell 2 kB behind gets gaps between words, never within.
    fn write_str(&mut self, text: &str) -> fmt::Result {
        if text.len() <= OUTPUT_BYTES - self.output.len() {
            for byte in text.bytes() {
                // There is room.
                let _ = self.output.push_back(byte);
            }
        }
        Ok(())
    }
}

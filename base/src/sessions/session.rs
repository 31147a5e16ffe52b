//! State of one session.

use core::fmt::{self, Write};

use gcode::{Decoder, Gathered, LineBuffer};
use heapless::Vec;
use program::Dialect;
use units::Micros;

use super::marks::{Marks, NEWS, REFUSED, Unmarked};
use super::output::{OUTPUT_BYTES, Output};
use super::periodic::Periods;
use super::{INBOX_BYTES, Inbox, LineBytes, Listing, Received};
use crate::grbl::framing::{BANNER, Framing};
use crate::reason::Reason;
use crate::sessions::{ConsoleKind, SessionProfile};

/// Waiting output, bytes, above which a session gets no turn.
const OUTPUT_AHEAD: usize = 512;
/// Waiting output, bytes, below which a status report is written.
const STATUS_BACKLOG: usize = 1_024;

/// Rights of a session, each with those before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rights {
    /// The session may ask, and stop the machine in an emergency.
    Watch,
    /// The session may have the machine work: move, heat, play files.
    Operate,
    /// The session may do everything: change files, settings and firmware too.
    #[default]
    Own,
}

/// Session with its line, output and dialect.
#[derive(Debug)]
pub struct Session {
    gathering: LineBuffer,
    line: Option<LineBytes>,
    output: Output,
    /// Converter of the output to GRBL's lines, in GRBL's dialect.
    framing: Framing,
    /// Marks behind answers, where the peer is a program.
    marks: Marks,
    /// Decoder of line numbers and checksums.
    pub decoder: Decoder,
    /// Dialect of the session's lines and answers.
    pub dialect: Dialect,
    /// Banner that senders of GRBL's dialect wait for at first, and after each reset.
    pub grbl_banner: &'static str,
    /// Rights of the session.
    pub rights: Rights,
    /// Answer in progress, of many lines.
    pub listing: Option<Listing>,
    /// Whether Ctrl-Y was received.
    pub stop_requested: bool,
    /// Value of `visits` when the former peer had gone.
    left_at: u32,
    /// Whether a file from the former peer was broken off by its leaving.
    pub broke_off_file: bool,
    /// Whether the session's line is being carried out.
    busy: bool,
    /// Value of `visits` when that line was begun.
    line_visits: u32,
    /// Count of bytes taken when the line was whole.
    line_ends_at: u32,
    /// Count of bytes received when a jogging peer had let go last.
    jogs_dropped_at: Option<u32>,
    /// Whether the line is a move that found the look-ahead queue full.
    waits_for_room: bool,
    /// Whether the line has been looked at for being a question.
    looked_at: bool,
    /// Lines that did not fit into the inbox, and are not answered yet.
    lost: u32,
    /// Whether a line was too long, and is not answered yet.
    too_long: bool,
    /// Number of times that a peer came or went, as last seen.
    visits: u32,
    /// Time at which output was last taken.
    taken_at: Micros,
    /// Whether the transport knows its peer to be there: then output waits for it.
    is_patient: bool,
    /// Whether the peer has taken nothing for long.
    is_stuck: bool,
    /// Periods of the reports without asking.
    pub periods: Periods,
}

impl Session {
    pub(super) const fn new() -> Self {
        Self {
            gathering: LineBuffer::new(),
            line: None,
            output: Output::new(),
            framing: Framing::new(),
            marks: Marks::new(false),
            decoder: Decoder::new(),
            dialect: Dialect::Smoothie,
            grbl_banner: BANNER,
            rights: Rights::Own,
            listing: None,
            stop_requested: false,
            left_at: 0,
            broke_off_file: false,
            busy: false,
            line_visits: 0,
            line_ends_at: 0,
            jogs_dropped_at: None,
            waits_for_room: false,
            looked_at: false,
            lost: 0,
            too_long: false,
            visits: 0,
            taken_at: Micros(0),
            is_patient: false,
            is_stuck: false,
            periods: Periods::NONE,
        }
    }

    /// Starts anew for a new peer.
    pub(super) fn begin(&mut self, profile: &SessionProfile, visits: u32) {
        self.gathering.clear();
        self.line = None;
        self.output.bytes.clear();
        self.framing = Framing::new();
        self.marks = Marks::new(profile.kind == ConsoleKind::Web);
        self.decoder = Decoder::new();
        self.rights = profile.rights;
        (self.stop_requested, self.broke_off_file) = (false, false);
        self.periods = Periods::NONE;
        self.waits_for_room = false;
        (self.lost, self.too_long) = (0, false);
        self.is_patient = matches!(profile.kind, ConsoleKind::Usb | ConsoleKind::Network | ConsoleKind::Web);
        self.visits = visits;
    }

    /// Notes that the peer has gone. Whole lines of the peer are carried out, for nobody to hear.
    pub(super) fn leave(&mut self, visits: u32) {
        self.output.bytes.clear();
        self.framing = Framing::new();
        self.marks = Marks::new(self.marks.are_on());
        // Other peers may have come and gone since then, unseen.
        self.left_at = if self.has_somebody() { self.visits.wrapping_add(1) } else { visits };
        self.visits = visits;
    }

    /// Returns whether lines of the former peer are still to be begun.
    pub(super) fn has_from_before(&self, inbox: &Inbox) -> bool {
        inbox.has_from_before() || self.line.is_some()
    }

    /// Forgets the lines of the peer that has gone, as far as they have not been begun.
    pub fn forget_visit(&mut self, inbox: &Inbox) {
        inbox.forget_visit(self.left_at);
        self.clear_line();
    }

    /// Returns whether the sender of the line that is carried out has gone; another peer may have come.
    pub(super) const fn asker_has_left(&self) -> bool {
        !self.line_visits.is_multiple_of(2) || self.line_visits != self.visits
    }

    /// Returns whether a peer is at the other end, as last seen.
    pub(super) const fn has_somebody(&self) -> bool {
        self.visits.is_multiple_of(2)
    }

    pub(super) const fn visits(&self) -> u32 {
        self.visits
    }

    /// Returns whether there is anything to do for the session beside its line and its output.
    #[must_use]
    #[inline(always)]
    pub fn wants_service(&self, inbox: &Inbox) -> bool {
        inbox.has_news()
            || self.visits != inbox.visits()
            || self.listing.is_some()
            || self.lost > 0
            || self.too_long
            || (self.line.is_some() && !self.looked_at)
    }

    /// Returns whether nothing is to be done for the session until its inbox changes: no line, no output.
    pub(super) fn is_silent(&self, inbox: &Inbox) -> bool {
        self.output.bytes.is_empty() && self.line.is_none() && !self.wants_service(inbox)
    }

    /// Returns whether several people send lines, each with rights of their own: visitors of the page.
    #[must_use]
    pub const fn is_shared(&self) -> bool {
        self.marks.are_on()
    }

    /// Gathers bytes until a line is whole.
    pub fn gather(&mut self, inbox: &Inbox) {
        // During a transfer the bytes are no lines.
        if matches!(self.listing, Some(Listing::Transfer)) {
            return;
        }
        while self.line.is_none() && self.lost == 0 && !self.too_long {
            // A peer that has come meanwhile is greeted first. Bytes of a peer that comes after this look are
            // not taken.
            let received = inbox.received();
            if self.visits != inbox.visits() && inbox.is_open() && !inbox.has_from_before() {
                return;
            }
            let byte = match inbox.take(received) {
                Some(Received::Byte(byte)) => byte,
                Some(Received::ForgetLine) => {
                    self.gathering.clear();
                    continue;
                }
                Some(Received::LoseLine) => {
                    self.gathering.clear();
                    self.lost = 1;
                    return;
                }
                None => {
                    self.lost = inbox.take_lost();
                    return;
                }
            };
            match self.gathering.push(byte) {
                Some(Gathered::Line(line)) => {
                    self.line_ends_at = inbox.taken();
                    self.line = Vec::from_slice(line).ok();
                    self.looked_at = false;
                }
                Some(Gathered::TooLong) => self.too_long = true,
                None => {}
            }
        }
    }

    /// Returns the line that waits.
    #[must_use]
    pub fn waiting(&self) -> Option<&[u8]> {
        self.line.as_deref()
    }

    /// Returns whether a whole line waits.
    #[inline(always)]
    pub(super) const fn has_line(&self) -> bool {
        self.line.is_some()
    }

    /// Returns whether the line can be carried out: it is whole, the one before has been answered, and there
    /// is room for the answer.
    pub fn is_ready(&self, path_is_full: bool) -> bool {
        self.line.is_some()
            && !self.busy
            && self.listing.is_none()
            && self.output.bytes.len() <= OUTPUT_AHEAD
            && !(path_is_full && self.waits_for_room)
    }

    /// Returns the waiting line, once, when nothing but the machine itself may hold it back: the caller
    /// answers it if it is a question.
    pub fn line_to_look_at(&mut self) -> Option<&LineBytes> {
        if self.looked_at || !self.is_ready(false) {
            return None;
        }
        self.looked_at = true;
        self.owe();
        self.line.as_ref()
    }

    /// Notes that a line has been taken, which is owed one answer.
    const fn owe(&mut self) {
        self.framing.owe();
        self.marks.owe();
    }

    /// Forgets the waiting line, which has been answered.
    pub fn drop_line(&mut self) {
        self.line = None;
        self.settle();
    }

    /// Takes the waiting line, to be carried out; [`Self::answered`] ends that.
    pub fn take_line(&mut self) -> Option<LineBytes> {
        let line = self.line.take();
        self.busy |= line.is_some();
        self.line_visits = self.visits;
        self.owe();
        self.waits_for_room = false;
        line
    }

    /// Notes that the waiting line is a move that found the look-ahead queue full: its turn comes when there
    /// is room.
    pub const fn wait_for_room(&mut self) {
        self.waits_for_room = true;
    }

    /// Whether refusals are numbers here, as in GRBL's dialect.
    #[must_use]
    pub fn numbers_refusals(&self) -> bool {
        self.dialect == Dialect::Grbl
    }

    /// Notes that the line that was taken has been answered.
    pub fn answered(&mut self) {
        self.busy = false;
        self.settle();
    }

    /// Returns whether the session's line is being carried out.
    pub(super) const fn is_busy(&self) -> bool {
        self.busy
    }

    /// Takes the reports that are due without asking: temperatures, progress of the file, a line that takes
    /// its time.
    pub fn take_due(&mut self, now: Micros) -> [bool; 3] {
        self.periods.take_due(self.dialect, self.busy, now)
    }

    /// Answers with `ok` a line that ended without an answer, as well as its listing, in GRBL's dialect; and
    /// with a mark, where there are marks.
    pub fn settle(&mut self) {
        if self.busy || self.listing.is_some() {
            return;
        }
        if self.dialect == Dialect::Grbl {
            let Self { framing, output, .. } = self;
            // Writing to the output cannot fail.
            let _ = framing.settle(output);
        }
        if let Some(mark) = self.marks.settle() {
            // A mark that does not fit is missed with the text before it; the output has room for a line's
            // answer whenever a line is taken.
            let _ = self.output.bytes.push_back(mark);
        }
    }

    /// Takes the fault of a line that was lost, to be answered as a refused one, so that a sender that counts
    /// answers stays in step. The answer keeps its place: earlier lines have been answered, and there is
    /// room.
    pub fn take_lost(&mut self) -> Option<(Reason, &'static str)> {
        if self.busy || self.line.is_some() || self.output.bytes.len() >= OUTPUT_BYTES / 2 {
            return None;
        }
        let lost = if core::mem::take(&mut self.too_long) {
            (Reason::LineLength, "Discarding long line")
        } else if self.lost > 0 {
            self.lost -= 1;
            (Reason::LineLength, "line lost, wait for ok before sending more")
        } else {
            return None;
        };
        self.owe();
        Some(lost)
    }

    /// Drops jogs that the peer sent before it let go, and that are still to be begun.
    pub fn drop_jogs(&mut self, inbox: &Inbox) {
        self.jogs_dropped_at = Some(inbox.stopped_at());
    }

    /// Returns whether the line that was taken last was sent before the peer let go.
    #[must_use]
    pub fn let_go_behind_line(&self) -> bool {
        self.jogs_dropped_at.is_some_and(|at| at.wrapping_sub(self.line_ends_at) as usize <= INBOX_BYTES)
    }

    /// Drops the unfinished line, as an abort does.
    pub fn clear_line(&mut self) {
        self.gathering.clear();
        self.line = None;
        if self.marks.are_on() {
            // A line that is dropped is not done.
            self.marks = Marks::new(true);
            let _ = self.output.bytes.push_back(REFUSED);
        }
    }

    /// Drops the session's lines and the answers owed to them, as GRBL's reset does.
    pub fn reset(&mut self, inbox: &Inbox) {
        inbox.drop_before_reset();
        self.clear_line();
        (self.lost, self.too_long) = (0, false);
        self.framing.forgive();
    }

    /// Sends a text as an answer. A text that does not fit whole is left out.
    pub fn say(&mut self, text: fmt::Arguments<'_>) {
        self.write(text, true);
    }

    /// Drops output that nobody is there to hear.
    pub(super) fn drop_output(&mut self) {
        self.output.bytes.clear();
    }

    /// Sends the greeting: the transport's, or the banner that senders of GRBL's dialect wait for.
    pub fn greet(&mut self, greeting: &str) {
        self.announce(format_args!("{}", if self.dialect == Dialect::Grbl { self.grbl_banner } else { greeting }));
    }

    /// Sends a text that answers no line.
    pub fn announce(&mut self, text: fmt::Arguments<'_>) {
        self.write(text, false);
    }

    fn write(&mut self, text: fmt::Arguments<'_>, is_reply: bool) {
        let Self { framing, marks, output, .. } = self;
        // Writing to the output cannot fail.
        let _ = match self.dialect {
            _ if marks.are_on() => {
                // Without room for it the text has none either.
                let _ = if is_reply { Ok(()) } else { output.bytes.push_back(NEWS) };
                Unmarked(output).write_fmt(text)
            }
            Dialect::Grbl => Framed { framing, output, is_reply }.write_fmt(text),
            _ => output.write_fmt(text),
        };
    }

    /// Refuses the line that was taken.
    pub fn refuse(&mut self, reason: Reason, why: fmt::Arguments<'_>) {
        self.marks.refuse();
        let Self { framing, output, .. } = self;
        // Writing to the output cannot fail.
        let _ = match self.dialect {
            Dialect::Grbl => framing.refuse(reason, why, output),
            _ => writeln!(output, "error:{why}"),
        };
    }

    /// Returns whether there is room for a status report.
    #[must_use]
    pub fn has_room_for_status(&self) -> bool {
        self.output.bytes.len() < STATUS_BACKLOG
    }

    /// Returns whether there is room for the next piece of a listing.
    #[must_use]
    pub fn has_room_for_listing(&self) -> bool {
        self.output.bytes.len() < OUTPUT_AHEAD
    }

    /// Returns whether the peer has taken nothing for so long that nobody waits for it.
    pub(super) const fn is_stuck(&self) -> bool {
        self.is_stuck
    }

    /// Returns whether no output waits; then everything has been taken by now.
    #[inline(always)]
    pub(super) fn has_nothing_to_say(&mut self, now: Micros) -> bool {
        let is_silent = self.output.bytes.is_empty();
        if is_silent {
            (self.taken_at, self.is_stuck) = (now, false);
        }
        is_silent
    }

    /// Notes that everything said before `now` has been taken.
    pub(super) const fn takes_from(&mut self, now: Micros) {
        self.taken_at = now;
    }

    /// Hands output on; output not taken for `timeout` is dropped, unless a peer is known to be there.
    pub(super) fn flush(&mut self, now: Micros, timeout: Micros, mut take: impl FnMut(&[u8]) -> usize) {
        if self.has_nothing_to_say(now) {
            return;
        }
        // Two rounds, for the ring's two halves.
        for _ in 0..2 {
            let (front, _) = self.output.bytes.as_slices();
            let taken = if front.is_empty() { 0 } else { take(front) };
            for _ in 0..taken {
                self.output.bytes.pop_front();
            }
            if taken > 0 {
                self.taken_at = now;
            }
        }
        self.is_stuck = now.since(self.taken_at) > timeout;
        if self.is_stuck && !self.is_patient {
            self.output.bytes.clear();
        }
    }
}

/// Text output in GRBL's dialect.
struct Framed<'s> {
    framing: &'s mut Framing,
    output: &'s mut Output,
    is_reply: bool,
}

impl Write for Framed<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.framing.pass(text, self.is_reply, self.output)
    }
}

//! Sessions: everybody who talks to the machine. Each has its line being gathered, its output, its line
//! numbers, its dialect and its rights; a reply goes to the session that asked.
//!
//! A session has at most one whole line waiting; while it waits no further bytes are taken, so a sender that
//! does not wait for `ok` is held back by its transport. The same holds while its output has not been taken:
//! it gets no turn, and nobody else waits for it.

mod inbox;
mod listing;
mod periodic;
mod reply;
mod session;

use core::{array, fmt};

use program::Dialect;
use units::Micros;

use crate::grbl::numbers::{Alarm, Error};
use crate::ports::{Consoles, SessionProfile};
pub use inbox::{INBOX_BYTES, Inbox, Intake, Received};
pub use listing::{Enumeration, Listing};
pub use periodic::Periodic;
pub use reply::Reply;
pub use session::{Rights, Session};

/// Most sessions a board can have: debug UART, two auxiliary UARTs, two USB serial ports, three network
/// sessions.
pub const MAX_SESSIONS: usize = 8;
/// A listener that takes nothing for this long is none; its output is dropped.
const LISTENER_TIMEOUT: Micros = Micros::from_seconds(2);

/// A line.
pub type LineBytes = heapless::Vec<u8, { gcode::MAX_LINE_LENGTH }>;

/// A session, by its number on this board: 0 is the debug UART, which always exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionId(pub u8);

/// Who hears what is said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Recipient {
    /// One session.
    Session(SessionId),
    /// Every session.
    All,
    /// Nobody: lines of a file played without `-v`.
    #[default]
    Nobody,
}

impl Recipient {
    /// The session that this is.
    #[must_use]
    pub const fn session(self) -> Option<SessionId> {
        match self {
            Self::Session(session) => Some(session),
            _ => None,
        }
    }
}

/// All sessions of a board.
#[derive(Debug)]
pub struct Sessions {
    sessions: [Session; MAX_SESSIONS],
    count: usize,
    /// The session to look at first, so that a busy one cannot keep the others out.
    turn: usize,
    /// While the line of a button is carried out: whether a button has asked it to end.
    pub button_stop: Option<bool>,
    /// What whoever comes is told behind the greeting.
    pub notice: &'static str,
}

/// What somebody hears who comes back in the middle of a file, from sleep for instance.
const FILE_BROKEN_OFF: &str =
    "Error: the file that was being sent is not kept: it was interrupted. Close the port, open it, and send it again\n";

/// What has become of the one at a session's other end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Visitor {
    /// One has left.
    Left,
    /// What the one before has sent is still to be carried out; then whoever is there now is greeted.
    Waits,
    /// One has come, and was greeted.
    Came,
}

impl Default for Sessions {
    fn default() -> Self {
        Self::new()
    }
}

impl Sessions {
    /// No line, no output. Never inlined: it would be on the caller's stack a second time.
    #[must_use]
    #[inline(never)]
    pub fn new() -> Self {
        // Each is made in its place: as a constant, one of 3 kB would lie in flash to be copied.
        Self { sessions: array::from_fn(|_| Session::new()), count: 0, turn: 0, button_stop: None, notice: "" }
    }

    /// Takes the sessions that a board has.
    pub fn configure(&mut self, consoles: &impl Consoles) {
        self.count = usize::from(consoles.sessions()).min(MAX_SESSIONS);
        for id in self.ids() {
            let profile = consoles.profile(id);
            let visits = consoles.inbox(id).visits();
            if let Some(session) = self.get_mut(id) {
                session.begin(&profile, visits);
            }
        }
    }

    /// Gives every session this dialect, unless its transport has one of its own, and the banner of GRBL's.
    pub fn set_dialect(&mut self, consoles: &impl Consoles, dialect: Dialect, grbl_banner: &'static str) {
        for id in self.ids() {
            let own = consoles.profile(id).dialect;
            if let Some(session) = self.get_mut(id) {
                session.dialect = own.unwrap_or(dialect);
                session.grbl_banner = grbl_banner;
                consoles.inbox(id).set_extended(session.dialect == Dialect::Grbl);
            }
        }
    }

    /// How many there are.
    #[must_use]
    pub const fn count(&self) -> u8 {
        self.count as u8
    }

    /// Those that there are.
    pub fn ids(&self) -> impl Iterator<Item = SessionId> + use<> {
        (0..self.count as u8).map(SessionId)
    }

    /// One session.
    #[must_use]
    pub fn get(&self, id: SessionId) -> Option<&Session> {
        self.sessions.get(usize::from(id.0))
    }

    /// One session.
    pub fn get_mut(&mut self, id: SessionId) -> Option<&mut Session> {
        self.sessions.get_mut(usize::from(id.0))
    }

    /// The dialect of whoever asks; of the first session for the machine itself.
    #[must_use]
    pub fn dialect_of(&self, who: Recipient) -> Dialect {
        let id = who.session().unwrap_or(SessionId(0));
        self.get(id).map_or(Dialect::Smoothie, |session| session.dialect)
    }

    /// The session whose turn it is to have its line carried out. `path_is_full`: those whose line waits for
    /// room in the look-ahead queue are passed over.
    pub fn next_ready(&mut self, path_is_full: bool) -> Option<SessionId> {
        if !self.sessions.iter().take(self.count).any(|session| session.is_ready(path_is_full)) {
            return None;
        }
        for step in 0..self.count {
            let index = (self.turn + step) % self.count;
            let ready = self.sessions.get(index).is_some_and(|session| session.is_ready(path_is_full));
            if ready {
                self.turn = index + 1;
                return Some(SessionId(index as u8));
            }
        }
        None
    }

    /// Says something to those who are meant.
    pub fn say(&mut self, to: Recipient, text: fmt::Arguments<'_>) {
        let count = self.count;
        match to {
            Recipient::Nobody => {}
            Recipient::Session(SessionId(id)) => {
                if let Some(session) = self.sessions.iter_mut().take(count).nth(usize::from(id)) {
                    session.say(text);
                }
            }
            Recipient::All => self.sessions.iter_mut().take(count).for_each(|session| session.announce(text)),
        }
    }

    /// Tells hosts what has become of the job, in their words; who asked for it knows.
    pub fn tell_hosts(&mut self, news: &str, asked: Recipient) {
        for id in self.ids().map(Recipient::Session).filter(|id| *id != asked) {
            if self.dialect_of(id) != Dialect::Grbl {
                self.say(id, format_args!("// action:{news}\n"));
            }
        }
    }

    /// Refuses the line of whoever asked. Of a line that nobody waits for everybody hears.
    pub fn refuse(&mut self, to: Recipient, error: Error, why: fmt::Arguments<'_>) {
        match to.session().and_then(|id| self.get_mut(id)) {
            Some(session) => session.refuse(error, why),
            None => self.say(Recipient::All, format_args!("error:{why}\n")),
        }
    }

    /// The machine has halted: senders of GRBL's dialect are told so by number.
    pub fn alarm(&mut self, alarm: Alarm) {
        for session in self.sessions.iter_mut().take(self.count).filter(|session| session.dialect == Dialect::Grbl) {
            session.announce(format_args!("ALARM:{}\n", alarm.number()));
        }
    }

    /// Whether a line of anybody is being carried out.
    #[must_use]
    pub fn are_busy(&self) -> bool {
        self.sessions.iter().take(self.count).any(Session::is_busy)
    }

    /// Whether somebody wants his command to end (Ctrl-Y), once.
    pub fn take_stop(&mut self, who: Recipient) -> bool {
        if who == Recipient::Nobody {
            return self.button_stop.as_mut().is_some_and(core::mem::take);
        }
        let session = who.session().and_then(|id| self.get_mut(id));
        session.is_some_and(|session| core::mem::take(&mut session.stop_requested))
    }

    /// Whether whoever sent the line that is carried out has gone since then; a button never has.
    #[must_use]
    pub fn has_left(&self, who: Recipient) -> bool {
        who.session().and_then(|id| self.get(id)).is_some_and(Session::asker_has_left)
    }

    /// Whether those who are meant have taken most of what was said to them; who takes nothing for long is
    /// not waited for.
    #[must_use]
    pub fn have_taken_most(&self, who: Recipient) -> bool {
        if who == Recipient::Nobody {
            return true;
        }
        let mut sessions = self.sessions.iter().take(self.count).enumerate();
        sessions.all(|(id, session)| {
            let is_meant = who == Recipient::All || who == Recipient::Session(SessionId(id as u8));
            !is_meant || session.has_room_for_listing() || session.is_stuck()
        })
    }

    /// Hands output to the transports, as much as they take. What nobody takes for [`LISTENER_TIMEOUT`] is
    /// forgotten, but on a transport that knows that somebody is there.
    pub fn flush(&mut self, consoles: &mut impl Consoles, now: Micros) {
        for (index, session) in self.sessions.iter_mut().take(self.count).enumerate() {
            let id = SessionId(index as u8);
            if session.visits() != consoles.inbox(id).visits() {
                session.drop_output();
            }
            session.flush(now, LISTENER_TIMEOUT, |bytes| consoles.write(id, bytes));
        }
    }

    /// Whether somebody has come to this session's other end, or gone, since it was last greeted.
    #[must_use]
    pub fn is_visited_anew(&self, consoles: &impl Consoles, id: SessionId) -> bool {
        self.get(id).is_some_and(|session| session.visits() != consoles.inbox(id).visits())
    }

    /// Follows who comes and goes; what one who has left has left unfinished is given back to be ended, also
    /// where it was begun when he had gone.
    /// Whoever comes finds nothing of the one before: neither his answers nor half a line of his; what that
    /// one had sent whole is carried out first.
    pub fn follow_visitor(&mut self, consoles: &impl Consoles, id: SessionId) -> (Visitor, Option<Listing>) {
        let (inbox, notice) = (consoles.inbox(id), self.notice);
        let visits = inbox.visits();
        let Some(session) = self.get_mut(id) else { return (Visitor::Waits, None) };
        if session.has_somebody() || !inbox.is_open() {
            // Whoever has come since then is met at the next look.
            session.leave(if inbox.is_open() { visits.wrapping_sub(1) } else { visits });
            return (Visitor::Left, session.listing.take());
        }
        if session.has_from_before(inbox) {
            return (Visitor::Waits, None);
        }
        let profile: SessionProfile = consoles.profile(id);
        let (dialect, listing) = (session.dialect, session.listing.take());
        let goes_on_with_file = session.broke_off_file && inbox.is_back();
        session.begin(&profile, visits);
        session.dialect = profile.dialect.unwrap_or(dialect);
        if goes_on_with_file {
            // The rest of the file is no lines to be carried out, and where it ends is not known.
            inbox.forget_visit(visits);
            session.announce(format_args!("{FILE_BROKEN_OFF}"));
            return (Visitor::Came, listing);
        }
        session.greet(profile.greeting);
        session.announce(format_args!("{notice}"));
        (Visitor::Came, listing)
    }
}

#[cfg(test)]
mod tests;

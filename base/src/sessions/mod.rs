//! Sessions: all peers that talk to the machine. Each has its line being gathered, its output, its line
//! numbers, its dialect and its rights; a reply goes to the session that asked.
//!
//! A session has at most one whole line waiting; while it waits no further bytes are taken, so a sender that
//! does not wait for `ok` is held back by its transport. The same holds while the session's output has not
//! been taken: it gets no turn, and nobody else waits for it.

mod consoles;
mod inbox;
mod listing;
mod marks;
mod output;
mod periodic;
mod reply;
mod session;

use core::{array, fmt};

use program::Dialect;
use units::Micros;

use crate::reason::{Alarm, Reason};
pub use consoles::{ConsoleKind, Consoles, SessionProfile};
pub use inbox::{INBOX_BYTES, Inbox, InboxOf, Intake, NETWORK_INBOX_BYTES, Received};
pub use listing::{Enumeration, Listing};
pub use marks::{DONE, NEWS, REFUSED};
pub use periodic::Periodic;
pub use reply::Reply;
pub use session::{Rights, Session};

/// Most sessions that a board can have: debug UART, two auxiliary UARTs, two USB serial ports, RTT, four of
/// the network, and that of the page.
pub const MAX_SESSIONS: usize = 11;
/// Time without taking anything after which a listener counts as none, and its output is dropped.
const LISTENER_TIMEOUT: Micros = Micros::from_seconds(2);

/// Bytes of a line.
pub type LineBytes = heapless::Vec<u8, { gcode::MAX_LINE_LENGTH }>;

/// Number of a session on this board: 0 is the debug UART, which always exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionId(pub u8);

/// Recipient of the machine's texts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Recipient {
    /// A single session hears.
    Session(SessionId),
    /// All sessions hear it.
    All,
    /// Nobody hears: lines of a file played without `-v`.
    #[default]
    Nobody,
}

impl Recipient {
    /// Returns the session, when there is a single one.
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
    /// Whether a session may have a line, output or anything else to be looked at. Mostly none has while a
    /// file is played, and each of its lines would look at all.
    is_stirred: bool,
    /// Whether no session had any at the last look.
    were_silent: bool,
    /// Session to look at first, so that a busy one cannot keep the others out.
    turn: usize,
    /// Whether a button has asked for the end of a button's line, while one is carried out.
    pub button_stop: Option<bool>,
    /// Text for new peers, behind the greeting.
    pub notice: &'static str,
}

/// Text for a peer that comes back in the middle of a file, from sleep for instance.
const FILE_BROKEN_OFF: &str =
    "Error: the file that was being sent is not kept: it was interrupted. Close the port, open it, and send it again\n";

/// Change of a session's peer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Visitor {
    /// The former peer has left.
    Left,
    /// Lines of the former peer are still to be carried out; then the present peer is greeted.
    Waits,
    /// A peer has come, and was greeted.
    Came,
}

impl Default for Sessions {
    fn default() -> Self {
        Self::new()
    }
}

impl Sessions {
    /// Makes sessions without lines and output. Never inlined: it would be on the caller's stack a second
    /// time.
    #[must_use]
    #[inline(never)]
    pub fn new() -> Self {
        // Each session is made in its place: as a constant, one of 3 kB would lie in flash to be copied.
        Self {
            sessions: array::from_fn(|_| Session::new()),
            count: 0,
            is_stirred: true,
            were_silent: false,
            turn: 0,
            button_stop: None,
            notice: "",
        }
    }

    /// Takes over the sessions that a board has.
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

    /// Returns the number of sessions.
    #[must_use]
    pub const fn count(&self) -> u8 {
        self.count as u8
    }

    /// Returns the ids of all sessions.
    pub fn ids(&self) -> impl Iterator<Item = SessionId> + use<> {
        (0..self.count as u8).map(SessionId)
    }

    /// Returns a session by its id.
    #[must_use]
    pub fn get(&self, id: SessionId) -> Option<&Session> {
        self.sessions.get(usize::from(id.0))
    }

    /// Returns a session to change.
    pub fn get_mut(&mut self, id: SessionId) -> Option<&mut Session> {
        self.is_stirred = true;
        self.sessions.get_mut(usize::from(id.0))
    }

    /// Returns the dialect of the recipient; of the first session for the machine itself.
    #[must_use]
    pub fn dialect_of(&self, who: Recipient) -> Dialect {
        let id = who.session().unwrap_or(SessionId(0));
        self.get(id).map_or(Dialect::Smoothie, |session| session.dialect)
    }

    /// Returns the rights of a recipient that asks for something. The machine itself has all.
    #[must_use]
    pub fn rights_of(&self, who: Recipient) -> Rights {
        who.session().and_then(|id| self.get(id)).map_or(Rights::Own, |session| session.rights)
    }

    /// Whether the recipient is a session whose refusals are numbers, as in GRBL's dialect.
    #[must_use]
    pub fn numbers_refusals(&self, who: Recipient) -> bool {
        who.session().and_then(|id| self.get(id)).is_some_and(Session::numbers_refusals)
    }

    /// Returns whether any session may want to be looked at.
    pub fn want_service(&mut self, consoles: &impl Consoles) -> bool {
        self.is_stirred |= consoles.have_news();
        self.is_stirred
    }

    /// Has all sessions looked at in the next turn, whatever is known of them.
    pub const fn stir(&mut self) {
        self.is_stirred = true;
    }

    /// Returns the session that is next to have its line carried out. With `path_is_full` sessions whose line
    /// waits for room in the look-ahead queue are passed over.
    pub fn next_ready(&mut self, path_is_full: bool) -> Option<SessionId> {
        // Mostly nobody has a line, and each line of a file comes through here twice.
        if !self.is_stirred || !self.sessions.iter().take(self.count).any(Session::has_line) {
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

    /// Sends a text to the recipient.
    pub fn say(&mut self, to: Recipient, text: fmt::Arguments<'_>) {
        if to == Recipient::Nobody {
            return;
        }
        let count = self.count;
        self.is_stirred = true;
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

    /// Tells hosts about the job in their own words; the session that asked knows already.
    pub fn tell_hosts(&mut self, news: &str, asked: Recipient) {
        for id in self.ids().map(Recipient::Session).filter(|id| *id != asked) {
            if self.dialect_of(id) != Dialect::Grbl {
                self.say(id, format_args!("// action:{news}\n"));
            }
        }
    }

    /// Refuses a line of the recipient. Without a single session, everybody hears the refusal.
    pub fn refuse(&mut self, to: Recipient, error: Reason, why: fmt::Arguments<'_>) {
        match to.session().and_then(|id| self.get_mut(id)) {
            Some(session) => session.refuse(error, why),
            None => self.say(Recipient::All, format_args!("error:{why}\n")),
        }
    }

    /// Tells senders of GRBL's dialect the number of the alarm with which the machine has halted.
    pub fn alarm(&mut self, alarm: Alarm) {
        self.is_stirred = true;
        for session in self.sessions.iter_mut().take(self.count).filter(|session| session.dialect == Dialect::Grbl) {
            session.announce(format_args!("ALARM:{}\n", alarm.number()));
        }
    }

    /// Returns whether a line of any session is being carried out.
    #[must_use]
    pub fn are_busy(&self) -> bool {
        self.sessions.iter().take(self.count).any(Session::is_busy)
    }

    /// Takes the request to end the recipient's command (Ctrl-Y).
    pub fn take_stop(&mut self, who: Recipient) -> bool {
        if who == Recipient::Nobody {
            return self.button_stop.as_mut().is_some_and(core::mem::take);
        }
        let session = who.session().and_then(|id| self.get_mut(id));
        session.is_some_and(|session| core::mem::take(&mut session.stop_requested))
    }

    /// Returns whether the sender of the line that is carried out has gone since then; a button never has.
    #[must_use]
    pub fn has_left(&self, who: Recipient) -> bool {
        who.session().and_then(|id| self.get(id)).is_some_and(Session::asker_has_left)
    }

    /// Returns whether the recipients have taken most of their output; a session that takes nothing for long
    /// is not waited for.
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

    /// Hands output to the transports, as much as they take. Output that nobody takes for
    /// [`LISTENER_TIMEOUT`] is dropped, but on a transport that knows that a peer is there.
    pub fn flush(&mut self, consoles: &mut impl Consoles, now: Micros) {
        if !self.is_stirred {
            return;
        }
        let were_silent = core::mem::replace(&mut self.were_silent, true);
        for (index, session) in self.sessions.iter_mut().take(self.count).enumerate() {
            let id = SessionId(index as u8);
            if were_silent {
                session.takes_from(now);
            }
            self.were_silent &= session.is_silent(consoles.inbox(id));
            if session.has_nothing_to_say(now) {
                continue;
            }
            if session.visits() != consoles.inbox(id).visits() {
                session.drop_output();
            }
            session.flush(now, LISTENER_TIMEOUT, |bytes| consoles.write(id, bytes));
        }
        self.is_stirred = !self.were_silent;
    }

    /// Returns whether a peer of this session has come, or gone, since it was last greeted.
    #[must_use]
    pub fn is_visited_anew(&self, consoles: &impl Consoles, id: SessionId) -> bool {
        self.get(id).is_some_and(|session| session.visits() != consoles.inbox(id).visits())
    }

    /// Follows peers that come and go; the unfinished listing of a peer that has left is given back to be
    /// ended, also when it was begun after that. A new peer finds nothing of the former: neither answers nor
    /// half a line; whole lines of the former peer are carried out first.
    pub fn follow_visitor(&mut self, consoles: &impl Consoles, id: SessionId) -> (Visitor, Option<Listing>) {
        let (inbox, notice) = (consoles.inbox(id), self.notice);
        let visits = inbox.visits();
        let Some(session) = self.get_mut(id) else { return (Visitor::Waits, None) };
        if session.has_somebody() || !inbox.is_open() {
            // A peer that has come since then is met at the next look.
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
            // The rest of the file is no lines to be carried out, and its end is not known.
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

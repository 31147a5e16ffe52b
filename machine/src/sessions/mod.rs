//! Sessions: everybody who talks to the machine. Each has its line being gathered, its output, its line
//! numbers, its dialect and its rights; a reply goes to the session that asked.
//!
//! A session has at most one whole line waiting; while it waits no further bytes are taken, so a sender that
//! does not wait for `ok` is held back by its transport. The same holds while its output has not been taken:
//! it gets no turn, and nobody else waits for it.

mod inbox;
mod listing;
mod reply;
mod session;

use core::fmt;

use program::Dialect;
use units::Micros;

use crate::grbl::numbers::{Alarm, Error};
use crate::ports::{Consoles, SessionProfile};
pub use inbox::{INBOX_BYTES, Inbox, Intake, Received};
pub use listing::{Enumeration, Listing};
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
    pub const fn new() -> Self {
        Self { sessions: [const { Session::new() }; MAX_SESSIONS], count: 0, turn: 0, button_stop: None, notice: "" }
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

    /// Whether those who are meant have taken most of what was said to them; who takes nothing for long is
    /// not waited for.
    #[must_use]
    pub fn have_taken_most(&self, who: Recipient) -> bool {
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

    /// Follows who comes and goes; what one who has left has left unfinished is given back to be ended.
    /// Whoever comes finds nothing of the one before: neither his answers nor half a line of his; what that
    /// one had sent whole is carried out first.
    pub fn follow_visitor(&mut self, consoles: &impl Consoles, id: SessionId) -> (Visitor, Option<Listing>) {
        let (inbox, notice) = (consoles.inbox(id), self.notice);
        let visits = inbox.visits();
        let Some(session) = self.get_mut(id) else { return (Visitor::Waits, None) };
        if session.visits().is_multiple_of(2) || !inbox.is_open() {
            // Whoever has come since then is met at the next look.
            session.leave(if inbox.is_open() { visits.wrapping_sub(1) } else { visits });
            return (Visitor::Left, session.listing.take());
        }
        if session.has_from_before(inbox) {
            return (Visitor::Waits, None);
        }
        let profile: SessionProfile = consoles.profile(id);
        let dialect = session.dialect;
        session.begin(&profile, visits);
        session.dialect = profile.dialect.unwrap_or(dialect);
        session.greet(profile.greeting);
        session.announce(format_args!("{notice}"));
        (Visitor::Came, None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ports::ConsoleKind;
    use std::collections::VecDeque;
    use std::vec::Vec;

    /// Two lines whose other ends are in memory.
    struct Desk {
        inboxes: [Inbox; 2],
        intakes: [Intake; 2],
        /// What each has been output, and how much more it takes.
        output: [(VecDeque<u8>, usize); 2],
        kinds: [ConsoleKind; 2],
    }

    impl Desk {
        fn new() -> Self {
            let visited = Inbox::new();
            visited.set_open(false);
            Self {
                inboxes: [Inbox::new(), visited],
                intakes: [Intake::new(); 2],
                output: [(VecDeque::new(), usize::MAX), (VecDeque::new(), usize::MAX)],
                kinds: [ConsoleKind::Serial, ConsoleKind::Network],
            }
        }

        fn type_on(&mut self, id: usize, text: &str) {
            text.bytes().for_each(|byte| assert!(self.inboxes[id].receive(&mut self.intakes[id], byte)));
        }

        fn read(&mut self, id: usize) -> String {
            String::from_utf8(self.output[id].0.drain(..).collect()).unwrap()
        }
    }

    impl Consoles for Desk {
        fn sessions(&self) -> u8 {
            2
        }

        fn inbox(&self, id: SessionId) -> &Inbox {
            &self.inboxes[usize::from(id.0)]
        }

        fn profile(&self, id: SessionId) -> SessionProfile {
            let kind = self.kinds[usize::from(id.0)];
            SessionProfile { kind, rights: Rights::Operate, dialect: None, greeting: "hello\n" }
        }

        fn write(&mut self, id: SessionId, bytes: &[u8]) -> usize {
            let (output, room) = &mut self.output[usize::from(id.0)];
            let taken = bytes.len().min(*room);
            *room -= taken;
            output.extend(&bytes[..taken]);
            taken
        }
    }

    fn sessions(desk: &Desk) -> Sessions {
        let mut sessions = Sessions::new();
        sessions.configure(desk);
        sessions
    }

    fn gather(sessions: &mut Sessions, desk: &Desk) {
        for id in sessions.ids() {
            sessions.get_mut(id).unwrap().gather(desk.inbox(id));
        }
    }

    fn greet(sessions: &mut Sessions, desk: &Desk) {
        assert!(sessions.is_visited_anew(desk, SessionId(1)));
        let (visitor, unfinished) = sessions.follow_visitor(desk, SessionId(1));
        assert!(visitor != Visitor::Waits && unfinished.is_none());
        assert!(!sessions.is_visited_anew(desk, SessionId(1)));
    }

    fn take(sessions: &mut Sessions) -> Option<(u8, Vec<u8>)> {
        let id = sessions.next_ready(false)?;
        let session = sessions.get_mut(id)?;
        let line = session.take_line()?;
        session.answered();
        Some((id.0, line.to_vec()))
    }

    #[test]
    fn a_waiting_line_holds_back_the_bytes_behind_it() {
        let mut desk = Desk::new();
        let mut sessions = sessions(&desk);
        desk.type_on(1, "G28\nM105\n");
        gather(&mut sessions, &desk);
        gather(&mut sessions, &desk);
        assert_eq!(take(&mut sessions), Some((1, b"G28".to_vec())));
        assert_eq!(take(&mut sessions), None);
        gather(&mut sessions, &desk);
        assert_eq!(take(&mut sessions), Some((1, b"M105".to_vec())));
    }

    #[test]
    fn sessions_take_turns() {
        let mut desk = Desk::new();
        let mut sessions = sessions(&desk);
        let mut order = Vec::new();
        desk.type_on(0, "a\nb\n");
        desk.type_on(1, "a\nb\n");
        for _ in 0..4 {
            gather(&mut sessions, &desk);
            order.push(take(&mut sessions).unwrap().0);
        }
        assert_eq!(order, [0, 1, 0, 1]);
    }

    #[test]
    fn what_is_said_goes_to_those_who_are_meant() {
        let mut desk = Desk::new();
        let mut sessions = sessions(&desk);
        sessions.say(Recipient::Session(SessionId(1)), format_args!("ok {}\n", 7));
        sessions.say(Recipient::All, format_args!("x"));
        sessions.say(Recipient::Nobody, format_args!("y"));
        sessions.flush(&mut desk, Micros(0));
        assert_eq!((desk.read(0), desk.read(1)), ("x".into(), "ok 7\nx".into()));
    }

    #[test]
    fn a_session_that_is_not_read_gets_no_turn_until_it_is_or_nobody_listens() {
        let mut desk = Desk::new();
        let mut sessions = sessions(&desk);
        desk.output[0].1 = 0;
        for _ in 0..100 {
            sessions.say(Recipient::Session(SessionId(0)), format_args!("a long answer\n"));
        }
        desk.type_on(0, "a\n");
        desk.type_on(1, "b\n");
        gather(&mut sessions, &desk);
        sessions.flush(&mut desk, Micros::from_millis(1));
        assert_eq!(take(&mut sessions), Some((1, b"b".to_vec())));
        assert_eq!(take(&mut sessions), None, "its output is full");
        sessions.flush(&mut desk, Micros::from_seconds(3));
        assert_eq!(take(&mut sessions), Some((0, b"a".to_vec())), "nobody listens");
    }

    #[test]
    fn whoever_comes_is_greeted_and_finds_nothing_of_the_one_before() {
        let mut desk = Desk::new();
        let mut sessions = sessions(&desk);
        desk.inboxes[1].set_open(true);
        greet(&mut sessions, &desk);
        desk.type_on(1, "half a li");
        gather(&mut sessions, &desk);
        sessions.flush(&mut desk, Micros(0));
        assert_eq!(desk.read(1), "hello\n");
        desk.inboxes[1].set_open(false);
        greet(&mut sessions, &desk);
        desk.inboxes[1].set_open(true);
        greet(&mut sessions, &desk);
        desk.type_on(1, "whole\n");
        gather(&mut sessions, &desk);
        assert_eq!(take(&mut sessions), Some((1, b"whole".to_vec())));
    }

    #[test]
    fn what_was_sent_whole_is_carried_out_before_whoever_comes_next() {
        let mut desk = Desk::new();
        let Desk { inboxes, intakes, .. } = &mut desk;
        inboxes[1].open(&mut intakes[1]);
        let mut sessions = sessions(&desk);
        desk.type_on(1, "G28\nG1 X5\nG1 Y");
        gather(&mut sessions, &desk);
        desk.inboxes[1].set_open(false);
        assert_eq!(sessions.follow_visitor(&desk, SessionId(1)).0, Visitor::Left);
        sessions.say(Recipient::Session(SessionId(1)), format_args!("ok\n"));
        let Desk { inboxes, intakes, .. } = &mut desk;
        inboxes[1].open(&mut intakes[1]);
        desk.type_on(1, "M105\n");
        let mut done = Vec::new();
        for _ in 0..4 {
            if sessions.is_visited_anew(&desk, SessionId(1)) {
                sessions.follow_visitor(&desk, SessionId(1));
            }
            gather(&mut sessions, &desk);
            if let Some((_, line)) = take(&mut sessions) {
                done.push(String::from_utf8(line).unwrap());
                sessions.say(Recipient::Session(SessionId(1)), format_args!("ok {}\n", done.len()));
            }
            sessions.flush(&mut desk, Micros(0));
        }
        assert_eq!(done, ["G28", "G1 X5", "M105"], "half a line is none");
        assert_eq!(desk.read(1), "hello\nok 3\n", "answers go to who has asked");
    }

    #[test]
    fn what_is_said_over_usb_waits_as_long_as_somebody_is_there() {
        let mut desk = Desk::new();
        desk.kinds[1] = ConsoleKind::Usb;
        let Desk { inboxes, intakes, .. } = &mut desk;
        inboxes[1].open(&mut intakes[1]);
        let mut sessions = sessions(&desk);
        desk.output[1].1 = 0;
        (0..60).for_each(|_| sessions.say(Recipient::Session(SessionId(1)), format_args!("a long answer\n")));
        sessions.flush(&mut desk, Micros(0));
        assert!(!sessions.have_taken_most(Recipient::All));
        sessions.flush(&mut desk, Micros::from_seconds(100));
        assert!(sessions.have_taken_most(Recipient::All), "the machine does not wait for it");
        desk.type_on(1, "M105\n");
        gather(&mut sessions, &desk);
        assert_eq!(take(&mut sessions), None, "it does for the machine");
        desk.output[1].1 = usize::MAX;
        sessions.flush(&mut desk, Micros::from_seconds(101));
        assert_eq!(desk.read(1).len(), 60 * 14, "and nothing is lost");
    }

    #[test]
    fn whoever_left_and_came_between_two_looks_has_left_first() {
        let mut desk = Desk::new();
        let Desk { inboxes, intakes, .. } = &mut desk;
        inboxes[1].open(&mut intakes[1]);
        let mut sessions = sessions(&desk);
        sessions.notice = "mind the step\n";
        desk.inboxes[1].set_open(false);
        let Desk { inboxes, intakes, .. } = &mut desk;
        inboxes[1].open(&mut intakes[1]);
        assert_eq!(sessions.follow_visitor(&desk, SessionId(1)).0, Visitor::Left);
        assert!(sessions.take_stop(Recipient::Session(SessionId(1))), "what he moved by hand stops");
        assert_eq!(sessions.follow_visitor(&desk, SessionId(1)).0, Visitor::Came);
        sessions.flush(&mut desk, Micros(0));
        assert_eq!(desk.read(1), "hello\nmind the step\n");
    }
}

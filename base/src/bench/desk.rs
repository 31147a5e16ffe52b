//! Two sessions, of which the first one asks.

use units::Micros;

use crate::sessions::{Consoles, INBOX_BYTES, Inbox, InboxOf, Recipient, Reply, SessionId, SessionProfile, Sessions};

/// Other ends of the two sessions' lines.
#[derive(Debug, Default)]
pub struct Line {
    inboxes: [InboxOf<INBOX_BYTES>; 2],
    output: [Vec<u8>; 2],
}

impl Line {
    /// Takes the text sent to a session since the last call.
    pub fn heard(&mut self, session: usize) -> String {
        String::from_utf8(std::mem::take(&mut self.output[session])).expect("text")
    }
}

impl Consoles for Line {
    fn sessions(&self) -> u8 {
        2
    }

    fn inbox(&self, session: SessionId) -> &Inbox {
        &self.inboxes[usize::from(session.0)]
    }

    fn profile(&self, _: SessionId) -> SessionProfile {
        SessionProfile::SERIAL
    }

    fn write(&mut self, session: SessionId, bytes: &[u8]) -> usize {
        self.output[usize::from(session.0)].extend(bytes);
        bytes.len()
    }
}

/// Two sessions, of which the first one asks.
#[derive(Debug)]
pub struct Desk {
    /// The sessions.
    pub sessions: Sessions,
    line: Line,
}

impl Default for Desk {
    fn default() -> Self {
        Self::new()
    }
}

impl Desk {
    /// Makes two sessions with nothing said.
    #[must_use]
    pub fn new() -> Self {
        let line = Line::default();
        let mut sessions = Sessions::new();
        sessions.configure(&line);
        Self { sessions, line }
    }

    /// Takes the text sent to the first session since the last call.
    pub fn heard(&mut self) -> String {
        self.sessions.flush(&mut self.line, Micros(0));
        self.line.heard(0)
    }

    /// Returns the text that `says` sends to the first session.
    pub fn hears(&mut self, says: impl FnOnce(&mut Reply<'_>)) -> String {
        says(&mut Reply::new(&mut self.sessions, Recipient::Session(SessionId(0))));
        self.heard()
    }
}

//! Simulated other ends of sessions: they connect, type and disconnect.

use machine::sessions::SessionId;

use crate::Bench;

impl Bench {
    /// Somebody comes to the other end of a session in memory, or goes.
    pub fn set_open(&mut self, session: SessionId, open: bool) {
        self.runner.set_open(session, open);
    }

    /// Reconnects a session in memory that has gone; its sender continues with the unsent rest.
    pub fn come_back(&mut self, session: SessionId) {
        self.runner.come_back(session);
    }

    /// From now on a session takes at most so many bytes that nobody has read.
    pub fn set_room(&mut self, session: SessionId, bytes: usize) {
        self.runner.set_room(session, bytes);
    }

    /// Types on any session without waiting.
    ///
    /// # Panics
    /// When its inbox is full.
    pub fn type_on(&mut self, session: SessionId, text: &str) {
        assert!(self.runner.type_on(session, text), "the inbox is full");
    }

    /// As [`Self::type_on`], but what is not taken is lost. False when something was.
    pub fn try_type_on(&mut self, session: SessionId, text: &str) -> bool {
        self.runner.type_on(session, text)
    }
}

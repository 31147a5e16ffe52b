//! Simulated other ends of sessions: they connect, type and disconnect.

use base::sessions::SessionId;
use sim::runner::SimulatedNetwork;

use crate::Bench;

impl Bench {
    /// Opens or closes the other end of a session in memory.
    pub fn set_open(&mut self, session: SessionId, open: bool) {
        self.runner.set_open(session, open);
    }

    /// Runs `work` with the network that the machine is in.
    pub fn network<R>(&mut self, work: impl FnOnce(&mut SimulatedNetwork) -> R) -> R {
        self.runner.network(work)
    }

    /// Reconnects a session in memory that has gone; its sender continues with the unsent rest.
    pub fn come_back(&mut self, session: SessionId) {
        self.runner.come_back(session);
    }

    /// Limits the unread bytes that a session takes, from now on.
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

    /// As [`Self::type_on`], but text that is not taken is lost. Returns false when some was lost.
    pub fn try_type_on(&mut self, session: SessionId, text: &str) -> bool {
        self.runner.type_on(session, text)
    }
}

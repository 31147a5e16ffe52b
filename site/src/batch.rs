//! Calls that come in one message, as an array, and are answered by one (JSON-RPC 2.0 section 6): those of
//! one visitor at a time.

use heapless::Deque;

use crate::console::Asker;
use crate::reply::Reply;

/// Most calls of a message.
pub const CALLS: u8 = 8;
/// Time after which a message that is not whole makes room for another one, milliseconds.
const PATIENCE_MS: u64 = 2_000;
/// Answers to them, and one that says that there were more.
const REPLIES: usize = CALLS as usize + 1;

/// Visitor whose message it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Owner {
    /// Visitor of a WebSocket.
    Seat(Asker),
    /// Request of the connection at this place.
    Connection(u8),
}

/// Calls of one message, whose answers go out when all of them are there: what the machine says meanwhile
/// would else have to wait.
#[derive(Debug, Default)]
pub struct Batch {
    owner: Option<Owner>,
    /// Time at which it began, milliseconds.
    since_ms: u64,
    /// Answers that are there.
    replies: Deque<Reply, REPLIES>,
    /// Number of answers that come later.
    waits: u8,
    /// Whether the message is whole.
    is_whole: bool,
    /// Whether answers go out, and the sign before the next one.
    is_sending: bool,
    sign: Option<u8>,
}

impl Batch {
    /// Begins with a message. False while another one is not answered: one that does not come to its end
    /// makes room.
    pub fn begin(&mut self, owner: Owner, now_ms: u64) -> bool {
        if self.owner.is_some() && (self.is_whole || now_ms.saturating_sub(self.since_ms) < PATIENCE_MS) {
            return false;
        }
        self.clear();
        (self.owner, self.since_ms) = (Some(owner), now_ms);
        true
    }

    /// Forgets all, at its place: answers are a kilobyte of memory.
    fn clear(&mut self) {
        self.replies.clear();
        (self.owner, self.waits, self.is_whole, self.is_sending, self.sign) = (None, 0, false, false, None);
    }

    /// Returns whether the message is this visitor's.
    #[must_use]
    pub fn is_of(&self, owner: Owner) -> bool {
        self.owner == Some(owner)
    }

    /// Forgets the message of a visitor who goes.
    pub fn forget(&mut self, owner: Owner) {
        if self.is_of(owner) {
            self.clear();
        }
    }

    /// Takes an answer, or notes that it comes later.
    pub fn add(&mut self, reply: Option<Reply>) {
        match reply {
            // There are as many places as answers.
            Some(reply) => drop(self.replies.push_back(reply)),
            None => self.waits += 1,
        }
    }

    /// Takes an answer that comes later, unless its visitor has gone.
    pub fn answer(&mut self, owner: Owner, reply: Reply) {
        if self.is_of(owner) {
            self.waits = self.waits.saturating_sub(1);
            self.add(Some(reply));
        }
    }

    /// Notes that the message is whole.
    pub const fn end_message(&mut self) {
        self.is_whole = true;
    }

    /// Begins to send the answers of this visitor, who has heard the machine up to a place. Returns the first
    /// one, when all are there.
    pub fn begin_sending(&mut self, owner: Owner, heard: u32) -> Option<Reply> {
        let is_due = self.is_of(owner) && self.is_whole && self.waits == 0 && !self.is_sending;
        if !is_due || !self.replies.iter().all(|reply| reply.is_due(heard)) {
            return None;
        }
        let first = self.replies.pop_front();
        if first.is_none() {
            // Nobody wanted an answer.
            self.forget(owner);
            return None;
        }
        (self.is_sending, self.sign) = (true, Some(b'['));
        first
    }

    /// Returns whether the answers of this visitor go out.
    #[must_use]
    pub fn is_sent_to(&self, owner: Owner) -> bool {
        self.is_sending && self.is_of(owner)
    }

    /// Takes the sign that stands before the answer that goes out, if it is not out.
    pub const fn take_sign(&mut self) -> Option<u8> {
        self.sign.take()
    }

    /// Returns the next answer, behind one that is out. None: that was the last one.
    pub fn next(&mut self) -> Option<Reply> {
        let next = self.replies.pop_front();
        if next.is_some() {
            self.sign = Some(b',');
        } else {
            self.clear();
        }
        next
    }
}

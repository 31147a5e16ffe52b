//! A WebSocket's visitor: calls that come in, answers and notifications that go out.

use base::snapshot::Snapshot;
use heapless::Deque;

use crate::calls::Reader;
use crate::console::Console;
use crate::objects::{self, MAX_OBJECTS, Objects};
use crate::reply::{Content, Reply};

/// Answers that wait to be sent. While there is no place for another, nothing more is read.
const REPLIES: usize = 4;

/// States of the machine after which the visitor is told that it is there, if nothing else was told: a
/// second.
const SILENCE: u32 = 4;

/// State of a visitor.
#[derive(Debug)]
pub struct Client {
    /// Place of the visitor.
    place: u8,
    /// Message that is being read, if one has begun.
    pub reader: Option<Reader>,
    replies: Deque<Reply, REPLIES>,
    /// Reply that is being sent.
    pub sending: Option<Reply>,
    /// Objects that are told of when they change.
    subscribed: Objects,
    /// Hash of each object as it was told last.
    told: [u32; MAX_OBJECTS],
    /// Number of the state that was looked at last.
    looked: u32,
    /// Number of the state with which something was told last.
    spoken: u32,
    /// Place up to which the machine's words were passed on.
    pub heard: u32,
    /// State of the machine that was told last.
    pub klippy_state: &'static str,
    /// Number of the change of files that was told last.
    pub told_change: u32,
}

impl Client {
    /// Makes the state of a visitor who has come, and hears what is said from now on.
    #[must_use]
    pub const fn new(place: u8, heard: u32, klippy_state: &'static str, told_change: u32) -> Self {
        Self {
            place,
            reader: None,
            replies: Deque::new(),
            sending: None,
            subscribed: 0,
            told: [0; MAX_OBJECTS],
            looked: 0,
            spoken: 0,
            heard,
            klippy_state,
            told_change,
        }
    }

    /// Returns whether another call can be answered.
    #[must_use]
    pub fn has_room(&self) -> bool {
        !self.replies.is_full()
    }

    /// Returns whether answers wait, or one is being sent.
    #[must_use]
    pub fn has_answers(&self) -> bool {
        !self.replies.is_empty() || self.sending.is_some()
    }

    /// Queues an answer behind those that wait.
    pub fn reply(&mut self, reply: Reply) {
        // Room was looked at, or the visitor misses an outcome while taking none of four answers.
        let _ = self.replies.push_back(reply);
    }

    /// Takes the next answer. One to a script comes behind what the machine said to it.
    fn next_reply(&mut self) -> Option<Reply> {
        let heard = self.heard;
        self.replies.front().is_some_and(|reply| reply.is_due(heard)).then(|| self.replies.pop_front()).flatten()
    }

    /// Returns the next line of the machine's that this visitor hears.
    fn next_line(&mut self, console: &Console) -> Option<Reply> {
        while let Some(said) = console.line(self.heard) {
            let at = core::mem::replace(&mut self.heard, said.next);
            if said.is_for(self.place) {
                return Some(Reply::message(None, Content::Said(at)));
            }
        }
        None
    }

    /// Has the visitor told of objects when they change, beginning with these states.
    pub fn subscribe(&mut self, objects: Objects, hashes: &[u32; MAX_OBJECTS]) {
        self.subscribed = objects;
        self.told = *hashes;
    }

    /// Returns the notification of what has changed, if anything has that the visitor is told of. `number` is
    /// that of the state.
    fn changes(&mut self, hashes: &[u32; MAX_OBJECTS], number: u32) -> Option<Reply> {
        if core::mem::replace(&mut self.looked, number) == number || self.subscribed == 0 {
            return None;
        }
        let pairs = self.told.iter().zip(hashes).enumerate();
        let changed = pairs.filter(|(_, (told, now))| told != now).fold(0, |set, (place, _)| set | 1 << place);
        let changed = changed & self.subscribed;
        self.told = *hashes;
        (changed != 0).then(|| Reply::message(None, Content::Changed(changed)))
    }

    /// Returns the next message to the visitor: answers first, then what the machine says and how it is, for
    /// who may see that.
    pub fn next_message(
        &mut self,
        may_watch: bool,
        console: &Console,
        snapshot: &Snapshot,
        hashes: &[u32; MAX_OBJECTS],
        number: u32,
        change: u32,
    ) -> Option<Reply> {
        if let Some(reply) = self.next_reply() {
            return Some(reply);
        }
        if !may_watch {
            (self.heard, self.looked) = (console.end(), number);
            return self.beat(number);
        }
        let state = objects::klippy_state(snapshot.state);
        if core::mem::replace(&mut self.klippy_state, state) != state {
            let method = if state == "ready" { "notify_klippy_ready" } else { "notify_klippy_shutdown" };
            return Some(Reply::message(None, Content::Notice(method)));
        }
        if let Some(reply) = self.next_line(console).or_else(|| self.next_reply()) {
            return Some(reply);
        }
        if core::mem::replace(&mut self.told_change, change) != change {
            return Some(Reply::message(None, Content::FilesChanged));
        }
        let reply = self.changes(hashes, number);
        if reply.is_some() {
            self.spoken = number;
        }
        reply.or_else(|| self.beat(number))
    }

    /// Returns the notification that the board is there, when nothing else was told for a second: a page
    /// takes a machine for lost that is silent for some seconds.
    fn beat(&mut self, number: u32) -> Option<Reply> {
        let is_silent = number.wrapping_sub(self.spoken) >= SILENCE;
        is_silent.then(|| {
            self.spoken = number;
            Reply::message(None, Content::Beat)
        })
    }
}

//! Server of web connections that says back what it hears.

use std::collections::{BTreeMap, VecDeque};
use std::net::Ipv4Addr;

use crate::{Streams, Verdict, Wish, Word};

/// State of a connection.
#[derive(Debug, Default)]
struct Echo {
    /// Bytes that are still to be said back.
    queue: VecDeque<u8>,
    has_ended: bool,
    dies: bool,
}

/// The server. The word `die` ends a connection at once, and `bye` closes the server's side of it.
#[derive(Debug, Default)]
pub struct TestStreams {
    connections: BTreeMap<usize, Echo>,
    /// Connections that have come and gone, and who has come.
    pub opened: usize,
    pub closed: usize,
    pub from: Vec<Ipv4Addr>,
    /// Words that wait for their verdict, and the verdicts.
    pub words: VecDeque<Word>,
    pub verdicts: Vec<Verdict>,
}

/// Most bytes that wait to be said back.
const MOST: usize = 3_000;

impl TestStreams {
    fn of(&mut self, place: usize) -> &mut Echo {
        self.connections.get_mut(&place).expect("a connection that is open")
    }
}

impl Streams for TestStreams {
    fn take_word(&mut self) -> Option<Word> {
        self.words.pop_front()
    }

    fn hear_verdict(&mut self, verdict: Verdict) {
        self.verdicts.push(verdict);
    }

    fn open(&mut self, place: usize, from: Ipv4Addr, _now: u64) {
        assert!(self.connections.insert(place, Echo::default()).is_none(), "place {place} is taken");
        self.opened += 1;
        self.from.push(from);
    }

    fn receive(&mut self, place: usize, bytes: &mut [u8], _now: u64) -> usize {
        let echo = self.of(place);
        let count = bytes.len().min(MOST - echo.queue.len());
        echo.queue.extend(bytes[..count].iter());
        echo.dies |= bytes == b"die\n";
        echo.has_ended |= bytes == b"bye\n";
        count
    }

    fn hear_end(&mut self, place: usize) {
        self.of(place).has_ended = true;
    }

    fn transmit(&mut self, place: usize, room: &mut [u8], _now: u64) -> usize {
        let echo = self.of(place);
        let count = room.len().min(echo.queue.len());
        room.iter_mut().zip(echo.queue.drain(..count)).for_each(|(place, byte)| *place = byte);
        count
    }

    fn wish(&mut self, place: usize, _now: u64) -> Wish {
        let echo = self.of(place);
        if echo.dies {
            Wish::Abort
        } else if echo.has_ended && echo.queue.is_empty() {
            Wish::Finish
        } else {
            Wish::Open
        }
    }

    fn close(&mut self, place: usize) {
        self.connections.remove(&place).expect("a connection that is open");
        self.closed += 1;
    }
}

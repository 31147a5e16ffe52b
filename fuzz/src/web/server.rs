//! A server with one connection, over bytes in pieces.

use http::limits::{HEAD_BYTES, MESSAGE_BYTES};
use http::{Body, Connection, Event, Extent, Fields, Kind, Life, Made, Response, Status};

/// Events that came, with bytes of their own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Heard {
    Request(String),
    Body(Vec<u8>),
    End,
    Refused(u16),
    Message(Kind, Vec<u8>, bool),
    Closed(u16),
}

/// Answer that echoes, in small pieces.
struct Echo(Vec<u8>);

impl Body for Echo {
    fn fields(&self, fields: &mut Fields<'_, '_>) {
        fields.location("/a", "b");
    }

    fn make(&mut self, room: &mut [u8]) -> Made {
        let count = room.len().min(self.0.len());
        room[..count].copy_from_slice(&self.0[..count]);
        self.0.drain(..count);
        if self.0.is_empty() { Made::Last(count) } else { Made::Part(count) }
    }
}

/// Server and what it has heard.
pub struct Server {
    connection: Connection,
    now: u64,
    pub heard: Vec<Heard>,
    pub sent: Vec<u8>,
    waiting: Vec<u8>,
    room: usize,
    body: Echo,
    is_open: bool,
    extent: Extent,
}

impl Server {
    /// Serves bytes in these pieces, with so much room at a time.
    pub fn serve(pieces: &[&[u8]], room: usize) -> Self {
        let mut server = Self {
            connection: Connection::new(HEAD_BYTES, 0),
            now: 0,
            heard: Vec::new(),
            sent: Vec::new(),
            waiting: Vec::new(),
            room,
            body: Echo(Vec::new()),
            is_open: true,
            extent: Extent::Open,
        };
        for piece in pieces {
            server.waiting.extend_from_slice(piece);
            server.turn();
        }
        server
    }

    /// Lets the time go on, in which the peer does nothing: the connection has to end.
    pub fn end(&mut self) {
        for _ in 0..1_000 {
            if !self.is_open {
                return;
            }
            self.now += 250;
            self.turn();
        }
        panic!("the connection stays for ever");
    }

    fn turn(&mut self) {
        for _ in 0..10_000 {
            match self.connection.poll(self.now) {
                Life::Open => {}
                Life::Finish => assert!(!self.connection.is_sending(), "the end before the end"),
                Life::Abort => self.is_open = false,
            }
            let took = self.take();
            let mut room = vec![0; self.room];
            let count = self.connection.transmit(&mut room, &mut self.body, self.now);
            self.sent.extend_from_slice(&room[..count]);
            if !took && count == 0 {
                return;
            }
        }
        panic!("no end of a turn");
    }

    fn take(&mut self) -> bool {
        let mut bytes = self.waiting.clone();
        let (used, event) = self.connection.receive(&mut bytes, self.now);
        let mut is_whole = false;
        let mut did = true;
        match event {
            Event::Nothing => did = used > 0,
            Event::Request(request) => {
                let path = request.path;
                assert!(path == "*" || path.starts_with('/') && !path.contains(['\\', '\0']), "{path:?}");
                assert!(!path.split('/').any(|segment| matches!(segment, "." | "..")), "{path:?}");
                let cookie = request.header("Cookie").unwrap_or_default();
                assert!(!cookie.contains(['\r', '\n']), "{cookie:?}");
                self.heard.push(Heard::Request(format!("{:?} {path:?} {:?} {cookie}", request.head, request.query)));
                let _selected = http::Selection::of(&request, None, 100);
                self.extent = if path.len() > 9 { Extent::Known(path.len() as u64) } else { Extent::Open };
                self.body = Echo(path.as_bytes().to_vec());
                if path == "/ws" {
                    self.connection.upgrade(&request);
                }
            }
            Event::Body(piece) => match self.heard.last_mut() {
                Some(Heard::Body(body)) => body.extend_from_slice(piece),
                _ => self.heard.push(Heard::Body(piece.to_vec())),
            },
            Event::End => {
                self.heard.push(Heard::End);
                is_whole = true;
            }
            Event::Refused(status) => self.heard.push(Heard::Refused(status.code())),
            Event::Message { kind, is_first, is_last, bytes } => {
                if is_first {
                    self.heard.push(Heard::Message(kind, Vec::new(), false));
                }
                let Some(Heard::Message(of, message, end @ false)) = self.heard.last_mut() else {
                    panic!("no message")
                };
                message.extend_from_slice(bytes);
                *end = is_last;
                assert!(*of == kind && message.len() <= MESSAGE_BYTES as usize);
                assert!(!is_last || kind == Kind::Binary || std::str::from_utf8(message).is_ok(), "text that is none");
                if is_last && self.connection.send(kind) {
                    self.body = Echo(message.clone());
                }
            }
            Event::Closed(code) => {
                // What is heard of a broken message depends on how much of it came at once.
                let _half = self.heard.pop_if(|heard| matches!(heard, Heard::Message(_, _, false)));
                self.heard.push(Heard::Closed(code));
            }
        }
        assert_eq!(bytes[used..], self.waiting[used..], "bytes that were not taken are changed");
        self.waiting.drain(..used);
        if is_whole {
            self.connection.respond(Response::of(Status::Ok, "text/plain", self.extent));
        }
        did
    }
}

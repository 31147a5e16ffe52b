//! A server for tests: bytes in pieces of any size, room in pieces of any size.

use crate::{Body, Cache, Connection, EntityTag, Event, Extent, Kind, Life, Made, Method, Methods, Response, Status};

/// Events that came, with bytes of their own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Heard {
    /// Method, path, query, and whether there is a body.
    Request(Method, String, String),
    Body(Vec<u8>),
    End,
    Refused(u16),
    /// Message, and whether it is whole.
    Message(Kind, Vec<u8>, bool),
    Closed(u16),
}

/// Body made of pieces that are as long as the room lets them be, and of a pause before each.
pub struct Paused {
    pub bytes: Vec<u8>,
    pub at: usize,
    pub pauses: bool,
    pub fields: Vec<(&'static str, &'static str)>,
}

impl Paused {
    pub fn new(bytes: &[u8]) -> Self {
        Self { bytes: bytes.to_vec(), at: 0, pauses: false, fields: Vec::new() }
    }
}

impl Body for Paused {
    fn fields(&self, fields: &mut crate::Fields<'_, '_>) {
        self.fields.iter().for_each(|(name, value)| fields.line(name, value));
    }

    fn make(&mut self, room: &mut [u8]) -> Made {
        self.pauses = !self.pauses;
        if self.pauses {
            return Made::Part(0);
        }
        let count = room.len().min(self.bytes.len() - self.at);
        room[..count].copy_from_slice(&self.bytes[self.at..self.at + count]);
        self.at += count;
        if self.at == self.bytes.len() { Made::Last(count) } else { Made::Part(count) }
    }
}

/// Server with one connection. Paths say what is answered.
pub struct Desk {
    pub connection: Connection,
    pub now: u64,
    pub heard: Vec<Heard>,
    pub sent: Vec<u8>,
    waiting: Vec<u8>,
    body: Paused,
    path: String,
    /// Most bytes of a body that are allowed, where that is to be said.
    pub allow: Option<u64>,
    pub room: usize,
}

impl Desk {
    pub fn new() -> Self {
        Self {
            connection: Connection::new(4_096, 0),
            now: 0,
            heard: Vec::new(),
            sent: Vec::new(),
            waiting: Vec::new(),
            body: Paused::new(b""),
            path: String::new(),
            allow: None,
            room: 1_024,
        }
    }

    /// Sends the bytes in pieces of this size, and lets the server do what there is to do.
    pub fn feed(&mut self, bytes: &[u8], size: usize) {
        for piece in bytes.chunks(size.max(1)) {
            self.waiting.extend_from_slice(piece);
            self.turn();
        }
    }

    /// Lets the server do what there is to do.
    pub fn turn(&mut self) {
        loop {
            let took = self.take();
            let sent = self.send();
            if !took && !sent {
                return;
            }
        }
    }

    fn take(&mut self) -> bool {
        let mut bytes = self.waiting.clone();
        let (used, event) = self.connection.receive(&mut bytes, self.now);
        let mut whole = false;
        let mut did = true;
        match event {
            Event::Nothing => did = used > 0,
            Event::Request(request) => {
                self.path = request.path.to_owned();
                self.heard.push(Heard::Request(
                    request.head.method,
                    request.path.to_owned(),
                    request.query.as_str().to_owned(),
                ));
                if let Some(allow) = self.allow {
                    self.connection.allow_body(allow);
                }
                if request.path == "/ws" {
                    self.connection.upgrade(&request);
                }
                if request.path == "/early" {
                    self.connection.respond_error(Response::new(Status::Forbidden), "not you");
                }
            }
            Event::Body(piece) => match self.heard.last_mut() {
                Some(Heard::Body(body)) => body.extend_from_slice(piece),
                _ => self.heard.push(Heard::Body(piece.to_vec())),
            },
            Event::End => {
                self.heard.push(Heard::End);
                whole = true;
            }
            Event::Message { kind, is_first, is_last, bytes } => {
                if is_first {
                    self.heard.push(Heard::Message(kind, Vec::new(), false));
                }
                match self.heard.last_mut() {
                    Some(Heard::Message(of, message, whole @ false)) if *of == kind => {
                        message.extend_from_slice(bytes);
                        *whole = is_last;
                    }
                    other => panic!("a piece of no message: {other:?}"),
                }
                if let Some(Heard::Message(_, message, true)) = self.heard.last() {
                    let echo = Paused::new(message);
                    if self.connection.send(kind) {
                        self.body = echo;
                    }
                }
            }
            Event::Closed(code) => self.heard.push(Heard::Closed(code)),
            Event::Refused(status) => self.heard.push(Heard::Refused(status.code())),
        }
        assert_eq!(bytes[used..], self.waiting[used..], "bytes that were not taken are changed");
        self.waiting.drain(..used);
        if whole {
            self.answer();
        }
        did
    }

    fn answer(&mut self) {
        let long: Vec<u8> = (0..3_000_u32).map(|n| b'a' + (n % 26) as u8).collect();
        let known = |length: usize| Response::of(Status::Ok, "text/plain", Extent::Known(length as u64));
        let (response, bytes) = match self.path.as_str() {
            "/chunks" => (Response::json(Status::Ok), long),
            "/long" => (known(long.len()), long),
            "/short" => (known(5), b"four".to_vec()),
            "/empty" => (Response::json(Status::Ok), Vec::new()),
            "/gone" => (Response::new(Status::NoContent), Vec::new()),
            "/later" => return,
            "/method" => {
                let allow = Methods::NONE.with(Method::Get).with(Method::Post);
                let response = Response { allow, retry_s: 7, ..Response::new(Status::MethodNotAllowed) };
                self.connection.respond_error(response, "no");
                return;
            }
            "/tagged" => {
                let mut response = known(2);
                (response.tag, response.cache) = (Some(EntityTag(0xAB)), Cache::Always);
                (response.is_gzip, response.has_parts) = (true, true);
                (response, b"ok".to_vec())
            }
            _ => (known(5), b"hello".to_vec()),
        };
        self.body = Paused::new(&bytes);
        if self.path == "/tagged" {
            self.body.fields.push(("X-Mine", "a\r\nX-Yours: b"));
        }
        self.connection.respond(response);
    }

    fn send(&mut self) -> bool {
        let mut room = vec![0; self.room];
        let count = self.connection.transmit(&mut room, &mut self.body, self.now);
        self.sent.extend_from_slice(&room[..count]);
        // The maker pauses at each second call.
        count > 0
            || self.connection.is_sending() && self.connection.transmit(&mut [], &mut self.body, 0) == 0 && {
                let count = self.connection.transmit(&mut room, &mut self.body, self.now);
                self.sent.extend_from_slice(&room[..count]);
                count > 0
            }
    }

    /// Lets time pass, and says what becomes of the socket.
    pub fn pass(&mut self, ms: u64) -> Life {
        self.now += ms;
        let life = self.connection.poll(self.now);
        self.turn();
        match life {
            Life::Open => self.connection.poll(self.now),
            life => life,
        }
    }

    /// Returns what was sent, as text.
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.sent).into_owned()
    }

    /// Returns the status of the last answer that is no 100.
    pub fn status(&self) -> u16 {
        let text = self.text();
        let at = text.rfind("HTTP/1.1 ").expect("an answer");
        text[at + 9..at + 12].parse().expect("a status")
    }
}

/// Serves these bytes, in pieces of this size, with rooms of that size.
pub fn serve(bytes: &[u8], size: usize, room: usize) -> Desk {
    let mut desk = Desk::new();
    desk.room = room;
    desk.feed(bytes, size);
    desk
}

/// Joins the data of chunks.
pub fn joined(mut chunks: &[u8]) -> Vec<u8> {
    let mut body = Vec::new();
    loop {
        let end = chunks.windows(2).position(|pair| pair == b"\r\n").expect("a line");
        let size = usize::from_str_radix(std::str::from_utf8(&chunks[..end]).expect("digits"), 16).expect("a size");
        let data = &chunks[end + 2..];
        body.extend_from_slice(&data[..size]);
        assert_eq!(&data[size..size + 2], b"\r\n");
        chunks = &data[size + 2..];
        if size == 0 {
            assert!(chunks.is_empty(), "bytes behind the last chunk");
            return body;
        }
    }
}

/// Splits an answer into head and body.
pub fn split(answer: &[u8]) -> (String, Vec<u8>) {
    let end = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("a head") + 4;
    (String::from_utf8(answer[..end].to_vec()).expect("text"), answer[end..].to_vec())
}

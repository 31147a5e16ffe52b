//! Connection of one visitor, from the greeting to the end.

use core::net::Ipv4Addr;

use smoltcp::iface::SocketHandle;
use smoltcp::socket::tcp::{Socket, State};
use smoltcp::time::{Duration, Instant};

use super::ahead::Ahead;
use super::login::{Login, Turn};
use super::telnet::{Decoder, Encoder, Heard};
use crate::line::{Line, Role, Visitor};
use crate::news::{Inform, News};
use crate::password::Gate;
use crate::settings::Service;
use crate::wire::{Peer, remote};

/// Bytes that are handed to a line at once.
const CHUNK: usize = 128;
/// Time without output after which a visitor is seen off who has closed his side.
const LINGER: Duration = Duration::from_secs(1);
/// The same when another visitor may come, and there is no other place for him.
const LINGER_SCARCE: Duration = Duration::from_millis(100);
/// Time that the end of a connection may take.
const CLOSING: Duration = Duration::from_secs(5);

/// Stage of a connection.
#[derive(Clone, Debug)]
enum Stage {
    Empty,
    Login(Login),
    Open(Visitor),
    /// Nothing more is read or written but what is on its way.
    Closing,
}

/// What a seat works with.
pub struct Means<'a> {
    pub now: Instant,
    pub gate: &'a mut Gate,
    pub news: &'a mut Inform,
    pub scratch: &'a mut [u8],
    /// Services with no place for another visitor.
    pub scarce: [bool; Service::ALL.len()],
}

impl<'a> Means<'a> {
    /// Gathers what seats work with; whose places are scarce is found by the consoles.
    pub const fn new(now: Instant, gate: &'a mut Gate, news: &'a mut Inform, scratch: &'a mut [u8]) -> Self {
        Self { now, gate, news, scratch, scarce: [false; Service::ALL.len()] }
    }
}

/// Place for a visitor.
#[derive(Debug)]
pub struct Seat {
    handle: SocketHandle,
    line: usize,
    service: Service,
    stage: Stage,
    /// Time since which the stage, or a silence after the peer's end, lasts.
    since: Instant,
    decoder: Decoder,
    encoder: Encoder,
    ahead: Ahead,
    /// Whether a line feed belongs to the line before.
    skips_line_feed: bool,
}

impl Seat {
    /// Makes an empty seat for the visitors of a line.
    pub const fn new(handle: SocketHandle, line: usize, service: Service) -> Self {
        Self {
            handle,
            line,
            service,
            stage: Stage::Empty,
            since: Instant::ZERO,
            decoder: Decoder::new(),
            encoder: Encoder::new(),
            ahead: Ahead::new(),
            skips_line_feed: false,
        }
    }

    /// Returns the seat's socket.
    pub const fn handle(&self) -> SocketHandle {
        self.handle
    }

    /// Returns the service that the seat belongs to.
    pub const fn service(&self) -> Service {
        self.service
    }

    /// Returns whether a visitor sits here.
    pub const fn is_taken(&self) -> bool {
        !matches!(self.stage, Stage::Empty)
    }

    /// Returns who is connected to the line.
    pub const fn visitor(&self) -> Option<Visitor> {
        match self.stage {
            Stage::Open(visitor) => Some(visitor),
            Stage::Empty | Stage::Login(_) | Stage::Closing => None,
        }
    }

    /// Returns the connection as it is seen from the wire.
    pub fn peer(&self, socket: &Socket<'static>) -> Option<Peer> {
        let own = socket.local_endpoint()?.port;
        let port = socket.remote_endpoint()?.port;
        Some(Peer { address: remote(socket), port, own, owes: socket.send_queue() > 0 })
    }

    /// Ends the connection without a word.
    pub fn abort(&mut self, socket: &mut Socket<'static>, line: &mut impl Line, means: &mut Means<'_>) {
        socket.abort();
        self.leave(line, means);
    }

    /// Does what is due.
    pub fn run(&mut self, socket: &mut Socket<'static>, line: &mut impl Line, means: &mut Means<'_>) {
        match socket.state() {
            State::Closed | State::Listen | State::SynSent | State::SynReceived => self.leave(line, means),
            State::Established | State::CloseWait => self.serve(socket, line, means),
            State::FinWait1 | State::FinWait2 | State::Closing | State::LastAck | State::TimeWait => {
                self.end(socket, line, means);
            }
        }
    }

    fn serve(&mut self, socket: &mut Socket<'static>, line: &mut impl Line, means: &mut Means<'_>) {
        if !self.is_taken() {
            self.arrive(socket, line, means);
        }
        self.send_answers(socket);
        match &self.stage {
            Stage::Login(_) => self.log_in(socket, line, means),
            Stage::Open(_) => self.take_in(socket, line, means),
            Stage::Closing | Stage::Empty => {}
        }
        self.send_answers(socket);
        if socket.state() == State::CloseWait {
            let is_scarce = means.scarce.get(self.service as usize).is_some_and(|scarce| *scarce);
            let linger = if is_scarce { LINGER_SCARCE } else { LINGER };
            self.see_off(socket, linger, means.now);
        }
    }

    fn arrive(&mut self, socket: &mut Socket<'static>, line: &mut impl Line, means: &mut Means<'_>) {
        (self.decoder, self.encoder, self.ahead) = (Decoder::new(), Encoder::new(), Ahead::new());
        self.skips_line_feed = false;
        self.since = means.now;
        if means.gate.is_required() {
            self.stage = Stage::Login(Login::new(means.now));
        } else {
            self.open(remote(socket), Role::Operate, line, means);
        }
    }

    fn open(&mut self, from: Ipv4Addr, role: Role, line: &mut impl Line, means: &mut Means<'_>) {
        let visitor = Visitor { service: self.service, role, from };
        self.stage = Stage::Open(visitor);
        line.open(visitor);
        means.news.tell(News::Came(visitor));
    }

    /// The connection is over, or was none.
    fn leave(&mut self, line: &mut impl Line, means: &mut Means<'_>) {
        match core::mem::replace(&mut self.stage, Stage::Empty) {
            Stage::Open(visitor) => {
                line.close();
                means.news.tell(News::Left(visitor));
            }
            Stage::Login(_) => means.gate.forget(self.line),
            Stage::Empty | Stage::Closing => {}
        }
    }

    /// Ends the connection when all that was said has been sent.
    fn close(&mut self, socket: &mut Socket<'static>, now: Instant) {
        socket.close();
        self.stage = Stage::Closing;
        self.since = now;
    }

    /// Waits for the end of a connection that this end has closed.
    fn end(&mut self, socket: &mut Socket<'static>, line: &mut impl Line, means: &mut Means<'_>) {
        let is_late = means.now >= self.since + CLOSING;
        if socket.state() == State::TimeWait || is_late {
            socket.abort();
            self.leave(line, means);
        }
    }

    /// Sees a visitor off who has closed his side, when all that he sent is received and nothing is answered
    /// any more.
    fn see_off(&mut self, socket: &mut Socket<'static>, linger: Duration, now: Instant) {
        if socket.recv_queue() > 0 || socket.send_queue() > 0 {
            self.since = now;
        } else if now >= self.since + linger || !matches!(self.stage, Stage::Open(_)) {
            self.close_open(socket, now);
        }
    }

    /// Closes without forgetting who is there: the line is closed when the connection has ended.
    fn close_open(&mut self, socket: &mut Socket<'static>, now: Instant) {
        socket.close();
        self.since = now;
    }

    fn log_in(&mut self, socket: &mut Socket<'static>, line: &mut impl Line, means: &mut Means<'_>) {
        self.take_word(socket);
        let from = remote(socket);
        let is_known = self.decoder.is_telnet() || socket.recv_queue() > 0;
        let Stage::Login(login) = &mut self.stage else { return };
        if self.decoder.is_telnet() {
            self.encoder.hide();
        }
        let turn = login.run(self.line, from, means.gate, is_known, means.now);
        let wrong = News::WrongPassword { from };
        match turn {
            Turn::Nothing => {}
            Turn::Ask(words, was_wrong) => {
                if was_wrong {
                    means.news.tell(wrong);
                }
                self.send_answers(socket);
                say(socket, words);
            }
            Turn::Refuse(words, was_wrong) => {
                if was_wrong {
                    means.news.tell(wrong);
                }
                means.gate.forget(self.line);
                say(socket, words);
                self.close(socket, means.now);
            }
            Turn::LetIn => {
                if self.decoder.is_telnet() {
                    self.encoder.show();
                    say(socket, "\r\n");
                }
                self.open(from, Role::Own, line, means);
            }
        }
    }

    /// Takes what was typed, up to the end of the password's line.
    fn take_word(&mut self, socket: &mut Socket<'static>) {
        let Self { stage, decoder, encoder, skips_line_feed, .. } = self;
        let Stage::Login(login) = stage else { return };
        let _open = socket.recv(|bytes| {
            let mut used = 0;
            for byte in bytes.iter() {
                // What precedes any data is telnet's; data waits for the prompt.
                let mut ahead = *decoder;
                let heard = ahead.hear(*byte);
                let data = if let Heard::Byte(byte) = heard { Some(byte) } else { None };
                let is_wanted = data.is_none() || login.is_typing();
                if !is_wanted || !encoder.has_room() {
                    break;
                }
                *decoder = ahead;
                used += 1;
                let skips = core::mem::take(skips_line_feed) && data == Some(b'\n');
                match (heard, data) {
                    (_, Some(_)) if skips => {}
                    (_, Some(byte)) => {
                        *skips_line_feed = byte == b'\r';
                        login.hear(byte);
                    }
                    (Heard::Two(first, second), None) => [first, second].into_iter().for_each(|byte| login.hear(byte)),
                    (heard, None) => encoder.answer(heard),
                }
            }
            (used, ())
        });
    }

    /// Hands over what has come, as far as the line has room.
    fn take_in(&mut self, socket: &mut Socket<'static>, line: &mut impl Line, means: &mut Means<'_>) {
        loop {
            let mut chunk = Chunk { bytes: [0; CHUNK], count: 0, most: line.room().min(CHUNK) };
            let used = self.decode(socket, &mut chunk);
            if chunk.count > 0 {
                line.receive(chunk.bytes.get(..chunk.count).unwrap_or_default());
            }
            if used == 0 {
                break;
            }
        }
        if socket.recv_queue() > self.ahead.looked() && self.ahead.has_room() {
            self.look_ahead(socket, line, means.scratch);
        }
    }

    /// Takes bytes out of the TCP buffer that have room in the chunk. Returns how many.
    fn decode(&mut self, socket: &mut Socket<'static>, chunk: &mut Chunk) -> usize {
        let Self { decoder, encoder, ahead, skips_line_feed, .. } = self;
        let taken = socket.recv(|bytes| {
            let mut used = 0;
            for byte in bytes.iter() {
                // A byte may be two.
                if !encoder.has_room() || chunk.count + 2 > chunk.most {
                    break;
                }
                used += 1;
                let mut keep = |byte: u8| {
                    let skips = core::mem::take(skips_line_feed) && byte == b'\n';
                    if ahead.take() && !skips {
                        chunk.push(byte);
                    }
                };
                match decoder.hear(*byte) {
                    Heard::Byte(byte) => keep(byte),
                    Heard::Two(first, second) => {
                        keep(first);
                        keep(second);
                    }
                    heard => encoder.answer(heard),
                }
            }
            ahead.consumed(used);
            (used, used)
        });
        taken.unwrap_or(0)
    }

    /// Lets bytes act that have no room yet.
    fn look_ahead(&mut self, socket: &mut Socket<'static>, line: &mut impl Line, scratch: &mut [u8]) {
        let queued = socket.peek_slice(scratch).unwrap_or(0);
        let before = self.ahead.looked();
        let (mut decoder, mut index, mut count, mut looked) = (self.decoder, 0, 0, 0);
        for at in 0..queued {
            if at == before {
                looked = count;
            }
            let heard = decoder.hear(scratch.get(at).copied().unwrap_or_default());
            let (first, second) = match heard {
                Heard::Byte(byte) => (Some(byte), None),
                Heard::Two(first, second) => (Some(first), Some(second)),
                _ => (None, None),
            };
            for byte in [first, second].into_iter().flatten() {
                if !self.ahead.acted(index)
                    && let Some(place) = scratch.get_mut(count)
                {
                    *place = byte;
                    count += 1;
                }
                index += 1;
            }
        }
        // Where no more places can be remembered, the search goes on from here when one is free.
        while self.ahead.has_room() {
            let waiting = scratch.get(..count).unwrap_or_default();
            let place = line.look_ahead(waiting, looked).unwrap_or_default();
            let place = place.start.min(count)..place.end.min(count);
            if place.is_empty() {
                self.ahead.look(queued);
                break;
            }
            self.ahead.act(place.clone());
            looked = place.start;
            for from in place.end..count {
                let byte = scratch.get(from).copied().unwrap_or_default();
                if let Some(to) = scratch.get_mut(from - place.len()) {
                    *to = byte;
                }
            }
            count -= place.len();
        }
    }

    fn send_answers(&mut self, socket: &mut Socket<'static>) {
        let encoder = &mut self.encoder;
        let _open = socket.send(|into| (encoder.write_answers(into), ()));
    }

    /// Takes bytes for the visitor. Returns how many: as many as have room, all if nobody listens.
    pub fn write(&mut self, socket: &mut Socket<'static>, bytes: &[u8]) -> usize {
        if self.visitor().is_none() || !socket.may_send() {
            return bytes.len();
        }
        let (encoder, is_telnet) = (&mut self.encoder, self.decoder.is_telnet());
        let mut left = bytes;
        loop {
            let taken = socket.send(|into| {
                let (taken, written) = encoder.write(is_telnet, left, into);
                (written, (taken, written))
            });
            match taken {
                Ok((_, 0)) => return bytes.len() - left.len(),
                Ok((taken, _)) => left = left.get(taken..).unwrap_or_default(),
                Err(_) => return bytes.len(),
            }
        }
    }
}

/// Bytes on their way to a line.
struct Chunk {
    bytes: [u8; CHUNK],
    count: usize,
    most: usize,
}

impl Chunk {
    fn push(&mut self, byte: u8) {
        if let Some(place) = self.bytes.get_mut(self.count) {
            *place = byte;
            self.count += 1;
        }
    }
}

/// Says something to a visitor, as far as it fits.
fn say(socket: &mut Socket<'static>, words: &str) {
    let _sent = socket.send_slice(words.as_bytes());
}

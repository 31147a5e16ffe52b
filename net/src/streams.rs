//! Connections of the web: bytes both ways, and what they mean is somebody else's.

use core::net::Ipv4Addr;

use heapless::Vec;
use smoltcp::iface::{SocketHandle, SocketSet};
use smoltcp::socket::tcp::{Socket, State};
use smoltcp::time::{Duration, Instant};

use crate::password::{Gate, WORD_BYTES};
use crate::wire::remote;

/// Connections at a time: a browser opens up to six.
pub const STREAMS: usize = 8;
/// Time after which a connection that is not yet one makes room for another.
const HALF_OPEN: Duration = Duration::from_millis(200);
/// Time without a sign of life after which a peer is given up, and between two questions for one.
const TIMEOUT: Duration = Duration::from_secs(20);
const KEEP_ALIVE: Duration = Duration::from_secs(5);
/// Time that the end of a connection may take.
const CLOSING: Duration = Duration::from_secs(5);
/// The same for a peer that has acknowledged everything, while others find no place.
const CLOSING_IN_A_CROWD: Duration = Duration::from_millis(500);

/// Time for which a place is kept for the reset (RST) that tells a peer of its connection's end: a peer that
/// cannot be reached gets none.
const RESETTING: Duration = Duration::from_secs(1);

/// Wish of the server for a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Go on.
    Open,
    /// Close this side when all has been sent.
    Finish,
    /// End the connection at once.
    Abort,
}

/// Server of web connections, which are known by their places from 0 to [`STREAMS`].
///
/// The order of calls: `open`, then all others any number of times, then `close`. Times are in microseconds.
pub trait Streams {
    /// A peer has come.
    fn open(&mut self, place: usize, from: Ipv4Addr, now: u64);

    /// Takes bytes that have come, and may change them. Returns how many it took; the rest is offered again,
    /// as it was.
    fn receive(&mut self, place: usize, bytes: &mut [u8], now: u64) -> usize;

    /// The peer sends nothing any more.
    fn hear_end(&mut self, place: usize);

    /// Writes what is to be sent into the room. Returns how many bytes.
    fn transmit(&mut self, place: usize, room: &mut [u8], now: u64) -> usize;

    /// Returns what is to become of the connection.
    fn wish(&mut self, place: usize, now: u64) -> Wish;

    /// The connection has ended.
    fn close(&mut self, place: usize);

    /// Takes the next word that a peer has given for the password. The verdict on it follows.
    fn take_word(&mut self) -> Option<Word> {
        None
    }

    /// Hears the verdict on the word that was taken.
    fn hear_verdict(&mut self, _verdict: Verdict) {}
}

/// Word that a peer has given for the password.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Word {
    /// Address of the peer.
    pub from: Ipv4Addr,
    /// The word.
    pub bytes: Vec<u8, WORD_BYTES>,
}

/// Verdict on a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The word is the password.
    Right,
    /// The word is not the password.
    Wrong,
    /// There is no password.
    NoPassword,
    /// Too many wrong words came: seconds to wait.
    Wait(u32),
}

/// Place of the gate's visitor for all web connections, of which one at a time has a word verified.
const GATE_LINE: usize = usize::MAX;

/// The word that is being verified, by its peer's address.
#[derive(Debug, Default)]
pub struct Login {
    from: Option<Ipv4Addr>,
}

impl Login {
    /// Tells the server a verdict that is there, or else has its next word verified. Returns the address that
    /// a wrong word came from.
    pub fn run(&mut self, gate: &mut Gate, server: &mut impl Streams, now: Instant) -> Option<Ipv4Addr> {
        if let Some(from) = self.from {
            let is_right = gate.verdict(GATE_LINE, from, now)?;
            self.from = None;
            server.hear_verdict(if is_right { Verdict::Right } else { Verdict::Wrong });
            return (!is_right).then_some(from);
        }
        if !gate.is_free() {
            return None;
        }
        let Word { from, bytes } = server.take_word()?;
        let wait = gate.wait(from, now);
        if gate.record().is_none() {
            server.hear_verdict(Verdict::NoPassword);
        } else if wait > Duration::ZERO {
            server.hear_verdict(Verdict::Wait(wait.total_micros().div_ceil(1_000_000) as u32));
        } else if gate.prove(GATE_LINE, &bytes) {
            self.from = Some(from);
        }
        None
    }
}

/// Stage of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Empty,
    Open,
    /// The peer sends nothing any more.
    HalfClosed,
    /// This side is closed since then.
    Closing(Instant),
}

/// Place for a connection.
#[derive(Clone, Copy, Debug)]
struct Place {
    handle: SocketHandle,
    stage: Stage,
    /// Time since which the socket has been half open.
    half_open: Option<Instant>,
    /// Time since which the socket has had a reset to send.
    resetting: Option<Instant>,
}

/// Places for as many peers as can be served at once.
#[derive(Debug)]
pub struct Places {
    places: [Place; STREAMS],
    port: Option<u16>,
    /// No place is free.
    is_full: bool,
}

/// Sets a socket up for a web connection.
pub fn prepare(socket: &mut Socket<'static>) {
    socket.set_timeout(Some(TIMEOUT));
    socket.set_keep_alive(Some(KEEP_ALIVE));
    socket.set_nagle_enabled(false);
    // The buffer holds one segment and a piece of another, which a peer does not send before the first is
    // acknowledged (RFC 1122 section 4.2.3.4): a delay would be one in every 2 kB.
    socket.set_ack_delay(None);
}

impl Places {
    /// Makes empty places that are listened at, if there is a port.
    pub fn new(port: Option<u16>, sockets: [SocketHandle; STREAMS]) -> Self {
        let port = port.filter(|port| *port != 0);
        Self {
            places: sockets.map(|handle| Place { handle, stage: Stage::Empty, half_open: None, resetting: None }),
            port,
            is_full: false,
        }
    }

    /// Returns how many peers there are.
    pub fn peers(&self) -> usize {
        self.places.iter().filter(|place| place.stage != Stage::Empty).count()
    }

    /// Ends all connections.
    pub fn abort(&mut self, sockets: &mut SocketSet<'static>, server: &mut impl Streams) {
        for (number, place) in self.places.iter_mut().enumerate() {
            sockets.get_mut::<Socket>(place.handle).abort();
            place.leave(number, server);
        }
    }

    /// Has sockets listen for the next peers. Returns the port if none does.
    pub fn listen(&mut self, sockets: &mut SocketSet<'static>, now: Instant) -> Option<u16> {
        let port = self.port?;
        let mut listens = false;
        for place in &mut self.places {
            let socket = sockets.get_mut::<Socket>(place.handle);
            if socket.state() == State::Closed && place.stage == Stage::Empty && !place.is_resetting(socket, now) {
                let _listens = socket.listen(port);
            }
            listens |= socket.is_listening();
            let is_half_open = socket.state() == State::SynReceived;
            place.half_open = is_half_open.then(|| place.half_open.unwrap_or(now));
        }
        let oldest = self.places.iter().filter_map(|place| Some((place.half_open?, place.handle))).min();
        if let Some((_, handle)) = oldest.filter(|(since, _)| !listens && now >= *since + HALF_OPEN) {
            let socket = sockets.get_mut::<Socket>(handle);
            socket.abort();
            listens = socket.listen(port).is_ok();
        }
        self.is_full = !listens;
        (!listens).then_some(port)
    }

    /// Serves every peer once.
    pub fn run(
        &mut self,
        sockets: &mut SocketSet<'static>,
        server: &mut impl Streams,
        scratch: &mut [u8],
        now: Instant,
    ) {
        for (number, place) in self.places.iter_mut().enumerate() {
            let patience = if self.is_full { CLOSING_IN_A_CROWD } else { CLOSING };
            place.run(number, sockets.get_mut(place.handle), server, scratch, now, patience);
        }
    }
}

impl Place {
    fn run(
        &mut self,
        number: usize,
        socket: &mut Socket<'static>,
        server: &mut impl Streams,
        scratch: &mut [u8],
        now: Instant,
        patience: Duration,
    ) {
        match socket.state() {
            State::Closed | State::Listen | State::SynSent | State::SynReceived => self.leave(number, server),
            State::Established | State::CloseWait => self.serve(number, socket, server, scratch, now),
            State::FinWait1 | State::FinWait2 | State::Closing | State::LastAck | State::TimeWait => {
                self.end(number, socket, server, now, patience);
            }
        }
    }

    fn serve(
        &mut self,
        number: usize,
        socket: &mut Socket<'static>,
        server: &mut impl Streams,
        scratch: &mut [u8],
        now: Instant,
    ) {
        let micros = now.total_micros().unsigned_abs();
        if self.stage == Stage::Empty {
            self.stage = Stage::Open;
            server.open(number, remote(socket), micros);
        }
        let scratch_bytes = scratch.len();
        let waiting = socket.peek_slice(scratch).unwrap_or(0);
        let mut used = 0;
        while let Some(bytes) = scratch.get_mut(used..waiting).filter(|bytes| !bytes.is_empty()) {
            let taken = server.receive(number, bytes, micros);
            if taken == 0 {
                break;
            }
            used += taken;
        }
        // What was looked at may lie in two pieces.
        if let Some(taken) = scratch.get_mut(..used) {
            let _all = socket.recv_slice(taken);
        }
        let is_at_end = socket.state() == State::CloseWait && socket.recv_queue() == 0;
        if is_at_end && self.stage == Stage::Open {
            self.stage = Stage::HalfClosed;
            server.hear_end(number);
        }
        // The server gets all free room in one piece, and may wait for more than there is.
        let free = socket.send_capacity() - socket.send_queue();
        if socket.may_send()
            && let Some(room) = scratch.get_mut(..free.min(scratch_bytes)).filter(|room| !room.is_empty())
        {
            let written = server.transmit(number, room, micros).min(room.len());
            let _all = socket.send_slice(room.get(..written).unwrap_or_default());
        }
        match server.wish(number, micros) {
            Wish::Open => {}
            Wish::Finish => {
                socket.close();
                self.stage = Stage::Closing(now);
            }
            Wish::Abort => {
                socket.abort();
                self.leave(number, server);
            }
        }
    }

    /// Waits for the end of a connection that this side has closed. What still comes is dropped. A peer that
    /// has acknowledged everything is waited for with `patience`, as nothing is lost without its own end.
    fn end(
        &mut self,
        number: usize,
        socket: &mut Socket<'static>,
        server: &mut impl Streams,
        now: Instant,
        patience: Duration,
    ) {
        let _dropped = socket.recv(|bytes| (bytes.len(), ()));
        let longest = if socket.state() == State::FinWait2 { patience } else { CLOSING };
        let is_late = matches!(self.stage, Stage::Closing(since) if now >= since + longest);
        if socket.state() == State::TimeWait || is_late {
            socket.abort();
            self.leave(number, server);
        }
    }

    /// Whether a socket that is closed must still tell its peer so: to listen would forget that.
    fn is_resetting(&mut self, socket: &Socket<'static>, now: Instant) -> bool {
        self.resetting = socket.remote_endpoint().map(|_| self.resetting.unwrap_or(now));
        self.resetting.is_some_and(|since| now < since + RESETTING)
    }

    fn leave(&mut self, number: usize, server: &mut impl Streams) {
        if core::mem::replace(&mut self.stage, Stage::Empty) != Stage::Empty {
            server.close(number);
        }
    }
}

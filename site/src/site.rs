//! The site: all its connections.

use core::net::Ipv4Addr;

use base::ports::{Factors, Storage};
use base::snapshot::Snapshot;
use heapless::String;
use http::{Connection, Life, Response, Role};
use program::State;

use crate::access::{Access, Pass, Target};
use crate::batch::{Batch, Owner};
use crate::calls::{Reader, SCRIPT_BYTES};
use crate::client::Client;
use crate::console::{Asker, Console, Listeners, Outcome};
use crate::files::{FileWork, Files};
use crate::jog::{JOG_PLACE, Jogs};
use crate::memory::{Memory, Stores};
use crate::objects::{self, MAX_OBJECTS, Told};
use crate::path::Path;
use crate::questions::{self, Questions};
use crate::reply::{Content, Reply};

mod factors;
mod jogs;
mod path;

/// Visitors of WebSockets at a time.
pub const CLIENTS: usize = 4;
/// Time between two states of the machine that visitors are told of, milliseconds.
pub const PERIOD_MS: u64 = 250;
/// Longest name of the board.
const HOST_BYTES: usize = 72;

/// Work of a connection.
#[derive(Debug)]
pub(crate) enum Work {
    Nothing,
    /// Call whose parameters are read.
    Call,
    /// Call that is answered later.
    Waiting,
    /// File of the page, from this byte to that.
    Page(&'static [u8]),
    /// Answer of the API.
    Answer(Reply),
    /// WebSocket of this client.
    Socket(u8),
    Files(FileWork),
    /// Answer to a question about files that is asked over HTTP.
    Asked(Reply),
}

/// A connection and its work.
#[derive(Debug)]
pub(crate) struct Slot {
    pub connection: Connection,
    pub work: Work,
    /// Answer that is due when the request is whole.
    pub due: Option<Response>,
    /// Address of the peer.
    pub from: [u8; 4],
    /// Proof that the request has shown.
    pub pass: Pass,
}

/// Place for a WebSocket's visitor.
#[derive(Debug, Default)]
pub(crate) struct Seat {
    pub client: Option<Client>,
    /// Number of the visit.
    pub visit: u32,
    /// Proof of the visitor, and address.
    pub pass: Pass,
    pub from: [u8; 4],
}

impl Seat {
    /// Returns whether nobody has the seat.
    pub(crate) const fn is_empty(&self) -> bool {
        self.client.is_none()
    }
}

/// Call whose parameters are read out of the body of a request: one at a time.
#[derive(Debug)]
pub(crate) struct BodyCall {
    pub place: u8,
    pub since_ms: u64,
    pub reader: Reader,
}

/// Stop that a visitor asks for, which does not wait for lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EmergencyStop;

/// The site, for `N` connections.
#[derive(Debug)]
pub struct Site<const N: usize> {
    pub(crate) slots: [Option<Slot>; N],
    pub(crate) seats: [Seat; CLIENTS],
    pub(crate) access: Access,
    pub(crate) body: Option<BodyCall>,
    /// Calls of one message that are answered together.
    pub(crate) batch: Batch,
    /// Time when the site was last called, milliseconds.
    pub(crate) now_ms: u64,
    pub(crate) console: Console,
    pub(crate) files: Files,
    pub(crate) questions: Questions,
    jogs: Jogs,
    pub(crate) path: Path,
    pub(crate) snapshot: Snapshot,
    pub(crate) stores: &'static mut Stores,
    /// Hash of each object, and the number of the state.
    pub(crate) hashes: [u32; MAX_OBJECTS],
    pub(crate) number: u32,
    /// Time of the last state.
    shown_ms: u64,
    /// Name of the board in the network, alone and with `.local`.
    pub(crate) host: String<HOST_BYTES>,
    pub(crate) full_host: String<HOST_BYTES>,
    pub(crate) addresses: [[u8; 4]; 2],
    pub(crate) version: &'static str,
    stop: Option<EmergencyStop>,
    /// Factors that are to act at once.
    factors: Option<Factors>,
}

impl<const N: usize> Site<N> {
    /// Makes the site, without connections and without a name. `without` is what visitors may do who have
    /// neither logged in nor a key.
    #[must_use]
    pub fn new(version: &'static str, without: Role, memory: &'static mut Memory) -> Self {
        let Memory { said, stores } = memory;
        Self {
            slots: [const { None }; N],
            seats: core::array::from_fn(|_| Seat::default()),
            access: Access::new(without),
            body: None,
            batch: Batch::default(),
            now_ms: 0,
            console: Console::new(said),
            files: Files::default(),
            questions: Questions::default(),
            jogs: Jogs::new(),
            path: Path::new(),
            snapshot: Snapshot::default(),
            stores,
            hashes: [0; MAX_OBJECTS],
            number: 0,
            shown_ms: 0,
            host: String::new(),
            full_host: String::new(),
            addresses: [[127, 0, 0, 1]; 2],
            version,
            stop: None,
            factors: None,
        }
    }

    /// Sets the board's name in the network, without `.local`.
    pub fn set_host(&mut self, host: &str) {
        self.host = String::try_from(host).unwrap_or_default();
        self.full_host.clone_from(&self.host);
        // A name with it is as long as a label of DNS at the most.
        let _ = self.full_host.push_str(".local");
    }

    /// Sets the board's address, which requests may name instead of the board.
    pub const fn set_address(&mut self, address: Ipv4Addr) {
        self.addresses[0] = address.octets();
    }

    /// Returns whether somebody wants to see the machine as it is now, or its temperatures are to be kept.
    #[must_use]
    pub fn wants_snapshot(&self, now_ms: u64) -> bool {
        let is_looked_at = self.slots.iter().any(Option::is_some);
        let is_old = self.number == 0 || now_ms.saturating_sub(self.shown_ms) >= PERIOD_MS;
        is_looked_at && is_old || self.stores.temperatures.is_due(now_ms)
    }

    /// Takes the machine as it is now.
    pub fn show(&mut self, snapshot: &Snapshot, now_ms: u64) {
        self.snapshot.clone_from(snapshot);
        self.stores.temperatures.take(snapshot, now_ms);
        self.stores.macros.keep(snapshot.macros);
        self.console.keep_fault(snapshot.state == State::Alarm);
        self.access.sessions.expire(now_ms);
        (self.now_ms, self.shown_ms, self.number) = (now_ms, now_ms, self.number.wrapping_add(1).max(1));
        let Self { console, stores, .. } = self;
        let (fault, heights) = (console.fault(), &stores.heights);
        let told = Told { of: snapshot, fault, heights, messages: &console.messages };
        for (place, hash) in self.hashes.iter_mut().enumerate() {
            *hash = objects::hash(place, &told);
        }
    }

    /// Returns whether the heights of the mesh of this number are yet to be given.
    #[must_use]
    pub fn wants_heights(&self, number: u32) -> bool {
        !self.stores.heights.are_of(number)
    }

    /// Takes a row of heights of the mesh of this number, mm: rows from the front, each from the left.
    pub fn show_heights(&mut self, number: u32, row: usize, heights: &[f32]) {
        self.stores.heights.set(number, row, heights);
    }

    /// Returns the number of the macro that an answer waits for, or will ask for next.
    #[must_use]
    pub fn wants_macro(&self) -> Option<u16> {
        self.stores.macros.next()
    }

    /// Takes the macro of this number: its name, and what it says of itself; none: there are no more.
    pub fn show_macro(&mut self, number: u16, told: Option<(&str, &str)>) {
        self.stores.macros.tell(number, told);
    }

    /// Returns the next line for the machine, if the one before is done, and the role of its sender. A jog
    /// begins only while no script waits.
    pub fn next_line(&mut self, now_ms: u64) -> Option<(String<SCRIPT_BYTES>, Role)> {
        if self.console.is_idle()
            && let Some((line, id, holder)) = self.jogs.next_line()
        {
            let (asker, pass) = (Asker { place: JOG_PLACE, visit: id }, self.pass_of_seat(holder));
            // An idle console has room.
            let _taken = self.console.take(asker, pass, None, &line, Listeners::All);
        }
        let Self { console, access, .. } = self;
        let line = console.next_line(now_ms, |pass| access.role(pass));
        self.tell_outcomes();
        line
    }

    /// Returns whether the machine is to break off its answer in work, for lines that wait. True once.
    pub fn breaks_off(&mut self, now_ms: u64) -> bool {
        self.console.breaks_off(now_ms, self.jogs.waits())
    }

    /// Takes a visitor's request to stop at once.
    pub const fn take_stop(&mut self) -> Option<EmergencyStop> {
        self.stop.take()
    }

    /// Hears what the machine says. Returns how many bytes: a visitor who alone listens misses nothing.
    pub fn hear(&mut self, bytes: &[u8], now_ms: u64) -> usize {
        let heard = self.console.only_listener().and_then(|asker| self.client(asker)).map(|client| client.heard);
        let taken = self.console.room(heard, now_ms).min(bytes.len());
        self.console.hear(bytes.get(..taken).unwrap_or_default(), now_ms);
        self.tell_outcomes();
        taken
    }

    /// Tells visitors whose scripts are done.
    fn tell_outcomes(&mut self) {
        while let Some(Outcome { asker, id, ending, said }) = self.console.take_outcome() {
            if asker.place == JOG_PLACE {
                self.jogs.ended(asker.visit);
            } else if id.is_some() {
                self.reply(asker, Reply::outcome(id, Content::of(ending), said));
            }
        }
    }

    /// Answers a call of a WebSocket, unless its visitor has gone.
    pub(crate) fn reply(&mut self, asker: Asker, reply: Reply) {
        if reply.is_of_batch() {
            self.batch.answer(Owner::Seat(asker), reply);
        } else if let Some(client) = self.client(asker) {
            client.reply(reply);
        }
    }

    /// Returns the visitor of a WebSocket, unless gone.
    pub(crate) fn client(&mut self, asker: Asker) -> Option<&mut Client> {
        let seat = self.seats.get_mut(usize::from(asker.place))?;
        seat.client.as_mut().filter(|_| seat.visit == asker.visit)
    }

    /// Returns who sits at a place.
    pub(crate) fn asker(&self, place: u8) -> Asker {
        Asker { place, visit: self.seats.get(usize::from(place)).map_or(0, |seat| seat.visit) }
    }

    /// Returns the proof of the visitor of a WebSocket; none of who has gone.
    pub(crate) fn pass_of_seat(&self, asker: Asker) -> Pass {
        let seat = self.seats.get(usize::from(asker.place)).filter(|seat| seat.visit == asker.visit);
        seat.map_or(Pass::None, |seat| seat.pass)
    }

    /// A peer has connected, from this address.
    pub fn open(&mut self, place: usize, from: Ipv4Addr, buffer_bytes: usize, now_ms: u64) {
        if let Some(slot) = self.slots.get_mut(place) {
            let connection = Connection::new(buffer_bytes, now_ms);
            *slot = Some(Slot { connection, work: Work::Nothing, due: None, from: from.octets(), pass: Pass::None });
        }
    }

    /// The connection has ended.
    pub fn close(&mut self, place: usize, card: &mut impl Storage) {
        let slot = self.slots.get_mut(place).and_then(Option::take);
        if let Some(Slot { work, .. }) = slot {
            self.end_work(work, place as u8, card);
        }
        if self.slots.iter().all(Option::is_none) {
            // While nobody looks, the machine may be released and halt anew.
            self.console.keep_fault(false);
        }
    }

    /// Ends a connection's work, done or not.
    pub(crate) fn end_work(&mut self, work: Work, place: u8, card: &mut impl Storage) {
        match work {
            Work::Nothing | Work::Page(_) => {}
            Work::Answer(_) => self.batch.forget(Owner::Connection(place)),
            Work::Call => {
                self.body.take_if(|body| body.place == place);
                self.batch.forget(Owner::Connection(place));
            }
            Work::Waiting => self.access.forget(|target| matches!(target, Target::Request(of) if *of == place)),
            Work::Socket(seat) => self.leave(seat, card),
            Work::Files(work) => self.files.end(work, place, card),
            Work::Asked(_) => self.questions.leave(questions::Asker::Connection(place), &mut self.files, card),
        }
    }

    /// The peer sends nothing any more.
    pub fn hear_end(&mut self, place: usize) {
        if let Some(slot) = self.slots.get_mut(place).and_then(Option::as_mut) {
            slot.connection.hear_end();
            if let Work::Socket(seat) = slot.work {
                self.jogs.leave(self.asker(seat));
            }
        }
    }

    /// Returns what is to become of the connection.
    pub fn life(&mut self, place: usize, now_ms: u64) -> Life {
        self.slots.get_mut(place).and_then(Option::as_mut).map_or(Life::Abort, |slot| slot.connection.poll(now_ms))
    }

    pub(crate) fn leave(&mut self, seat: u8, card: &mut impl Storage) {
        let asker = self.asker(seat);
        self.jogs.leave(asker);
        self.questions.leave(questions::Asker::Seat(seat), &mut self.files, card);
        self.access.first.forget(asker);
        self.batch.forget(Owner::Seat(asker));
        self.access.forget(|target| matches!(target, Target::Call(of, _) if *of == asker));
        if let Some(seat) = self.seats.get_mut(usize::from(seat)) {
            (seat.client, seat.visit) = (None, seat.visit.wrapping_add(1));
        }
    }
}

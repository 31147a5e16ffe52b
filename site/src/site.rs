//! The site: all its connections.

use core::net::Ipv4Addr;

use base::ports::Storage;
use base::snapshot::Snapshot;
use heapless::String;
use http::{Connection, Event, Found, Known, Length, Life, Request, Response, Role, Status};
use program::State;

use crate::calls::{Call, Id, Method, Reader, SCRIPT_BYTES, codes};
use crate::client::Client;
use crate::console::{Asker, Console, Listeners, Outcome};
use crate::files::{FileWork, Files, Question, Visitor};
use crate::jog::{JOG_PLACE, Jogs};
use crate::objects::{self, MAX_OBJECTS, Objects};
use crate::path::Path;
use crate::reply::{Content, Reply};
use crate::routes::{Handler, ROUTES, UPLOAD_BYTES};
use crate::script;

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
    /// File of the page, from this byte to that.
    Page(&'static [u8]),
    /// Answer of the API.
    Answer(Reply),
    /// WebSocket of this client.
    Socket(u8),
    Files(FileWork),
}

/// A connection and its work.
#[derive(Debug)]
pub(crate) struct Slot {
    pub connection: Connection,
    pub work: Work,
    /// Answer that is due when the request is whole.
    pub due: Option<Response>,
}

/// Place for a WebSocket's visitor.
#[derive(Debug, Default)]
pub(crate) struct Seat {
    pub client: Option<Client>,
    /// Number of the visit.
    visit: u32,
}

/// Stop that a visitor asks for, which does not wait for lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EmergencyStop;

/// The site, for `N` connections.
#[derive(Debug)]
pub struct Site<const N: usize> {
    pub(crate) slots: [Option<Slot>; N],
    pub(crate) seats: [Seat; CLIENTS],
    pub(crate) console: Console,
    pub(crate) files: Files,
    jogs: Jogs,
    pub(crate) path: Path,
    pub(crate) snapshot: Snapshot,
    /// Hash of each object, and the number of the state.
    pub(crate) hashes: [u32; MAX_OBJECTS],
    pub(crate) number: u32,
    /// Time of the last state.
    shown_ms: u64,
    /// Role of every visitor.
    pub(crate) role: Role,
    /// Name of the board in the network, alone and with `.local`.
    pub(crate) host: String<HOST_BYTES>,
    full_host: String<HOST_BYTES>,
    addresses: [[u8; 4]; 2],
    pub(crate) version: &'static str,
    stop: Option<EmergencyStop>,
}

impl<const N: usize> Site<N> {
    /// Makes the site, without connections. `host` is the board's name in the network, without `.local`,
    /// `role` is what visitors may do.
    #[must_use]
    pub fn new(host: &str, version: &'static str, role: Role) -> Self {
        let mut site = Self {
            slots: [const { None }; N],
            seats: core::array::from_fn(|_| Seat::default()),
            console: Console::new(),
            files: Files::default(),
            jogs: Jogs::new(),
            path: Path::new(),
            snapshot: Snapshot::default(),
            hashes: [0; MAX_OBJECTS],
            number: 0,
            shown_ms: 0,
            role,
            host: String::new(),
            full_host: String::new(),
            addresses: [[127, 0, 0, 1]; 2],
            version,
            stop: None,
        };
        site.set_host(host);
        site
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

    /// Returns whether somebody wants to see the machine as it is now.
    #[must_use]
    pub fn wants_snapshot(&self, now_ms: u64) -> bool {
        let is_looked_at = self.slots.iter().any(Option::is_some);
        is_looked_at && (self.number == 0 || now_ms.saturating_sub(self.shown_ms) >= PERIOD_MS)
    }

    /// Takes the machine as it is now.
    pub fn show(&mut self, snapshot: &Snapshot, now_ms: u64) {
        self.snapshot.clone_from(snapshot);
        self.console.keep_fault(snapshot.state == State::Alarm);
        (self.shown_ms, self.number) = (now_ms, self.number.wrapping_add(1).max(1));
        for (place, hash) in self.hashes.iter_mut().enumerate() {
            *hash = objects::hash(place, snapshot, self.console.fault());
        }
    }

    /// Returns the next line for the machine, if the one before is done. A jog begins only while no script
    /// waits.
    pub fn next_line(&mut self, now_ms: u64) -> Option<String<SCRIPT_BYTES>> {
        if self.console.is_idle()
            && let Some((line, id)) = self.jogs.next_line()
        {
            // An idle console has room.
            let _taken = self.console.take(Asker { place: JOG_PLACE, visit: id }, None, &line, Listeners::All);
        }
        self.console.next_line(now_ms)
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
        let heard = self.console.only_listener().and_then(|asker| self.client_of(asker)).map(|client| client.heard);
        let taken = self.console.room(heard, now_ms).min(bytes.len());
        self.console.hear(bytes.get(..taken).unwrap_or_default());
        while let Some(Outcome { asker, id, ending, said }) = self.console.take_outcome() {
            if asker.place == JOG_PLACE {
                self.jogs.ended(asker.visit);
            } else if let Some(client) = self.client_of(asker) {
                client.reply(Reply::outcome(id, Content::of(ending), said));
            }
        }
        taken
    }

    /// Returns the visitor who has asked, if it is still there.
    fn client_of(&mut self, asker: Asker) -> Option<&mut Client> {
        let seat = self.seats.get_mut(usize::from(asker.place))?;
        seat.client.as_mut().filter(|_| seat.visit == asker.visit)
    }

    /// A peer has connected.
    pub fn open(&mut self, place: usize, buffer_bytes: usize, now_ms: u64) {
        if let Some(slot) = self.slots.get_mut(place) {
            *slot = Some(Slot { connection: Connection::new(buffer_bytes, now_ms), work: Work::Nothing, due: None });
        }
    }

    /// The connection has ended.
    pub fn close(&mut self, place: usize, card: &mut impl Storage) {
        let slot = self.slots.get_mut(place).and_then(Option::take);
        if let Some(Slot { work, .. }) = slot {
            self.end_work(work, place as u8, card);
        }
    }

    /// Ends a connection's work, done or not.
    fn end_work(&mut self, work: Work, place: u8, card: &mut impl Storage) {
        match work {
            Work::Nothing | Work::Page(_) | Work::Answer(_) => {}
            Work::Socket(seat) => self.leave(seat, card),
            Work::Files(work) => self.files.end(work, place, card),
        }
        if self.slots.iter().all(Option::is_none) {
            // While nobody looks, the machine may be released and halt anew.
            self.console.keep_fault(false);
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

    fn leave(&mut self, seat: u8, card: &mut impl Storage) {
        self.jogs.leave(self.asker(seat));
        self.files.end_question(Visitor::Seat(seat), card);
        if let Some(seat) = self.seats.get_mut(usize::from(seat)) {
            (seat.client, seat.visit) = (None, seat.visit.wrapping_add(1));
        }
    }

    /// Takes bytes of a connection. Returns how many.
    pub fn receive(&mut self, place: usize, bytes: &mut [u8], now_ms: u64, card: &mut impl Storage) -> usize {
        let Some(mut slot) = self.slots.get_mut(place).and_then(Option::take) else { return bytes.len() };
        let used = self.receive_in(&mut slot, place as u8, bytes, now_ms, card);
        if let Some(free) = self.slots.get_mut(place) {
            *free = Some(slot);
        }
        used
    }

    fn receive_in(
        &mut self,
        slot: &mut Slot,
        place: u8,
        bytes: &mut [u8],
        now_ms: u64,
        card: &mut impl Storage,
    ) -> usize {
        let mut used = 0;
        loop {
            let come = bytes.get_mut(used..).unwrap_or_default();
            let Some(most) = self.most(slot, place, come, now_ms, card) else {
                slot.connection.hold(now_ms);
                return used;
            };
            let Slot { connection, work, due } = &mut *slot;
            let (taken, event) = connection.receive(come.get_mut(..most).unwrap_or_default(), now_ms);
            used += taken;
            match event {
                Event::Nothing => return used,
                Event::Request(request) => {
                    let former = core::mem::replace(work, Work::Nothing);
                    self.end_work(former, place, card);
                    self.start(slot, &request, card);
                }
                Event::Body(bytes) => {
                    if let Work::Files(FileWork::Upload(number)) = work
                        && let Err(refusal) = self.files.take(*number, bytes, card)
                    {
                        connection.respond_error(Response::new(refusal.status), refusal.message);
                        let former = core::mem::replace(work, Work::Nothing);
                        self.end_work(former, place, card);
                    }
                }
                Event::End => {
                    if let Work::Files(FileWork::Upload(number)) = work {
                        self.files.end_form(*number);
                    }
                    if let Some(response) = due.take() {
                        connection.respond(response);
                    }
                }
                Event::Refused(_) => {
                    let former = core::mem::replace(work, Work::Nothing);
                    self.end_work(former, place, card);
                }
                Event::Message { is_first, is_last, bytes, .. } => {
                    if let Work::Socket(seat) = *work {
                        self.read_message(seat, (is_first, is_last), bytes, now_ms);
                    }
                }
                Event::Closed(_) => {
                    let former = core::mem::replace(work, Work::Nothing);
                    self.end_work(former, place, card);
                }
            }
        }
    }

    /// Begins with a request whose head is whole.
    fn start(&mut self, slot: &mut Slot, request: &Request<'_>, card: &mut impl Storage) {
        let began = self.begin(request, card);
        let Slot { connection, work, due } = slot;
        match began {
            Begun::Answer(response, next) => (*due, *work) = (Some(response), next),
            Begun::Files(response, next) => {
                (*due, *work) = (response, Work::Files(next));
                connection.allow_body(UPLOAD_BYTES);
            }
            Begun::Stop => {
                self.stop = Some(EmergencyStop);
                self.console.drop_waiting();
                let done = Work::Answer(Reply::answer(Content::Done));
                (*due, *work) = (Some(Response::json(Status::Ok)), done);
            }
            Begun::Refuse(status, message) => {
                (*due, *work) = (None, Work::Nothing);
                connection.respond_error(refusal(status, request), message);
            }
            Begun::Upgrade => {
                if connection.upgrade(request) {
                    *work = self.seat().map_or(Work::Nothing, Work::Socket);
                }
            }
        }
    }

    /// Decides on a request whose head is whole.
    fn begin(&mut self, request: &Request<'_>, card: &mut impl Storage) -> Begun {
        let names = [self.host.as_str(), self.full_host.as_str(), "localhost"];
        let known = Known { names: &names, addresses: &self.addresses, origins: &[] };
        if let Err(status) = known.check(request) {
            return Begun::Refuse(status, "this is not the page of this board");
        }
        let (route, rest) = match ROUTES.find(request.head.method, request.path) {
            Found::Route(route, rest) => (route, rest),
            Found::WrongMethod(_) => return Begun::Refuse(Status::MethodNotAllowed, "the path knows other methods"),
            Found::Nothing => return Begun::Refuse(Status::NotFound, "there is nothing of this name"),
        };
        if let Err(status) = route.admit(self.role) {
            return Begun::Refuse(status, "the password is wanted first");
        }
        if !route.content.takes(request.header("Content-Type")) {
            return Begun::Refuse(Status::UnsupportedMediaType, "this path takes content of another type");
        }
        if matches!(request.head.length, Length::Known(bytes) if bytes > route.body_bytes) {
            return Begun::Refuse(Status::ContentTooLarge, "the body is too long");
        }
        let json = |content| Begun::Answer(Response::json(Status::Ok), Work::Answer(Reply::answer(content)));
        match route.handler {
            Handler::Socket if self.seats.iter().all(|seat| seat.client.is_some()) => {
                Begun::Refuse(Status::ServiceUnavailable, "as many pages as can be are open: close another one")
            }
            Handler::Socket => Begun::Upgrade,
            Handler::EmergencyStop => Begun::Stop,
            Handler::ServerInfo => json(Content::Server),
            Handler::PrinterInfo => json(Content::Printer),
            Handler::ListObjects => json(Content::Names),
            Handler::QueryObjects => json(Content::State(self.objects_of(request))),
            Handler::Upload | Handler::File | Handler::RemoveFile | Handler::Page => {
                self.begin_files(route.handler, rest, request, card)
            }
        }
    }

    /// Returns the objects that a query names: `?toolhead&extruder=temperature`; without names, none.
    fn objects_of(&self, request: &Request<'_>) -> Objects {
        let mut room = [0; objects::NAME_BYTES];
        request.query.iter().fold(0, |set, (name, _)| {
            set | http::percent::decode(name, true, &mut room).map_or(0, |name| objects::named(name, &self.snapshot))
        })
    }

    /// Finds a seat for a visitor who has come.
    fn seat(&mut self) -> Option<u8> {
        let (heard, state) = (self.console.end(), objects::klippy_state(self.snapshot.state));
        let change = self.files.change.number;
        let (place, seat) = self.seats.iter_mut().enumerate().find(|(_, seat)| seat.client.is_none())?;
        seat.client = Some(Client::new(place as u8, heard, state, change));
        Some(place as u8)
    }

    /// Takes a piece of a visitor's message.
    fn read_message(&mut self, seat: u8, (is_first, is_last): (bool, bool), bytes: &[u8], now_ms: u64) {
        let Self { seats, snapshot, .. } = self;
        let Some(client) = seats.get_mut(usize::from(seat)).and_then(|seat| seat.client.as_mut()) else { return };
        if is_first {
            client.reader = Some(Reader::new());
        }
        if let Some(reader) = &mut client.reader {
            reader.read(bytes, snapshot);
        }
        if is_last && let Some(reader) = client.reader.take() {
            self.call(seat, reader, now_ms);
        }
    }

    /// Carries out a call. A call without an id is not answered (JSON-RPC 2.0 section 4.1).
    fn call(&mut self, place: u8, mut reader: Reader, now_ms: u64) {
        let read = reader.end();
        if let Ok(Call { method: Method::Files(ask), .. }) = &read
            && self.role >= Method::Files(*ask).least_role()
            && let Some(client) = self.seats.get_mut(usize::from(place)).and_then(|seat| seat.client.as_mut())
        {
            (client.question, client.reader) = (Some(Question::new(*ask)), Some(reader));
            return;
        }
        let Reader { id, text, .. } = reader;
        let is_notification = id.is_none() && !matches!(read, Err((codes::PARSE | codes::INVALID, _)));
        let content = match read {
            Err((code, message)) => Some(Content::Error(code, message)),
            Ok(call) => self.carry_out(place, &call, id.as_ref(), &text, now_ms),
        };
        let client = self.seats.get_mut(usize::from(place)).and_then(|seat| seat.client.as_mut());
        if let (Some(client), Some(content)) = (client, content)
            && !is_notification
        {
            client.reply(Reply::message(id, content));
        }
    }

    /// Carries out a call; none: the answer comes when the machine is done.
    fn carry_out(&mut self, place: u8, call: &Call, id: Option<&Id>, text: &str, now_ms: u64) -> Option<Content> {
        if self.role < call.method.least_role() {
            return Some(Content::Error(codes::FORBIDDEN, "this is for who may operate the machine"));
        }
        let script = match call.method {
            Method::Identify => return Some(Content::Connection(u32::from(place))),
            Method::AccessInfo => return Some(Content::Access(self.role)),
            Method::ServerInfo => return Some(Content::Server),
            Method::PrinterInfo => return Some(Content::Printer),
            Method::ListObjects => return Some(Content::Names),
            Method::QueryObjects => return Some(Content::State(call.objects)),
            Method::Subscribe => {
                let client = self.seats.get_mut(usize::from(place)).and_then(|seat| seat.client.as_mut())?;
                client.subscribe(call.objects, &self.hashes);
                return Some(Content::State(call.objects));
            }
            Method::PathSince => return Some(self.path_since(call)),
            Method::EmergencyStop => {
                self.stop_at_once();
                return Some(Content::Done);
            }
            Method::JogStart | Method::JogBeat | Method::JogStop => return Some(self.jog(place, call, text, now_ms)),
            _ => script::of(call, text),
        };
        let script = match script {
            Ok(script) => script,
            Err(message) => return Some(Content::Error(codes::PARAMETERS, message)),
        };
        let listeners = if call.method == Method::Ask { Listeners::Asker } else { Listeners::All };
        let has_room = self.console.take(self.asker(place), id.cloned(), &script, listeners);
        (!has_room).then_some(Content::Error(codes::BUSY, "the machine has lines enough: wait for their answers"))
    }
}

/// Decision on a request.
pub(crate) enum Begun {
    /// Answer with this head, whose body the work makes.
    Answer(Response, Work),
    /// The same about files; without a head it comes later.
    Files(Option<Response>, FileWork),
    Refuse(Status, &'static str),
    /// The machine stops at once.
    Stop,
    /// The connection becomes a WebSocket.
    Upgrade,
}

fn refusal(status: Status, request: &Request<'_>) -> Response {
    let mut response = Response::new(status);
    if let Found::WrongMethod(methods) = ROUTES.find(request.head.method, request.path) {
        response.allow = methods;
    }
    response
}

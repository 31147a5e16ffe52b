//! Answers that go out on connections, and the site's work on files.

use base::ports::Storage;
use base::snapshot::Snapshot;
use http::json::{Next, Writer};
use http::{Connection, Request, Response, Role, Selection, Status};

use crate::access::Pass;
use crate::assets::{Asset, Counted};
use crate::batch::{Batch, Owner};
use crate::calls::{Method, SCRIPT_BYTES, codes};
use crate::client::Client;
use crate::console::{self, Console, Listeners};
use crate::files::{Ask, Change, FileBody, FileWork, Files, Refusal, Stored, Visitor, may_want_card, write_item};
use crate::objects::MAX_OBJECTS;
use crate::path::Path;
use crate::questions::{self, Asker, Questions};
use crate::reply::{Content, Facts, Reply, ReplyBody};
use crate::routes::Handler;
use crate::site::{Seat, Site, Slot, Work};

/// Place of the asker of what nobody waits for.
const NOBODY: u8 = u8::MAX;

/// Decision on a request.
pub(crate) enum Begun {
    /// Answer with this head, whose body the work makes.
    Answer(Response, Work),
    /// The same about files; without a head it comes later.
    Files(Option<Response>, FileWork),
    /// Question about files of this number, which is answered later.
    Asked(u8),
    Refuse(Status, &'static str),
    /// The body has the parameters of this call, or else whole calls.
    Call(Option<Method>),
    /// The machine stops at once.
    Stop,
    /// The connection becomes a WebSocket.
    Upgrade,
}

impl<const N: usize> Site<N> {
    /// Returns how many of the bytes that have come on a connection are to be taken; none while they have to
    /// wait: for the answers to calls before them, for the card.
    pub(crate) fn most(
        &mut self,
        slot: &Slot,
        place: u8,
        bytes: &[u8],
        now_ms: u64,
        card: &mut impl Storage,
    ) -> Option<usize> {
        if let Work::Socket(seat) = slot.work {
            let client = self.seats.get(usize::from(seat)).and_then(|seat| seat.client.as_ref());
            return client.is_some_and(Client::has_room).then_some(bytes.len());
        }
        if let Work::Files(work) = &slot.work {
            return self.files.most(work, place, bytes.len(), slot.connection.body_left(), now_ms, card);
        }
        let waits = slot.connection.wants_head()
            && may_want_card(bytes)
            && !self.files.has_card(Visitor::Connection(place), now_ms, card);
        (!waits).then_some(bytes.len())
    }

    /// Begins with a request about a file of the card or of the page.
    pub(crate) fn begin_files(
        &mut self,
        handler: Handler,
        (rest, role): (&str, Role),
        request: &Request<'_>,
        card: &mut impl Storage,
    ) -> Begun {
        let Self { files, .. } = self;
        let begun = match handler {
            Handler::Upload => files.begin_upload(request, role).map(|work| Begun::Files(None, work)),
            Handler::File => files.begin_reading(rest, request, card).map(|(response, work)| match (response, work) {
                (response, Some(work)) => Begun::Files(response, work),
                (response, None) => Begun::Answer(response.unwrap_or(Response::new(Status::Ok)), Work::Nothing),
            }),
            Handler::RemoveFile => files
                .remove(rest, role, card)
                .map(|()| Begun::Answer(Response::json(Status::Ok), Work::Answer(Reply::answer(Content::Done)))),
            Handler::Page
            | Handler::Socket
            | Handler::Ask(_)
            | Handler::ServerInfo
            | Handler::PrinterInfo
            | Handler::ListObjects
            | Handler::QueryObjects
            | Handler::Lines
            | Handler::Temperatures
            | Handler::EmergencyStop
            | Handler::UploadPart
            | Handler::Calls
            | Handler::Call(_) => return self.begin_page(request, card),
        };
        begun.unwrap_or_else(|refusal| Begun::Refuse(refusal.status, refusal.message))
    }

    /// Answers how much is there of an upload that broke off. If its connection has not ended, which may have
    /// died without a word, the upload goes on over another.
    pub(crate) fn begin_part(&mut self, request: &Request<'_>, card: &mut impl Storage) -> Begun {
        match self.files.ask_part(request, self.now_ms, card) {
            Ok((size, under_way)) => {
                let is_it =
                    |slot: &&mut Slot| matches!(slot.work, Work::Files(FileWork::Upload(of)) if Some(of) == under_way);
                if let Some(slot) = self.slots.iter_mut().flatten().find(is_it) {
                    slot.connection.respond_error(Response::new(Status::Conflict), "the upload goes on elsewhere");
                    slot.work = Work::Nothing;
                }
                Begun::Answer(Response::json(Status::Ok), Work::Answer(Reply::answer(Content::Offset(size))))
            }
            Err(refusal) => Begun::Refuse(refusal.status, refusal.message),
        }
    }

    /// Begins with a question about files, whose path stands in the query.
    pub(crate) fn begin_question(&mut self, ask: Ask, place: u8, request: &Request<'_>) -> Begun {
        let mut room = [0; SCRIPT_BYTES];
        // A value that is no text is taken for none.
        let named =
            ["path", "root", "filename"].into_iter().find(|name| request.query.value(name, &mut room).is_some());
        let text = named.and_then(|name| request.query.value(name, &mut room)).unwrap_or_default();
        let asked = self.questions.ask(Asker::Connection(place), ask, text, None);
        asked.map_or(Begun::Refuse(Status::ServiceUnavailable, questions::FULL), Begun::Asked)
    }

    /// Begins to send a file of the page: of the user's own, if he has one, but for names that the board's
    /// page has, and for `/?builtin`, which gets past a page that does not work.
    fn begin_page(&mut self, request: &Request<'_>, card: &mut impl Storage) -> Begun {
        let asset = Asset::find(request.path);
        let is_board_s = if request.path == "/" { request.query.as_str() == "builtin" } else { asset.is_some() };
        if !is_board_s && let Ok((response, work)) = self.files.begin_page(request.path, request, card) {
            return match work {
                Some(work) => Begun::Files(Some(response), work),
                None => Begun::Answer(response, Work::Nothing),
            };
        }
        let Some(asset) = asset else {
            return Begun::Refuse(Status::NotFound, "there is nothing of this name");
        };
        let whole = asset.response();
        let selection = Selection::of(request, whole.tag, asset.bytes.len() as u64);
        let bytes = match selection {
            Selection::Whole => asset.bytes,
            Selection::Part(part) => asset.bytes.get(part.first as usize..=part.last as usize).unwrap_or_default(),
            Selection::NotModified | Selection::Unsatisfiable => &[],
        };
        Begun::Answer(selection.answer(whole, asset.bytes.len() as u64), Work::Page(bytes))
    }

    /// Does what is to be done on files. Returns whether there is more to do soon.
    pub fn run(&mut self, now_ms: u64, card: &mut impl Storage) -> bool {
        self.files.look_for_others(now_ms, card);
        let mut is_busy = false;
        for place in 0..N {
            if let Some(mut slot) = self.slots.get_mut(place).and_then(Option::take) {
                is_busy |= self.go_on(&mut slot, place as u8, now_ms, card);
                if let Some(free) = self.slots.get_mut(place) {
                    *free = Some(slot);
                }
            }
        }
        is_busy |= self.go_on_with_calls(now_ms, card);
        let Self { files, slots, .. } = self;
        if is_busy {
            // What an upload has written need not wait for the machine to go round.
            card.let_go();
        }
        let is_used = slots.iter().any(Option::is_some);
        let is_busy = files.clear(now_ms, card) || is_used && files.run(now_ms, card) || is_busy;
        files.count_own(card);
        is_busy
    }

    /// Goes on with visitors' calls about files. Returns whether there is more to do soon.
    fn go_on_with_calls(&mut self, now_ms: u64, card: &mut impl Storage) -> bool {
        let Self { seats, files, questions, access, batch, .. } = self;
        let mut is_busy = false;
        for (number, seat) in questions.seats() {
            is_busy = true;
            let Some(Seat { client: Some(client), pass, visit, .. }) = seats.get_mut(usize::from(seat)) else {
                continue;
            };
            let owner = Owner::Seat(console::Asker { place: seat, visit: *visit });
            if !client.has_room() {
                continue;
            }
            let Some(done) = questions.go_on(number, access.role(*pass), files, card, now_ms) else { continue };
            let id = questions.id(number);
            let content = match done {
                Ok(()) => Content::Files(number),
                Err(Refusal { status: Status::BadRequest, message }) => Content::Error(codes::PARAMETERS, message),
                Err(Refusal { status, message }) => Content::Error(i32::from(status.code()), message),
            };
            if done.is_err() || id.is_none() {
                questions.end(number, files, card);
            }
            if id.is_some() {
                let reply = Reply::message(id, content);
                if reply.is_of_batch() {
                    batch.answer(owner, reply);
                } else {
                    client.reply(reply);
                }
            }
        }
        is_busy
    }

    /// Goes on with a connection's work on files. Returns whether there is more to do soon.
    fn go_on(&mut self, slot: &mut Slot, place: u8, now_ms: u64, card: &mut impl Storage) -> bool {
        let Slot { connection, work, pass, .. } = slot;
        match work {
            Work::Files(FileWork::Upload(number)) => {
                let number = *number;
                match self.files.keep(number, place, now_ms, card) {
                    None => {}
                    Some(Stored::Refused(refusal)) => {
                        connection.respond_error(Response::new(refusal.status), refusal.message);
                        self.files.end(FileWork::Upload(number), place, card);
                        *work = Work::Nothing;
                    }
                    Some(Stored::Whole(prints)) => {
                        let is_started = prints && self.play(number, *pass);
                        self.files.note_started(number, is_started);
                        connection.respond(Response::json(Status::Created));
                        *work = Work::Files(FileWork::Stored(number, Default::default()));
                    }
                }
                true
            }
            Work::Files(FileWork::Find(_)) => {
                self.look_for_picture(slot, place, now_ms, card);
                true
            }
            Work::Files(FileWork::Stored(..) | FileWork::Read(_) | FileWork::Picture(_)) => true,
            Work::Asked(reply) => {
                let number = reply.question().unwrap_or_default();
                let role = self.access.role(*pass);
                match self.questions.go_on(number, role, &mut self.files, card, now_ms) {
                    None => {}
                    Some(Ok(())) => connection.respond(Response::json(Status::Ok)),
                    Some(Err(refusal)) => {
                        connection.respond_error(Response::new(refusal.status), refusal.message);
                        self.questions.end(number, &mut self.files, card);
                        *work = Work::Nothing;
                    }
                }
                true
            }
            Work::Nothing | Work::Call | Work::Waiting | Work::Page(_) | Work::Answer(_) | Work::Socket(_) => false,
        }
    }

    /// Goes on to look for a picture, and begins to answer when it is found, or is not there.
    fn look_for_picture(&mut self, slot: &mut Slot, place: u8, now_ms: u64, card: &mut impl Storage) {
        let Slot { connection, work, .. } = slot;
        let Work::Files(FileWork::Find(mut picture)) = core::mem::replace(work, Work::Nothing) else {
            return;
        };
        let found = match self.files.has_card(Visitor::Connection(place), now_ms, card) {
            true => picture.find(card),
            false => None,
        };
        match found {
            None => *work = Work::Files(FileWork::Find(picture)),
            Some(true) => {
                let mut response = Response::json(Status::Ok);
                response.content_type = picture.content_type();
                connection.respond(response);
                *work = Work::Files(FileWork::Picture(picture));
            }
            Some(false) => {
                connection.respond_error(Response::new(Status::NotFound), "the file has no such picture");
                self.files.end(FileWork::Find(picture), place, card);
            }
        }
    }

    /// Has the machine play an upload. False if it has lines enough.
    fn play(&mut self, number: u8, pass: Pass) -> bool {
        use core::fmt::Write as _;
        let mut line = heapless::String::<SCRIPT_BYTES>::new();
        let written = write!(line, "play \"{}\"", self.files.path_of(number));
        let nobody = console::Asker { place: NOBODY, visit: 0 };
        written.is_ok() && self.console.take(nobody, pass, None, &line, Listeners::All)
    }

    /// Writes what is to be sent on a connection. Returns how many bytes.
    pub fn transmit(&mut self, place: usize, room: &mut [u8], now_ms: u64, card: &mut impl Storage) -> usize {
        let Self { slots, seats, access, batch, files, questions, console, path, snapshot, hashes, number, .. } = self;
        let facts = Facts { host: &self.host, version: self.version, access, stores: self.stores };
        let mut machine = Machine { may_watch: false, console, path, snapshot, hashes, number: *number, facts, now_ms };
        let Some(slot) = slots.get_mut(place).and_then(Option::as_mut) else { return 0 };
        let Slot { connection, work, due, .. } = slot;
        match work {
            Work::Nothing | Work::Call | Work::Waiting => connection.transmit(room, &mut http::Empty, now_ms),
            Work::Page(left) => {
                let mut body = Counted::new(left);
                let written = connection.transmit(room, &mut body, now_ms);
                *left = left.get(body.made..).unwrap_or_default();
                written
            }
            Work::Answer(reply) => {
                let mut body = machine.body(reply);
                body.batch = Some(batch).filter(|batch| batch.is_sent_to(Owner::Connection(place as u8)));
                connection.transmit(room, &mut body, now_ms)
            }
            Work::Files(of) => {
                let written = connection.transmit(
                    room,
                    &mut FileBody { work: of, place: place as u8, files, card, now_ms },
                    now_ms,
                );
                let is_over = !connection.is_sending() && due.is_none() && of.is_answered();
                if is_over && let Work::Files(of) = core::mem::replace(work, Work::Nothing) {
                    files.end(of, place as u8, card);
                }
                written
            }
            Work::Asked(reply) => {
                let number = reply.question().unwrap_or_default();
                let mut teller =
                    |part: u32, json: &mut Writer<'_, '_>| questions.write(number, part, files, card, now_ms, json);
                let mut body = machine.body(reply);
                body.teller = Some(&mut teller);
                let written = connection.transmit(room, &mut body, now_ms);
                if !connection.is_sending() && questions.is_answered(number) {
                    questions.end(number, files, card);
                    *work = Work::Nothing;
                }
                written
            }
            Work::Socket(seat) => {
                let Some(Seat { client: Some(client), pass, visit, .. }) = seats.get_mut(usize::from(*seat)) else {
                    return 0;
                };
                let owner = Owner::Seat(console::Asker { place: *seat, visit: *visit });
                machine.may_watch = access.role(*pass) >= Role::Watch;
                if access.has_ended(*pass) && !client.has_answers() {
                    // The page connects anew, as who it is now.
                    connection.close(http::codes::POLICY);
                }
                let mut talk = Talk { client, questions, files, card, batch, owner };
                talk.go_on(connection, &machine, room)
            }
        }
    }
}

/// The machine, as visitors are told of it.
struct Machine<'m> {
    /// Whether the visitor may see it.
    may_watch: bool,
    console: &'m Console,
    path: &'m Path,
    snapshot: &'m Snapshot,
    hashes: &'m [u32; MAX_OBJECTS],
    number: u32,
    facts: Facts<'m>,
    now_ms: u64,
}

impl<'m> Machine<'m> {
    /// Returns the body of a reply that tells of the machine.
    const fn body<'r>(&self, reply: &'r mut Reply) -> ReplyBody<'r>
    where
        'm: 'r,
    {
        let Self { console, path, snapshot, facts, now_ms, .. } = *self;
        ReplyBody { reply, snapshot, console, path, facts, now_ms, teller: None, batch: None, is_over: false }
    }
}

/// Talk with a visitor of a WebSocket.
struct Talk<'t, S> {
    client: &'t mut Client,
    questions: &'t mut Questions,
    files: &'t mut Files,
    card: &'t mut S,
    batch: &'t mut Batch,
    /// The visitor, as one whose calls are answered together.
    owner: Owner,
}

impl<S: Storage> Talk<'_, S> {
    /// Writes as many messages as there are, and room for. Returns how many bytes.
    fn go_on(&mut self, connection: &mut Connection, machine: &Machine<'_>, room: &mut [u8]) -> usize {
        let mut used = 0;
        loop {
            if !connection.is_sending() {
                let Self { client, questions, files, card, batch, owner } = self;
                if let Some(number) = client.sending.take().and_then(|reply| reply.question()) {
                    questions.end(number, files, *card);
                }
                let Machine { may_watch, console, snapshot, hashes, number, .. } = *machine;
                client.sending = batch
                    .begin_sending(*owner, client.heard)
                    .or_else(|| client.next_message(may_watch, console, snapshot, hashes, number, files.change.number));
                if client.sending.is_none() || !connection.send(http::Kind::Text) {
                    return used;
                }
            }
            let written = self.send(connection, machine, room.get_mut(used..).unwrap_or_default());
            used += written;
            if written == 0 {
                return used;
            }
        }
    }

    /// Writes a piece of the message that is being sent.
    fn send(&mut self, connection: &mut Connection, machine: &Machine<'_>, room: &mut [u8]) -> usize {
        let now_ms = machine.now_ms;
        let Self { client: Client { sending, .. }, questions, files, card, batch, owner } = self;
        let Some(reply) = sending else { return connection.transmit(room, &mut http::Empty, now_ms) };
        let (question, tells) = (reply.question(), reply.is_of_files());
        let mut teller = |part: u32, json: &mut Writer<'_, '_>| match question {
            Some(number) => questions.write(number, part, files, *card, now_ms, json),
            None => tell_change(&files.change, json),
        };
        let mut body = machine.body(reply);
        body.batch = Some(&mut **batch).filter(|batch| batch.is_sent_to(*owner));
        if tells {
            body.teller = Some(&mut teller);
        }
        let written = connection.transmit(room, &mut body, now_ms);
        if body.is_over
            && let Some(number) = question
        {
            questions.end(number, files, *card);
        }
        written
    }
}

/// Tells of a change of files.
fn tell_change(change: &Change, json: &mut Writer<'_, '_>) -> Next {
    json.begin_object();
    json.key("action");
    json.text(change.action);
    json.key("item");
    write_item(change.shown(), json);
    json.end_object();
    Next::End
}

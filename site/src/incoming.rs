//! Requests and calls that come in on connections, and the work they ask for.

use core::cell::Cell;

use base::ports::Storage;
use http::{Event, Response};

use crate::access::{Target, Visitor};
use crate::calls::{Call, Method, Quantity, Reader, codes};
use crate::console::{Asker, Listeners};
use crate::files::FileWork;
use crate::questions;
use crate::reply::{Content, Reply};
use crate::script;
use crate::site::{Site, Slot, Work};
use crate::visitors::{forbidden, head_of};

impl<const N: usize> Site<N> {
    /// Takes bytes of a connection. Returns how many.
    pub fn receive(&mut self, place: usize, bytes: &mut [u8], now_ms: u64, card: &mut impl Storage) -> usize {
        self.now_ms = now_ms;
        self.files.look_for_others(now_ms, card);
        let Some(mut slot) = self.slots.get_mut(place).and_then(Option::take) else { return bytes.len() };
        let used = self.receive_in(&mut slot, place as u8, bytes, now_ms, card);
        if let Some(free) = self.slots.get_mut(place) {
            *free = Some(slot);
        }
        self.files.count_own(card);
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
            let Slot { connection, work, due, from, pass } = &mut *slot;
            let (taken, event) = connection.receive(come.get_mut(..most).unwrap_or_default(), now_ms);
            used += taken;
            match event {
                Event::Nothing => return used,
                Event::Request(request) => {
                    let former = core::mem::replace(work, Work::Nothing);
                    self.end_work(former, place, card);
                    self.take_request(place, slot, &request, card);
                }
                Event::Body(bytes) => {
                    if let (Work::Call, Some(body)) = (&*work, self.body.as_mut().filter(|body| body.place == place)) {
                        body.reader.read(bytes, &self.snapshot);
                    }
                    if let Work::Files(FileWork::Upload(number)) = work
                        && let Err(refusal) = self.files.take(*number, bytes, card)
                    {
                        connection.respond_error(Response::new(refusal.status), refusal.message);
                        let former = core::mem::replace(work, Work::Nothing);
                        self.end_work(former, place, card);
                    }
                }
                Event::End => {
                    if matches!(work, Work::Call) {
                        let visitor = Visitor { target: Target::Request(place), pass: *pass, from: *from };
                        (*due, *work) = self.end_body(place, visitor);
                    }
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
        let Some(seat) = self.seats.get(usize::from(place)) else { return };
        let (asker, pass, from) = (Asker { place, visit: seat.visit }, seat.pass, seat.from);
        let read = reader.end();
        let is_notification = reader.id.is_none() && !matches!(read, Err((codes::PARSE | codes::INVALID, _)));
        let target = Target::Call(asker, reader.id.clone());
        let content = match read {
            Err((code, message)) => Some(Content::Error(code, message)),
            Ok(call) => self.carry_out(Visitor { target, pass, from }, &call, &reader, now_ms),
        };
        if let (Some(client), Some(content)) = (self.client(asker), content)
            && !is_notification
        {
            client.reply(Reply::message(reader.id, content));
        }
    }

    /// Carries out a call; none: the answer comes later.
    fn carry_out(&mut self, visitor: Visitor, call: &Call, reader: &Reader, now_ms: u64) -> Option<Content> {
        let role = self.access.role(visitor.pass);
        if role < call.method.least_role() {
            return Some(forbidden(role));
        }
        if call.method.is_about_access() {
            return self.call_access(visitor, call, &reader.text, &reader.role);
        }
        let Target::Call(asker, id) = visitor.target else {
            return Some(Content::Error(codes::METHOD, "this is called over the WebSocket"));
        };
        let script = match call.method {
            Method::Identify => return Some(Content::Connection(u32::from(asker.place))),
            Method::ServerInfo => return Some(Content::Server),
            Method::PrinterInfo => return Some(Content::Printer),
            Method::ListObjects => return Some(Content::Names),
            Method::QueryObjects => return Some(Content::State(call.objects)),
            Method::Subscribe => {
                let Self { seats, hashes, .. } = self;
                let client = seats.get_mut(usize::from(asker.place)).and_then(|seat| seat.client.as_mut())?;
                client.subscribe(call.objects, hashes);
                return Some(Content::State(call.objects));
            }
            Method::Help => return Some(Content::Help),
            Method::Temperatures => return Some(Content::Temperatures),
            Method::Lines => {
                let count = call.number(Quantity::Count).map_or(usize::MAX, |count| count as usize);
                return Some(Content::Lines(Cell::new((0, self.console.last(count)))));
            }
            Method::PathSince => return Some(self.path_since(call)),
            Method::EmergencyStop => {
                self.stop_at_once();
                return Some(Content::Done);
            }
            Method::JogStart | Method::JogBeat | Method::JogStop => {
                return Some(self.jog(asker, call, &reader.text, now_ms));
            }
            Method::Files(ask) => {
                let asked = self.questions.ask(questions::Asker::Seat(asker.place), ask, &reader.text, id);
                return asked.is_none().then_some(Content::Error(codes::BUSY, questions::FULL));
            }
            Method::Override => match self.set_factors(call) {
                Ok(true) => script::of(call, &reader.text),
                Ok(false) => return Some(Content::Done),
                Err((code, message)) => return Some(Content::Error(code, message)),
            },
            _ => script::of(call, &reader.text),
        };
        let script = match script {
            Ok(script) => script,
            Err(message) => return Some(Content::Error(codes::PARAMETERS, message)),
        };
        let listeners = if call.method == Method::Ask { Listeners::Asker } else { Listeners::All };
        let has_room = self.console.take(asker, visitor.pass, id, &script, listeners);
        (!has_room).then_some(Content::Error(codes::BUSY, "the machine has lines enough: wait for their answers"))
    }

    /// Ends the parameters of a call, and carries it out. Returns the answer, if it is due now.
    fn end_body(&mut self, place: u8, visitor: Visitor) -> (Option<Response>, Work) {
        let body = self.body.take_if(|body| body.place == place);
        let content = match body.map(|mut body| (body.reader.end(), body.reader)) {
            None => Some(Content::Error(codes::BUSY, "the call took too long to come")),
            Some((Err((code, message)), _)) => Some(Content::Error(code, message)),
            Some((Ok(call), reader)) => self.carry_out(visitor, &call, &reader, self.now_ms),
        };
        match content {
            Some(content) => (Some(head_of(&content)), Work::Answer(Reply::answer(content))),
            None => (None, Work::Waiting),
        }
    }
}

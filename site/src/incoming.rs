//! Requests and calls that come in on connections, and the work they ask for.

use core::cell::Cell;

use base::ports::Storage;
use http::{Event, Response, Status};

use crate::access::{Target, Visitor};
use crate::batch::{self, Owner};
use crate::calls::{Call, Calls, Method, Quantity, Reader, codes};
use crate::console::Listeners;
use crate::files::FileWork;
use crate::questions;
use crate::reply::{Content, Reply};
use crate::script;
use crate::site::{Site, Slot, Work};
use crate::visitors::{forbidden, head_of};

/// Refusal of a call that is not answered at once, over HTTP.
const ELSEWHERE: &str = "this is called over the WebSocket, or by its own path";

impl Visitor {
    /// Returns who has calls of one message answered together.
    const fn owner(&self) -> Owner {
        match self.target {
            Target::Call(asker, _) => Owner::Seat(asker),
            Target::Request(place) => Owner::Connection(place),
            Target::Nobody => Owner::Connection(u8::MAX),
        }
    }
}

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
                    if matches!(work, Work::Call) {
                        self.read_body(
                            place,
                            Visitor { target: Target::Request(place), pass: *pass, from: *from },
                            bytes,
                        );
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
        let asker = self.asker(seat);
        let Some(place) = self.seats.get_mut(usize::from(seat)) else { return };
        let visitor = Visitor { target: Target::Call(asker, None), pass: place.pass, from: place.from };
        let Some(client) = place.client.as_mut() else { return };
        let begun = if is_first { Some(Reader::new()) } else { client.reader.take() };
        let Some(mut reader) = begun else { return };
        self.read_calls(&visitor, &mut reader, bytes, now_ms);
        let reply = match is_last {
            true => self.end_message(visitor, &mut reader, now_ms),
            false => None,
        };
        let Some(client) = self.client(asker) else { return };
        reply.into_iter().for_each(|reply| client.reply(reply));
        client.reader = Some(reader).filter(|_| !is_last);
    }

    /// Takes a piece of a request's body that has parameters of a call, or calls.
    fn read_body(&mut self, place: u8, visitor: Visitor, bytes: &[u8]) {
        let Some(mut body) = self.body.take_if(|body| body.place == place) else { return };
        self.read_calls(&visitor, &mut body.reader, bytes, self.now_ms);
        self.body = Some(body);
    }

    /// Reads a piece of a message, and carries out the calls that are whole, where it has several.
    fn read_calls(&mut self, visitor: &Visitor, reader: &mut Reader, mut bytes: &[u8], now_ms: u64) {
        while reader.read(&mut bytes, &self.snapshot) {
            let owner = visitor.owner();
            let taken = match reader.batch() {
                Some(Calls::Taken(0)) if !self.batch.begin(owner, now_ms) => Calls::Enough,
                Some(Calls::Taken(_)) if !self.batch.is_of(owner) => Calls::Enough,
                Some(Calls::Taken(batch::CALLS)) => {
                    let text = "a message has at most 8 calls: those behind them are not carried out";
                    self.batch.add(Some(Reply::message(None, Content::Error(codes::INVALID, text))));
                    Calls::Enough
                }
                Some(Calls::Taken(before)) => {
                    let read = reader.end_call();
                    let is_answered = reader.id.is_some() || read.is_err_and(|(code, _)| code == codes::INVALID);
                    reader.id.iter_mut().for_each(|id| id.is_of_batch = true);
                    let reply = self.call(visitor.clone(), read, reader, now_ms);
                    if is_answered {
                        self.batch.add(reply);
                    }
                    Calls::Taken(before + 1)
                }
                _ => Calls::Enough,
            };
            reader.begin_next(taken);
        }
    }

    /// Ends a message. Returns the answer to its call, or why it is none; those to several calls go out when
    /// all are there.
    fn end_message(&mut self, visitor: Visitor, reader: &mut Reader, now_ms: u64) -> Option<Reply> {
        let owner = visitor.owner();
        let Some(calls) = reader.batch() else {
            let read = reader.end();
            let is_broken = matches!(read, Err((codes::PARSE | codes::INVALID, _)));
            // A call without an id is not answered (JSON-RPC 2.0 section 4.1).
            return self.call(visitor, read, reader, now_ms).filter(|_| reader.id.is_some() || is_broken);
        };
        let error = match (reader.finish(), calls) {
            (Err(error), _) => Some(error),
            (Ok(()), Calls::Taken(0)) => Some((codes::INVALID, "the message has no call")),
            (Ok(()), Calls::Enough) if !self.batch.is_of(owner) => {
                Some((codes::BUSY, "another message of several calls is being answered: try again"))
            }
            (Ok(()), Calls::Taken(_) | Calls::Enough) => None,
        };
        let error = error.map(|(code, message)| Reply::message(None, Content::Error(code, message)));
        if !self.batch.is_of(owner) {
            return error;
        }
        if error.is_some() && calls != Calls::Enough {
            self.batch.add(error);
        }
        self.batch.end_message();
        None
    }

    /// Carries out a call. Returns its answer; none: it comes later.
    fn call(
        &mut self,
        visitor: Visitor,
        read: Result<Call, (i32, &'static str)>,
        reader: &Reader,
        now_ms: u64,
    ) -> Option<Reply> {
        let target = match visitor.target {
            Target::Call(asker, _) => Target::Call(asker, reader.id.clone()),
            target => target,
        };
        let content = match read {
            Err((code, message)) => Some(Content::Error(code, message)),
            Ok(call) if matches!(target, Target::Request(_)) && call.method.waits() => {
                Some(Content::Error(codes::METHOD, ELSEWHERE))
            }
            Ok(call) => self.carry_out(Visitor { target, ..visitor }, &call, reader, now_ms),
        };
        content.map(|content| Reply::message(reader.id.clone(), content))
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
        let told = self.told(call);
        if told.is_some() {
            return told;
        }
        let Target::Call(asker, id) = visitor.target else {
            return Some(Content::Error(codes::METHOD, ELSEWHERE));
        };
        let script = match call.method {
            Method::Identify => return Some(Content::Connection(u32::from(asker.place))),
            Method::Subscribe => {
                let Self { seats, hashes, .. } = self;
                let client = seats.get_mut(usize::from(asker.place)).and_then(|seat| seat.client.as_mut())?;
                client.subscribe(call.objects, hashes);
                return Some(Content::State(call.objects));
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

    /// Carries out a call that is answered at once, whichever way it came. None: it is another one.
    fn told(&mut self, call: &Call) -> Option<Content> {
        Some(match call.method {
            Method::ServerInfo => Content::Server,
            Method::PrinterInfo => Content::Printer,
            Method::ListObjects => Content::Names,
            Method::QueryObjects => Content::State(call.objects),
            Method::Help => Content::Help,
            Method::Temperatures => Content::Temperatures,
            Method::Lines => self.lines(call.number(Quantity::Count).map(|count| count as usize)),
            Method::PathSince => self.path_since(call),
            Method::EmergencyStop => {
                self.stop_at_once();
                Content::Done
            }
            _ => return None,
        })
    }

    /// Returns the last lines of the console, so many or all that are kept.
    pub(crate) fn lines(&self, count: Option<usize>) -> Content {
        Content::Lines(Cell::new((0, self.console.last(count.unwrap_or(usize::MAX)))))
    }

    /// Ends the parameters of a call, and carries it out. Returns the answer, if it is due now.
    fn end_body(&mut self, place: u8, visitor: Visitor) -> (Option<Response>, Work) {
        let mut body = self.body.take_if(|body| body.place == place);
        if let Some(mut body) = body.take_if(|body| body.reader.is_of_calls()) {
            let owner = visitor.owner();
            let reply = self.end_message(visitor, &mut body.reader, self.now_ms);
            let reply = reply.or_else(|| self.batch.begin_sending(owner, self.console.end()));
            return match reply {
                Some(reply) => (Some(Response::json(Status::Ok)), Work::Answer(reply)),
                // Nobody wanted an answer.
                None => (Some(Response::new(Status::NoContent)), Work::Nothing),
            };
        }
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

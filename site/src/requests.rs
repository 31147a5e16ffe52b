//! Requests over HTTP: what becomes of one whose head is whole.

use base::ports::Storage;
use http::{Found, Known, Length, Request, Response, Status};

use crate::access::Pass;
use crate::calls::Reader;
use crate::objects::{self, Objects};
use crate::reply::{Content, Reply};
use crate::routes::{Handler, ROUTES, UPLOAD_BYTES};
use crate::serving::Begun;
use crate::site::{BodyCall, Site, Slot, Work};

/// Room for a count in a query, bytes.
const COUNT_BYTES: usize = 20;
/// Time after which a call that is still read makes room for another, milliseconds.
const CALL_MS: u64 = 2_000;

impl<const N: usize> Site<N> {
    /// Takes a request whose head is whole: the answer is begun, or due with the request's end.
    pub(crate) fn take_request(&mut self, place: u8, slot: &mut Slot, request: &Request<'_>, card: &mut impl Storage) {
        slot.pass = self.pass_of(request);
        (slot.due, slot.work) = match self.begin(request, (place, slot.pass), card) {
            Begun::Answer(response, next) => (Some(response), next),
            Begun::Files(response, next) => {
                slot.connection.allow_body(UPLOAD_BYTES);
                (response, Work::Files(next))
            }
            Begun::Asked(number) => (None, Work::Asked(Reply::answer(Content::Files(number)))),
            Begun::Stop => {
                self.stop_at_once();
                (Some(Response::json(Status::Ok)), Work::Answer(Reply::answer(Content::Done)))
            }
            Begun::Refuse(status, message) => {
                slot.connection.respond_error(refusal(status, request), message);
                (None, Work::Nothing)
            }
            Begun::Call(method) => {
                let reader = method.map_or(Reader::new(), Reader::of);
                self.body = Some(BodyCall { place, since_ms: self.now_ms, reader });
                (None, Work::Call)
            }
            Begun::Upgrade if slot.connection.upgrade(request) => {
                (None, self.seat(slot.pass, slot.from, card).map_or(Work::Nothing, Work::Socket))
            }
            Begun::Upgrade => (None, Work::Nothing),
        };
    }

    /// Decides on a request whose head is whole.
    fn begin(&mut self, request: &Request<'_>, (place, pass): (u8, Pass), card: &mut impl Storage) -> Begun {
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
        let role = self.access.role(pass);
        if let Err(status) = route.admit(role) {
            let is_unknown = status == Status::Unauthorized;
            return Begun::Refuse(
                status,
                if is_unknown { "log in first" } else { "the role does not suffice: log in" },
            );
        }
        if !route.content.takes(request.header("Content-Type")) {
            return Begun::Refuse(Status::UnsupportedMediaType, "this path takes content of another type");
        }
        if matches!(request.head.length, Length::Known(bytes) if bytes > route.body_bytes) {
            return Begun::Refuse(Status::ContentTooLarge, "the body is too long");
        }
        let json = |content| Begun::Answer(Response::json(Status::Ok), Work::Answer(Reply::answer(content)));
        match route.handler {
            Handler::Socket if !self.has_seat(pass) => {
                Begun::Refuse(Status::ServiceUnavailable, "as many pages as can be are open: close another one")
            }
            Handler::Socket => Begun::Upgrade,
            Handler::Call(_) | Handler::Calls
                if self.body.as_ref().is_some_and(|body| self.now_ms < body.since_ms + CALL_MS) =>
            {
                Begun::Refuse(Status::ServiceUnavailable, "another call is being read: try again")
            }
            Handler::Call(method) => Begun::Call(Some(method)),
            Handler::Calls => Begun::Call(None),
            Handler::EmergencyStop => Begun::Stop,
            Handler::ServerInfo => json(Content::Server),
            Handler::PrinterInfo => json(Content::Printer),
            Handler::ListObjects => json(Content::Names),
            Handler::QueryObjects => json(Content::State(self.objects_of(request))),
            Handler::Lines => match request.query.value("count", &mut [0; COUNT_BYTES]).map(str::parse) {
                Some(Err(_)) => Begun::Refuse(Status::BadRequest, "count is a number of lines"),
                count => json(self.lines(count.and_then(Result::ok))),
            },
            Handler::Temperatures => json(Content::Temperatures),
            Handler::Ask(ask) => self.begin_question(ask, place, request),
            Handler::UploadPart => self.begin_part(request, card),
            Handler::Upload | Handler::File | Handler::RemoveFile | Handler::Page => {
                self.begin_files(route.handler, (rest, role), request, card)
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
}

fn refusal(status: Status, request: &Request<'_>) -> Response {
    let mut response = Response::new(status);
    if let Found::WrongMethod(methods) = ROUTES.find(request.head.method, request.path) {
        response.allow = methods;
    }
    response
}

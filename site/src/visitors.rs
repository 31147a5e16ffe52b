//! Visitors of the site: what proves their roles, logins, passwords and keys.

use base::ports::{KeysRecord, Storage};
use heapless::String;
use http::{Request, Response, Role, Status, bearer, cookie};

use crate::access::{
    Asker, COOKIE, Keeping, NAME_BYTES, NoKey, NotNow, Pass, Random, Target, Told, Verdict, Visitor, Word, is_fit,
    text_of,
};
use crate::calls::{Call, Method, codes};
use crate::client::Client;
use crate::objects;
use crate::reply::{Content, Reply};
use crate::role_names;
use crate::site::{Seat, Site, Work};

/// Text of a refusal for want of a stock of random bytes, which is filled in each turn.
const NOT_READY: &str = "the board is not ready for that: try again";
const ONE_AT_A_TIME: &str = "another change is being kept on the card: try again";

/// Returns the error for a visitor of this role, who may not call a method.
pub const fn forbidden(role: Role) -> Content {
    match role {
        Role::Nobody => Content::Error(codes::UNKNOWN, "log in first"),
        Role::Watch => Content::Error(codes::FORBIDDEN, "this is for who may operate the machine: log in"),
        Role::Operate | Role::Own => Content::Error(codes::FORBIDDEN, "this is for who has the password: log in"),
    }
}

impl<const N: usize> Site<N> {
    /// Returns the proof that a request shows: a key, or else the cookie of a session.
    pub(crate) fn pass_of(&self, request: &Request<'_>) -> Pass {
        let key = request.header("X-Api-Key").or_else(|| request.header("Authorization").and_then(bearer));
        self.access.pass(key, request.header("Cookie").and_then(|line| cookie(line, COOKIE)))
    }

    /// Returns whether there is a seat for a visitor with this proof. Who may see nothing makes room for who
    /// may.
    pub(crate) fn has_seat(&self, pass: Pass) -> bool {
        let may_watch = self.access.role(pass) >= Role::Watch;
        self.seats.iter().any(|seat| seat.is_empty() || may_watch && self.access.role(seat.pass) < Role::Watch)
    }

    /// Finds a seat for a visitor who has come.
    pub(crate) fn seat(&mut self, pass: Pass, from: [u8; 4], card: &mut impl Storage) -> Option<u8> {
        let empty = self.seats.iter().position(Seat::is_empty);
        let place = empty.or_else(|| self.seats.iter().position(|seat| self.access.role(seat.pass) < Role::Watch))?;
        if empty.is_none() {
            self.turn_out(place as u8, card);
        }
        let (heard, change) = (self.console.end(), self.files.change.number);
        let client = Client::new(place as u8, heard, objects::klippy_state(self.snapshot.state), change);
        let seat = self.seats.get_mut(place)?;
        (seat.client, seat.pass, seat.from) = (Some(client), pass, from);
        Some(place as u8)
    }

    /// Ends the WebSocket of a seat, which another visitor gets.
    fn turn_out(&mut self, place: u8, card: &mut impl Storage) {
        let held = self.slots.iter_mut().flatten().find(|slot| matches!(slot.work, Work::Socket(of) if of == place));
        if let Some(slot) = held {
            slot.connection.close(http::codes::POLICY);
            slot.work = Work::Nothing;
        }
        self.leave(place, card);
    }

    /// Carries out a call about access; none: the answer comes later.
    pub(crate) fn call_access(&mut self, visitor: Visitor, call: &Call, text: &str, role: &str) -> Option<Content> {
        let told = match call.method {
            Method::Login => {
                let has_room = self.access.queue(visitor, text);
                return (!has_room)
                    .then_some(Content::Error(codes::BUSY, "others are logging in: try again in some seconds"));
            }
            Method::Logout => {
                if let Pass::Session(number) = visitor.pass {
                    self.access.sessions.end(number);
                }
                if let Target::Call(asker, _) = visitor.target {
                    self.set_pass(asker, Pass::None);
                }
                Told::LoggedOut
            }
            Method::AccessInfo => Told::Info(visitor.pass),
            Method::GetUser => Told::User(visitor.pass),
            Method::ListKeys => Told::Keys,
            Method::SetPassword => return self.set_password(visitor, call.is_code, text),
            Method::MakeKey => return self.make_key(visitor, text, role),
            Method::RevokeKey => {
                if self.access.is_keeping() {
                    return Some(Content::Error(codes::BUSY, ONE_AT_A_TIME));
                }
                if !self.access.keys.revoke(text) {
                    return Some(Content::Error(codes::MISSING, "there is no key of this name"));
                }
                self.access.keep_keys(Keeping::Revoked, visitor.target);
                return None;
            }
            _ => return Some(Content::Error(codes::METHOD, "there is no such method")),
        };
        Some(Content::Access(told))
    }

    fn make_key(&mut self, visitor: Visitor, name: &str, role: &str) -> Option<Content> {
        let error = |code, text| Some(Content::Error(code, text));
        let role = if role.is_empty() { Some(Role::Operate) } else { role_names::of_key(role) };
        let Some(role) = role else { return error(codes::PARAMETERS, "role is Watch, Operate or Own") };
        if self.access.is_keeping() {
            return error(codes::BUSY, ONE_AT_A_TIME);
        }
        let Some(random) = self.access.take_random() else { return error(codes::BUSY, NOT_READY) };
        match self.access.keys.add(name, role, &text_of(&random)) {
            Ok(()) => {
                let name = String::<NAME_BYTES>::try_from(name).unwrap_or_default();
                self.access.keep_keys(Keeping::NewKey(random, name), visitor.target);
                None
            }
            Err(NoKey::Name) => error(codes::PARAMETERS, "name has 1 to 24 letters, digits and signs of ASCII"),
            Err(NoKey::Taken) => error(codes::TAKEN, "another key has this name: revoke that one first"),
            Err(NoKey::Full) => error(codes::TAKEN, "there are eight keys, no more can be: revoke one first"),
        }
    }

    /// Sets the password. The first one needs a code that the machine shows; others are the owner's to set.
    fn set_password(&mut self, visitor: Visitor, is_code: bool, text: &str) -> Option<Content> {
        let error = |code, text| Some(Content::Error(code, text));
        let role = self.access.role(visitor.pass);
        if self.access.has_password && role < Role::Own {
            return error(codes::FORBIDDEN, "there is a password: who has it may change it");
        }
        let Target::Call(asker, _) = visitor.target else {
            return error(codes::REFUSED, "the password is set over the WebSocket");
        };
        if self.access.is_keeping() {
            return error(codes::BUSY, ONE_AT_A_TIME);
        }
        let outcome = if is_code {
            self.access.first.confirm(asker, text, self.now_ms).map(Some)
        } else if !is_fit(text) {
            return error(codes::PARAMETERS, "a password has 8 to 63 letters, digits and signs of ASCII");
        } else if role == Role::Own {
            // The text fits, as it is not too long.
            Word::from_slice(text.as_bytes()).map(Some).map_err(|_| NotNow::NoWord)
        } else {
            let Some([a, b, c, d, ..]) = self.access.take_random() else { return error(codes::BUSY, NOT_READY) };
            let word = Word::from_slice(text.as_bytes()).unwrap_or_default();
            let code = self.access.first.begin(asker, word, u32::from_le_bytes([a, b, c, d]), self.now_ms);
            code.map(|code| {
                self.access.show_code(code, visitor.from);
                None
            })
        };
        match outcome {
            Ok(None) => Some(Content::Access(Told::Confirm)),
            Ok(Some(word)) => {
                self.access.keep_password(word, visitor.target);
                None
            }
            Err(NotNow::Wait(seconds)) => Some(Content::Access(Told::Wait(seconds))),
            Err(NotNow::WrongCode) => error(codes::REFUSED, "this is not the code that the machine shows"),
            Err(NotNow::NoWord) => error(codes::REFUSED, "no password waits for a code: begin again"),
        }
    }

    /// Takes the next word that a visitor has given for the password, with the visitor's address. The verdict
    /// on it comes to [`Self::hear_verdict`].
    pub fn take_word(&mut self) -> Option<([u8; 4], Word)> {
        self.access.take_word()
    }

    /// Hears the verdict on the word that was taken.
    pub fn hear_verdict(&mut self, verdict: Verdict) {
        let Some(Visitor { target, .. }) = self.access.take_verified() else { return };
        let content = match (verdict, &target) {
            (_, Target::Nobody) => return,
            (Verdict::Right, Target::Call(asker, _)) => {
                self.set_pass(*asker, self.access.socket_pass());
                Content::Access(Told::LoggedIn(None))
            }
            (Verdict::Right, Target::Request(_)) => match self.access.take_random() {
                Some(random) => {
                    self.access.sessions.begin(&text_of(&random), self.now_ms);
                    Content::Access(Told::LoggedIn(Some(random)))
                }
                None => Content::Error(codes::BUSY, NOT_READY),
            },
            (Verdict::Wrong, _) => Content::Error(codes::UNKNOWN, "this is not the password"),
            (Verdict::NoPassword, _) => Content::Error(codes::UNKNOWN, "no password is set: set the first one"),
            (Verdict::Wait(seconds), _) => Content::Access(Told::Wait(seconds)),
        };
        self.answer(target, content);
    }

    /// Answers a visitor who has waited.
    fn answer(&mut self, target: Target, content: Content) {
        match target {
            Target::Nobody => {}
            Target::Call(asker, id) => {
                // A call without an id is not answered.
                if id.is_some() {
                    self.reply(asker, Reply::message(id, content));
                }
            }
            Target::Request(place) => {
                let Some(slot) = self.slots.get_mut(usize::from(place)).and_then(Option::as_mut) else { return };
                if matches!(slot.work, Work::Waiting) {
                    slot.connection.respond(head_of(&content));
                    slot.work = Work::Answer(Reply::answer(content));
                }
            }
        }
    }

    /// Gives the visitor of a WebSocket another proof.
    fn set_pass(&mut self, asker: Asker, pass: Pass) {
        let seat = self.seats.get_mut(usize::from(asker.place)).filter(|seat| seat.visit == asker.visit);
        if let Some(seat) = seat {
            seat.pass = pass;
        }
    }

    /// Sets whether the board has a password.
    pub const fn set_has_password(&mut self, has_password: bool) {
        self.access.has_password = has_password;
    }

    /// The password is another one, or there is none any more: all who have logged in are nobody again.
    pub fn change_password(&mut self) {
        self.access.change_password();
    }

    /// Takes the record of keys that is kept.
    pub fn read_keys(&mut self, record: &[u8]) {
        self.access.keys.read(record);
    }

    /// Returns whether random bytes are wanted: see [`Self::add_random`].
    #[must_use]
    pub fn wants_random(&self) -> bool {
        self.access.wants_random()
    }

    /// Takes bytes of the chip's generator, of which tokens, keys and codes are made.
    pub fn add_random(&mut self, random: Random) {
        self.access.add_random(random);
    }

    /// Takes a code that is to be shown where only who stands at the machine reads it, and the address of the
    /// visitor who has asked for it.
    pub const fn take_code(&mut self) -> Option<(u32, [u8; 4])> {
        self.access.take_code()
    }

    /// Takes a word that is to be made the password and kept. The outcome comes to [`Self::hear_kept`].
    pub const fn take_password(&mut self) -> Option<Word> {
        self.access.take_password()
    }

    /// Returns whether the keys are to be kept: see [`Self::take_keys`].
    #[must_use]
    pub const fn has_keys_to_keep(&self) -> bool {
        self.access.has_keys_to_keep()
    }

    /// Takes the record of all keys, which is to be kept. The outcome comes to [`Self::hear_kept`].
    pub fn take_keys(&mut self) -> Option<KeysRecord> {
        self.access.take_keys()
    }

    /// Hears whether what was taken is kept, or why not.
    pub fn hear_kept(&mut self, kept: Result<(), &'static str>) {
        let Some((keeping, target)) = self.access.take_kept() else { return };
        let content = match (keeping, kept) {
            (Keeping::NewKey(random, _), Ok(())) => Content::Access(Told::Key(random)),
            (Keeping::NewKey(_, name), Err(why)) => {
                self.access.keys.revoke(&name);
                Content::Error(codes::FAILED, why)
            }
            (Keeping::Password | Keeping::Revoked, Ok(())) => Content::Done,
            (Keeping::Password | Keeping::Revoked, Err(why)) => Content::Error(codes::FAILED, why),
        };
        self.answer(target, content);
    }
}

/// Returns the head of the answer that has this content.
pub fn head_of(content: &Content) -> Response {
    let status = match content {
        Content::Error(codes::UNKNOWN, _) => Status::Unauthorized,
        Content::Error(codes::FORBIDDEN, _) => Status::Forbidden,
        Content::Error(codes::MISSING, _) => Status::NotFound,
        Content::Error(codes::TAKEN, _) => Status::Conflict,
        Content::Error(codes::FAILED, _) => Status::InternalServerError,
        Content::Error(codes::BUSY, _) => Status::ServiceUnavailable,
        Content::Error(..) => Status::BadRequest,
        Content::Access(Told::Wait(_)) => Status::TooManyRequests,
        _ => Status::Ok,
    };
    let mut response = Response::json(status);
    if let Content::Access(Told::Wait(seconds)) = content {
        response.retry_s = u16::try_from(*seconds).unwrap_or(u16::MAX);
    }
    response
}

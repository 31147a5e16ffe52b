//! Answers and notifications, made as they go.

use core::cell::Cell;

use base::snapshot::Snapshot;
use http::json::{Next, Parts, Writer};

use crate::access::{Access, Told};
use crate::calls::{Id, IdValue, codes};
use crate::console::{Console, Ending, Said};
use crate::help;
use crate::memory::Stores;
use crate::objects::{self, MAX_OBJECTS, Objects};
use crate::path::{self, Path, Piece};
use crate::temperatures;

mod body;

pub use body::ReplyBody;

/// Facts about the board that answers tell.
#[derive(Clone, Copy, Debug)]
pub struct Facts<'f> {
    /// Name in the network.
    pub host: &'f str,
    /// Version of the firmware.
    pub version: &'f str,
    /// Sessions, keys and the rest of access, of which answers tell.
    pub access: &'f Access,
    /// Temperatures, and heights of the bed.
    pub stores: &'f Stores,
}

/// Content of a message or of an answer.
#[derive(Clone, Debug)]
pub enum Content {
    /// The call is done.
    Done,
    /// Number of the connection.
    Connection(u32),
    /// Bytes that are there of an upload.
    Offset(u32),
    /// Number of a jog that begins.
    Jog(u32),
    /// Codes, commands and macros with their help.
    Help,
    /// Temperatures of the last minutes.
    Temperatures,
    /// Lines that the machine said and was sent, by the number of the part that is made and the place of its
    /// line.
    Lines(Cell<(u32, u32)>),
    /// Piece of the path that the machine has made.
    Path(Piece),
    /// Answer to a call about access.
    Access(Told),
    /// State of the server.
    Server,
    /// State of the machine, in short.
    Printer,
    /// Names of all objects.
    Names,
    /// Objects with their fields.
    State(Objects),
    /// Error: code and text.
    Error(i32, &'static str),
    /// Error: the machine refused; the place of its reason in what it said.
    Refused(Option<u32>),
    /// Notification: objects that have changed.
    Changed(Objects),
    /// Notification: the machine said a line, which begins at this place of what it said.
    Said(u32),
    /// Notification that the board is there, where nothing else is to be told.
    Beat,
    /// Notification without content, by its method.
    Notice(&'static str),
    /// Answer to the question of this number, about files, whose parts somebody else tells.
    Files(u8),
    /// Notification: files have changed, which somebody else tells.
    FilesChanged,
}

/// Teller of an answer's parts, by their numbers.
pub type Teller<'r> = &'r mut dyn FnMut(u32, &mut Writer<'_, '_>) -> Next;

impl Content {
    /// Returns the content that tells how a script ended.
    #[must_use]
    pub const fn of(ending: Ending) -> Self {
        match ending {
            Ending::Done => Self::Done,
            Ending::Refused(reason) => Self::Refused(reason),
            Ending::BrokenOff => Self::Error(codes::BUSY, "broken off, as another visitor has lines for the machine"),
        }
    }
}

/// Answer or notification, as far as it is out.
#[derive(Clone, Debug)]
pub struct Reply {
    /// Id of the call that is answered; none over HTTP, and with notifications.
    id: Option<Id>,
    /// Whether this goes over a WebSocket.
    is_message: bool,
    /// Place in what the machine said that the visitor is told up to before.
    pub said: Option<u32>,
    content: Content,
    parts: Parts,
}

impl Reply {
    /// Returns whether files are what this tells of.
    #[must_use]
    pub const fn is_of_files(&self) -> bool {
        matches!(self.content, Content::Files(_) | Content::FilesChanged)
    }

    /// Returns whether the answer may go to a visitor who has heard the machine up to this place.
    #[must_use]
    pub fn is_due(&self, heard: u32) -> bool {
        self.said.is_none_or(|said| said.wrapping_sub(heard).cast_signed() <= 0)
    }

    /// Returns whether this answers one of several calls of a message.
    #[must_use]
    pub fn is_of_batch(&self) -> bool {
        self.id.as_ref().is_some_and(|id| id.is_of_batch)
    }

    /// Returns the number of the question about files that is answered.
    #[must_use]
    pub const fn question(&self) -> Option<u8> {
        if let Content::Files(number) = self.content { Some(number) } else { None }
    }

    /// Makes the answer to a call of a WebSocket.
    #[must_use]
    pub const fn message(id: Option<Id>, content: Content) -> Self {
        Self { id, is_message: true, said: None, content, parts: Parts::new() }
    }

    /// Makes the answer to a call whose script is done, behind what the machine said up to this place.
    #[must_use]
    pub const fn outcome(id: Option<Id>, content: Content, said: u32) -> Self {
        Self { id, is_message: true, said: Some(said), content, parts: Parts::new() }
    }

    /// Makes the answer to a request of HTTP.
    #[must_use]
    pub const fn answer(content: Content) -> Self {
        Self { id: None, is_message: false, said: None, content, parts: Parts::new() }
    }
}

/// Facts and state that a part is made of.
struct Tells<'t> {
    id: Option<&'t Id>,
    is_message: bool,
    content: &'t Content,
    snapshot: &'t Snapshot,
    console: &'t Console,
    path: &'t Path,
    facts: Facts<'t>,
    now_ms: u64,
}

impl Tells<'_> {
    /// Writes a part: the first has all but the objects, of which each is a part; the last ends the text.
    fn write(&self, part: u32, json: &mut Writer<'_, '_>) -> Next {
        let objects = match self.content {
            Content::State(objects) | Content::Changed(objects) => *objects,
            _ => 0,
        };
        if part == 0 {
            self.begin(json);
        } else if let Content::Path(piece) = self.content {
            if !self.path.write(piece, part - 1, json) {
                self.end(json);
                return Next::End;
            }
        } else if matches!(self.content, Content::Help | Content::Names) {
            let macros = &self.facts.stores.macros;
            let written = match self.content {
                Content::Help => help::write(part - 1, macros, json),
                _ => macros.at((part - 1) as u16).map(|row| row.is_some_and(|row| write_macro(&row.name, json))),
            };
            match written {
                None => return Next::Later,
                Some(true) => {}
                Some(false) => {
                    self.end(json);
                    return Next::End;
                }
            }
        } else if matches!(self.content, Content::Temperatures) {
            self.facts.stores.temperatures.write(part as usize - 1, self.snapshot, json);
            if part as usize >= temperatures::PARTS {
                self.end(json);
                return Next::End;
            }
        } else if let Content::Lines(place) = self.content {
            if !self.write_line(place, part, json) {
                self.end(json);
                return Next::End;
            }
        } else if objects == 0 || part as usize > objects::PARTS {
            self.end(json);
            return Next::End;
        } else {
            let Self { snapshot: of, console, facts, .. } = *self;
            let (fault, heights) = (console.fault(), &facts.stores.heights);
            let told = objects::Told { of, fault, heights, messages: &console.messages };
            objects::write_part(part as usize - 1, objects, &told, json);
        }
        Next::Part
    }

    /// Writes the line of a part, which may be made anew. False if there is none any more.
    fn write_line(&self, place: &Cell<(u32, u32)>, part: u32, json: &mut Writer<'_, '_>) -> bool {
        let (made, mut at) = place.get();
        if part > made {
            at = self.console.next_kept(at).filter(|_| made > 0).map_or(at, |said| said.next);
            place.set((part, at));
        }
        let Some(said) = self.console.next_kept(at) else { return false };
        json.begin_object();
        pair("message", &said.text, json);
        json.key("time");
        json.number(u64::from(said.at_s));
        pair("type", if said.is_sent() { "command" } else { "response" }, json);
        json.end_object();
        true
    }

    fn begin(&self, json: &mut Writer<'_, '_>) {
        json.begin_object();
        if self.is_message {
            json.key("jsonrpc");
            json.text("2.0");
        }
        match self.content {
            Content::Changed(_) => {
                begin_notification("notify_status_update", json);
                json.begin_object();
            }
            Content::Said(at) => {
                let said = self.console.line(*at);
                let is_private = said.as_ref().is_some_and(Said::is_private);
                begin_notification(if is_private { "notify_velvet_answer" } else { "notify_gcode_response" }, json);
                json.text(said.as_ref().map_or("", |said| &said.text));
            }
            Content::Notice(method) => begin_notification(method, json),
            Content::FilesChanged => begin_notification("notify_filelist_changed", json),
            Content::Files(_) => json.key("result"),
            Content::Beat => {
                begin_notification("notify_proc_stat_update", json);
                json.begin_object();
                json.end_object();
            }
            Content::Error(code, message) => error(*code, message, json),
            Content::Refused(reason) => {
                let said = reason.filter(|at| !self.console.is_lost(*at)).and_then(|at| self.console.line(at));
                let reason = said.as_ref().map_or("the machine refused: the console says why", Said::reason);
                error(codes::REFUSED, reason, json);
            }
            Content::Access(told) if let Some(message) = told.error() => error(codes::TOO_MANY, &message, json),
            _ => {
                json.key("result");
                self.begin_result(json);
            }
        }
    }

    fn begin_result(&self, json: &mut Writer<'_, '_>) {
        let Self { snapshot, facts, .. } = self;
        match self.content {
            Content::Connection(number) | Content::Jog(number) | Content::Offset(number) => {
                json.begin_object();
                json.key(match self.content {
                    Content::Jog(_) => "id",
                    Content::Offset(_) => "offset",
                    _ => "connection_id",
                });
                json.number(u64::from(*number));
                json.end_object();
            }
            Content::Access(told) => told.write(facts.access, json),
            Content::Server => {
                json.begin_object();
                pair("klippy_state", objects::klippy_state(snapshot.state), json);
                json.key("klippy_connected");
                json.bool(true);
                json.key("components");
                json.begin_array();
                json.end_array();
                pair("moonraker_version", facts.version, json);
                pair("api_version_string", "1.5.0", json);
                json.end_object();
            }
            Content::Printer => {
                json.begin_object();
                pair("state", objects::klippy_state(snapshot.state), json);
                pair("hostname", facts.host, json);
                pair("software_version", facts.version, json);
                pair("app", "Velvet", json);
                json.end_object();
            }
            Content::Names => write_names(snapshot, json),
            Content::Help | Content::Temperatures => json.begin_object(),
            Content::Lines(_) => {
                json.begin_object();
                json.key("eventtime");
                json.fixed(self.now_ms as i64, 3);
                json.key("gcode_store");
                json.begin_array();
            }
            Content::Path(piece) => path::begin(piece, json),
            Content::State(_) => {
                json.begin_object();
                json.key("eventtime");
                json.fixed(self.now_ms as i64, 3);
                json.key("status");
                json.begin_object();
            }
            _ => json.text("ok"),
        }
    }

    fn end(&self, json: &mut Writer<'_, '_>) {
        match self.content {
            Content::State(_) => {
                json.end_object();
                json.end_object();
            }
            Content::Changed(_) => {
                json.end_object();
                json.fixed(self.now_ms as i64, 3);
                json.end_array();
            }
            Content::Path(_) | Content::Lines(_) | Content::Names => {
                json.end_array();
                json.end_object();
            }
            Content::Help | Content::Temperatures => json.end_object(),
            Content::Said(_) | Content::Notice(_) | Content::Beat | Content::FilesChanged => json.end_array(),
            _ => {}
        }
        match self.id {
            Some(Id { value: IdValue::Number(number), .. }) => {
                json.key("id");
                json.signed(*number);
            }
            Some(Id { value: IdValue::Text(text), .. }) => {
                json.key("id");
                json.text(text);
            }
            // An error that answers no call it could name (JSON-RPC 2.0 section 5).
            None if self.is_message && matches!(self.content, Content::Error(..)) => {
                json.key("id");
                json.null();
            }
            None => {}
        }
        json.end_object();
    }
}

fn error(code: i32, message: &str, json: &mut Writer<'_, '_>) {
    json.key("error");
    json.begin_object();
    json.key("code");
    json.signed(i64::from(code));
    pair("message", message, json);
    json.end_object();
}

/// Writes the name of a macro as an object's. Returns that there is one.
fn write_macro(name: &str, json: &mut Writer<'_, '_>) -> bool {
    json.begin_text();
    ["gcode_macro ", name].into_iter().for_each(|piece| json.more_text(piece));
    json.end_text();
    true
}

/// Writes the names of all objects but macros, and leaves their list open.
fn write_names(snapshot: &Snapshot, json: &mut Writer<'_, '_>) {
    json.begin_object();
    json.key("objects");
    json.begin_array();
    (0..MAX_OBJECTS).filter_map(|place| objects::name(place, snapshot)).for_each(|name| json.text(&name));
}

fn begin_notification(method: &str, json: &mut Writer<'_, '_>) {
    pair("method", method, json);
    json.key("params");
    json.begin_array();
}

fn pair(name: &str, value: &str, json: &mut Writer<'_, '_>) {
    json.key(name);
    json.text(value);
}

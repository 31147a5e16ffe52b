//! Calls of JSON-RPC 2.0, read out of messages that come in pieces.

use base::snapshot::Snapshot;
use heapless::String;
use http::Role;
use http::json::{Parser, Token};

use crate::files::{Ask, SOURCE, TARGET};
use crate::objects::{self, Objects};

/// Longest script of a call, bytes.
pub const SCRIPT_BYTES: usize = 512;
/// Longest name of a method, and longest id that is a text.
const METHOD_BYTES: usize = 40;
const ID_BYTES: usize = 24;
/// Longest name of a role.
const ROLE_BYTES: usize = 8;

/// Codes of errors (JSON-RPC 2.0 section 5.1), and Moonraker's for what the machine refuses.
pub mod codes {
    /// The message is no JSON.
    pub const PARSE: i32 = -32_700;
    /// The message is no call.
    pub const INVALID: i32 = -32_600;
    /// There is no such method.
    pub const METHOD: i32 = -32_601;
    /// Parameters are missing, or of another type.
    pub const PARAMETERS: i32 = -32_602;
    /// The machine refuses what the call asks for.
    pub const REFUSED: i32 = 400;
    /// The visitor is nobody yet.
    pub const UNKNOWN: i32 = 401;
    /// The visitor may not.
    pub const FORBIDDEN: i32 = 403;
    /// There is nothing of this name or number.
    pub const MISSING: i32 = 404;
    /// There is one already, or as many as can be.
    pub const TAKEN: i32 = 409;
    /// Too many attempts came.
    pub const TOO_MANY: i32 = 429;
    /// The board could not do it.
    pub const FAILED: i32 = 500;
    /// There is no place for the call at present.
    pub const BUSY: i32 = 503;
}

/// Id of a call, which its answer repeats.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Id {
    /// Number that the caller has counted.
    Number(i64),
    /// Text of the caller's own.
    Text(String<ID_BYTES>),
}

/// Method of a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    Identify,
    AccessInfo,
    Login,
    Logout,
    GetUser,
    SetPassword,
    MakeKey,
    ListKeys,
    RevokeKey,
    ServerInfo,
    PrinterInfo,
    ListObjects,
    QueryObjects,
    Subscribe,
    Script,
    /// Lines whose answers are for the caller alone.
    Ask,
    EmergencyStop,
    Pause,
    Resume,
    Cancel,
    /// Release from a halt.
    Release,
    Play,
    Home,
    JogStep,
    JogStart,
    JogBeat,
    JogStop,
    Override,
    PathSince,
    /// Temperatures of the last minutes.
    Temperatures,
    /// Lines of the console from before.
    Lines,
    Help,
    /// Question about files, or a change of them.
    Files(Ask),
}

/// All methods by their names.
pub const METHODS: [(&str, Method); 39] = [
    ("server.files.list", Method::Files(Ask::List)),
    ("server.files.get_directory", Method::Files(Ask::Directory)),
    ("server.files.metadata", Method::Files(Ask::Metadata)),
    ("server.files.post_directory", Method::Files(Ask::MakeFolder)),
    ("server.files.move", Method::Files(Ask::Move)),
    ("server.files.delete_file", Method::Files(Ask::RemoveFile)),
    ("server.files.delete_directory", Method::Files(Ask::RemoveFolder(false))),
    ("access.info", Method::AccessInfo),
    ("access.login", Method::Login),
    ("access.logout", Method::Logout),
    ("access.get_user", Method::GetUser),
    ("access.post_api_key", Method::MakeKey),
    ("velvet.keys.list", Method::ListKeys),
    ("velvet.keys.revoke", Method::RevokeKey),
    ("velvet.password.set", Method::SetPassword),
    ("printer.firmware_restart", Method::Release),
    ("printer.print.start", Method::Play),
    ("velvet.ask", Method::Ask),
    ("velvet.home", Method::Home),
    ("velvet.jog.step", Method::JogStep),
    ("velvet.jog.start", Method::JogStart),
    ("velvet.jog.beat", Method::JogBeat),
    ("velvet.jog.stop", Method::JogStop),
    ("velvet.override.set", Method::Override),
    ("velvet.path.since", Method::PathSince),
    ("server.temperature_store", Method::Temperatures),
    ("server.gcode_store", Method::Lines),
    ("printer.gcode.help", Method::Help),
    ("server.connection.identify", Method::Identify),
    ("server.info", Method::ServerInfo),
    ("printer.info", Method::PrinterInfo),
    ("printer.objects.list", Method::ListObjects),
    ("printer.objects.query", Method::QueryObjects),
    ("printer.objects.subscribe", Method::Subscribe),
    ("printer.gcode.script", Method::Script),
    ("printer.emergency_stop", Method::EmergencyStop),
    ("printer.print.pause", Method::Pause),
    ("printer.print.resume", Method::Resume),
    ("printer.print.cancel", Method::Cancel),
];

impl Method {
    /// Returns the least role that may call the method.
    #[must_use]
    pub const fn least_role(self) -> Role {
        match self {
            Self::Identify | Self::AccessInfo | Self::Login | Self::Logout | Self::GetUser | Self::SetPassword => {
                Role::Nobody
            }
            Self::ServerInfo
            | Self::PrinterInfo
            | Self::ListObjects
            | Self::QueryObjects
            | Self::Subscribe
            | Self::PathSince
            | Self::Temperatures
            | Self::Lines
            | Self::Ask
            | Self::Help
            | Self::EmergencyStop
            | Self::Files(Ask::List | Ask::Directory | Ask::Metadata) => Role::Watch,
            Self::Script
            | Self::Pause
            | Self::Resume
            | Self::Cancel
            | Self::Release
            | Self::Play
            | Self::Home
            | Self::JogStep
            | Self::JogStart
            | Self::JogBeat
            | Self::JogStop
            | Self::Override
            | Self::Files(Ask::MakeFolder) => Role::Operate,
            Self::MakeKey
            | Self::ListKeys
            | Self::RevokeKey
            | Self::Files(Ask::Move | Ask::RemoveFile | Ask::RemoveFolder(_)) => Role::Own,
        }
    }

    /// Returns whether the method is about who may what.
    #[must_use]
    pub const fn is_about_access(self) -> bool {
        matches!(
            self,
            Self::AccessInfo
                | Self::Login
                | Self::Logout
                | Self::GetUser
                | Self::SetPassword
                | Self::MakeKey
                | Self::ListKeys
                | Self::RevokeKey
        )
    }

    /// Returns the method of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        METHODS.iter().find(|(known, _)| *known == name).map(|(_, method)| *method)
    }
}

/// A call that is whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Call {
    /// Method that is called.
    pub method: Method,
    /// Objects that it is about.
    pub objects: Objects,
    /// Whether its text is a code that the machine shows.
    pub is_code: bool,
    numbers: [Option<f64>; QUANTITIES],
}

impl Call {
    /// Returns a number of the call.
    #[must_use]
    pub fn number(&self, quantity: Quantity) -> Option<f64> {
        self.numbers.get(quantity as usize).copied().flatten()
    }
}

/// Member of a call that is being read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Member {
    #[default]
    Other,
    Method,
    Id,
    Params,
}

impl Member {
    fn named(key: &str) -> Self {
        match key {
            "method" => Self::Method,
            "id" => Self::Id,
            "params" => Self::Params,
            _ => Self::Other,
        }
    }
}

/// Parameter that is being read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Parameter {
    #[default]
    Other,
    Objects,
    Text,
    Force,
    /// Role that a key is to give.
    Role,
    Number(Quantity),
}

impl Parameter {
    fn named(key: &str) -> Self {
        match key {
            "objects" => Self::Objects,
            "script" | "filename" | "axes" | "axis" | "path" | "root" | "source" | "dest" | "password" | "name"
            | "code" => Self::Text,
            "role" => Self::Role,
            "force" => Self::Force,
            key => Quantity::named(key).map_or(Self::Other, Self::Number),
        }
    }
}

/// Returns the mark that stands before a text in the text of a call that has two.
fn mark_of(key: &str) -> Option<char> {
    match key {
        "source" => Some(SOURCE),
        "dest" => Some(TARGET),
        _ => None,
    }
}

/// Number among the parameters of a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Distance to jog, mm.
    Mm,
    /// Speed, mm per minute.
    MmPerMin,
    /// Share of feed rates; 1 is as programmed.
    Feed,
    /// Direction of a jog: 1 or -1.
    Direction,
    /// Number of a jog.
    Id,
    /// Number of a place on the path.
    Seq,
    /// Share of the speed of rapids, and of the spindle's.
    Rapid,
    Spindle,
    /// Number of lines that are wanted.
    Count,
}

/// Count of the quantities.
const QUANTITIES: usize = 9;

impl Quantity {
    fn named(key: &str) -> Option<Self> {
        match key {
            "mm" => Some(Self::Mm),
            "mm_per_min" => Some(Self::MmPerMin),
            "feed" => Some(Self::Feed),
            "direction" => Some(Self::Direction),
            "id" => Some(Self::Id),
            "seq" => Some(Self::Seq),
            "rapid" => Some(Self::Rapid),
            "spindle" => Some(Self::Spindle),
            "count" => Some(Self::Count),
            _ => None,
        }
    }
}

/// Reader of a call.
#[derive(Clone, Debug)]
pub struct Reader {
    parser: Parser,
    member: Member,
    parameter: Parameter,
    /// Method whose parameters are all of the message: the body of a request over HTTP.
    preset: Option<Method>,
    method: String<METHOD_BYTES>,
    /// Id, once it was read.
    pub id: Option<Id>,
    objects: Objects,
    /// Text that the call is about: a script, the name of a file, axes.
    pub text: String<SCRIPT_BYTES>,
    /// Name of the role that a key is to give.
    pub role: String<ROLE_BYTES>,
    /// Numbers of the call, by [`Quantity`].
    numbers: [Option<f64>; QUANTITIES],
    flags: Flags,
}

/// Truths about a call.
#[derive(Clone, Copy, Debug)]
struct Flags {
    /// Whether a folder is to be removed with all that it holds.
    is_forced: bool,
    /// Whether its text is a code that the machine shows.
    is_code: bool,
    /// Whether something was longer than there is room for, and whether the message is no JSON.
    is_too_long: bool,
    is_broken: bool,
    /// Whether any of it has come.
    has_begun: bool,
}

impl Default for Reader {
    fn default() -> Self {
        Self::new()
    }
}

impl Reader {
    /// Makes a reader for a message that begins.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            parser: Parser::new(),
            member: Member::Other,
            parameter: Parameter::Other,
            preset: None,
            method: String::new(),
            id: None,
            objects: 0,
            text: String::new(),
            role: String::new(),
            numbers: [None; QUANTITIES],
            flags: Flags { is_forced: false, is_code: false, is_too_long: false, is_broken: false, has_begun: false },
        }
    }

    /// Makes a reader for the parameters of this method, which are the body of a request.
    #[must_use]
    pub const fn of(method: Method) -> Self {
        let mut reader = Self::new();
        (reader.member, reader.preset) = (Member::Params, Some(method));
        reader
    }

    /// Takes a piece of the message.
    pub fn read(&mut self, mut bytes: &[u8], of: &Snapshot) {
        let Self { parser, member, parameter, preset, method, id, objects, text: about, role, numbers, flags } = self;
        let Flags { is_forced, is_code, is_too_long, is_broken, has_begun } = flags;
        *has_begun |= !bytes.is_empty();
        loop {
            // Parameters that are all of the message stand where others have theirs.
            let depth = parser.depth() + usize::from(preset.is_some());
            let token = match parser.next(&mut bytes) {
                Ok(Some(token)) => token,
                Ok(None) => return,
                Err(_) => {
                    *is_broken = true;
                    return;
                }
            };
            match (depth, token) {
                (1, Token::Key(key)) if preset.is_none() => {
                    *member = Member::named(key);
                }
                (1, Token::Text(text, _)) if *member == Member::Method => {
                    *is_too_long |= method.push_str(text).is_err()
                }
                (1, Token::Text(text, _)) if *member == Member::Id => *is_too_long |= add_to_id(id, text),
                (1, Token::Number(number)) if *member == Member::Id => *id = number.as_i64().map(Id::Number),
                (2, Token::Key(key)) if *member == Member::Params => {
                    *parameter = Parameter::named(key);
                    *is_code |= key == "code";
                    if let Some(mark) = mark_of(key) {
                        *is_too_long |= about.push(mark).is_err();
                    }
                }
                (2, Token::Text(text, _)) if *member == Member::Params && *parameter == Parameter::Text => {
                    *is_too_long |= about.push_str(text).is_err();
                }
                (2, Token::Bool(is_set)) if *member == Member::Params && *parameter == Parameter::Force => {
                    *is_forced = is_set;
                }
                (2, Token::Text(text, _)) if *member == Member::Params && *parameter == Parameter::Role => {
                    *is_too_long |= role.push_str(text).is_err();
                }
                (2, Token::Number(number)) if *member == Member::Params => {
                    if let Parameter::Number(quantity) = *parameter
                        && let Some(place) = numbers.get_mut(quantity as usize)
                    {
                        *place = Some(number.as_f64());
                    }
                }
                (3, Token::Key(name)) if *member == Member::Params && *parameter == Parameter::Objects => {
                    *objects |= objects::named(name, of);
                }
                _ => {}
            }
        }
    }

    /// Ends the message. Returns its call.
    ///
    /// # Errors
    /// Code and text of the error, when the message is no call.
    pub fn end(&mut self) -> Result<Call, (i32, &'static str)> {
        // A request without a body has no parameters.
        let is_empty = self.preset.is_some() && !self.flags.has_begun;
        if self.flags.is_broken || !is_empty && self.parser.finish().is_err() {
            return Err((codes::PARSE, "the message is no JSON"));
        }
        if self.flags.is_too_long {
            return Err((codes::INVALID, "the call is too long: send scripts of more than 512 bytes as a file"));
        }
        if self.method.is_empty() && self.preset.is_none() {
            return Err((codes::INVALID, "the message names no method; batches are not taken"));
        }
        let method = self.preset.or_else(|| Method::named(&self.method));
        let method = match method.ok_or((codes::METHOD, "there is no such method"))? {
            Method::Files(Ask::RemoveFolder(_)) => Method::Files(Ask::RemoveFolder(self.flags.is_forced)),
            method => method,
        };
        Ok(Call { method, objects: self.objects, is_code: self.flags.is_code, numbers: self.numbers })
    }
}

/// Adds a piece of text to an id. Returns whether it is too long.
fn add_to_id(id: &mut Option<Id>, text: &str) -> bool {
    match id {
        Some(Id::Text(id)) => id.push_str(text).is_err(),
        Some(Id::Number(_)) | None => {
            let first = String::try_from(text);
            let is_too_long = first.is_err();
            *id = Some(Id::Text(first.unwrap_or_default()));
            is_too_long
        }
    }
}

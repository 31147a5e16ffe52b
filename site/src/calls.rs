//! Calls of JSON-RPC 2.0, read out of messages that come in pieces.

use heapless::String;
use http::Role;

use crate::files::Ask;
use crate::objects::Objects;

mod reader;

pub use reader::{Calls, Reader};

/// Longest script of a call, bytes.
pub const SCRIPT_BYTES: usize = 512;
/// Longest id that is a text, bytes.
const ID_BYTES: usize = 24;

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
pub struct Id {
    /// Number or text of the id.
    pub value: IdValue,
    /// Whether the call is one of several in a message, which are answered together.
    pub is_of_batch: bool,
}

impl Id {
    /// Makes the id of a call that stands alone.
    #[must_use]
    pub const fn of(value: IdValue) -> Self {
        Self { value, is_of_batch: false }
    }
}

/// Number or text of an id.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum IdValue {
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

    /// Returns whether the method is about who may what, and answered later or with a cookie.
    #[must_use]
    pub const fn waits(self) -> bool {
        self.is_about_access() && !matches!(self, Self::AccessInfo | Self::GetUser | Self::ListKeys)
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

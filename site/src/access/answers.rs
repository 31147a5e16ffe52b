//! Answers to calls about access: who the visitor is, how to log in, keys.

use core::fmt::Write as _;

use heapless::String;
use http::json::Writer;
use http::{Fields, SetCookie};

use super::{Access, CODE_S, Pass, Random, SESSION_S, text_of};
use crate::role_names;

/// Name of the cookie that has a session's token.
pub const COOKIE: &str = "velvet";
/// Name of the one user, whom the password is for.
const OWNER: &str = "owner";

/// Content of an answer about access.
#[derive(Clone, Copy, Debug)]
pub enum Told {
    /// Steps by which a visitor with this proof gets in: the answer to `access.info`.
    Info(Pass),
    /// Name and role of the visitor with this proof.
    User(Pass),
    /// The visitor has logged in; over HTTP with the token of a session.
    LoggedIn(Option<Random>),
    /// The visitor has logged out.
    LoggedOut,
    /// The new key, which is shown this once.
    Key(Random),
    /// All keys, by their names.
    Keys,
    /// A code is shown at the machine.
    Confirm,
    /// Error: so many seconds to wait.
    Wait(u32),
}

impl Told {
    /// Adds the header lines of an answer over HTTP: the cookie of a session.
    pub fn fields(&self, fields: &mut Fields<'_, '_>) {
        match self {
            Self::LoggedIn(Some(token)) => {
                fields.cookie(&SetCookie { name: COOKIE, value: &text_of(token), max_age_s: SESSION_S });
            }
            Self::LoggedOut => fields.cookie(&SetCookie { name: COOKIE, value: "", max_age_s: 0 }),
            _ => {}
        }
    }

    /// Returns the text of the error that this is, if it is one.
    #[must_use]
    pub fn error(&self) -> Option<String<64>> {
        let Self::Wait(seconds) = self else { return None };
        let mut text = String::new();
        // The text and ten digits have room.
        let _ = write!(text, "too many attempts came: try again in {seconds} s");
        Some(text)
    }

    /// Writes the result of the call as JSON.
    pub fn write(&self, access: &Access, json: &mut Writer<'_, '_>) {
        match self {
            Self::Info(pass) => info(*pass, access, json),
            Self::User(pass) => user(*pass, access, json),
            Self::LoggedIn(_) => {
                json.begin_object();
                pair("username", OWNER, json);
                pair("role", role_names::name(http::Role::Own), json);
                pair("action", "user_logged_in", json);
                json.end_object();
            }
            Self::LoggedOut => {
                json.begin_object();
                pair("username", OWNER, json);
                pair("action", "user_logged_out", json);
                json.end_object();
            }
            Self::Key(random) => json.text(&text_of(random)),
            Self::Keys => {
                json.begin_object();
                json.key("keys");
                json.begin_array();
                for key in access.keys.iter() {
                    json.begin_object();
                    pair("name", &key.name, json);
                    pair("role", role_names::name(key.role), json);
                    json.end_object();
                }
                json.end_array();
                json.end_object();
            }
            Self::Confirm => {
                json.begin_object();
                pair("state", "confirm", json);
                pair("shown_on", "consoles", json);
                json.key("expires_s");
                json.number(CODE_S);
                json.end_object();
            }
            Self::Wait(_) => json.null(),
        }
    }
}

fn info(pass: Pass, access: &Access, json: &mut Writer<'_, '_>) {
    json.begin_object();
    json.key("login_required");
    json.bool(access.without() == http::Role::Nobody);
    json.key("password_set");
    json.bool(access.has_password);
    pair("role", role_names::name(access.role(pass)), json);
    pair("default_source", "velvet", json);
    json.key("available_sources");
    json.begin_array();
    json.text("velvet");
    json.end_array();
    json.end_object();
}

fn user(pass: Pass, access: &Access, json: &mut Writer<'_, '_>) {
    json.begin_object();
    json.key("username");
    match pass {
        Pass::Session(_) | Pass::Socket(_) if !access.has_ended(pass) => json.text(OWNER),
        Pass::Key(number) => match access.keys.get(number) {
            Some(key) => json.text(&key.name),
            None => json.null(),
        },
        _ => json.null(),
    }
    pair("source", "velvet", json);
    json.key("created_on");
    json.number(0);
    pair("role", role_names::name(access.role(pass)), json);
    json.end_object();
}

fn pair(name: &str, value: &str, json: &mut Writer<'_, '_>) {
    json.key(name);
    json.text(value);
}

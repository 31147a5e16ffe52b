//! Reader of calls, one or several of a message.

use base::snapshot::Snapshot;
use heapless::String;
use http::json::{Parser, Token};

use super::{Call, Id, IdValue, Method, QUANTITIES, Quantity, SCRIPT_BYTES, codes};
use crate::files::{Ask, SOURCE, TARGET};
use crate::objects::{self, Objects};

/// Longest name of a method, bytes.
const METHOD_BYTES: usize = 40;
/// Longest name of a role, bytes.
const ROLE_BYTES: usize = 8;

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
    /// Calls so far, where the message is an array of them.
    batch: Option<Calls>,
}

/// Calls of a message that has several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Calls {
    /// So many were carried out.
    Taken(u8),
    /// No more are taken.
    Enough,
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

impl Flags {
    const NONE: Self =
        Self { is_forced: false, is_code: false, is_too_long: false, is_broken: false, has_begun: false };
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
            flags: Flags::NONE,
            batch: None,
        }
    }

    /// Makes a reader for the parameters of this method, which are the body of a request.
    #[must_use]
    pub const fn of(method: Method) -> Self {
        let mut reader = Self::new();
        (reader.member, reader.preset) = (Member::Params, Some(method));
        reader
    }

    /// Returns whether this reads calls, and not the parameters of one.
    #[must_use]
    pub const fn is_of_calls(&self) -> bool {
        self.preset.is_none()
    }

    /// Returns what was made of the calls before, where the message has several.
    #[must_use]
    pub const fn batch(&self) -> Option<Calls> {
        self.batch
    }

    /// Begins with the next call of a message that has several.
    pub fn begin_next(&mut self, before: Calls) {
        let parser = core::mem::take(&mut self.parser);
        *self = Self { parser, batch: Some(before), ..Self::new() };
    }

    /// Takes a piece of the message. Returns whether one of several calls is whole, behind which there may be
    /// more: see [`Self::end_call`].
    pub fn read(&mut self, bytes: &mut &[u8], of: &Snapshot) -> bool {
        let Self { parser, member, parameter, preset, method, id, objects, text: about, role, numbers, flags, batch } =
            self;
        let Flags { is_forced, is_code, is_too_long, is_broken, has_begun } = flags;
        *has_begun |= !bytes.is_empty();
        loop {
            // Parameters that are all of the message stand where others have theirs.
            let depth = (parser.depth() + usize::from(preset.is_some())).wrapping_sub(usize::from(batch.is_some()));
            let token = match parser.next(bytes) {
                Ok(Some(token)) => token,
                Ok(None) => return false,
                Err(_) => {
                    *is_broken = true;
                    return false;
                }
            };
            if batch.is_some() && is_whole(depth, &token) {
                return true;
            }
            match (depth, token) {
                (0, Token::BeginArray) if preset.is_none() && batch.is_none() => *batch = Some(Calls::Taken(0)),
                (1, Token::Key(key)) if preset.is_none() => {
                    *member = Member::named(key);
                }
                (1, Token::Text(text, _)) if *member == Member::Method => {
                    *is_too_long |= method.push_str(text).is_err()
                }
                (1, Token::Text(text, _)) if *member == Member::Id => *is_too_long |= add_to_id(id, text),
                (1, Token::Number(number)) if *member == Member::Id => {
                    *id = number.as_i64().map(|number| Id::of(IdValue::Number(number)));
                }
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
        if !is_empty {
            self.finish()?;
        }
        self.end_call()
    }

    /// Ends the message.
    ///
    /// # Errors
    /// Code and text of the error, when the message is no JSON.
    pub fn finish(&mut self) -> Result<(), (i32, &'static str)> {
        if self.flags.is_broken || self.parser.finish().is_err() {
            return Err((codes::PARSE, "the message is no JSON"));
        }
        Ok(())
    }

    /// Returns the call that is whole.
    ///
    /// # Errors
    /// Code and text of the error, when it is no call.
    pub fn end_call(&mut self) -> Result<Call, (i32, &'static str)> {
        if self.flags.is_too_long {
            return Err((codes::INVALID, "the call is too long: send scripts of more than 512 bytes as a file"));
        }
        if self.method.is_empty() && self.preset.is_none() {
            return Err((codes::INVALID, "the message names no method"));
        }
        let method = self.preset.or_else(|| Method::named(&self.method));
        let method = match method.ok_or((codes::METHOD, "there is no such method"))? {
            Method::Files(Ask::RemoveFolder(_)) => Method::Files(Ask::RemoveFolder(self.flags.is_forced)),
            method => method,
        };
        Ok(Call { method, objects: self.objects, is_code: self.flags.is_code, numbers: self.numbers })
    }
}

/// Returns whether one of several calls ends with a token. What is no object is no call, and is answered as
/// such.
const fn is_whole(depth: usize, token: &Token<'_>) -> bool {
    match token {
        Token::EndObject | Token::EndArray => depth == 1,
        Token::Text(_, true) | Token::Number(_) | Token::Bool(_) | Token::Null => depth == 0,
        _ => false,
    }
}

/// Adds a piece of text to an id. Returns whether it is too long.
fn add_to_id(id: &mut Option<Id>, text: &str) -> bool {
    match id {
        Some(Id { value: IdValue::Text(id), .. }) => id.push_str(text).is_err(),
        Some(Id { value: IdValue::Number(_), .. }) | None => {
            let first = String::try_from(text);
            let is_too_long = first.is_err();
            *id = Some(Id::of(IdValue::Text(first.unwrap_or_default())));
            is_too_long
        }
    }
}

//! Head of a request (RFC 9112, sections 2 to 5): found whole, then read strictly, as what a proxy and we
//! might read differently is refused (section 11.2, request smuggling).

use core::ops::Range;

use super::body::Length;
use super::query::Query;
use crate::limits::{HEADERS, TARGET_BYTES};
use crate::method::Method;
use crate::percent;
use crate::status::Status;

/// Place of a head among bytes that have arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scan {
    /// More bytes are needed.
    Open,
    /// The head has so many bytes.
    Whole(usize),
    /// No head begins like this.
    Broken,
}

/// Looks for the end of a head, behind what has been looked at. Lines must end with CR and LF, and no other
/// control character but the tabulator may occur: what is no HTTP is known by its first bytes.
#[must_use]
pub fn scan(bytes: &[u8], looked: usize) -> Scan {
    for (at, byte) in bytes.iter().enumerate().skip(looked) {
        let before = |back: usize| at.checked_sub(back).and_then(|at| bytes.get(at)).copied();
        match (before(1), *byte) {
            (Some(b'\r'), b'\n') if before(2) == Some(b'\n') && before(3) == Some(b'\r') => return Scan::Whole(at + 1),
            (Some(b'\r'), b'\n') => {}
            (Some(b'\r'), _) | (_, b'\n' | 0..=8 | 11..=12 | 14..=31 | 127) => return Scan::Broken,
            _ => {}
        }
    }
    Scan::Open
}

/// Protocol that a request asks its connection to go on with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Upgrade {
    /// Nothing, or a protocol that is not spoken here.
    None,
    /// WebSocket, by RFC 6455.
    WebSocket,
}

/// Facts of a head that the connection has to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Head {
    /// Method of the request.
    pub method: Method,
    /// Length of the body.
    pub length: Length,
    /// Whether the connection is to stay.
    pub keeps: bool,
    /// Whether the peer speaks HTTP/1.0 alone.
    pub is_old: bool,
    /// Whether the peer waits for 100 (Continue) before it sends the body.
    pub expects: bool,
    /// Protocol that the connection is to go on with.
    pub upgrade: Upgrade,
}

/// Request whose head is whole.
#[derive(Clone, Copy, Debug)]
pub struct Request<'b> {
    /// Facts that the connection knows too.
    pub head: Head,
    /// Path, decoded once: it begins with a slash, and holds no segment that is empty (but for the last), "."
    /// or "..", no backslash and no control character.
    pub path: &'b str,
    /// Parameters behind the question mark, encoded.
    pub query: Query<'b>,
    fields: &'b [u8],
}

impl<'b> Request<'b> {
    /// Returns the value of the first header line of this name.
    #[must_use]
    pub fn header(&self, name: &str) -> Option<&'b str> {
        fields(self.fields).find(|(known, _)| known.eq_ignore_ascii_case(name.as_bytes())).and_then(|(_, value)| {
            let value = core::str::from_utf8(value).ok()?;
            Some(value.trim_ascii())
        })
    }

    /// Reads a head, and decodes its path in place.
    ///
    /// # Errors
    /// The status that the request is to be refused with.
    pub fn read(bytes: &'b mut [u8]) -> Result<Self, Status> {
        let (head, target, begin) = read(bytes)?;
        let (line, fields) = bytes.split_at_mut_checked(begin).ok_or(Status::BadRequest)?;
        let target = line.get_mut(target).ok_or(Status::BadRequest)?;
        let length = target.iter().position(|byte| *byte == b'?').unwrap_or(target.len());
        let (path, query) = target.split_at_mut_checked(length).ok_or(Status::BadRequest)?;
        let path = percent::decode_in_place(path, false).filter(|path| is_normal(path)).ok_or(Status::BadRequest)?;
        let query = core::str::from_utf8(query.get(1..).unwrap_or_default()).map_err(|_| Status::BadRequest)?;
        Ok(Self { head, path, query: Query::new(query), fields })
    }
}

/// Returns whether a path can mean one thing only.
fn is_normal(path: &str) -> bool {
    if path == "/" || path == "*" {
        return true;
    }
    let Some(path) = path.strip_prefix('/') else { return false };
    let mut segments = path.strip_suffix('/').unwrap_or(path).split('/');
    segments.all(|segment| !matches!(segment, "" | "." | "..")) && !path.chars().any(|c| c.is_control() || c == '\\')
}

/// Header lines of a head that was read: name and value, with its spaces.
fn fields(lines: &[u8]) -> impl Iterator<Item = (&[u8], &[u8])> {
    lines.split(|byte| *byte == b'\n').filter_map(|line| {
        let line = line.strip_suffix(b"\r")?;
        let colon = line.iter().position(|byte| *byte == b':')?;
        Some((line.get(..colon)?, line.get(colon + 1..)?))
    })
}

/// Reads a head: what the connection has to know, where the target is, where the header lines begin.
fn read(bytes: &[u8]) -> Result<(Head, Range<usize>, usize), Status> {
    let mut headers = [httparse::EMPTY_HEADER; HEADERS];
    let mut parsed = httparse::Request::new(&mut headers);
    match parsed.parse(bytes) {
        Ok(httparse::Status::Complete(length)) if length == bytes.len() => {}
        Ok(_) => return Err(Status::BadRequest),
        Err(httparse::Error::TooManyHeaders) => return Err(Status::RequestHeaderFieldsTooLarge),
        Err(httparse::Error::Version) => return Err(Status::HttpVersionNotSupported),
        Err(_) => return Err(Status::BadRequest),
    }
    let (Some(name), Some(target), Some(minor)) = (parsed.method, parsed.path, parsed.version) else {
        return Err(Status::BadRequest);
    };
    if target.len() > TARGET_BYTES {
        return Err(Status::UriTooLong);
    }
    let method = Method::named(name).ok_or(Status::NotImplemented)?;
    let mut facts = Facts::default();
    for header in parsed.headers.iter() {
        facts.note(header.name, header.value)?;
    }
    let (authority, path) = split(target, method)?;
    if let Some(authority) = authority
        && facts.host != Some(authority.as_bytes())
    {
        return Err(Status::BadRequest);
    }
    let head = facts.head(method, minor == 0)?;
    let start = name.len() + 1 + target.len() - path.len();
    let begin = bytes.iter().position(|byte| *byte == b'\n').map_or(bytes.len(), |at| at + 1);
    Ok((head, start..start + path.len(), begin))
}

/// Splits a target into the authority, where it has one (RFC 9112, section 3.2), and the rest.
fn split(target: &str, method: Method) -> Result<(Option<&str>, &str), Status> {
    if !target.is_ascii() || target.contains('#') {
        return Err(Status::BadRequest);
    }
    if target.starts_with('/') || target == "*" && method == Method::Options {
        return Ok((None, target));
    }
    let rest = target.strip_prefix("http://").ok_or(Status::BadRequest)?;
    let slash = rest.find('/').ok_or(Status::BadRequest)?;
    let (authority, path) = rest.split_at_checked(slash).ok_or(Status::BadRequest)?;
    Ok((Some(authority), path))
}

/// Header lines that are looked at. Of the first [`SINGLE`] there may be one at the most, as they decide who
/// asks, for what, and how much of it.
const NAMES: [&str; 15] = [
    "host",
    "content-length",
    "transfer-encoding",
    "expect",
    "content-type",
    "origin",
    "authorization",
    "x-api-key",
    "cookie",
    "range",
    "sec-websocket-key",
    "sec-websocket-version",
    "sec-fetch-site",
    "connection",
    "upgrade",
];
/// Number of names that may be there once.
const SINGLE: usize = 13;

/// Facts that header lines say.
#[derive(Default)]
struct Facts<'b> {
    /// Lines of [`NAMES`] that were there, a bit each.
    seen: u16,
    host: Option<&'b [u8]>,
    length: Option<u64>,
    is_chunked: bool,
    closes: bool,
    keeps: bool,
    upgrades: bool,
    to_websocket: bool,
    expects: bool,
}

impl<'b> Facts<'b> {
    /// Notes a header line.
    fn note(&mut self, name: &str, value: &'b [u8]) -> Result<(), Status> {
        let Some(place) = NAMES.iter().position(|known| name.eq_ignore_ascii_case(known)) else { return Ok(()) };
        let bit = 1 << place;
        if place < SINGLE && self.seen & bit != 0 {
            return Err(Status::BadRequest);
        }
        self.seen |= bit;
        match NAMES.get(place).copied().unwrap_or_default() {
            "host" => self.host = Some(value),
            "content-length" => self.length = Some(decimal(value).ok_or(Status::BadRequest)?),
            "transfer-encoding" if value.eq_ignore_ascii_case(b"chunked") => self.is_chunked = true,
            "transfer-encoding" => return Err(Status::NotImplemented),
            "expect" if value.eq_ignore_ascii_case(b"100-continue") => self.expects = true,
            "expect" => return Err(Status::ExpectationFailed),
            "connection" => {
                self.closes |= has_token(value, b"close");
                self.keeps |= has_token(value, b"keep-alive");
                self.upgrades |= has_token(value, b"upgrade");
            }
            "upgrade" => self.to_websocket |= has_token(value, b"websocket"),
            _ => {}
        }
        Ok(())
    }

    fn head(&self, method: Method, is_old: bool) -> Result<Head, Status> {
        if self.host.is_none() && !is_old {
            return Err(Status::BadRequest);
        }
        let length = match (self.is_chunked, self.length) {
            (true, None) if !is_old => Length::Chunked,
            (true, _) => return Err(Status::BadRequest),
            (false, Some(length)) => Length::Known(length),
            // Without either there is no body: what has to have one is to say so.
            (false, None) if matches!(method, Method::Put) => return Err(Status::LengthRequired),
            (false, None) => Length::Known(0),
        };
        let upgrade = if self.upgrades && self.to_websocket && !is_old { Upgrade::WebSocket } else { Upgrade::None };
        Ok(Head {
            method,
            length,
            keeps: if is_old { self.keeps && !self.closes } else { !self.closes },
            is_old,
            expects: self.expects && !is_old && length != Length::Known(0),
            upgrade,
        })
    }
}

/// Reads a decimal number of at most 15 digits, and of nothing else.
fn decimal(text: &[u8]) -> Option<u64> {
    if text.is_empty() || text.len() > 15 || !text.iter().all(u8::is_ascii_digit) {
        return None;
    }
    Some(text.iter().fold(0, |number, digit| number * 10 + u64::from(digit - b'0')))
}

/// Returns whether a list holds the token, in letters of any case.
fn has_token(list: &[u8], token: &[u8]) -> bool {
    list.split(|byte| *byte == b',').any(|item| item.trim_ascii().eq_ignore_ascii_case(token))
}

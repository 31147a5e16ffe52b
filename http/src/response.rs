//! Heads of answers: status and header lines.

use crate::fields::Fields;
use crate::method::Methods;
use crate::security;
use crate::status::Status;
use crate::window::Window;

/// Validator of a representation (RFC 9110, section 8.8.3): a number that changes with its bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EntityTag(pub u64);

impl EntityTag {
    /// Writes the tag as it stands in a header line.
    pub(crate) fn put(self, window: &mut Window<'_>) {
        window.put(b"\"");
        window.hex(self.0);
        window.put(b"\"");
    }
}

/// Length of an answer's body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// So many bytes, said before the first one.
    Known(u64),
    /// Nobody knows before the end.
    Open,
}

/// Permission for browsers to keep an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cache {
    /// Nothing: it says how the machine is.
    Never,
    /// Browsers keep the answer, and ask each time whether it is still so.
    Ask,
    /// Browsers keep the answer for good: another content has another name.
    Always,
}

/// Part of a representation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Number of the first byte.
    pub first: u64,
    /// Number of the last byte.
    pub last: u64,
}

/// Head of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Response {
    /// Status of the answer.
    pub status: Status,
    /// Type of the content, empty where there is none.
    pub content_type: &'static str,
    /// Length of the body.
    pub extent: Extent,
    /// Permission for browsers to keep the answer.
    pub cache: Cache,
    /// Validator of the content.
    pub tag: Option<EntityTag>,
    /// Whether the content is compressed by gzip.
    pub is_gzip: bool,
    /// Whether parts of the content can be asked for.
    pub has_parts: bool,
    /// Part of the content that this is; with the length of the whole it says what was refused with 416.
    pub part: Option<Part>,
    /// Length of the whole content, where this is a part or was to be one.
    pub whole: u64,
    /// Methods that the path knows, with 405.
    pub allow: Methods,
    /// Time after which to try again, seconds; 0 where nothing is to be said.
    pub retry_s: u16,
}

impl Response {
    /// Makes a head without content. Never inlined: there are dozens of callers, and a field takes an
    /// instruction.
    #[inline(never)]
    #[must_use]
    pub const fn new(status: Status) -> Self {
        Self {
            status,
            content_type: "",
            extent: Extent::Known(0),
            cache: Cache::Never,
            tag: None,
            is_gzip: false,
            has_parts: false,
            part: None,
            whole: 0,
            allow: Methods::NONE,
            retry_s: 0,
        }
    }

    /// Makes a head with content.
    #[must_use]
    pub const fn of(status: Status, content_type: &'static str, extent: Extent) -> Self {
        let mut response = Self::new(status);
        response.content_type = content_type;
        response.extent = extent;
        response
    }

    /// Makes the head of an answer in JSON whose length nobody knows. Never inlined, as [`Self::new`].
    #[inline(never)]
    #[must_use]
    pub const fn json(status: Status) -> Self {
        Self::of(status, "application/json", Extent::Open)
    }

    /// Returns whether a body follows the head, unless HEAD was asked for.
    pub(crate) fn has_body(&self) -> bool {
        !self.status.is_bare() && self.extent != Extent::Known(0)
    }

    /// Writes the head up to the last line, which [`end`] writes.
    pub(crate) fn write(&self, window: &mut Window<'_>) {
        window.text("HTTP/1.1 ");
        window.number(u64::from(self.status.code()));
        window.text(" ");
        window.text(self.status.reason());
        window.text("\r\n");
        let mut fields = Fields::new(window);
        if !self.content_type.is_empty() {
            fields.line("Content-Type", self.content_type);
            for (name, value) in security::LINES {
                fields.line(name, value);
            }
        }
        if self.is_gzip {
            fields.line("Content-Encoding", "gzip");
        }
        if self.status != Status::SwitchingProtocols {
            fields.line(
                "Cache-Control",
                match self.cache {
                    Cache::Never => "no-store",
                    Cache::Ask => "no-cache",
                    Cache::Always => "public, max-age=31536000, immutable",
                },
            );
        }
        if let Some(tag) = self.tag {
            fields.parts("ETag", |window| tag.put(window));
        }
        if self.has_parts {
            fields.line("Accept-Ranges", "bytes");
        }
        self.write_rare(&mut fields);
    }

    /// Writes lines that few answers have.
    fn write_rare(&self, fields: &mut Fields<'_, '_>) {
        if let Some(part) = self.part {
            fields.parts("Content-Range", |window| {
                window.text("bytes ");
                window.number(part.first);
                window.text("-");
                window.number(part.last);
                window.text("/");
                window.number(self.whole);
            });
        } else if self.status == Status::RangeNotSatisfiable {
            fields.parts("Content-Range", |window| {
                window.text("bytes */");
                window.number(self.whole);
            });
        }
        if !self.allow.is_empty() {
            fields.parts("Allow", |window| {
                for (place, method) in self.allow.iter().enumerate() {
                    window.text(if place == 0 { "" } else { ", " });
                    window.text(method.name());
                }
            });
        }
        if self.status == Status::Unauthorized {
            // Browsers ask nothing for it, and show the page.
            fields.line("WWW-Authenticate", "Bearer");
        }
        if self.retry_s != 0 {
            fields.number("Retry-After", u64::from(self.retry_s));
        }
        if self.status == Status::UpgradeRequired {
            fields.line("Upgrade", "websocket");
            fields.line("Sec-WebSocket-Version", "13");
        }
    }
}

/// Writes an error in JSON.
pub(crate) fn write_error(window: &mut Window<'_>, status: Status, message: &str) {
    window.text("{\"error\":{\"code\":");
    window.number(u64::from(status.code()));
    window.text(",\"message\":\"");
    // Messages are texts of the program, without quotation marks and the like.
    message.bytes().filter(|byte| !byte.is_ascii_control() && !b"\"\\".contains(byte)).for_each(|byte| {
        window.put(&[byte]);
    });
    window.text("\"}}");
}

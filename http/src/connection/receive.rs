//! The way of bytes that arrive.

use super::patience::Patience;
use super::{Connection, Continue, Event, Reading};
use crate::request::{Request, Scan, scan};
use crate::status::Status;

impl Connection {
    /// Takes bytes, as many as have a meaning now, and says how many they were and what they mean. Call it
    /// with what is left until [`Event::Nothing`] comes.
    ///
    /// `bytes` begins with those that were not taken before: all that have arrived, in one piece, while the
    /// connection [`wants`](Self::wants_head) a head. Bytes that are taken may be changed in place, others
    /// never are.
    pub fn receive<'b>(&mut self, bytes: &'b mut [u8], now_ms: u64) -> (usize, Event<'b>) {
        match self.reading {
            Reading::Head => self.receive_head(bytes, now_ms),
            Reading::Body => self.receive_body(bytes, now_ms),
            Reading::End => {
                self.reading = Reading::Answer;
                (0, Event::End)
            }
            Reading::Answer => (0, Event::Nothing),
            Reading::Socket => self.receive_frames(bytes, now_ms),
            Reading::Swallow | Reading::Linger | Reading::Over => (bytes.len(), Event::Nothing),
        }
    }

    /// Returns whether the next bytes are a head, which has to be in one piece.
    #[must_use]
    pub fn wants_head(&self) -> bool {
        self.reading == Reading::Head
    }

    fn receive_head<'b>(&mut self, bytes: &'b mut [u8], now_ms: u64) -> (usize, Event<'b>) {
        let all = bytes.len();
        // Some browsers of old ended bodies with a line too many (RFC 9112, section 2.2).
        let skipped = 2 * bytes.chunks(2).take_while(|pair| *pair == b"\r\n").count();
        let rest = bytes.get_mut(skipped..).unwrap_or_default();
        if skipped > 0 {
            self.looked = 0;
        }
        // A line feed may be on its way.
        if !self.has_begun && rest.first().is_some_and(|byte| *byte != b'\r') {
            self.has_begun = true;
            self.reads = Patience::new(now_ms);
        }
        let most = rest.get(..usize::from(self.head_bytes)).unwrap_or(rest);
        let length = match scan(most, usize::from(self.looked)) {
            Scan::Whole(length) => length,
            Scan::Broken => return (all, self.refused(Status::BadRequest)),
            Scan::Open if most.len() == usize::from(self.head_bytes) => {
                let has_line = most.contains(&b'\n');
                let status = if has_line { Status::RequestHeaderFieldsTooLarge } else { Status::UriTooLong };
                return (all, self.refused(status));
            }
            Scan::Open => {
                self.looked = rest.len() as u16;
                return (skipped, Event::Nothing);
            }
        };
        match Request::read(rest.get_mut(..length).unwrap_or_default()) {
            Ok(request) => {
                self.begin(request.head, now_ms);
                (skipped + length, Event::Request(request))
            }
            Err(status) => (all, self.refused(status)),
        }
    }

    fn receive_body<'b>(&mut self, bytes: &'b mut [u8], now_ms: u64) -> (usize, Event<'b>) {
        let all = bytes.len();
        if self.go_on == Continue::Wanted {
            self.go_on = if bytes.is_empty() { Continue::Due } else { Continue::No };
        }
        if !self.decoder.fits() {
            return (all, self.refused(Status::ContentTooLarge));
        }
        let piece = match self.decoder.take(bytes) {
            Ok(piece) => piece,
            Err(status) => return (all, self.refused(status)),
        };
        let used = piece.skipped + piece.bytes;
        if used > 0 {
            self.reads.moved(used, now_ms);
        }
        let is_over = self.decoder.is_over();
        if is_over {
            self.reading = Reading::End;
        }
        match bytes.get(piece.skipped..used) {
            Some(data) if !data.is_empty() => (used, Event::Body(data)),
            _ if is_over => {
                self.reading = Reading::Answer;
                (used, Event::End)
            }
            _ => (used, Event::Nothing),
        }
    }

    fn refused(&mut self, status: Status) -> Event<'static> {
        let message = match status {
            Status::UriTooLong => "the address is too long",
            Status::RequestHeaderFieldsTooLarge => "the head of the request is too long",
            Status::ContentTooLarge => "the body is too long",
            Status::NotImplemented => "no such method or coding",
            Status::HttpVersionNotSupported => "no such version of HTTP is spoken here",
            Status::ExpectationFailed => "nothing but 100-continue can be expected",
            Status::LengthRequired => "the body has to have a length",
            _ => "this is no request that means one thing only",
        };
        self.refuse(status, message);
        Event::Refused(status)
    }
}

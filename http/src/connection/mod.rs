//! A connection of the server: requests in, answers out, in whatever pieces the socket has.

mod chunk;
mod patience;
mod receive;
mod socket;
mod stage;
mod transmit;

use crate::limits::{BODY_BYTES, BODY_MS, HEAD_BYTES, HEAD_MS, IDLE_MS, LINGER_MS, SEND_MS};
use crate::method::Method;
use crate::request::{BodyDecoder, Head, Length, Request};
use crate::response::{Extent, Response};
use crate::status::Status;
use crate::websocket::{Kind, Receiver};
use patience::Patience;
use socket::Owed;
use stage::Stage;

/// Meaning of bytes that have arrived.
#[derive(Debug)]
pub enum Event<'b> {
    /// Nothing more: bytes that were not taken wait, for more of them or for the answer to go out.
    Nothing,
    /// A request whose head is whole. Its body and its end follow.
    Request(Request<'b>),
    /// A piece of the body.
    Body(&'b [u8]),
    /// The end of the request, with or without a body: now the answer is due.
    End,
    /// A request that was refused. The connection answers by itself, and ends.
    Refused(Status),
    /// A piece of a WebSocket's message.
    Message {
        /// Kind of the message. Text is UTF-8 as a whole; a piece may end in the middle of a character.
        kind: Kind,
        /// Whether it is the first piece.
        is_first: bool,
        /// Whether it is the last piece, which may be empty.
        is_last: bool,
        /// Bytes of the piece.
        bytes: &'b [u8],
    },
    /// A WebSocket ends, with this code: the peer wants it to, or has broken the protocol. The connection
    /// does the rest by itself.
    Closed(u16),
}

/// Fate of the socket.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Life {
    /// The socket stays open.
    Open,
    /// Close the socket for sending, behind what it has still to send; what arrives is to be received all the
    /// same.
    Finish,
    /// Abort the socket, by a reset.
    Abort,
}

/// Purpose of bytes that arrive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reading {
    /// Bytes are a head.
    Head,
    /// Bytes are the body of a request.
    Body,
    /// The request is whole, which has not been said yet.
    End,
    /// Bytes wait for the answer to the request before them.
    Answer,
    /// Bytes are frames of a WebSocket.
    Socket,
    /// Bytes are thrown away, as the connection ends with the answer.
    Swallow,
    /// Bytes are thrown away behind the answer.
    Linger,
    /// Nothing, there is no connection.
    Over,
}

/// Kind of bytes that the connection sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sending {
    Nothing,
    /// Head of an answer, of which so many bytes are out.
    Head(u16),
    /// Body of which so many bytes are to come.
    Known(u64),
    Chunks,
    /// Body that ends with the connection.
    Rest,
    /// Body that tells an error, of which so many bytes are out.
    Error(u16),
    /// Message to a WebSocket: of this kind where its first frame is not out.
    Message(Option<Kind>),
}

/// Whether the peer waits to be told to send the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Continue {
    No,
    /// Unless the request is refused.
    Wanted,
    Due,
}

/// State of a connection.
#[derive(Clone, Debug)]
pub struct Connection {
    reading: Reading,
    sending: Sending,
    go_on: Continue,
    /// Longest head that the socket can hold.
    head_bytes: u16,
    /// Bytes of the head that have been looked at.
    looked: u16,
    /// Whether the first byte of a head has come.
    has_begun: bool,
    /// Whether the connection ends with the answer.
    closes: bool,
    /// Whether the answer is to HEAD, to HTTP/1.0.
    is_head: bool,
    is_old: bool,
    decoder: BodyDecoder,
    response: Response,
    /// Words of an error that the connection tells by itself.
    error: Option<&'static str>,
    stage: Stage,
    socket: Receiver,
    /// Control frame that is to be sent, and how much of it is out.
    owed: Owed,
    owed_sent: u8,
    /// Code of the end that follows.
    closing: Option<u16>,
    /// Whether a ping was sent since anything came.
    is_pinged: bool,
    /// Whether something was to be sent when the clock was last looked at.
    was_sending: bool,
    /// Patience with what is read, and with what is sent.
    reads: Patience,
    sends: Patience,
}

#[cfg(target_pointer_width = "32")]
const _: () = assert!(size_of::<Connection>() <= 400, "ten connections are to fit into 4 kB");

impl Connection {
    /// Makes the state of a new connection, whose socket can hold so many bytes that were not taken.
    #[must_use]
    pub const fn new(buffer_bytes: usize, now_ms: u64) -> Self {
        let head_bytes = if buffer_bytes < HEAD_BYTES { buffer_bytes } else { HEAD_BYTES };
        Self {
            reading: Reading::Head,
            sending: Sending::Nothing,
            go_on: Continue::No,
            head_bytes: head_bytes as u16,
            looked: 0,
            has_begun: false,
            closes: false,
            is_head: false,
            is_old: false,
            decoder: BodyDecoder::new(Length::Known(0), 0),
            response: Response::new(Status::Ok),
            error: None,
            stage: Stage::new(),
            socket: Receiver::new(),
            owed: Owed::Nothing,
            owed_sent: 0,
            closing: None,
            is_pinged: false,
            was_sending: false,
            reads: Patience::new(now_ms),
            sends: Patience::new(now_ms),
        }
    }

    /// Returns whether a request waits for an answer.
    #[must_use]
    pub fn owes_answer(&self) -> bool {
        matches!(self.reading, Reading::Body | Reading::End | Reading::Answer) && self.sending == Sending::Nothing
    }

    /// Returns whether something is to be sent: [`Self::transmit`] wants to be called when there is room.
    #[must_use]
    pub fn is_sending(&self) -> bool {
        self.sending != Sending::Nothing
            || self.go_on == Continue::Due
            || self.owed != Owed::Nothing
            || !self.stage.is_empty()
    }

    /// Lets the body of the request be so long. Without it, [`BODY_BYTES`] are allowed.
    ///
    /// False if the body is longer: the request is refused.
    pub fn allow_body(&mut self, bytes: u64) -> bool {
        let fits = self.decoder.allow(bytes);
        if !fits && self.reading == Reading::Body {
            self.refuse(Status::ContentTooLarge, "the body is too long");
        }
        fits
    }

    /// Returns how many bytes of the body are to come; none where nobody knows.
    #[must_use]
    pub const fn body_left(&self) -> Option<u64> {
        self.decoder.left()
    }

    /// Begins the answer to the request. A body that has not been read is thrown away, and the connection
    /// ends.
    pub fn respond(&mut self, response: Response) {
        if !self.owes_answer() {
            return;
        }
        self.error = None;
        if self.reading == Reading::Body {
            self.closes = true;
            self.reading = Reading::Swallow;
        } else {
            self.reading = Reading::Answer;
        }
        self.closes |= self.is_old && response.extent == Extent::Open && !response.status.is_bare() && !self.is_head;
        self.go_on = Continue::No;
        self.response = response;
        self.sending = Sending::Head(0);
    }

    /// Begins an answer that tells an error, in JSON, with a body that the connection makes by itself.
    pub fn respond_error(&mut self, response: Response, message: &'static str) {
        self.respond(Response { content_type: "application/json", extent: Extent::Open, ..response });
        self.error = Some(message);
    }

    /// Notes that bytes wait because the caller has no place for them: the peer is not to blame.
    pub fn hold(&mut self, now_ms: u64) {
        self.reads.hold(now_ms);
    }

    /// Notes that the peer sends no more. What is owed to it is still sent.
    pub fn hear_end(&mut self) {
        match self.reading {
            Reading::Head | Reading::Body | Reading::Socket | Reading::Linger => self.cut(),
            Reading::End | Reading::Answer | Reading::Swallow => self.closes = true,
            Reading::Over => {}
        }
    }

    /// Looks at the clock, and says what is to become of the socket. Call it often: at least four times a
    /// second.
    pub fn poll(&mut self, now_ms: u64) -> Life {
        let rest = self.reads.waited_ms(now_ms);
        match self.reading {
            Reading::Head if self.has_begun && rest >= HEAD_MS => {
                self.refuse(Status::RequestTimeout, "the head of the request did not come in time");
            }
            Reading::Head if !self.has_begun && rest >= IDLE_MS => self.linger(now_ms),
            Reading::Body if rest >= BODY_MS => {
                self.refuse(Status::RequestTimeout, "the body of the request did not come in time");
            }
            Reading::Linger if rest >= LINGER_MS => self.cut(),
            Reading::Socket => self.watch_socket(rest),
            _ => {}
        }
        let is_sending = self.is_sending();
        if !core::mem::replace(&mut self.was_sending, is_sending) {
            self.sends = Patience::new(now_ms);
        } else if is_sending && self.sends.waited_ms(now_ms) >= SEND_MS {
            self.cut();
        }
        match self.reading {
            Reading::Linger if !self.is_sending() => Life::Finish,
            Reading::Over => Life::Abort,
            _ => Life::Open,
        }
    }

    /// Refuses a request that the connection will not hand on, or not to its end.
    fn refuse(&mut self, status: Status, message: &'static str) {
        if self.sending != Sending::Nothing {
            self.cut();
            return;
        }
        self.reading = Reading::Body;
        self.respond_error(Response::new(status), message);
    }

    /// Begins with a request whose head is whole.
    fn begin(&mut self, head: Head, now_ms: u64) {
        self.looked = 0;
        self.has_begun = false;
        self.reads = Patience::new(now_ms);
        self.closes = !head.keeps;
        self.is_head = head.method == Method::Head;
        self.is_old = head.is_old;
        self.decoder = BodyDecoder::new(head.length, BODY_BYTES);
        self.reading = if self.decoder.is_over() { Reading::End } else { Reading::Body };
        self.go_on = if head.expects { Continue::Wanted } else { Continue::No };
    }

    /// Ends an answer that is out whole.
    fn end_answer(&mut self, now_ms: u64) {
        self.sending = Sending::Nothing;
        if self.response.status == Status::SwitchingProtocols {
            self.reading = Reading::Socket;
            self.reads = Patience::new(now_ms);
        } else if self.closes {
            self.linger(now_ms);
        } else {
            self.reading = Reading::Head;
            self.reads = Patience::new(now_ms);
        }
    }

    fn linger(&mut self, now_ms: u64) {
        self.reading = Reading::Linger;
        self.reads = Patience::new(now_ms);
    }

    fn cut(&mut self) {
        self.reading = Reading::Over;
        self.sending = Sending::Nothing;
        self.go_on = Continue::No;
        self.owed = Owed::Nothing;
        self.stage = Stage::new();
    }
}

//! A connection that has become a WebSocket.

use super::patience::Patience;
use super::{Connection, Event, Reading, Sending};
use crate::limits::{PING_MS, PONG_MS};
use crate::method::Method;
use crate::request::{Length, Request, Upgrade};
use crate::response::Response;
use crate::status::Status;
use crate::websocket::{Kind, Receiver, Took, accept, opcode, put_close, put_control};
use crate::window::Window;

/// Control frame that is to be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Owed {
    Nothing,
    Ping,
    /// Answer to a ping, with its data.
    Pong,
    /// End of the connection, with this code.
    Close(u16),
}

impl Connection {
    /// Makes the connection a WebSocket, as the request wants. False if it does not, or not as it should: the
    /// request is answered by the error that this is.
    pub fn upgrade(&mut self, request: &Request<'_>) -> bool {
        let head = request.head;
        let version = request.header("Sec-WebSocket-Version");
        if head.method != Method::Get || head.upgrade != Upgrade::WebSocket || version != Some("13") {
            self.respond_error(Response::new(Status::UpgradeRequired), "a WebSocket of version 13 is wanted here");
            return false;
        }
        let key = request.header("Sec-WebSocket-Key").and_then(accept).filter(|_| head.length == Length::Known(0));
        let Some(key) = key else {
            self.respond_error(Response::new(Status::BadRequest), "the handshake of a WebSocket is broken");
            return false;
        };
        self.socket = Receiver::new();
        self.socket.keep(&key);
        self.respond(Response::new(Status::SwitchingProtocols));
        true
    }

    /// Returns whether the connection is a WebSocket that is open.
    #[must_use]
    pub fn is_socket(&self) -> bool {
        self.reading == Reading::Socket
    }

    /// Begins a message. False if another is under way, or if this is no WebSocket.
    pub fn send(&mut self, kind: Kind) -> bool {
        let can = self.is_socket() && self.sending == Sending::Nothing;
        if can {
            self.sending = Sending::Message(Some(kind));
        }
        can
    }

    /// Ends a WebSocket, with this code. A message under way breaks off.
    pub fn close(&mut self, code: u16) {
        if self.is_socket() {
            self.reading = Reading::Swallow;
            self.sending = Sending::Nothing;
            self.closing = Some(code);
            if self.owed == Owed::Nothing {
                self.owe_next();
            }
        }
    }

    fn owe(&mut self, owed: Owed) {
        (self.owed, self.owed_sent) = (owed, 0);
    }

    /// Goes on to the end of the connection, where it is to end.
    fn owe_next(&mut self) {
        let next = self.closing.take().map_or(Owed::Nothing, Owed::Close);
        self.owe(next);
    }

    /// Sends a control frame, between others.
    pub(super) fn send_control(&mut self, room: &mut [u8], now_ms: u64) -> usize {
        let mut window = Window::new(room, usize::from(self.owed_sent));
        match self.owed {
            Owed::Nothing => {}
            Owed::Ping => put_control(&mut window, opcode::PING, &[]),
            Owed::Pong => put_control(&mut window, opcode::PONG, self.socket.control()),
            Owed::Close(code) => put_close(&mut window, code),
        }
        let written = window.written();
        if !window.is_whole() {
            self.owed_sent += written as u8;
        } else if matches!(self.owed, Owed::Close(_)) {
            self.owe(Owed::Nothing);
            self.linger(now_ms);
        } else {
            self.owe_next();
        }
        written
    }

    /// Takes frames, up to the end of a piece.
    pub(super) fn receive_frames<'b>(&mut self, bytes: &'b mut [u8], now_ms: u64) -> (usize, Event<'b>) {
        let all = bytes.len();
        let mut used = 0;
        if all > 0 {
            self.reads = Patience::new(now_ms);
            self.is_pinged = false;
        }
        loop {
            // Data of a ping stays where it is until it has gone back: what comes behind it waits.
            if self.owed != Owed::Nothing {
                return (used, Event::Nothing);
            }
            let before = used;
            let (count, took) = match self.socket.take(bytes.get_mut(used..).unwrap_or_default()) {
                Ok(took) => took,
                Err(code) => {
                    self.close(code);
                    return (all, Event::Closed(code));
                }
            };
            used += count;
            match took {
                Took::Nothing if used == all => return (used, Event::Nothing),
                Took::Nothing | Took::Pong => {}
                Took::Ping => self.owe(Owed::Pong),
                Took::Close(code) => {
                    self.close(code);
                    return (all, Event::Closed(code));
                }
                Took::Piece { kind, is_first, is_last, at } => {
                    let bytes = bytes.get(before + at.start..before + at.end).unwrap_or_default();
                    return (used, Event::Message { kind, is_first, is_last, bytes });
                }
            }
        }
    }

    /// Looks after a peer of which nothing has come for so long.
    pub(super) fn watch_socket(&mut self, rest_ms: u32) {
        if rest_ms >= PING_MS + PONG_MS {
            self.cut();
        } else if rest_ms >= PING_MS && !self.is_pinged && self.owed == Owed::Nothing {
            self.is_pinged = true;
            self.owe(Owed::Ping);
        }
    }
}

//! The way of bytes that are sent.

use super::chunk;
use super::socket::Owed;
use super::{Connection, Continue, Sending};
use crate::body::{Body, Made};
use crate::fields::Fields;
use crate::limits::BODY_ROOM;
use crate::response::{Extent, write_error};
use crate::status::Status;
use crate::websocket::{self, Kind, codes};
use crate::window::Window;

/// Outcome of a step.
enum Step {
    /// So many bytes were written; there may be more to do.
    Made(usize),
    /// Nothing can be done now.
    Rest,
}

impl Connection {
    /// Writes what is to be sent into the room that the socket has, and returns how many bytes it is. `body`
    /// is that of the answer, or of the message; it is not asked while neither is under way.
    pub fn transmit(&mut self, room: &mut [u8], body: &mut dyn Body, now_ms: u64) -> usize {
        let used = self.fill(room, body, now_ms);
        match used {
            0 if room.is_empty() => {}
            // Room that is left over is no reason to wait for the peer.
            0 => self.sends.hold(now_ms),
            _ => self.sends.moved(used, now_ms),
        }
        used
    }

    fn fill(&mut self, room: &mut [u8], body: &mut dyn Body, now_ms: u64) -> usize {
        let mut used = 0;
        loop {
            used += self.stage.drain(room.get_mut(used..).unwrap_or_default());
            let free = room.get_mut(used..).unwrap_or_default();
            if free.is_empty() {
                return used;
            }
            match self.step(free, body, now_ms) {
                Step::Made(count) => used += count,
                Step::Rest => return used,
            }
        }
    }

    /// Does the next thing. The stage is empty, and there is some room.
    fn step(&mut self, room: &mut [u8], body: &mut dyn Body, now_ms: u64) -> Step {
        if self.go_on == Continue::Due {
            self.go_on = Continue::No;
            self.stage.add(b"HTTP/1.1 100 Continue\r\n\r\n");
            return Step::Made(0);
        }
        if self.owed != Owed::Nothing {
            return Step::Made(self.send_control(room, now_ms));
        }
        match self.sending {
            Sending::Nothing => Step::Rest,
            Sending::Message(kind) => self.send_frame(kind, room, body),
            Sending::Head(sent) => self.send_head(sent, room, body, now_ms),
            Sending::Error(sent) => self.send_error(sent, room, now_ms),
            Sending::Known(left) => self.send_known(left, room, body, now_ms),
            Sending::Chunks => self.send_chunk(room, body, now_ms),
            Sending::Rest => self.send_rest(room, body, now_ms),
        }
    }

    fn send_head(&mut self, sent: u16, room: &mut [u8], body: &mut dyn Body, now_ms: u64) -> Step {
        let mut window = Window::new(room, usize::from(sent));
        self.write_head(&mut window, body);
        let written = window.written();
        if !window.is_whole() {
            self.sending = Sending::Head(sent + written as u16);
            return Step::Made(written);
        }
        if self.is_head || !self.response.has_body() {
            self.end_answer(now_ms);
        } else if self.error.is_some() {
            self.sending = Sending::Error(0);
        } else {
            self.sending = match self.response.extent {
                Extent::Known(length) => Sending::Known(length),
                Extent::Open if self.is_old => Sending::Rest,
                Extent::Open => Sending::Chunks,
            };
        }
        Step::Made(written)
    }

    fn write_head(&self, window: &mut Window<'_>, body: &dyn Body) {
        self.response.write(window);
        if self.error.is_none() {
            body.fields(&mut Fields::new(window));
        }
        let mut fields = Fields::new(window);
        if !self.response.status.is_bare() {
            match (self.response.extent, self.error) {
                (_, Some(message)) => {
                    let length = Window::count(|window| write_error(window, self.response.status, message));
                    fields.number("Content-Length", length as u64);
                }
                (Extent::Known(length), None) => fields.number("Content-Length", length),
                (Extent::Open, None) if self.is_old => {}
                (Extent::Open, None) => fields.line("Transfer-Encoding", "chunked"),
            }
        }
        if self.response.status == Status::SwitchingProtocols {
            fields.line("Upgrade", "websocket");
            fields.line("Connection", "Upgrade");
            fields.line("Sec-WebSocket-Accept", core::str::from_utf8(self.socket.control()).unwrap_or_default());
        } else if self.closes {
            fields.line("Connection", "close");
        } else if self.is_old {
            fields.line("Connection", "keep-alive");
        } else if self.response.status == Status::UpgradeRequired {
            fields.line("Connection", "Upgrade");
        }
        window.text("\r\n");
    }

    fn send_error(&mut self, sent: u16, room: &mut [u8], now_ms: u64) -> Step {
        let mut window = Window::new(room, usize::from(sent));
        write_error(&mut window, self.response.status, self.error.unwrap_or_default());
        let written = window.written();
        if window.is_whole() {
            self.end_answer(now_ms);
        } else {
            self.sending = Sending::Error(sent + written as u16);
        }
        Step::Made(written)
    }

    fn send_frame(&mut self, kind: Option<Kind>, room: &mut [u8], body: &mut dyn Body) -> Step {
        let piece = self.make_framed(room, |room| websocket::make(room, kind, body));
        match piece.made {
            Made::Failed => {
                self.close(codes::FAULT);
                return Step::Made(0);
            }
            Made::Last(_) => self.sending = Sending::Nothing,
            Made::Part(_) if piece.count > 0 => self.sending = Sending::Message(None),
            Made::Part(_) => {}
        }
        piece.step()
    }

    fn send_known(&mut self, left: u64, room: &mut [u8], body: &mut dyn Body, now_ms: u64) -> Step {
        let most = usize::try_from(left).unwrap_or(usize::MAX);
        let piece = self.make(room, most, body);
        let left = left - piece.count as u64;
        self.sending = Sending::Known(left);
        match piece.made {
            Made::Failed => self.fail(),
            // A body that is shorter than was said cannot be told from one that was cut.
            Made::Last(_) if left > 0 => self.fail(),
            Made::Part(_) | Made::Last(_) if left == 0 => {
                self.end_answer(now_ms);
                Step::Made(piece.direct)
            }
            Made::Part(_) | Made::Last(_) => piece.step(),
        }
    }

    fn send_rest(&mut self, room: &mut [u8], body: &mut dyn Body, now_ms: u64) -> Step {
        let piece = self.make(room, usize::MAX, body);
        match piece.made {
            Made::Failed => self.fail(),
            Made::Last(_) => {
                self.end_answer(now_ms);
                Step::Made(piece.direct)
            }
            Made::Part(_) => piece.step(),
        }
    }

    fn send_chunk(&mut self, room: &mut [u8], body: &mut dyn Body, now_ms: u64) -> Step {
        let piece = self.make_framed(room, |room| chunk::make(room, body));
        match piece.made {
            Made::Failed => self.fail(),
            Made::Last(_) => {
                self.stage.add(chunk::END);
                self.end_answer(now_ms);
                Step::Made(piece.direct)
            }
            Made::Part(_) => piece.step(),
        }
    }

    /// Has a piece of a body made, in the room, or in the stage where the room is too small for it.
    fn make(&mut self, room: &mut [u8], most: usize, body: &mut dyn Body) -> Piece {
        let count_of = |made: Made, most: usize| match made {
            Made::Part(count) | Made::Last(count) => count.min(most),
            Made::Failed => 0,
        };
        if room.len() >= BODY_ROOM.min(most) {
            let most = most.min(room.len());
            let made = body.make(room.get_mut(..most).unwrap_or_default());
            let count = count_of(made, most);
            return Piece { count, direct: count, made };
        }
        let mut piece = Piece { count: 0, direct: 0, made: Made::Part(0) };
        self.stage.fill(|stage| {
            let most = most.min(BODY_ROOM);
            piece.made = body.make(stage.get_mut(..most).unwrap_or_default());
            piece.count = count_of(piece.made, most);
            piece.count
        });
        piece
    }

    /// Has a framed piece made, in the room, or in the stage where the room is too small for it.
    fn make_framed(&mut self, room: &mut [u8], make: impl FnOnce(&mut [u8]) -> (usize, Made)) -> Piece {
        if room.len() >= BODY_ROOM + chunk::FRAME {
            let (count, made) = make(room);
            return Piece { count, direct: count, made };
        }
        let mut piece = Piece { count: 0, direct: 0, made: Made::Part(0) };
        self.stage.fill(|stage| {
            // The end of all chunks may have to follow.
            let most = stage.len() - chunk::END.len();
            (piece.count, piece.made) = make(stage.get_mut(..most).unwrap_or_default());
            piece.count
        });
        piece
    }

    /// Ends the connection in the middle of an answer.
    fn fail(&mut self) -> Step {
        self.cut();
        Step::Rest
    }
}

/// Piece of a body that was made.
struct Piece {
    /// Bytes that were made.
    count: usize,
    /// Bytes of it in the room, and not in the stage.
    direct: usize,
    made: Made,
}

impl Piece {
    /// Goes on, unless the maker has nothing to say yet.
    const fn step(&self) -> Step {
        if self.count == 0 { Step::Rest } else { Step::Made(self.direct) }
    }
}

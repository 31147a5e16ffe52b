//! Door of a service whose consoles are all in use: tells visitors so, rather than leaving them waiting.

use smoltcp::iface::SocketHandle;
use smoltcp::socket::tcp::{Socket, State};
use smoltcp::time::{Duration, Instant};

/// Time that a visitor may take who is turned away.
const MOST_TIME: Duration = Duration::from_secs(5);
const WORDS: &[u8] = b"All consoles are in use.\r\n";

/// The socket that turns visitors away.
#[derive(Debug)]
pub struct Door {
    handle: SocketHandle,
    /// Time since which a visitor is there.
    since: Option<Instant>,
    has_told: bool,
}

impl Door {
    /// Makes a closed door.
    pub const fn new(handle: SocketHandle) -> Self {
        Self { handle, since: None, has_told: false }
    }

    /// Returns the door's socket.
    pub const fn handle(&self) -> SocketHandle {
        self.handle
    }

    /// Does what is due. `is_full` says that all consoles are in use.
    pub fn run(&mut self, socket: &mut Socket<'static>, port: u16, is_full: bool, now: Instant) {
        match socket.state() {
            State::Closed | State::Listen => {
                (self.since, self.has_told) = (None, false);
                if !is_full {
                    socket.abort();
                } else if !socket.is_listening() {
                    let _listens = socket.listen(port);
                }
                return;
            }
            State::Established | State::CloseWait => {
                let _dropped = socket.recv(|bytes| (bytes.len(), ()));
                if !self.has_told && socket.send_slice(WORDS).is_ok() {
                    socket.close();
                    self.has_told = true;
                }
            }
            State::SynSent | State::SynReceived | State::FinWait1 | State::Closing | State::LastAck => {}
            State::FinWait2 => {
                let _dropped = socket.recv(|bytes| (bytes.len(), ()));
            }
            State::TimeWait => socket.abort(),
        }
        let since = *self.since.get_or_insert(now);
        if now >= since + MOST_TIME {
            socket.abort();
        }
    }
}

//! Transports of sessions: serial lines, USB, network, memory. A new transport has to implement three things:
//! bytes in, bytes out, and the profile of its peer.

use program::Dialect;

use super::{Inbox, Rights, SessionId};

/// Kind of a session's transport.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConsoleKind {
    /// A serial line (UART).
    Serial,
    /// A USB serial port.
    Usb,
    /// A connection over the network: Telnet, or a sender in GRBL's dialect.
    Network,
    /// The board's own web server, a program that asks for others: behind each answer comes a mark, and each
    /// line has the rights that the profile says then.
    Web,
    /// RTT, or a test's memory.
    Memory,
}

/// Profile of the peer at the other end of a transport.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionProfile {
    /// Kind of the transport.
    pub kind: ConsoleKind,
    /// Rights of the session.
    pub rights: Rights,
    /// Dialect of the session; none: the configuration's.
    pub dialect: Option<Dialect>,
    /// Text sent first to a peer that connects.
    pub greeting: &'static str,
}

impl SessionProfile {
    /// Profile of a serial line: all rights, the configuration's dialect, and no connecting or leaving.
    pub const SERIAL: Self =
        Self { kind: ConsoleKind::Serial, rights: Rights::Own, dialect: None, greeting: "Welcome to Smoothie\nok\n" };
}

/// Access to the sessions of a board.
pub trait Consoles {
    /// Returns the number of sessions. Ids run from 0; 0 is the debug UART.
    fn sessions(&self) -> u8;

    /// Returns the inbox of a session: bytes that arrived, and peers that came and went.
    fn inbox(&self, session: SessionId) -> &Inbox;

    /// Returns whether an inbox may have changed since the last call: bytes, requests, a peer that came or
    /// went. Transports that cannot tell say yes.
    fn have_news(&self) -> bool {
        true
    }

    /// Returns the profile of the session's peer.
    fn profile(&self, session: SessionId) -> SessionProfile;

    /// Sends bytes; returns how many were taken. Takes none while the transport's buffer is full. A session
    /// that nobody listens to takes everything.
    fn write(&mut self, session: SessionId, bytes: &[u8]) -> usize;
}

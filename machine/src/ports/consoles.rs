//! Transports of sessions: serial lines, USB, network, memory. To add one, implement its three things: bytes
//! in, bytes out, and who it is.

use program::Dialect;

use crate::sessions::{Inbox, Rights, SessionId};

/// What kind of transport a session has, as far as somebody wants to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConsoleKind {
    /// A UART.
    Serial,
    /// A USB serial port.
    Usb,
    /// Telnet or WebSocket.
    Network,
    /// RTT, or a test.
    Memory,
}

/// Who is at the other end of a transport.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionProfile {
    /// What kind of transport it is.
    pub kind: ConsoleKind,
    /// What it may do.
    pub rights: Rights,
    /// A dialect of its own; else that of the configuration.
    pub dialect: Option<Dialect>,
    /// What whoever comes is told first.
    pub greeting: &'static str,
}

impl SessionProfile {
    /// A serial line: may do everything, in the configuration's dialect, and nobody comes or goes.
    pub const SERIAL: Self = Self {
        kind: ConsoleKind::Serial,
        rights: Rights::Operate,
        dialect: None,
        greeting: "Welcome to Smoothie\nok\n",
    };
}

/// The sessions of a board.
pub trait Consoles {
    /// How many there are. Ids run from 0; 0 is the debug UART.
    fn sessions(&self) -> u8;

    /// Bytes that arrived, who came and went.
    fn inbox(&self, session: SessionId) -> &Inbox;

    /// Who is at the other end.
    fn profile(&self, session: SessionId) -> SessionProfile;

    /// Sends bytes; returns how many were taken. Takes none while the transport's buffer is full. A session
    /// that nobody listens to takes everything.
    fn write(&mut self, session: SessionId, bytes: &[u8]) -> usize;
}

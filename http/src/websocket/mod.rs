//! WebSocket, the server's side (RFC 6455), without extensions.

mod frame;
mod handshake;
mod receiver;

pub use frame::{Kind, make, opcode, put_close, put_control};
pub use handshake::accept;
pub use receiver::{Receiver, Took};

/// Codes that a connection is closed with (RFC 6455, section 7.4.1).
pub mod codes {
    /// All is done, nobody is at fault.
    pub const NORMAL: u16 = 1_000;
    /// The server goes away.
    pub const GOING_AWAY: u16 = 1_001;
    /// Frames are no frames.
    pub const PROTOCOL: u16 = 1_002;
    /// The kind of message is not understood.
    pub const UNSUPPORTED: u16 = 1_003;
    /// The peer gave no code; never sent.
    pub const NO_CODE: u16 = 1_005;
    /// Text is no UTF-8.
    pub const NO_TEXT: u16 = 1_007;
    /// A message says what is not allowed.
    pub const POLICY: u16 = 1_008;
    /// A message is too long.
    pub const TOO_LONG: u16 = 1_009;
    /// The server is at fault.
    pub const FAULT: u16 = 1_011;
}

//! Frames of a WebSocket: pieces and rooms of any size make no difference, text is UTF-8, every connection
//! ends.

use super::cut;
use super::server::Server;

/// Request that makes a connection a WebSocket.
const HANDSHAKE: &[u8] = b"GET /ws HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
    Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n";

/// Pieces that inputs are made of: frames. Masks of zeros leave the data as it is.
pub const PIECES: &[&[u8]] = &[
    b"\x81\x85\0\0\0\0Hello",
    b"\x81\x85\x37\xfa\x21\x3d\x7f\x9f\x4d\x51\x58",
    b"\x82\xFE\x01\x00\0\0\0\0",
    b"\x82\xFF\0\0\0\0\0\x01\0\0\0\0\0\0",
    b"\x01\x82\0\0\0\0a\xC3",
    b"\x80\x82\0\0\0\0\xBCb",
    b"\x00\x80\0\0\0\0",
    b"\x02\x81\0\0\0\0a",
    b"\x89\x83\0\0\0\0one",
    b"\x89\x80\0\0\0\0",
    b"\x8A\x80\0\0\0\0",
    b"\x88\x82\0\0\0\0\x03\xE8",
    b"\x88\x80\0\0\0\0",
    b"\x81\x80\0\0\0\0",
    b"\x81",
    b"\x85",
    b"\0\0\0\0",
    b"\xFE\x00\x7E",
    b"\xE2\x82\xAC",
    b"\xF0\x9D\x84\x9E",
];

/// Sends the bytes behind a handshake, whole and in pieces.
///
/// # Panics
/// When a condition of this module does not hold.
pub fn run(bytes: &[u8]) {
    let mut whole = Server::serve(&[HANDSHAKE, bytes], 4_096);
    for (seed, room) in [(1, 4_096), (2, 7), (3, 60)] {
        let mut pieces = vec![HANDSHAKE];
        pieces.extend(cut(bytes, seed));
        let mut pieces = Server::serve(&pieces, room);
        assert_eq!(pieces.heard, whole.heard, "in pieces of {seed}");
        pieces.end();
    }
    whole.end();
}

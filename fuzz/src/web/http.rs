//! Requests: pieces and rooms of any size make no difference, and every connection ends.

use super::cut;
use super::server::Server;

/// Pieces that inputs are made of.
pub const PIECES: &[&[u8]] = &[
    b"GET /a HTTP/1.1\r\nHost: a\r\n\r\n",
    b"POST /b?c=d HTTP/1.1\r\nHost: a\r\nContent-Length: 5\r\n\r\nhello",
    b"PUT /a/long/path HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n",
    b"5\r\nhello\r\n",
    b"A;x=y\r\n0123456789\r\n",
    b"0\r\n\r\n",
    b"0\r\nA: b\r\n\r\n",
    b"GET ",
    b"HEAD ",
    b"OPTIONS * ",
    b"/",
    b"/%2e%2E/",
    b"%41",
    b"%",
    b"?a=b&c",
    b"http://a/b",
    b" HTTP/1.1\r\n",
    b" HTTP/1.0\r\n",
    b"Host: a\r\n",
    b"\r\n",
    b"\r",
    b"\n",
    b"Content-Length: 3\r\n",
    b"Content-Length: 40000\r\n",
    b"Transfer-Encoding: chunked\r\n",
    b"Connection: close\r\n",
    b"Connection: keep-alive\r\n",
    b"Expect: 100-continue\r\n",
    b"Cookie: a=b; c=d\r\n",
    b"Range: bytes=1-5\r\n",
    b"If-None-Match: \"x\"\r\n",
    b"Upgrade: websocket\r\n",
    b": ",
    b" ",
];

/// Serves the bytes whole and in pieces.
///
/// # Panics
/// When a condition of this module does not hold.
pub fn run(bytes: &[u8]) {
    let mut whole = Server::serve(&[bytes], 4_096);
    for (seed, room) in [(1, 4_096), (2, 7), (3, 60)] {
        let mut pieces = Server::serve(&cut(bytes, seed), room);
        // Whether 100 (Continue) is said depends on what has come by then, and sizes of chunks on the room.
        assert_eq!(pieces.heard, whole.heard, "in pieces of {seed}");
        pieces.end();
    }
    whole.end();
    assert!(whole.sent.is_empty() || whole.sent.starts_with(b"HTTP/1.1 "), "an answer without a head");
}

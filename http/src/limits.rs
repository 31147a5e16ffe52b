//! Limits of everything that a peer can make large or slow, each with its reason. The tests hold each.

/// Longest head of a request, bytes: browsers send 600 to 900, with a cookie; the scratch that a head is read
/// in has this size.
pub const HEAD_BYTES: usize = 2_048;
/// Longest path and query of a request together, bytes: the longest file name, percent-encoded in part.
pub const TARGET_BYTES: usize = 512;
/// Greatest number of a request's header lines: browsers send up to 20.
pub const HEADERS: usize = 32;
/// Longest time from the first byte of a head to its last, milliseconds: a head fits into two packets.
pub const HEAD_MS: u32 = 5_000;
/// Longest rest of a connection between two requests, milliseconds: connections are few.
pub const IDLE_MS: u32 = 15_000;
/// Longest wait for bytes of a body, milliseconds: as long as TCP's own time-out. Bytes that come buy time
/// back, so that nobody holds a connection by a byte now and then.
pub const BODY_MS: u32 = 20_000;
/// Longest wait for a peer to take of an answer, milliseconds. Bytes that go buy time back.
pub const SEND_MS: u32 = 20_000;
/// Bytes that buy a millisecond back: 1 kB/s is a poor radio link.
pub const BYTES_A_MS: u32 = 1;
/// Time for which what comes behind the last answer is thrown away, so that a reset does not overtake the
/// answer (RFC 9112, section 9.6), milliseconds.
pub const LINGER_MS: u32 = 2_000;
/// Longest body of a request whose route says nothing else, bytes: what a call in JSON takes.
pub const BODY_BYTES: u64 = 32 * 1_024;
/// Longest line that gives the size of a chunk, bytes: eight digits and an extension that nobody uses.
pub const CHUNK_LINE_BYTES: u16 = 64;
/// Longest trailer behind the chunks of a body, bytes. Trailers are read over.
pub const TRAILER_BYTES: u16 = 512;
/// Room that the maker of a body always has, unless less is left of the body, bytes: small things need not be
/// made in pieces.
pub const BODY_ROOM: usize = 48;
/// Longest message that a WebSocket's peer may send, in bytes over all its fragments: Mainsail asks about 100
/// files in one of 9 kB.
pub const MESSAGE_BYTES: u32 = 32 * 1_024;
/// Longest frame that goes out to a WebSocket, bytes: what the socket has room for, and never the message.
pub const FRAME_BYTES: usize = 1_024;
/// Rest of a WebSocket after which it is pinged, milliseconds.
pub const PING_MS: u32 = 10_000;
/// Time for the answer to a ping, milliseconds: a phone that sleeps is gone after half a minute.
pub const PONG_MS: u32 = 10_000;
/// Greatest depth of arrays and objects in JSON: calls have five.
pub const DEPTH: usize = 16;
/// Longest key of a JSON object, bytes: the fields of Moonraker have up to 30.
pub const KEY_BYTES: usize = 60;
/// Longest number in JSON, characters: what is longer says more than 64 bits hold.
pub const NUMBER_BYTES: u8 = 40;
/// Longest boundary of a form, bytes (RFC 2046, section 5.1.1).
pub const BOUNDARY_BYTES: usize = 70;
/// Longest header line of a part of a form, bytes: a file name of 255 bytes beside what is fixed.
pub const PART_LINE_BYTES: usize = 400;
/// Greatest number of a part's header lines.
pub const PART_LINES: u8 = 8;
/// Greatest number of a form's parts: slicers send up to five.
pub const PARTS: u8 = 16;
/// Longest text before the first part of a form, bytes: nobody sends any.
pub const PREAMBLE_BYTES: u16 = 256;

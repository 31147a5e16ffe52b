//! Chunks of an answer (RFC 9112, section 7.1).

use crate::body::{Body, Made};

/// Digits of the size and the end of their line.
const HEAD: usize = 5;
/// End of the line behind the data.
const TAIL: &[u8] = b"\r\n";
/// Most that three digits can say.
const LONGEST: usize = 0xFFF;
/// Bytes around the data of a chunk.
pub const FRAME: usize = HEAD + TAIL.len();
/// End of all chunks, without a trailer.
pub const END: &[u8] = b"0\r\n\r\n";

/// Makes a chunk in `room`. Returns its bytes, none without data, and what came of the data.
pub fn make(room: &mut [u8], body: &mut dyn Body) -> (usize, Made) {
    let most = room.len().saturating_sub(FRAME).min(LONGEST);
    let Some((head, rest)) = room.split_at_mut_checked(HEAD) else { return (0, Made::Part(0)) };
    let made = body.make(rest.get_mut(..most).unwrap_or_default());
    let (Made::Part(count) | Made::Last(count)) = made else { return (0, made) };
    let count = count.min(most);
    if count == 0 {
        return (0, made);
    }
    let digit = |shift: usize| char::from_digit((count >> shift & 15) as u32, 16).map_or(b'0', |digit| digit as u8);
    let ends = rest.get_mut(count..).unwrap_or_default();
    for (place, byte) in head.iter_mut().zip([digit(8), digit(4), digit(0), b'\r', b'\n']) {
        *place = byte;
    }
    for (place, byte) in ends.iter_mut().zip(TAIL) {
        *place = *byte;
    }
    (HEAD + count + TAIL.len(), made)
}

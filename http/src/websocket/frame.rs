//! Frames out (RFC 6455, section 5). A server's frames have no masks.

use crate::body::{Body, Made};
use crate::limits::FRAME_BYTES;
use crate::window::Window;

/// Kind of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Text, which is UTF-8.
    Text,
    /// Bytes of any value.
    Binary,
}

/// Numbers of the kinds of frames.
pub mod opcode {
    pub const CONTINUATION: u8 = 0;
    pub const TEXT: u8 = 1;
    pub const BINARY: u8 = 2;
    pub const CLOSE: u8 = 8;
    pub const PING: u8 = 9;
    pub const PONG: u8 = 10;
}

/// Bit of the last frame of a message.
const LAST: u8 = 0x80;
/// Length that says that two bytes with the length follow.
const LONG: usize = 126;
/// Bytes in front of the data, at the most.
const FRAME_HEAD: usize = 4;
/// Bytes in front of the data of a frame that is shorter than 126 bytes.
const SHORT_HEAD: usize = 2;
/// Room of a frame that begins with [`SHORT_HEAD`] bytes only.
const SMALL_FRAME: usize = SHORT_HEAD + LONG - 1;
/// Longest data of a control frame.
pub const CONTROL_BYTES: usize = 125;

/// Makes a frame in `room`: of a message of this kind, or what goes on with it where `kind` is None. Returns
/// its bytes, none where there is nothing to say, and what came of the data.
pub fn make(room: &mut [u8], kind: Option<Kind>, body: &mut dyn Body) -> (usize, Made) {
    let reserved = if room.len() <= SMALL_FRAME { SHORT_HEAD } else { FRAME_HEAD };
    let most = room.len().saturating_sub(reserved).min(FRAME_BYTES - FRAME_HEAD);
    let data = room.get_mut(reserved..).and_then(|rest| rest.get_mut(..most)).unwrap_or_default();
    let made = body.make(data);
    let (count, last) = match made {
        Made::Part(0) | Made::Failed => return (0, made),
        Made::Part(count) => (count.min(most), 0),
        Made::Last(count) => (count.min(most), LAST),
    };
    let first = last
        | match kind {
            Some(Kind::Text) => opcode::TEXT,
            Some(Kind::Binary) => opcode::BINARY,
            None => opcode::CONTINUATION,
        };
    let is_long = count >= LONG;
    if !is_long && reserved > SHORT_HEAD {
        for at in 0..count {
            let byte = room.get(reserved + at).copied().unwrap_or(0);
            if let Some(place) = room.get_mut(SHORT_HEAD + at) {
                *place = byte;
            }
        }
    }
    let [high, low] = (count as u16).to_be_bytes();
    let head = if is_long { [first, LONG as u8, high, low] } else { [first, low, 0, 0] };
    let length = if is_long { FRAME_HEAD } else { SHORT_HEAD };
    for (place, byte) in room.iter_mut().zip(head).take(length) {
        *place = byte;
    }
    (length + count, made)
}

/// Writes a control frame.
pub fn put_control(window: &mut Window<'_>, opcode: u8, data: &[u8]) {
    window.put(&[LAST | opcode, data.len() as u8]);
    window.put(data);
}

/// Writes the frame that closes a connection. Without a code it has no data.
pub fn put_close(window: &mut Window<'_>, code: u16) {
    let code_bytes = code.to_be_bytes();
    let data = if code == super::codes::NO_CODE { &[] } else { code_bytes.as_slice() };
    put_control(window, opcode::CLOSE, data);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Slice;

    fn made(room: usize, kind: Option<Kind>, bytes: &[u8]) -> (Vec<u8>, Made) {
        let mut place = vec![0xEE; room];
        let (count, made) = make(&mut place, kind, &mut Slice::new(bytes));
        (place[..count].to_vec(), made)
    }

    #[test]
    fn frames_are_those_of_the_rfc() {
        // Section 5.7: "Hello" whole, and in two fragments.
        assert_eq!(made(100, Some(Kind::Text), b"Hello").0, b"\x81\x05Hello");
        assert_eq!(made(5, Some(Kind::Text), b"Hello"), (b"\x01\x03Hel".to_vec(), Made::Part(3)));
        assert_eq!(made(500, None, b"lo").0, b"\x80\x02lo");
        let long = made(2_000, Some(Kind::Binary), &[7; 256]).0;
        assert_eq!((&long[..4], long.len()), (b"\x82\x7E\x01\x00".as_slice(), 260));
    }

    #[test]
    fn lengths_are_written_in_the_fewest_bytes() {
        for (length, head) in [(0, 2), (125, 2), (126, 4), (1_020, 4)] {
            assert_eq!(made(2_000, None, &vec![1; length]).0.len(), head + length, "{length}");
        }
        let (frame, is) = made(2_000, None, &[1; 1_021]);
        assert_eq!((frame.len(), is, frame[0]), (FRAME_BYTES, Made::Part(1_020), 0));
        for room in 120..140 {
            let frame = made(room, None, &[1; 200]).0;
            assert!(frame.len() <= room && frame[1] as usize == if frame.len() > 127 { 126 } else { frame.len() - 2 });
        }
    }
}

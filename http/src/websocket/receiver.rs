//! Frames in (RFC 6455, sections 5 and 6): masks taken off, fragments joined, text checked.

use core::ops::Range;

use super::codes;
use super::frame::{CONTROL_BYTES, Kind, opcode};
use crate::limits::MESSAGE_BYTES;
use crate::utf8::Utf8;

/// Bytes of the longest head of a frame.
const HEAD: usize = 14;
/// Bytes of a mask.
const MASK: usize = 4;

/// Meaning of the bytes that were taken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Took {
    /// Nothing that means something yet.
    Nothing,
    /// A piece of a message, at this place of what was given.
    Piece { kind: Kind, is_first: bool, is_last: bool, at: Range<usize> },
    /// A ping, whose data is to go back.
    Ping,
    /// An answer to a ping.
    Pong,
    /// The peer closes the connection.
    Close(u16),
}

/// Receiver of frames and messages.
#[derive(Clone, Debug)]
pub struct Receiver {
    head: [u8; HEAD],
    /// Bytes of the head that have come.
    have: u8,
    /// Whether the head is whole.
    is_open: bool,
    /// Bytes left of the frame's data.
    left: u32,
    /// Bytes of the frame's data that have come.
    come: u32,
    /// Kind of the message under way.
    message: Option<Kind>,
    is_first: bool,
    message_bytes: u32,
    text: Utf8,
    control: [u8; CONTROL_BYTES],
    control_bytes: u8,
}

impl Receiver {
    /// Makes a receiver for a connection that begins.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            head: [0; HEAD],
            have: 0,
            is_open: false,
            left: 0,
            come: 0,
            message: None,
            is_first: false,
            message_bytes: 0,
            text: Utf8::new(),
            control: [0; CONTROL_BYTES],
            control_bytes: 0,
        }
    }

    /// Returns the data of the last control frame.
    #[must_use]
    pub fn control(&self) -> &[u8] {
        self.control.get(..usize::from(self.control_bytes)).unwrap_or_default()
    }

    /// Keeps bytes in the place of a control frame's data, until one comes.
    pub fn keep(&mut self, bytes: &[u8]) {
        self.control_bytes = 0;
        bytes.iter().for_each(|byte| self.push_control(*byte));
    }

    /// Takes bytes up to the end of a piece, and says how many they were.
    ///
    /// # Errors
    /// The code that the connection is to be closed with.
    pub fn take(&mut self, bytes: &mut [u8]) -> Result<(usize, Took), u16> {
        let mut used = 0;
        while !self.is_open {
            let Some(byte) = bytes.get(used) else { return Ok((used, Took::Nothing)) };
            used += 1;
            self.push_head(*byte)?;
        }
        let here = bytes.get_mut(used..).unwrap_or_default();
        let count = here.len().min(self.left as usize);
        let data = here.get_mut(..count).unwrap_or_default();
        self.unmask(data);
        self.left -= count as u32;
        self.is_open = self.left > 0;
        let at = used..used + count;
        let took = if self.opcode() >= opcode::CLOSE { self.take_control(data) } else { self.take_data(data, at) }?;
        Ok((used + count, took))
    }

    fn take_control(&mut self, data: &[u8]) -> Result<Took, u16> {
        data.iter().for_each(|byte| self.push_control(*byte));
        if self.is_open {
            return Ok(Took::Nothing);
        }
        match self.opcode() {
            opcode::PING => Ok(Took::Ping),
            opcode::PONG => Ok(Took::Pong),
            _ => close_code(self.control()).map(Took::Close),
        }
    }

    fn take_data(&mut self, data: &[u8], at: Range<usize>) -> Result<Took, u16> {
        let kind = self.message.ok_or(codes::PROTOCOL)?;
        let is_last = !self.is_open && self.is_final();
        if kind == Kind::Text && !(self.text.push_all(data) && (!is_last || self.text.is_whole())) {
            return Err(codes::NO_TEXT);
        }
        if is_last {
            self.message = None;
        } else if data.is_empty() {
            return Ok(Took::Nothing);
        }
        let is_first = core::mem::take(&mut self.is_first);
        Ok(Took::Piece { kind, is_first, is_last, at })
    }

    const fn opcode(&self) -> u8 {
        self.head[0] & 0x0F
    }

    const fn is_final(&self) -> bool {
        self.head[0] & 0x80 != 0
    }

    /// Takes a byte of the head, and begins the data behind the last one.
    fn push_head(&mut self, byte: u8) -> Result<(), u16> {
        if let Some(place) = self.head.get_mut(usize::from(self.have)) {
            *place = byte;
        }
        self.have += 1;
        match self.have {
            1 => self.look_at_kind(),
            2 => self.look_at_length(),
            have if usize::from(have) == self.head_bytes() => self.begin(),
            _ => Ok(()),
        }
    }

    /// Bytes that stand for the length behind the second byte.
    const fn length_bytes(&self) -> usize {
        match self.head[1] & 0x7F {
            126 => 2,
            127 => 8,
            _ => 0,
        }
    }

    const fn head_bytes(&self) -> usize {
        2 + self.length_bytes() + MASK
    }

    fn look_at_kind(&self) -> Result<(), u16> {
        let fits = match self.opcode() {
            opcode::CONTINUATION => self.message.is_some(),
            opcode::TEXT | opcode::BINARY => self.message.is_none(),
            opcode::CLOSE | opcode::PING | opcode::PONG => self.is_final(),
            _ => false,
        };
        // No extension has given the three bits a meaning.
        if fits && self.head[0] & 0x70 == 0 { Ok(()) } else { Err(codes::PROTOCOL) }
    }

    fn look_at_length(&self) -> Result<(), u16> {
        let is_masked = self.head[1] & 0x80 != 0;
        let fits = self.opcode() < opcode::CLOSE || self.length_bytes() == 0;
        if is_masked && fits { Ok(()) } else { Err(codes::PROTOCOL) }
    }

    /// Begins the data of a frame whose head is whole.
    fn begin(&mut self) -> Result<(), u16> {
        let bytes = self.head.get(2..2 + self.length_bytes()).unwrap_or_default();
        let long = bytes.iter().fold(0, |length: u64, byte| length << 8 | u64::from(*byte));
        let (length, least) = match bytes.len() {
            0 => (u64::from(self.head[1] & 0x7F), 0),
            2 => (long, 126),
            _ => (long, 0x1_0000),
        };
        if length < least || length >> 63 != 0 {
            return Err(codes::PROTOCOL);
        }
        if self.opcode() >= opcode::CLOSE {
            self.control_bytes = 0;
        } else {
            if self.opcode() != opcode::CONTINUATION {
                self.message = Some(if self.opcode() == opcode::TEXT { Kind::Text } else { Kind::Binary });
                (self.is_first, self.message_bytes, self.text) = (true, 0, Utf8::new());
            }
            let bytes = u64::from(self.message_bytes) + length;
            if bytes > u64::from(MESSAGE_BYTES) {
                return Err(codes::TOO_LONG);
            }
            self.message_bytes = bytes as u32;
        }
        (self.left, self.come) = (length as u32, 0);
        (self.have, self.is_open) = (0, true);
        Ok(())
    }

    fn unmask(&mut self, data: &mut [u8]) {
        let start = 2 + self.length_bytes();
        for byte in data {
            let place = start + self.come as usize % MASK;
            *byte ^= self.head.get(place).copied().unwrap_or(0);
            self.come = self.come.wrapping_add(1);
        }
    }

    fn push_control(&mut self, byte: u8) {
        if let Some(place) = self.control.get_mut(usize::from(self.control_bytes)) {
            *place = byte;
            self.control_bytes += 1;
        }
    }
}

/// Returns the code of a frame that closes the connection.
fn close_code(data: &[u8]) -> Result<u16, u16> {
    let [high, low, reason @ ..] = data else {
        return if data.is_empty() { Ok(codes::NO_CODE) } else { Err(codes::PROTOCOL) };
    };
    let code = u16::from_be_bytes([*high, *low]);
    // Section 7.4: some codes are never sent, others belong to nobody.
    if !matches!(code, 1_000..=1_003 | 1_007..=1_014 | 3_000..=4_999) {
        return Err(codes::PROTOCOL);
    }
    if core::str::from_utf8(reason).is_err() { Err(codes::NO_TEXT) } else { Ok(code) }
}

//! The line: blocks with length, sequence number and CRC, and the integers in them (Klipper,
//! `docs/Protocol.md`).

/// Length of the longest block, bytes.
pub const BLOCK_BYTES: usize = 64;
/// Bytes of a block besides its content: length, sequence number, CRC, and the byte at its end.
pub const FRAME_BYTES: usize = 5;
/// Byte at the end of each block. It may stand within a block as well.
const SYNC: u8 = 0x7E;
/// High half of the second byte.
const SEQUENCE_MARK: u8 = 0x10;

/// Returns the CRC of bytes: CRC-16/MCRF4XX, reflected polynomial 0x8408, initial value 0xFFFF.
#[must_use]
pub fn crc16(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF_u16, |crc, &byte| {
        // The reflected polynomial's effect on eight bits at once.
        let byte = byte ^ crc as u8;
        let byte = u16::from(byte ^ (byte << 4));
        (byte << 8 | crc >> 8) ^ byte >> 4 ^ byte << 3
    })
}

/// Reads an integer at the beginning of `bytes`. Returns it, modulo 2^32, and the bytes behind it.
#[must_use]
pub fn read_integer(bytes: &[u8]) -> Option<(u32, &[u8])> {
    let (&first, mut rest) = bytes.split_first()?;
    let mut value = u32::from(first & 0x7F);
    if first & 0x60 == 0x60 {
        value |= !0x1F;
    }
    let mut last = first;
    // An integer has five bytes at most.
    for _ in 0..4 {
        if last & 0x80 == 0 {
            break;
        }
        let (&next, behind) = rest.split_first()?;
        value = value << 7 | u32::from(next & 0x7F);
        (last, rest) = (next, behind);
    }
    if last & 0x80 == 0 { Some((value, rest)) } else { None }
}

/// Number of bytes that [`write_integer`] needs.
pub const INTEGER_BYTES: usize = 5;

/// Writes an integer, and returns its bytes. Values from 2^31 on are written as negative ones: the host knows
/// which are signed.
#[must_use]
pub fn write_integer(value: u32) -> ([u8; INTEGER_BYTES], usize) {
    let signed = value as i32;
    let mut bytes = [0; INTEGER_BYTES];
    let mut length = 0;
    // Groups of seven bits that the value needs: one more for each factor of 128 beyond -32 to 95.
    for group in (1..5_u32).rev() {
        let half = 1_i32 << (7 * group - 2);
        if signed >= half.saturating_mul(3) || signed < -half {
            bytes[length] = (signed >> (7 * group)) as u8 & 0x7F | 0x80;
            length += 1;
        }
    }
    bytes[length] = value as u8 & 0x7F;
    (bytes, length + 1)
}

/// A block whose length and CRC are right.
#[derive(Clone, Debug)]
pub struct Block {
    bytes: [u8; BLOCK_BYTES],
    length: usize,
}

impl Block {
    /// Returns the sequence number, 0 to 15.
    #[must_use]
    pub fn sequence(&self) -> u8 {
        self.bytes[1] & 0x0F
    }

    /// Returns the messages of the block.
    #[must_use]
    pub fn content(&self) -> &[u8] {
        self.bytes.get(2..self.length.saturating_sub(3)).unwrap_or(&[])
    }
}

/// Event on the line.
#[derive(Clone, Debug)]
pub enum Incoming {
    /// A whole block, whose CRC is right.
    Block(Block),
    /// Bytes that are none. Told once, and not again before the next block.
    Damaged,
}

/// Blocks out of the bytes of a line.
#[derive(Clone, Debug)]
pub struct Framer {
    bytes: [u8; BLOCK_BYTES],
    length: usize,
    /// Bytes are dropped up to the next [`SYNC`].
    is_lost: bool,
    has_told: bool,
}

impl Default for Framer {
    fn default() -> Self {
        Self::new()
    }
}

impl Framer {
    /// Creates a framer at the beginning of a block.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: [0; BLOCK_BYTES], length: 0, is_lost: false, has_told: false }
    }

    /// Takes the next byte of the line.
    pub fn take(&mut self, byte: u8) -> Option<Incoming> {
        if self.is_lost {
            self.is_lost = byte != SYNC;
            return None;
        }
        // A sync byte before a block is legal: the host sends one before a repetition.
        if self.length == 0 && byte == SYNC {
            return None;
        }
        self.bytes[self.length % BLOCK_BYTES] = byte;
        self.length += 1;
        let expected = usize::from(self.bytes[0]);
        if !(FRAME_BYTES..=BLOCK_BYTES).contains(&expected) || self.length == 2 && byte & 0xF0 != SEQUENCE_MARK {
            return self.lose(byte);
        }
        if self.length < expected {
            return None;
        }
        let (head, tail) = self.bytes.split_at(expected - 3);
        if byte != SYNC || crc16(head).to_be_bytes() != tail[..2] {
            return self.lose(byte);
        }
        self.length = 0;
        self.has_told = false;
        Some(Incoming::Block(Block { bytes: self.bytes, length: expected }))
    }

    /// Drops what has come, up to the next end of a block, which may have been this byte.
    fn lose(&mut self, byte: u8) -> Option<Incoming> {
        self.length = 0;
        self.is_lost = byte != SYNC;
        (!core::mem::replace(&mut self.has_told, true)).then_some(Incoming::Damaged)
    }
}

/// Writes a block of one message, or an empty one. Returns its length; the content is at most
/// [`BLOCK_BYTES`] less [`FRAME_BYTES`] long, the rest is cut.
pub fn write_block(content: &[u8], sequence: u8, into: &mut [u8; BLOCK_BYTES]) -> usize {
    let content = &content[..content.len().min(BLOCK_BYTES - FRAME_BYTES)];
    let length = content.len() + FRAME_BYTES;
    into[0] = length as u8;
    into[1] = SEQUENCE_MARK | sequence & 0x0F;
    into[2..2 + content.len()].copy_from_slice(content);
    let crc = crc16(&into[..2 + content.len()]).to_be_bytes();
    into[2 + content.len()..length - 1].copy_from_slice(&crc);
    into[length - 1] = SYNC;
    length
}

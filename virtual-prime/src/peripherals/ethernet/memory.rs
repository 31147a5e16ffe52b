//! The DMA's way to memory: purposes of its accesses, what it reaches, descriptors and buffers.

use std::ops::Range;

use rigless::device::DeviceContext;
use rigless::soc::Width;

use super::descriptor::{BYTES, pieces};

/// Memories that the Ethernet DMA reaches, RM0399 table 3: all but the TCMs and the peripherals. It writes to
/// all of them but the flash.
const READS: [Range<u64>; 6] = [
    0x0800_0000..0x0820_0000,
    0x2400_0000..0x2408_0000,
    0x3000_0000..0x3004_8000,
    0x3800_0000..0x3801_0000,
    0x3880_0000..0x3880_1000,
    0x6000_0000..0xE000_0000,
];
/// Complaint about descriptors.
pub(super) const RING_OUT_OF_REACH: &str =
    "RM0399 table 3: the Ethernet DMA does not reach the ring (TCM, or no memory): fatal bus error";
/// Complaint about buffers.
pub(super) const BUFFER_OUT_OF_REACH: &str =
    "RM0399 table 3: the Ethernet DMA does not reach a buffer (TCM, or no memory): fatal bus error";

/// Purpose of an access that the DMA makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Token {
    TransmitDescriptor,
    TransmitData,
    /// Write-back of a transmit descriptor.
    Close,
    ReceiveDescriptor,
    ReceiveData,
    /// Write-back of a receive descriptor.
    ReceiveClose,
    /// Look at the descriptor of a suspended receive channel.
    Look,
    /// Read of MACISR by which the DMA hands its interrupt to the block that has the line.
    Interrupt,
}

impl Token {
    const ALL: [Self; 8] = [
        Self::TransmitDescriptor,
        Self::TransmitData,
        Self::Close,
        Self::ReceiveDescriptor,
        Self::ReceiveData,
        Self::ReceiveClose,
        Self::Look,
        Self::Interrupt,
    ];

    pub(super) fn of(token: u64) -> Option<Self> {
        Self::ALL.into_iter().find(|&each| each as u64 == token)
    }
}

/// Whether the DMA can read all of these bytes.
pub(super) fn reads(address: u32, length: u32) -> bool {
    let (first, end) = (u64::from(address), u64::from(address) + u64::from(length));
    READS.iter().any(|range| range.start <= first && end <= range.end)
}

/// Whether the DMA can write all of these bytes.
pub(super) fn writes(address: u32, length: u32) -> bool {
    reads(address, length) && !READS[0].contains(&u64::from(address))
}

/// Returns the addresses of a descriptor's words.
pub(super) fn words_of(address: u32) -> [u32; 4] {
    [0, 4, 8, 12].map(|offset| address.wrapping_add(offset))
}

/// Returns the width of an access of so many bytes.
const fn width(bytes: u32) -> Width {
    match bytes {
        8 => Width::W64,
        4 => Width::W32,
        2 => Width::W16,
        _ => Width::W8,
    }
}

/// Asks for the words of a descriptor.
pub(super) fn read_words(address: u32, token: Token, context: &mut DeviceContext<'_>) {
    for word in words_of(address) {
        context.read_from(u64::from(word), Width::W32, token as u64);
    }
}

/// Asks for the bytes of a buffer.
pub(super) fn read(address: u32, length: u32, token: Token, context: &mut DeviceContext<'_>) {
    for (at, bytes) in pieces(address, length) {
        context.read_from(u64::from(at), width(bytes), token as u64);
    }
}

/// Writes bytes to a buffer.
pub(super) fn write(address: u32, bytes: &[u8], context: &mut DeviceContext<'_>) {
    let mut rest = bytes;
    for (at, count) in pieces(address, bytes.len() as u32) {
        let (piece, after) = rest.split_at(count as usize);
        let value = piece.iter().rev().fold(0, |value: u64, &byte| value << 8 | u64::from(byte));
        context.write_to(u64::from(at), width(count), value, Token::ReceiveData as u64);
        rest = after;
    }
}

/// Returns the address of the descriptor after this one, in a ring of `length` + 1.
pub(super) fn after(current: u32, base: u32, length: u32, skip: u32) -> u32 {
    let stride = BYTES + skip;
    let last = base.wrapping_add((length & 0x3FF) * stride);
    if current == last { base } else { current.wrapping_add(stride) }
}

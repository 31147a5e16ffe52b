//! The card's side: identification (SD physical layer 9.0, section 4.2 and 4.3) and what it says about
//! itself.

use super::SdError;
use super::controller::{Answer, Controller};
use crate::{time, wait};

/// How a card counts its addresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CardKind {
    /// Standard capacity: addresses are bytes.
    Standard,
    /// High or extended capacity: addresses are blocks.
    HighCapacity,
}

/// An identified card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CardInfo {
    /// How it is addressed.
    pub kind: CardKind,
    /// How many blocks of 512 bytes it holds.
    pub blocks: u32,
    /// The address it gave itself on the bus.
    pub(super) relative_address: u32,
}

impl CardInfo {
    /// The argument that names block `block` in a data command.
    pub(super) fn address_of(&self, block: u32) -> u32 {
        match self.kind {
            CardKind::Standard => block.wrapping_mul(512),
            CardKind::HighCapacity => block,
        }
    }
}

/// A card may take a second to get ready (section 4.2.3).
const READY_LIMIT_US: u64 = 1_000_000;
/// 2.7 to 3.6 V (section 5.1, OCR).
const OUR_VOLTAGES: u32 = 0x00FF_8000;
const HIGH_CAPACITY: u32 = 1 << 30;
const READY: u32 = 1 << 31;
/// CMD8: 2.7 to 3.6 V, and a pattern the card must repeat.
const INTERFACE_CONDITION: u32 = 0x1AA;
/// Error bits of the card status (section 4.10.1).
const STATUS_ERRORS: u32 = 0xFDF9_8008;

/// Finds the card and brings it to the transfer state, four bits wide at full speed.
pub(super) fn identify(bus: &mut Controller) -> Result<CardInfo, SdError> {
    bus.power_up();
    bus.command(0, 0, Answer::None)?;
    // Only cards since version 2 know CMD8, and only they may be of high capacity.
    let version_two = bus.command(8, INTERFACE_CONDITION, Answer::Short).is_ok();
    if version_two && bus.response() & 0xFFF != INTERFACE_CONDITION {
        return Err(SdError::Unsupported);
    }
    let conditions = wait_until_ready(bus, version_two)?;
    bus.command(2, 0, Answer::Long)?;
    bus.command(3, 0, Answer::Short)?;
    let relative_address = bus.response() & 0xFFFF_0000;
    bus.command(9, relative_address, Answer::Long)?;
    let blocks = blocks_of(bus.long_response())?;
    checked(bus, 7, relative_address)?;
    bus.wait_while_busy(7)?;
    checked(bus, 55, relative_address)?;
    // ACMD6: bus width of four bits.
    checked(bus, 6, 0b10)?;
    checked(bus, 16, 512)?;
    bus.speed_up();
    let kind = if conditions & HIGH_CAPACITY != 0 { CardKind::HighCapacity } else { CardKind::Standard };
    Ok(CardInfo { kind, blocks, relative_address })
}

/// A command with an R1 answer whose error bits are looked at.
pub(super) fn checked(bus: &mut Controller, index: u8, argument: u32) -> Result<u32, SdError> {
    bus.command(index, argument, Answer::Short)?;
    let status = bus.response();
    if status & STATUS_ERRORS != 0 { Err(SdError::Refused(index, status & STATUS_ERRORS)) } else { Ok(status) }
}

fn wait_until_ready(bus: &mut Controller, version_two: bool) -> Result<u32, SdError> {
    let argument = OUR_VOLTAGES | if version_two { HIGH_CAPACITY } else { 0 };
    let deadline = time::now().0 + READY_LIMIT_US;
    loop {
        // ACMD41 is CMD41 announced by CMD55; nobody answering to that means there is no SD card.
        bus.command(55, 0, Answer::Short).map_err(|_| SdError::NoCard)?;
        bus.command(41, argument, Answer::ShortUnchecked).map_err(|_| SdError::NoCard)?;
        let conditions = bus.response();
        if conditions & READY != 0 {
            return if conditions & OUR_VOLTAGES != 0 { Ok(conditions) } else { Err(SdError::Unsupported) };
        }
        if time::now().0 > deadline {
            return Err(SdError::NotResponding(41));
        }
        wait::pause(1_000);
    }
}

/// Capacity from the CSD register (section 5.3), most significant word first.
fn blocks_of(csd: [u32; 4]) -> Result<u32, SdError> {
    /// Bits `high` to `low` of the 128-bit register, as the specification numbers them; at most 32.
    fn field(csd: [u32; 4], high: u32, low: u32) -> u32 {
        let whole = csd.iter().fold(0_u128, |whole, word| whole << 32 | u128::from(*word));
        ((whole >> low) & ((1 << (high - low + 1)) - 1)) as u32
    }
    match field(csd, 127, 126) {
        0 => {
            // Version 1: capacity = (C_SIZE + 1) * 2^(C_SIZE_MULT + 2) * 2^READ_BL_LEN bytes.
            let shift = field(csd, 49, 47) + 2 + field(csd, 83, 80);
            Ok((field(csd, 73, 62) + 1) << shift.saturating_sub(9))
        }
        // Version 2: (C_SIZE + 1) * 512 KiB.
        1 => Ok((field(csd, 69, 48) + 1).saturating_mul(1024)),
        _ => Err(SdError::Unsupported),
    }
}

//! SCSI commands and their meaning. Pure: no bus, no medium.

use super::medium::{BLOCK_BYTES, State};
use super::reply::Reply;
use super::sense::{SENSE_BYTES, Sense};

/// Operation codes (SPC-4 table D.2, SBC-3 table 13).
mod operation {
    pub const TEST_UNIT_READY: u8 = 0x00;
    pub const REQUEST_SENSE: u8 = 0x03;
    pub const INQUIRY: u8 = 0x12;
    pub const MODE_SENSE_6: u8 = 0x1A;
    pub const START_STOP_UNIT: u8 = 0x1B;
    pub const PREVENT_ALLOW_MEDIUM_REMOVAL: u8 = 0x1E;
    pub const READ_FORMAT_CAPACITIES: u8 = 0x23;
    pub const READ_CAPACITY_10: u8 = 0x25;
    pub const READ_10: u8 = 0x28;
    pub const WRITE_10: u8 = 0x2A;
    pub const VERIFY_10: u8 = 0x2F;
    pub const SYNCHRONIZE_CACHE_10: u8 = 0x35;
    pub const MODE_SENSE_10: u8 = 0x5A;
    pub const SERVICE_ACTION_IN_16: u8 = 0x9E;
    pub const REPORT_LUNS: u8 = 0xA0;
}

/// SERVICE ACTION IN (16): READ CAPACITY (16).
const READ_CAPACITY_16: u8 = 0x10;
/// Vendor and product as INQUIRY has them, 8 and 16 characters.
const VENDOR: &str = "Velvet";
const PRODUCT: &str = "SD card";
const REVISION: &str = "1.0";

/// Range of consecutive blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blocks {
    /// Number of the first block.
    pub first: u32,
    /// Number of blocks, which may be 0.
    pub count: u32,
}

impl Blocks {
    /// Returns the size in bytes. A command names 65,535 blocks at most.
    pub const fn bytes(self) -> u32 {
        self.count * BLOCK_BYTES as u32
    }
}

/// Meaning of a command.
#[derive(Clone, Debug)]
pub enum Asked {
    /// No data to move.
    Nothing,
    /// Answer to be sent.
    Answer(Reply),
    /// Blocks to be read.
    Read(Blocks),
    /// Blocks to be written.
    Write(Blocks),
    /// Blocks to be checked for readability.
    Verify(Blocks),
    /// Allows or forbids removal of the medium.
    PreventRemoval(bool),
    /// Medium to be ejected.
    Eject,
}

/// State of the unit, as commands see it.
#[derive(Clone, Copy, Debug)]
pub struct Unit<'u> {
    /// Whether there is a medium.
    pub medium: State,
    /// Reason for the last command's failure.
    pub sense: Sense,
    /// Whether the host has forbidden removal of the medium.
    pub is_removal_prevented: bool,
    /// Serial number of the board.
    pub serial: &'u str,
}

fn half(command: &[u8; 16], at: usize) -> u16 {
    u16::from_be_bytes(part(command, at))
}

fn word(command: &[u8; 16], at: usize) -> u32 {
    u32::from_be_bytes(part(command, at))
}

/// Returns the bytes at an offset.
fn part<const N: usize>(command: &[u8; 16], at: usize) -> [u8; N] {
    command.get(at..).and_then(|rest| rest.first_chunk()).copied().unwrap_or([0; N])
}

/// Whether a command is carried out before the host has received a unit attention (SPC-4 section 5.14, SAM-5
/// section 5.14).
pub const fn comes_before_attention(command: &[u8; 16]) -> bool {
    matches!(command[0], operation::INQUIRY | operation::REQUEST_SENSE | operation::REPORT_LUNS)
}

/// Returns the meaning of a command.
///
/// # Errors
/// When the command cannot be carried out.
pub fn interpret(command: &[u8; 16], unit: &Unit<'_>) -> Result<Asked, Sense> {
    let blocks = || match unit.medium {
        State::Absent => Err(Sense::NO_MEDIUM),
        State::Ready { blocks, is_read_only, .. } => Ok((blocks, is_read_only)),
    };
    let answer = |reply: Reply, most: u32| Ok(Asked::Answer(reply.at_most(most)));
    let &[operation, first, second, ..] = command;
    match operation {
        operation::TEST_UNIT_READY | operation::SYNCHRONIZE_CACHE_10 => {
            // Data is on the medium when a write command ends, so there is no cache to empty.
            blocks().map(|_| Asked::Nothing)
        }
        operation::REQUEST_SENSE => {
            let sense = Reply::new().add(&unit.sense.data()).at_most(SENSE_BYTES as u32);
            answer(sense, command[4].into())
        }
        operation::INQUIRY => answer(inquiry(first & 1 != 0, second, unit)?, half(command, 3).into()),
        operation::REPORT_LUNS => {
            // A single entry of 8 bytes, unit 0 (SPC-4 table 215).
            answer(Reply::new().add(&[0, 0, 0, 8, 0, 0, 0, 0]).add(&[0; 8]), word(command, 6))
        }
        operation::MODE_SENSE_6 | operation::MODE_SENSE_10 => {
            let (_, is_read_only) = blocks()?;
            mode_sense(command, is_read_only).map(Asked::Answer)
        }
        operation::START_STOP_UNIT => match command[4] & 0b11 {
            // LOEJ without START ejects the medium.
            0b10 if unit.is_removal_prevented => Err(Sense::REMOVAL_PREVENTED),
            0b10 => Ok(Asked::Eject),
            // Only a person at the board can load a medium.
            _ => blocks().map(|_| Asked::Nothing),
        },
        operation::PREVENT_ALLOW_MEDIUM_REMOVAL => Ok(Asked::PreventRemoval(command[4] & 1 != 0)),
        operation::READ_FORMAT_CAPACITIES => answer(format_capacities(unit.medium), half(command, 7).into()),
        operation::READ_CAPACITY_10 => {
            let (count, _) = blocks()?;
            let reply = Reply::new().add(&count.saturating_sub(1).to_be_bytes());
            answer(reply.add(&(BLOCK_BYTES as u32).to_be_bytes()), u32::MAX)
        }
        operation::SERVICE_ACTION_IN_16 if first & 0x1F == READ_CAPACITY_16 => {
            let (count, _) = blocks()?;
            let last = u64::from(count).saturating_sub(1);
            let reply = Reply::new().add(&last.to_be_bytes()).add(&(BLOCK_BYTES as u32).to_be_bytes());
            // SBC-3 table 66: no protection, and logical blocks equal physical blocks.
            answer(reply.add(&[0; 20]), word(command, 10))
        }
        operation::READ_10 => within(blocks()?.0, command).map(Asked::Read),
        operation::WRITE_10 => {
            let (count, is_read_only) = blocks()?;
            if is_read_only { Err(Sense::READ_ONLY) } else { within(count, command).map(Asked::Write) }
        }
        // BYTCHK, where the host would send the expected data, is not supported.
        operation::VERIFY_10 if first & 0b110 != 0 => Err(Sense::BAD_FIELD),
        operation::VERIFY_10 => within(blocks()?.0, command).map(Asked::Verify),
        _ => Err(Sense::NO_SUCH_COMMAND),
    }
}

/// Returns the blocks that a ten-byte command names.
fn within(medium_blocks: u32, command: &[u8; 16]) -> Result<Blocks, Sense> {
    let (first, count) = (word(command, 2), u32::from(half(command, 7)));
    let is_within = first.checked_add(count).is_some_and(|end| end <= medium_blocks);
    if is_within { Ok(Blocks { first, count }) } else { Err(Sense::OUT_OF_RANGE) }
}

/// INQUIRY: returns the standard data, or one of two pages about the product (SPC-4 sections 6.6.2, 7.8).
fn inquiry(is_page: bool, page: u8, unit: &Unit<'_>) -> Result<Reply, Sense> {
    match (is_page, page) {
        // Direct-access device with a removable medium, SPC-2, and 31 more bytes.
        (false, 0) => {
            let head = Reply::new().add(&[0x00, 0x80, 0x04, 0x02, 31, 0, 0, 0]);
            Ok(head.text(VENDOR, 8).text(PRODUCT, 16).text(REVISION, 4))
        }
        // Page 0 lists the supported pages.
        (true, 0x00) => Ok(Reply::new().add(&[0, 0x00, 0, 2, 0x00, 0x80])),
        (true, 0x80) => {
            let length = unit.serial.len().min(32) as u8;
            Ok(Reply::new().add(&[0, 0x80, 0, length]).text(unit.serial, length.into()))
        }
        _ => Err(Sense::BAD_FIELD),
    }
}

/// MODE SENSE: returns the header, and the caching page if requested (SPC-4 sections 6.13, 7.5; SBC-3 section
/// 6.5.6): neither reads nor writes are cached.
fn mode_sense(command: &[u8; 16], is_read_only: bool) -> Result<Reply, Sense> {
    const CACHING: u8 = 0x08;
    const ALL: u8 = 0x3F;
    let is_short = command[0] == operation::MODE_SENSE_6;
    let (control, page) = (command[2] >> 6, command[2] & 0x3F);
    // Saved values are not supported.
    if control == 0b11 {
        return Err(Sense { key: 0x5, code: [0x39, 0x00] });
    }
    // RCD, bit 0 of byte 2 of the caching page, says that reads are not cached. No value can be changed.
    let caching = [CACHING, 0x12, if control == 0b01 { 0 } else { 0x01 }];
    let pages = match page {
        CACHING | ALL => Reply::new().add(&caching).add(&[0; 17]),
        0x00 => Reply::new(),
        _ => return Err(Sense::BAD_FIELD),
    };
    let protected = if is_read_only { 0x80 } else { 0 };
    let length = pages.bytes().len() as u8;
    let (head, most) = if is_short {
        (Reply::new().add(&[3 + length, 0, protected, 0]), u32::from(command[4]))
    } else {
        (Reply::new().add(&[0, 6 + length, 0, protected, 0, 0, 0, 0]), u32::from(half(command, 7)))
    };
    Ok(head.add(pages.bytes()).at_most(most))
}

/// READ FORMAT CAPACITIES (MMC-6 section 6.23): returns formatted media, or no medium.
fn format_capacities(medium: State) -> Reply {
    let (blocks, kind) = match medium {
        State::Ready { blocks, .. } => (blocks, 0b10),
        State::Absent => (0, 0b11),
    };
    let [_, a, b, c] = (BLOCK_BYTES as u32).to_be_bytes();
    Reply::new().add(&[0, 0, 0, 8]).add(&blocks.to_be_bytes()).add(&[kind, a, b, c])
}

#[cfg(test)]
#[path = "scsi_tests.rs"]
mod tests;

//! Journal of an image's operations on its flash, and effects of a power failure during each.
//!
//! Runs of a board are repeatable, so the flash before any operation can be rebuilt from the journal. RM0399
//! section 4.7.9 and the data sheet promise nothing of a word or a sector whose operation was cut off: it may
//! read as before, as after, as something between, or not at all, as the error correction of 256 bits gives
//! up.

use std::collections::BTreeSet;

use rigless::emulator::{Access, AccessKind, Host};
use rigless::soc::Width;
use rigless::soc::stm32h743::generated::flash::Register;

use crate::mcu::PrimeMcu;

/// Address of the flash.
pub const START: u64 = 0x0800_0000;
/// Size of the flash, bytes.
pub const BYTES: usize = 2 << 20;
/// Size of a flash word, bytes, which is programmed at once (RM0399 section 4.3.9).
pub const WORD: usize = 32;
/// Size of a sector, bytes (RM0399 section 4.3.4).
pub const SECTOR: usize = 128 << 10;
/// Registers of the interface; bank 2 has its own 0x100 above those of bank 1 (RM0399 section 4.9).
const REGISTERS: u64 = 0x5200_2000;
const BANK: u64 = 0x100;
const CR: u64 = 0x0C;
/// Bits SER and START of FLASH_CR, and QW of FLASH_SR.
const ERASES: u64 = 1 << 2 | 1 << 7;
const QW: u64 = 1 << 2;

/// An operation on the flash.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Operation {
    /// Programming of a word, by its offset in the flash.
    Program(usize, [u8; WORD]),
    /// Erasing of a sector, by its number.
    Erase(usize),
}

/// Journal of operations, where one was asked for.
#[derive(Debug, Default)]
pub struct FlashJournal {
    keeps: bool,
    operations: Vec<Operation>,
    word: [u8; WORD],
    /// Bytes of the word that have been stored, a bit each.
    stored: u32,
}

impl FlashJournal {
    /// Keeps a journal from now on.
    pub const fn keep(&mut self) {
        self.keeps = true;
    }

    /// Returns the operations so far.
    #[must_use]
    pub fn operations(&self) -> &[Operation] {
        &self.operations
    }

    /// Takes note of a settled access of the image. Returns an operation that it has begun.
    pub(crate) fn notice(&mut self, access: &Access, mcu: &PrimeMcu) -> Option<Operation> {
        if access.kind != AccessKind::Write {
            return None;
        }
        let operation = match access.address {
            at if (START..START + BYTES as u64).contains(&at) => self.store(at - START, access, mcu),
            at if at == REGISTERS + CR || at == REGISTERS + BANK + CR => {
                let sector = (access.value >> 8 & 7) as usize + if at >= REGISTERS + BANK { 8 } else { 0 };
                (access.value & ERASES == ERASES).then_some(Operation::Erase(sector))
            }
            _ => None,
        }?;
        if self.keeps {
            self.operations.push(operation.clone());
        }
        Some(operation)
    }

    fn store(&mut self, at: u64, access: &Access, mcu: &PrimeMcu) -> Option<Operation> {
        let within = at as usize % WORD;
        let bytes = access.value.to_le_bytes();
        let count = access.width.bytes() as usize;
        self.word.get_mut(within..within + count)?.copy_from_slice(&bytes[..count]);
        self.stored |= (((1_u64 << count) - 1) << within) as u32;
        if self.stored != u32::MAX {
            return None;
        }
        self.stored = 0;
        // Without PG the stores are refused, and nothing is queued.
        let status = mcu.flash_register(if (at as usize) < BYTES / 2 { Register::Sr1 } else { Register::Sr2 });
        (status & QW != 0).then_some(Operation::Program(at as usize - within, self.word))
    }
}

/// State of an operation that a power failure cuts off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Torn {
    /// The operation has not begun.
    NotBegun,
    /// The word cannot be read; in a sector, some words are erased, some cannot be read, some are as before.
    Unreadable,
    /// The word reads as something between; in a sector, some words do, some are erased.
    Between,
}

/// Contents of the flash as a power failure leaves them.
#[derive(Clone)]
pub struct FlashContent {
    bytes: Vec<u8>,
    /// Words that cannot be read, by their offsets.
    spoiled: BTreeSet<usize>,
}

impl Default for FlashContent {
    fn default() -> Self {
        Self { bytes: vec![0xFF; BYTES], spoiled: BTreeSet::new() }
    }
}

impl FlashContent {
    /// Stores bytes at an offset, as a debug probe does.
    pub fn put(&mut self, at: usize, bytes: &[u8]) {
        self.bytes[at..at + bytes.len()].copy_from_slice(bytes);
    }

    /// Returns all bytes; those of unreadable words are arbitrary.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Returns the word at an offset; `None` where it cannot be read.
    #[must_use]
    pub fn word(&self, at: usize) -> Option<[u8; WORD]> {
        let word = self.bytes.get(at..at + WORD)?.try_into().ok()?;
        (!self.spoiled.contains(&at)).then_some(word)
    }

    /// Carries an operation out.
    pub fn apply(&mut self, operation: &Operation) {
        match operation {
            Operation::Program(at, word) => {
                // Programming only clears bits (RM0399 section 4.3.9).
                let old = &mut self.bytes[*at..*at + WORD];
                old.iter_mut().zip(word).for_each(|(old, new)| *old &= new);
            }
            Operation::Erase(sector) => {
                self.bytes[sector * SECTOR..(sector + 1) * SECTOR].fill(0xFF);
                self.spoiled.retain(|at| at / SECTOR != *sector);
            }
        }
    }

    /// Leaves an operation as a power failure during it does.
    pub fn tear(&mut self, operation: &Operation, torn: Torn) {
        match (operation, torn) {
            (_, Torn::NotBegun) => {}
            (Operation::Program(at, _), Torn::Unreadable) => {
                self.spoiled.insert(*at);
            }
            (Operation::Program(at, word), Torn::Between) => {
                for (index, (old, new)) in self.bytes[*at..*at + WORD].iter_mut().zip(word).enumerate() {
                    *old &= new | if index % 2 == 0 { 0x55 } else { 0xAA };
                }
            }
            (Operation::Erase(sector), torn) => {
                for (index, at) in (sector * SECTOR..(sector + 1) * SECTOR).step_by(WORD).enumerate() {
                    let word = &mut self.bytes[at..at + WORD];
                    match (index % 3, torn) {
                        (0, _) => word.fill(0xFF),
                        (1, Torn::Unreadable) => {
                            self.spoiled.insert(at);
                        }
                        (1, _) => word.iter_mut().for_each(|byte| *byte |= 0x0F),
                        _ => {}
                    }
                }
            }
        }
    }

    /// Makes unreadable words unreadable to the image as well. The flash's bytes are loaded already.
    pub fn spoil(&self, host: &mut dyn Host) {
        for at in &self.spoiled {
            host.spoil(START + *at as u64, WORD as u64, true);
        }
    }

    /// Reads the flash of a running board.
    ///
    /// # Errors
    /// The emulator does not give it.
    pub fn read(host: &mut dyn Host) -> Result<Self, rigless::emulator::Error> {
        let mut content = Self::default();
        for at in (0..BYTES).step_by(8) {
            let value = host.read(START + at as u64, Width::W64)?;
            content.bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
        }
        Ok(content)
    }

    /// Returns the flash as an ELF file, for [`crate::vm::Vm::start`].
    #[must_use]
    pub fn elf(&self) -> Vec<u8> {
        const HEADER: usize = 52;
        const SEGMENT: usize = 32;
        let used = |sector: &usize| self.bytes[sector * SECTOR..(sector + 1) * SECTOR].iter().any(|byte| *byte != 0xFF);
        let sectors: Vec<usize> = (0..BYTES / SECTOR).filter(used).collect();
        let mut elf = vec![0x7F, b'E', b'L', b'F', 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        // The file is executable, for ARM, version 1; its entry is that of the vector table.
        let entry: [u8; 4] = self.bytes[4..8].try_into().unwrap_or_default();
        elf.extend([2, 0, 40, 0, 1, 0, 0, 0]);
        elf.extend(entry);
        let words = |elf: &mut Vec<u8>, words: &[u32]| words.iter().for_each(|word| elf.extend(word.to_le_bytes()));
        words(&mut elf, &[HEADER as u32, 0, 0x0500_0200]);
        let halves = [HEADER, SEGMENT, sectors.len(), 40, 0, 0];
        halves.iter().for_each(|half| elf.extend((*half as u16).to_le_bytes()));
        for (place, sector) in sectors.iter().enumerate() {
            let offset = (HEADER + SEGMENT * sectors.len() + place * SECTOR) as u32;
            let address = START as u32 + (sector * SECTOR) as u32;
            words(&mut elf, &[1, offset, address, address, SECTOR as u32, SECTOR as u32, 5, 4]);
        }
        sectors.iter().for_each(|sector| elf.extend(&self.bytes[sector * SECTOR..(sector + 1) * SECTOR]));
        elf
    }
}

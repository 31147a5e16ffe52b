//! A card in memory that can lose its power.

use std::collections::BTreeMap;
use std::io::{self, Cursor, ErrorKind, Read, Seek, SeekFrom, Write};
use std::rc::Rc;
use std::vec::Vec;

use fatfs::{FatType, FileSystem, FormatVolumeOptions, FsOptions};

use crate::fat::{BLOCK_BYTES, Block, Blocks, Volume};

/// First block of the volume on the card.
pub const FIRST_BLOCK: u32 = 63;

/// Error of every access after the power has gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Off;

/// A formatted card and what has been written over it.
#[derive(Clone)]
pub struct Card {
    formatted: Rc<Vec<u8>>,
    written: BTreeMap<u32, Block>,
    pub reads: u32,
    pub writes: u32,
    pub writes_left: Option<u32>,
    /// Limit of reads; more are a hang.
    pub read_limit: u32,
}

/// Parameters of the volume to make.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    pub kind: FatType,
    pub clusters: u32,
    pub blocks_per_cluster: u32,
    pub root_entries: u16,
    pub tables: u8,
}

impl Format {
    /// The smallest FAT16 volume, with clusters of one block: directories grow soon.
    pub const FAT16: Self =
        Self { kind: FatType::Fat16, clusters: 4_100, blocks_per_cluster: 1, root_entries: 128, tables: 2 };
    /// The smallest FAT32 volume.
    pub const FAT32: Self =
        Self { kind: FatType::Fat32, clusters: 65_600, blocks_per_cluster: 1, root_entries: 0, tables: 2 };
}

impl Card {
    pub fn new(format: Format) -> Self {
        let entry_bytes = if format.kind == FatType::Fat16 { 2 } else { 4 };
        let table_blocks = (format.clusters + 2) * entry_bytes / 512 + 1;
        let blocks = 40
            + table_blocks * u32::from(format.tables)
            + u32::from(format.root_entries) / 16
            + format.clusters * format.blocks_per_cluster;
        let mut options = FormatVolumeOptions::new()
            .fat_type(format.kind)
            .bytes_per_cluster(format.blocks_per_cluster * 512)
            .total_sectors(blocks)
            .fats(format.tables)
            .volume_label(*b"PRINTS     ");
        if format.root_entries > 0 {
            options = options.max_root_dir_entries(format.root_entries);
        }
        let mut image = Cursor::new(vec![0; blocks as usize * BLOCK_BYTES]);
        fatfs::format_volume(&mut image, options).unwrap();
        let formatted = Rc::new(image.into_inner());
        Self { formatted, written: BTreeMap::new(), reads: 0, writes: 0, writes_left: None, read_limit: u32::MAX }
    }

    /// Copies the card, with power for so many writes.
    pub fn powered_for(&self, writes: Option<u32>) -> Self {
        Self { reads: 0, writes: 0, writes_left: writes, ..self.clone() }
    }

    pub fn blocks(&self) -> u32 {
        (self.formatted.len() / BLOCK_BYTES) as u32
    }

    pub fn mount(&mut self) -> Volume {
        let blocks = self.blocks();
        Volume::open(self, FIRST_BLOCK, blocks).unwrap()
    }

    /// Returns the number of clusters of the volume, as the other tool counts.
    pub fn clusters(&self) -> u32 {
        let mut copy = self.clone();
        let other = FileSystem::new(copy.as_file(), FsOptions::new()).unwrap();
        other.stats().unwrap().total_clusters()
    }

    /// Returns the number of free clusters.
    pub fn free_clusters(&self) -> u32 {
        let mut copy = self.clone();
        let other = FileSystem::new(copy.as_file(), FsOptions::new()).unwrap();
        other.stats().unwrap().free_clusters()
    }

    /// A block of the volume, counted from its beginning.
    pub fn block(&self, number: u32) -> Block {
        let at = number as usize * BLOCK_BYTES;
        self.written.get(&number).copied().unwrap_or_else(|| self.formatted[at..at + BLOCK_BYTES].try_into().unwrap())
    }

    pub fn set_block(&mut self, number: u32, block: Block) {
        self.written.insert(number, block);
    }

    /// Returns the volume as a file for other tools.
    pub fn as_file(&mut self) -> CardFile<'_> {
        CardFile { card: self, at: 0 }
    }
}

impl Blocks for Card {
    type Error = Off;

    fn read(&mut self, number: u32, block: &mut Block) -> Result<(), Off> {
        self.reads += 1;
        assert!(self.reads < self.read_limit, "it hangs");
        let number =
            number.checked_sub(FIRST_BLOCK).filter(|number| *number < self.blocks()).expect("within the volume");
        *block = self.block(number);
        Ok(())
    }

    fn write(&mut self, number: u32, block: &Block) -> Result<(), Off> {
        let number =
            number.checked_sub(FIRST_BLOCK).filter(|number| *number < self.blocks()).expect("within the volume");
        if self.writes_left == Some(0) {
            return Err(Off);
        }
        self.writes_left = self.writes_left.map(|left| left - 1);
        self.writes += 1;
        self.set_block(number, *block);
        Ok(())
    }
}

pub struct CardFile<'a> {
    card: &'a mut Card,
    at: u64,
}

impl Read for CardFile<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let (number, offset) = ((self.at / 512) as u32, (self.at % 512) as usize);
        if number >= self.card.blocks() {
            return Ok(0);
        }
        let count = buffer.len().min(512 - offset);
        buffer[..count].copy_from_slice(&self.card.block(number)[offset..offset + count]);
        self.at += count as u64;
        Ok(count)
    }
}

impl Write for CardFile<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let (number, offset) = ((self.at / 512) as u32, (self.at % 512) as usize);
        if number >= self.card.blocks() {
            return Err(ErrorKind::WriteZero.into());
        }
        let count = bytes.len().min(512 - offset);
        let mut block = self.card.block(number);
        block[offset..offset + count].copy_from_slice(&bytes[..count]);
        self.card.set_block(number, block);
        self.at += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for CardFile<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.at = match to {
            SeekFrom::Start(at) => at,
            SeekFrom::Current(by) => self.at.checked_add_signed(by).ok_or(ErrorKind::InvalidInput)?,
            SeekFrom::End(by) => {
                (u64::from(self.card.blocks()) * 512).checked_add_signed(by).ok_or(ErrorKind::InvalidInput)?
            }
        };
        Ok(self.at)
    }
}

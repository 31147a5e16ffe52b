//! A FAT or exFAT volume: its place on the card, and reading of its files.

mod search;

#[cfg(test)]
mod tests;

pub use search::{NoVolume, find};

use crate::fat::{Attributes, Blocks, Error, Name, Place, Stamp};
use crate::{exfat, fat};

/// The volume of a card.
#[derive(Debug)]
pub enum Volume {
    /// FAT16 or FAT32 volume.
    Fat(fat::Volume),
    /// exFAT volume, only read.
    Exfat(exfat::Volume),
}

/// Position along a file.
#[derive(Clone, Copy, Debug)]
pub enum FileReader {
    /// File of a FAT volume.
    Fat(fat::Reader),
    /// File of an exFAT volume.
    Exfat(exfat::Reader),
}

impl FileReader {
    /// Returns the file's length in bytes.
    #[must_use]
    pub const fn size_bytes(&self) -> u32 {
        match self {
            Self::Fat(reader) => reader.size_bytes(),
            Self::Exfat(reader) => reader.size_bytes(),
        }
    }

    /// Reads from this offset to the end of its block at most; 0 at the end of the file.
    ///
    /// # Errors
    /// [`Error::Damaged`], or the device's.
    pub fn read<B: Blocks>(
        &mut self,
        volume: &mut Volume,
        device: &mut B,
        offset: u32,
        buffer: &mut [u8],
    ) -> Result<usize, Error<B::Error>> {
        match (self, volume) {
            (Self::Fat(reader), Volume::Fat(volume)) => reader.read(volume, device, offset, buffer),
            (Self::Exfat(reader), Volume::Exfat(volume)) => reader.read(volume, device, offset, buffer),
            _ => Err(Error::NotFound),
        }
    }

    /// Returns the blocks of the file's cluster at this offset, and their number; `None` at the end.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn stretch<B: Blocks>(
        &mut self,
        volume: &mut Volume,
        device: &mut B,
        offset: u32,
    ) -> Result<Option<(u32, u32)>, Error<B::Error>> {
        match (self, volume) {
            (Self::Fat(reader), Volume::Fat(volume)) => reader.stretch(volume, device, offset),
            (Self::Exfat(reader), Volume::Exfat(volume)) => reader.stretch(volume, device, offset),
            _ => Err(Error::NotFound),
        }
    }
}

/// Directory listing in progress.
#[derive(Clone, Copy, Debug)]
pub enum Listing {
    /// Directory of a FAT volume.
    Fat(fat::Listing),
    /// Directory of an exFAT volume.
    Exfat(exfat::Listing),
}

/// Properties of an entry.
#[derive(Clone, Copy, Debug)]
pub struct Facts {
    /// Size in bytes; of a directory 0.
    pub size_bytes: u32,
    /// Attribute bits of the entry.
    pub attributes: Attributes,
    /// Time of the last write.
    pub written: Stamp,
    /// First cluster; 0 where there is none, or where the volume is only read.
    pub first: u32,
}

impl Facts {
    fn of_fat(entry: &fat::Entry) -> Self {
        Self {
            size_bytes: entry.size_bytes(),
            attributes: entry.attributes(),
            written: entry.written(),
            first: entry.cluster(),
        }
    }

    const fn of_exfat(entry: &exfat::Entry) -> Self {
        Self { size_bytes: entry.size_bytes(), attributes: entry.attributes(), written: entry.written(), first: 0 }
    }
}

impl Listing {
    /// Lists the directory of this path, which begins below the root.
    ///
    /// # Errors
    /// Those of the volume's own `list`.
    pub fn start<B: Blocks>(volume: &mut Volume, device: &mut B, path: &str) -> Result<Self, Error<B::Error>> {
        match volume {
            Volume::Fat(volume) => volume.list(device, path).map(Self::Fat),
            Volume::Exfat(volume) => volume.list(device, path).map(Self::Exfat),
        }
    }

    /// Returns the next file or directory and its name; `None` behind the last.
    ///
    /// # Errors
    /// [`Error::Damaged`], or the device's.
    pub fn next<B: Blocks>(
        &mut self,
        volume: &mut Volume,
        device: &mut B,
        name: &mut Name,
    ) -> Result<Option<Facts>, Error<B::Error>> {
        match (self, volume) {
            (Self::Fat(listing), Volume::Fat(volume)) => {
                Ok(listing.next(volume, device, name)?.map(|entry| Facts::of_fat(&entry)))
            }
            (Self::Exfat(listing), Volume::Exfat(volume)) => {
                Ok(listing.next(volume, device, name)?.map(|entry| Facts::of_exfat(&entry)))
            }
            _ => Ok(None),
        }
    }
}

/// Finds a file or directory: returns its properties, and the place of its entry.
///
/// # Errors
/// [`Error::NotFound`], and those of the volume.
pub fn find_facts<B: Blocks>(
    volume: &mut Volume,
    device: &mut B,
    path: &str,
) -> Result<(Facts, Place), Error<B::Error>> {
    match volume {
        Volume::Fat(volume) => volume.find(device, path).map(|entry| (Facts::of_fat(&entry), entry.place())),
        Volume::Exfat(volume) => volume.find(device, path).map(|entry| (Facts::of_exfat(&entry), entry.place())),
    }
}

/// Opens a file for reading: returns its reader, and the place of its entry.
///
/// # Errors
/// [`Error::NotFound`], [`Error::IsDirectory`], [`Error::ReadOnly`] for one of exFAT's that has more than
/// 4 GB, and those of the volume.
pub fn find_file<B: Blocks>(
    volume: &mut Volume,
    device: &mut B,
    path: &str,
) -> Result<(FileReader, Place), Error<B::Error>> {
    match volume {
        Volume::Fat(volume) => {
            let entry = volume.find(device, path)?;
            if entry.is_directory() {
                Err(Error::IsDirectory)
            } else {
                Ok((FileReader::Fat(fat::Reader::new(&entry)), entry.place()))
            }
        }
        Volume::Exfat(volume) => {
            let entry = volume.find(device, path)?;
            if entry.is_directory() {
                return Err(Error::IsDirectory);
            }
            if entry.is_too_large() {
                Err(Error::ReadOnly)
            } else {
                Ok((FileReader::Exfat(entry.reader()), entry.place()))
            }
        }
    }
}

//! A volume of either kind, and the way along a file on it.

use drivers::fat::{Attributes, Blocks, Error, Name, Place, Stamp};
use drivers::{exfat, fat};

/// The volume of the card.
pub(crate) enum Mounted {
    /// FAT16 or FAT32.
    Fat(fat::Volume),
    /// Only read.
    Exfat(exfat::Volume),
}

/// The way along a file.
#[derive(Clone, Copy)]
pub(crate) enum FileReader {
    Fat(fat::Reader),
    Exfat(exfat::Reader),
}

impl FileReader {
    pub const fn size_bytes(&self) -> u32 {
        match self {
            Self::Fat(reader) => reader.size_bytes(),
            Self::Exfat(reader) => reader.size_bytes(),
        }
    }

    /// Reads from this offset to the end of its block at most; 0 at the end of the file.
    pub fn read<B: Blocks>(
        &mut self,
        volume: &mut Mounted,
        device: &mut B,
        offset: u32,
        buffer: &mut [u8],
    ) -> Result<usize, Error<B::Error>> {
        match (self, volume) {
            (Self::Fat(reader), Mounted::Fat(volume)) => reader.read(volume, device, offset, buffer),
            (Self::Exfat(reader), Mounted::Exfat(volume)) => reader.read(volume, device, offset, buffer),
            _ => Err(Error::NotFound),
        }
    }

    /// The blocks of its cluster at this offset, and how many; `None` at the end.
    pub fn stretch<B: Blocks>(
        &mut self,
        volume: &mut Mounted,
        device: &mut B,
        offset: u32,
    ) -> Result<Option<(u32, u32)>, Error<B::Error>> {
        match (self, volume) {
            (Self::Fat(reader), Mounted::Fat(volume)) => reader.stretch(volume, device, offset),
            (Self::Exfat(reader), Mounted::Exfat(volume)) => reader.stretch(volume, device, offset),
            _ => Err(Error::NotFound),
        }
    }
}

/// A directory that is listed.
pub(crate) enum Listing {
    Fat(fat::Listing),
    Exfat(exfat::Listing),
}

/// What is said of an entry.
pub(crate) struct Facts {
    pub size_bytes: u32,
    pub attributes: Attributes,
    pub written: Stamp,
}

impl Listing {
    pub fn start<B: Blocks>(volume: &mut Mounted, device: &mut B, path: &str) -> Result<Self, Error<B::Error>> {
        match volume {
            Mounted::Fat(volume) => volume.list(device, path).map(Self::Fat),
            Mounted::Exfat(volume) => volume.list(device, path).map(Self::Exfat),
        }
    }

    pub fn next<B: Blocks>(
        &mut self,
        volume: &mut Mounted,
        device: &mut B,
        name: &mut Name,
    ) -> Result<Option<Facts>, Error<B::Error>> {
        match (self, volume) {
            (Self::Fat(listing), Mounted::Fat(volume)) => Ok(listing.next(volume, device, name)?.map(|entry| Facts {
                size_bytes: entry.size_bytes(),
                attributes: entry.attributes(),
                written: entry.written(),
            })),
            (Self::Exfat(listing), Mounted::Exfat(volume)) => Ok(listing.next(volume, device, name)?.map(|entry| {
                Facts { size_bytes: entry.size_bytes(), attributes: entry.attributes(), written: entry.written() }
            })),
            _ => Ok(None),
        }
    }
}

/// A file to be read: its way, and where its entry is.
pub(crate) fn find_file<B: Blocks>(
    volume: &mut Mounted,
    device: &mut B,
    path: &str,
) -> Result<(FileReader, Place), Error<B::Error>> {
    match volume {
        Mounted::Fat(volume) => {
            let entry = volume.find(device, path)?;
            if entry.is_directory() {
                Err(Error::IsDirectory)
            } else {
                Ok((FileReader::Fat(fat::Reader::new(&entry)), entry.place()))
            }
        }
        Mounted::Exfat(volume) => {
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

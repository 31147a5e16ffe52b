//! Directories: sets of entries that stand for files (sections 6 and 7).

use super::{ENTRY_BYTES, Reader, Volume, small};
use crate::fat::{Attributes, Blocks, Error, Name, Place, Stamp, half, word};

/// Types of entries (sections 7.4, 7.6 and 7.7).
const END: u8 = 0;
const FILE: u8 = 0x85;
const STREAM: u8 = 0xC0;
const NAME: u8 = 0xC1;
/// UTF-16 units of a name's entry.
const UNITS: usize = 15;
/// Most entries behind the first of a set: a stream, up to 17 of the name (section 7.4.1), and additions of
/// other systems.
const MOST_SECONDARIES: u8 = 18;
/// Greatest length read of a directory, 256 MB (section 7).
const LARGEST_BYTES: u32 = 256 << 20;

/// A file or a directory.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    reader: Reader,
    attributes: Attributes,
    written: Stamp,
    place: Place,
    /// The file is larger than 4 GB.
    is_too_large: bool,
}

impl Entry {
    /// Attribute bits: those of FAT.
    #[must_use]
    pub const fn attributes(&self) -> Attributes {
        self.attributes
    }

    /// Returns whether the entry is a directory.
    #[must_use]
    pub const fn is_directory(&self) -> bool {
        self.attributes.has(Attributes::DIRECTORY)
    }

    /// Size in bytes; of a directory zero.
    #[must_use]
    pub const fn size_bytes(&self) -> u32 {
        if self.is_directory() { 0 } else { self.reader.size_bytes() }
    }

    /// Returns the time of the last write.
    #[must_use]
    pub const fn written(&self) -> Stamp {
        self.written
    }

    /// Returns the place of the entry's set, unique among the entries.
    #[must_use]
    pub const fn place(&self) -> Place {
        self.place
    }

    /// Returns whether the file is too large to be read here.
    #[must_use]
    pub const fn is_too_large(&self) -> bool {
        self.is_too_large
    }

    /// Returns a reader of the entry's contents.
    #[must_use]
    pub const fn reader(&self) -> Reader {
        self.reader
    }
}

/// The entries of a directory, one after the other.
#[derive(Clone, Copy, Debug)]
pub struct Listing {
    reader: Reader,
    offset: u32,
}

/// The bytes of an entry.
type Bytes = [u8; ENTRY_BYTES];

/// Set of entries, as far as read.
struct Set {
    first: Bytes,
    stream: Bytes,
    place: Place,
    sum: u16,
    left: u8,
}

impl Listing {
    const fn of(reader: Reader) -> Self {
        Self { reader, offset: 0 }
    }

    fn entry<B: Blocks>(&mut self, volume: &Volume, device: &mut B) -> Result<Option<(Bytes, Place)>, Error<B::Error>> {
        let mut bytes = [0; ENTRY_BYTES];
        let Some((block, _)) = self.reader.stretch(volume, device, self.offset)? else { return Ok(None) };
        if self.reader.read(volume, device, self.offset, &mut bytes)? < ENTRY_BYTES {
            return Ok(None);
        }
        let place = Place { block, slot: (self.offset as usize % 512 / ENTRY_BYTES) as u8 };
        self.offset += ENTRY_BYTES as u32;
        Ok(Some((bytes, place)))
    }

    /// The next file or directory and its name; `None` behind the last. Sets that are not whole are passed
    /// over.
    ///
    /// # Errors
    /// [`Error::Damaged`], or the device's.
    pub fn next<B: Blocks>(
        &mut self,
        volume: &Volume,
        device: &mut B,
        name: &mut Name,
    ) -> Result<Option<Entry>, Error<B::Error>> {
        let (mut set, mut units, mut count) = (None::<Set>, [0_u16; 18 * UNITS], 0);
        while let Some((bytes, place)) = self.entry(volume, device)? {
            let kind = bytes[0];
            if kind == END {
                // Nothing follows, now and when it is asked again.
                self.offset -= ENTRY_BYTES as u32;
                return Ok(None);
            }
            if kind == FILE {
                count = 0;
                let sum = checksum(0, &bytes, true);
                set = Some(Set { first: bytes, stream: [0; ENTRY_BYTES], place, sum, left: bytes[1] });
                if !(2..=MOST_SECONDARIES).contains(&bytes[1]) {
                    set = None;
                }
                continue;
            }
            let Some(open) = &mut set else { continue };
            // An unused or non-secondary entry ends a set that is not whole.
            if kind & 0xC0 != 0xC0 {
                set = None;
                continue;
            }
            open.sum = checksum(open.sum, &bytes, false);
            open.left -= 1;
            match kind {
                STREAM => open.stream = bytes,
                NAME => {
                    for place in 0..UNITS {
                        if let Some(unit) = units.get_mut(count) {
                            *unit = half(&bytes, 2 + place * 2);
                            count += 1;
                        }
                    }
                }
                _ => {}
            }
            if open.left > 0 {
                continue;
            }
            let length = usize::from(open.stream[3]);
            if open.sum == half(&open.first, 2) && open.stream[0] == STREAM && (1..=count).contains(&length) {
                name.set(units.iter().copied().take(length));
                return Ok(Some(finished(open)));
            }
            set = None;
        }
        Ok(None)
    }
}

/// Adds bytes to the sum of section 6.3.3: all bytes of the set, but those of the checksum itself.
fn checksum(sum: u16, bytes: &[u8], is_first: bool) -> u16 {
    bytes
        .iter()
        .enumerate()
        .filter(|(at, _)| !(is_first && matches!(at, 2 | 3)))
        .fold(sum, |sum, (_, byte)| sum.rotate_right(1).wrapping_add(u16::from(*byte)))
}

fn finished(set: &Set) -> Entry {
    const NO_FAT_CHAIN: u8 = 2;
    let stream = &set.stream;
    let (size, valid) = (small(stream, 24), small(stream, 8));
    Entry {
        reader: Reader::new(word(stream, 20), size, valid.min(size), stream[1] & NO_FAT_CHAIN != 0),
        attributes: Attributes(set.first[4]),
        written: Stamp { date: half(&set.first, 14), time: half(&set.first, 12) },
        place: set.place,
        is_too_large: size == u32::MAX,
    }
}

impl Volume {
    /// The entry of this path; parts are divided by `/`.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::IsFile`] for a part that should be a directory, [`Error::BadName`] for
    /// the root, which has no entry, [`Error::Damaged`], or the device's.
    pub fn find<B: Blocks>(&self, device: &mut B, path: &str) -> Result<Entry, Error<B::Error>> {
        let mut found = None::<Entry>;
        for part in path.split('/').filter(|part| !part.is_empty()) {
            let mut listing = self.listing_of(found.as_ref())?;
            let (wanted, mut name) = (Name::parse(part).ok_or(Error::NotFound)?, Name::new());
            found = None;
            while let Some(entry) = listing.next(self, device, &mut name)? {
                if wanted.same(name.units().iter().copied()) {
                    found = Some(entry);
                    break;
                }
            }
            if found.is_none() {
                return Err(Error::NotFound);
            }
        }
        found.ok_or(Error::BadName)
    }

    /// The entries of a directory; of the root for an empty path.
    ///
    /// # Errors
    /// As [`find`](Self::find).
    pub fn list<B: Blocks>(&self, device: &mut B, path: &str) -> Result<Listing, Error<B::Error>> {
        match self.find(device, path) {
            Err(Error::BadName) => self.listing_of(None),
            found => self.listing_of(Some(&found?)),
        }
    }

    fn listing_of<E>(&self, directory: Option<&Entry>) -> Result<Listing, Error<E>> {
        match directory {
            // The length of the root directory is recorded nowhere: it extends to the end of its chain, or to
            // an end entry.
            None => {
                let most = self.clusters().saturating_mul(self.cluster_bytes()).min(LARGEST_BYTES);
                Ok(Listing::of(Reader::of_root(self.root, most)))
            }
            Some(entry) if entry.is_directory() => Ok(Listing::of(entry.reader)),
            Some(_) => Err(Error::IsFile),
        }
    }
}

//! Finding entries by name, and listing them.

use super::cursor::Cursor;
use super::disk::Disk;
use super::entry::Entry;
use super::geometry::Directory;
use super::name::{Assembly, Name};
use super::short_name;
use super::slot::{Attributes, Place, SlotKind, kind_of, short_name};
use super::{Blocks, Error, Volume};

/// The entries of a directory, one after the other. The listing may be kept between calls; entries that
/// change meanwhile may be missed or seen twice.
#[derive(Clone, Copy, Debug)]
pub struct Listing {
    at: Option<Cursor>,
}

impl Listing {
    pub(super) fn start<B: Blocks>(disk: &Disk<'_, B>, directory: Directory) -> Result<Self, Error<B::Error>> {
        Ok(Self { at: Some(Cursor::start(disk, directory)?) })
    }

    /// The next file or directory and its name; `None` behind the last. The volume's label, `.` and `..` are
    /// left out.
    ///
    /// # Errors
    /// [`Error::Damaged`], or the device's.
    pub fn next<B: Blocks>(
        &mut self,
        volume: &mut Volume,
        device: &mut B,
        name: &mut Name,
    ) -> Result<Option<Entry>, Error<B::Error>> {
        let disk = &mut Disk::new(volume, device);
        while let Some(entry) = self.next_entry(disk, name)? {
            if is_file_or_directory(&entry) {
                return Ok(Some(entry));
            }
        }
        Ok(None)
    }

    /// The next entry of any kind and its name: the long one if it has one that is whole, else the short one.
    pub(super) fn next_entry<B: Blocks>(
        &mut self,
        disk: &mut Disk<'_, B>,
        name: &mut Name,
    ) -> Result<Option<Entry>, Error<B::Error>> {
        let mut assembly = Assembly::new(name);
        while let Some(at) = self.at {
            let slot = at.read(disk)?;
            let kind = kind_of(&slot);
            self.at = if kind == SlotKind::End { None } else { at.next(disk)? };
            match kind {
                SlotKind::End => {}
                SlotKind::Free => assembly.forget(),
                SlotKind::LongName => assembly.take(&slot, at),
                SlotKind::Entry => {
                    let first = assembly.finish(&short_name(&slot));
                    let entry = Entry::new(disk.volume, slot, at.place(), first.unwrap_or(at));
                    if first.is_none() {
                        name.set(short_name::units(entry.short_name(), entry.case_bits()));
                    }
                    return Ok(Some(entry));
                }
            }
        }
        Ok(None)
    }
}

fn is_file_or_directory(entry: &Entry) -> bool {
    !entry.attributes().has(Attributes::LABEL) && entry.slot[0] != b'.'
}

/// Returns whether an entry has this name, as its own or its short one.
fn answers_to(entry: &Entry, name: &Name, wanted: &Name) -> bool {
    wanted.same(name.units().iter().copied()) || wanted.same(short_name::units(entry.short_name(), 0))
}

impl<B: Blocks> Disk<'_, B> {
    /// The entry of this name.
    pub fn find(&mut self, directory: Directory, name: &str) -> Result<Entry, Error<B::Error>> {
        let wanted = Name::parse(name).ok_or(Error::NotFound)?;
        self.search(directory, &wanted, None, |_, _| {})?.ok_or(Error::NotFound)
    }

    /// Searches a directory for a name, long or short. Of two entries that differ in case alone, which others
    /// may have made, the one that is exactly so counts. `except` is passed over. `each` sees every entry,
    /// when none is exactly so.
    pub fn search(
        &mut self,
        directory: Directory,
        wanted: &Name,
        except: Option<Place>,
        mut each: impl FnMut(&Entry, &Name),
    ) -> Result<Option<Entry>, Error<B::Error>> {
        let (mut listing, mut name, mut found) = (Listing::start(self, directory)?, Name::new(), None);
        while let Some(entry) = listing.next_entry(self, &mut name)? {
            if except == Some(entry.place()) {
                continue;
            }
            each(&entry, &name);
            if !is_file_or_directory(&entry) {
                continue;
            }
            if name.units() == wanted.units() {
                return Ok(Some(entry));
            }
            if found.is_none() && answers_to(&entry, &name, wanted) {
                found = Some(entry);
            }
        }
        Ok(found)
    }

    /// Returns the directory of an entry.
    pub fn directory_of(&self, entry: &Entry) -> Result<Directory, Error<B::Error>> {
        match entry.cluster() {
            _ if !entry.is_directory() => Err(Error::IsFile),
            cluster if self.volume.has_cluster(cluster) => Ok(Directory::Chain(cluster)),
            _ => Err(Error::Damaged),
        }
    }

    /// Returns the directory of this path; the root for an empty one. No part of the path may be the
    /// directory that begins with `outside`.
    pub fn directory(&mut self, path: &str, outside: Option<u32>) -> Result<Directory, Error<B::Error>> {
        let mut directory = self.volume.root;
        for part in path.split('/').filter(|part| !part.is_empty()) {
            let entry = self.find(directory, part)?;
            directory = self.directory_of(&entry)?;
            if outside == Some(entry.cluster()) {
                return Err(Error::IntoItself);
            }
        }
        Ok(directory)
    }
}

/// Splits a path into its directory and its last part.
pub(super) fn split<E>(path: &str) -> Result<(&str, &str), Error<E>> {
    let path = path.trim_end_matches('/');
    let (directory, name) = path.rsplit_once('/').unwrap_or(("", path));
    if name.is_empty() { Err(Error::BadName) } else { Ok((directory, name)) }
}

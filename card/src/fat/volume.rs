//! Operations on files and directories of a volume. Paths are relative to its root, parts divided by `/`.

use super::disk::Disk;
use super::entry::Entry;
use super::geometry::Directory;
use super::lookup::split;
use super::name::Name;
use super::slot::{Attributes, Place, Stamp, cluster, new_slot, set_cluster, set_written};
use super::table::{Chain, Link};
use super::{Blocks, Error, Listing, Volume, put, word};

impl Volume {
    /// Finds the entry of this path, by long names or short ones.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::IsFile`] for a part that should be a directory, [`Error::BadName`] for
    /// the root, which has no entry, [`Error::Damaged`], or the device's.
    pub fn find<B: Blocks>(&mut self, device: &mut B, path: &str) -> Result<Entry, Error<B::Error>> {
        let disk = &mut Disk::new(self, device);
        let (path, name) = split(path)?;
        let directory = disk.directory(path, None)?;
        disk.find(directory, name)
    }

    /// The entries of a directory; of the root for an empty path.
    ///
    /// # Errors
    /// As [`find`](Self::find).
    pub fn list<B: Blocks>(&mut self, device: &mut B, path: &str) -> Result<Listing, Error<B::Error>> {
        let disk = &mut Disk::new(self, device);
        let directory = disk.directory(path, None)?;
        Listing::start(disk, directory)
    }

    /// Makes an empty file.
    ///
    /// # Errors
    /// [`Error::Exists`], [`Error::BadName`], [`Error::Full`], [`Error::DirectoryFull`], or as
    /// [`find`](Self::find).
    pub fn create<B: Blocks>(&mut self, device: &mut B, path: &str, now: Stamp) -> Result<Entry, Error<B::Error>> {
        let disk = &mut Disk::new(self, device);
        let (path, name) = split(path)?;
        let directory = disk.directory(path, None)?;
        let name = Name::parse(name).ok_or(Error::BadName)?;
        let name = disk.new_name(directory, &name, None)?;
        let room = disk.make_room(directory, name.slots())?;
        disk.write_entry(room, &name, new_slot(name.short_name, name.case_bits, Attributes::ARCHIVE, now), None)
    }

    /// Makes an empty directory.
    ///
    /// # Errors
    /// As [`create`](Self::create).
    pub fn make_directory<B: Blocks>(
        &mut self,
        device: &mut B,
        path: &str,
        now: Stamp,
    ) -> Result<Entry, Error<B::Error>> {
        let disk = &mut Disk::new(self, device);
        let (path, name) = split(path)?;
        let directory = disk.directory(path, None)?;
        let name = Name::parse(name).ok_or(Error::BadName)?;
        let name = disk.new_name(directory, &name, None)?;
        let room = disk.make_room(directory, name.slots())?;
        let parent = disk.parent_cluster(directory);
        let cluster = disk.allocate(None, |block, own| {
            for (at, name, cluster) in [(0, b".          ", own), (32, b"..         ", parent)] {
                let mut slot = new_slot(*name, 0, Attributes::DIRECTORY, now);
                set_cluster(&mut slot, cluster);
                put(block, at, &slot);
            }
        })?;
        let mut slot = new_slot(name.short_name, name.case_bits, Attributes::DIRECTORY, now);
        set_cluster(&mut slot, cluster);
        disk.write_entry(room, &name, slot, None)
    }

    /// Empties a file. No other user may have it open.
    ///
    /// # Errors
    /// [`Error::IsDirectory`], [`Error::ReadOnly`], or the device's.
    pub fn empty<B: Blocks>(&mut self, device: &mut B, file: &Entry, now: Stamp) -> Result<(), Error<B::Error>> {
        if file.is_directory() {
            return Err(Error::IsDirectory);
        }
        if file.attributes().has(Attributes::READ_ONLY) {
            return Err(Error::ReadOnly);
        }
        let disk = &mut Disk::new(self, device);
        disk.change(file.place(), |slot| {
            set_cluster(slot, 0);
            put(slot, 28, &[0; 4]);
            set_written(slot, now);
            slot[11] |= Attributes::ARCHIVE.0;
        })?;
        disk.store()?;
        disk.free_chain(file.cluster())
    }

    /// Removes a file, or a directory that is empty. No other user may have it open.
    ///
    /// # Errors
    /// [`Error::ReadOnly`], [`Error::NotEmpty`], [`Error::Damaged`], or the device's.
    pub fn remove<B: Blocks>(&mut self, device: &mut B, entry: &Entry) -> Result<(), Error<B::Error>> {
        if entry.attributes().has(Attributes::READ_ONLY) {
            return Err(Error::ReadOnly);
        }
        if entry.is_directory() {
            let directory = Disk::new(self, device).directory_of(entry)?;
            let mut listing = Listing::start(&Disk::new(self, device), directory)?;
            if listing.next(self, device, &mut Name::new())?.is_some() {
                return Err(Error::NotEmpty);
            }
        }
        let disk = &mut Disk::new(self, device);
        disk.remove_slots(entry)?;
        disk.free_chain(entry.cluster())
    }

    /// Returns whether a file has as many clusters as its size needs, in a chain that ends.
    ///
    /// # Errors
    /// [`Error::Damaged`] if not, or the device's.
    pub fn check<B: Blocks>(&mut self, device: &mut B, file: &Entry) -> Result<(), Error<B::Error>> {
        let disk = &mut Disk::new(self, device);
        let needed = file.size_bytes().div_ceil(disk.volume.cluster_bytes());
        if needed == 0 && file.cluster() == 0 {
            return Ok(());
        }
        let (mut chain, mut count) = (Chain::new(disk.volume, file.cluster())?, 1_u32);
        while chain.advance(disk)? {
            count += 1;
        }
        if count < needed { Err(Error::Damaged) } else { Ok(()) }
    }

    /// Frees the clusters behind those that a file's size needs. No other user may have it open.
    ///
    /// # Errors
    /// [`Error::Damaged`], or the device's.
    pub fn trim<B: Blocks>(&mut self, device: &mut B, file: Place) -> Result<(), Error<B::Error>> {
        let disk = &mut Disk::new(self, device);
        let slot = disk.slot(file)?;
        let (size, first) = (word(&slot, 28), cluster(&slot, disk.volume.kind));
        let needed = size.div_ceil(disk.volume.cluster_bytes());
        match (first, needed) {
            (0, _) => Ok(()),
            (first, 0) => {
                disk.change(file, |slot| set_cluster(slot, 0))?;
                disk.store()?;
                disk.free_chain(first)
            }
            (first, needed) => {
                let mut chain = Chain::new(disk.volume, first)?;
                for _ in 1..needed {
                    if !chain.advance(disk)? {
                        return Err(Error::Damaged);
                    }
                }
                let rest = disk.link(chain.at)?;
                if rest != Link::End {
                    disk.set_link(chain.at, Link::End)?;
                }
                if let Link::Next(rest) = rest { disk.free_chain(rest) } else { Ok(()) }
            }
        }
    }

    /// Sets the volume's count of free clusters to "unknown", before another user takes clusters.
    ///
    /// # Errors
    /// The device's.
    pub fn forget_free_count<B: Blocks>(&mut self, device: &mut B) -> Result<(), Error<B::Error>> {
        Disk::new(self, device).forget_free_count()
    }

    /// Returns the number of clusters.
    #[must_use]
    pub const fn clusters(&self) -> u32 {
        self.clusters
    }

    /// Counts free clusters in so many blocks of the allocation table, from this one on; returns the block to
    /// go on with, unless that was the last.
    ///
    /// # Errors
    /// The device's.
    pub fn count_free<B: Blocks>(
        &mut self,
        device: &mut B,
        first: u32,
        blocks: u32,
    ) -> Result<(u32, Option<u32>), Error<B::Error>> {
        let per_block = 512 / self.kind.entry_bytes();
        let (mut cluster, end) = ((first * per_block).max(2), self.clusters + 2);
        let stop = first.saturating_add(blocks).saturating_mul(per_block).min(end);
        let (disk, mut free) = (&mut Disk::new(self, device), 0);
        while cluster < stop {
            free += u32::from(disk.link(cluster)? == Link::Free);
            cluster += 1;
        }
        Ok((free, (stop < end).then_some(stop / per_block)))
    }

    /// Returns whether at least so many clusters are free.
    ///
    /// # Errors
    /// The device's.
    pub fn has_free<B: Blocks>(&mut self, device: &mut B, clusters: u32) -> Result<bool, Error<B::Error>> {
        Disk::new(self, device).has_free(clusters)
    }
}

impl<B: Blocks> Disk<'_, B> {
    /// Returns the cluster that `..` of a directory inside this one must have: 0 for the root, also if the
    /// root has a cluster.
    pub fn parent_cluster(&self, directory: Directory) -> u32 {
        match directory {
            Directory::Chain(cluster) if directory != self.volume.root => cluster,
            _ => 0,
        }
    }
}

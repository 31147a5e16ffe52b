//! Allocation table: chains of clusters and free clusters (FAT 1.03, "FAT Data Structure").

use super::disk::Disk;
use super::geometry::Kind;
use super::{Blocks, Error, Volume, half, put, word};

/// Entry of the table for a cluster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Link {
    Free,
    /// The number of the next cluster.
    Next(u32),
    /// Last cluster of its chain.
    End,
    /// A mark for a bad cluster, a reserved value, or a cluster that the volume does not have.
    Bad,
}

impl Volume {
    /// The block with a cluster's entry, and the entry's offset in it.
    const fn entry_of(&self, cluster: u32) -> (u32, usize) {
        let offset = cluster * self.kind.entry_bytes();
        (self.table + offset / 512, (offset % 512) as usize)
    }

    fn link(&self, block: &[u8], offset: usize) -> Link {
        let (value, last) = match self.kind {
            Kind::Fat16 => (u32::from(half(block, offset)), 0xFFF8),
            Kind::Fat32 => (word(block, offset) & 0x0FFF_FFFF, 0x0FFF_FFF8),
        };
        match value {
            0 => Link::Free,
            value if value >= last => Link::End,
            value if self.has_cluster(value) => Link::Next(value),
            _ => Link::Bad,
        }
    }

    fn put_link(&self, block: &mut [u8], offset: usize, link: Link) {
        let value = match link {
            Link::Free => 0,
            Link::Next(cluster) => cluster,
            Link::End | Link::Bad => 0x0FFF_FFFF,
        };
        match self.kind {
            Kind::Fat16 => put(block, offset, &(value as u16).to_le_bytes()),
            Kind::Fat32 => {
                // The upper four bits are reserved and kept.
                let kept = word(block, offset) & 0xF000_0000;
                put(block, offset, &(kept | value).to_le_bytes());
            }
        }
    }
}

/// Position along a chain of clusters. A loop is noticed within three times its length (R. P. Brent, An
/// Improved Monte Carlo Factorization Algorithm, 1980, section 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Chain {
    pub at: u32,
    /// Cluster passed `steps` ago; replaced by the present one each time `steps` reaches `limit`.
    passed: u32,
    steps: u32,
    limit: u32,
}

impl Chain {
    /// Starts at the first cluster, which the volume must have.
    pub fn new<E>(volume: &Volume, first: u32) -> Result<Self, Error<E>> {
        if !volume.has_cluster(first) {
            return Err(Error::Damaged);
        }
        Ok(Self { at: first, passed: first, steps: 0, limit: 1 })
    }

    /// Goes on by one cluster; returns false at the last.
    pub fn advance<B: Blocks>(&mut self, disk: &mut Disk<'_, B>) -> Result<bool, Error<B::Error>> {
        let next = match disk.link(self.at)? {
            Link::End => return Ok(false),
            Link::Next(next) if next != self.passed => next,
            _ => return Err(Error::Damaged),
        };
        self.at = next;
        self.steps += 1;
        if self.steps == self.limit {
            (self.passed, self.steps, self.limit) = (next, 0, self.limit.saturating_mul(2));
        }
        Ok(true)
    }
}

impl<B: Blocks> Disk<'_, B> {
    /// Returns the link of this cluster, which the volume has.
    pub fn link(&mut self, cluster: u32) -> Result<Link, Error<B::Error>> {
        let (block, offset) = self.volume.entry_of(cluster);
        self.load(block)?;
        Ok(self.volume.link(&self.block, offset))
    }

    /// Sets the link of a cluster, in all copies of the table.
    pub fn set_link(&mut self, cluster: u32, link: Link) -> Result<(), Error<B::Error>> {
        self.change_link(cluster, link)?;
        self.store_in_tables()
    }

    fn change_link(&mut self, cluster: u32, link: Link) -> Result<(), Error<B::Error>> {
        let (number, offset) = self.volume.entry_of(cluster);
        self.load(number)?;
        self.volume.put_link(&mut self.block, offset, link);
        Ok(())
    }

    /// Takes a free cluster, zeroes it, has `fill` write into its first block, and links it behind
    /// `previous`.
    pub fn allocate(
        &mut self,
        previous: Option<u32>,
        fill: impl FnOnce(&mut [u8], u32),
    ) -> Result<u32, Error<B::Error>> {
        self.forget_free_count()?;
        let cluster = self.find_free()?;
        let first = self.volume.block_of(cluster);
        // Zeroed and filled while still free: so a cluster is right from the first moment at which it belongs
        // to something.
        for number in (first + 1..first + self.volume.blocks_per_cluster).rev() {
            self.blank(number);
            self.store()?;
        }
        fill(self.blank(first), cluster);
        self.store()?;
        self.change_link(cluster, Link::End)?;
        if let Some(previous) = previous {
            if self.volume.entry_of(previous).0 != self.volume.entry_of(cluster).0 {
                self.store_in_tables()?;
            }
            self.change_link(previous, Link::Next(cluster))?;
        }
        self.store_in_tables()?;
        self.volume.next_free = cluster + 1;
        Ok(cluster)
    }

    /// The next free cluster after the one that was taken last.
    fn find_free(&mut self) -> Result<u32, Error<B::Error>> {
        let (first, end) = (2, self.volume.clusters + 2);
        let from = self.volume.next_free.clamp(first, end);
        for cluster in (from..end).chain(first..from) {
            if self.link(cluster)? == Link::Free {
                return Ok(cluster);
            }
        }
        Err(Error::Full)
    }

    /// Whether at least `wanted` clusters are free.
    pub fn has_free(&mut self, wanted: u32) -> Result<bool, Error<B::Error>> {
        let (first, end) = (2, self.volume.clusters + 2);
        let from = self.volume.next_free.clamp(first, end);
        let mut found = 0;
        for cluster in (from..end).chain(first..from) {
            found += u32::from(self.link(cluster)? == Link::Free);
            if found >= wanted {
                return Ok(true);
            }
        }
        Ok(found >= wanted)
    }

    /// Frees a chain that nothing names any more. A damaged chain is freed up to its damage; a loop ends at
    /// the first cluster that is free already.
    pub fn free_chain(&mut self, first: u32) -> Result<(), Error<B::Error>> {
        self.forget_free_count()?;
        let mut rest = Some(first);
        while let Some(cluster) = rest {
            rest = self.free_within_block(cluster)?;
        }
        Ok(())
    }

    /// Frees a chain from `cluster` on, as long as its entries lie in one block of the table; gives the rest.
    fn free_within_block(&mut self, cluster: u32) -> Result<Option<u32>, Error<B::Error>> {
        let (number, _) = self.volume.entry_of(cluster);
        let mut next = Some(cluster).filter(|cluster| self.volume.has_cluster(*cluster));
        let Some(mut at) = next else { return Ok(None) };
        while next.is_some() && self.volume.entry_of(at).0 == number {
            next = match self.link(at)? {
                Link::Next(next) => Some(next),
                _ => None,
            };
            self.change_link(at, Link::Free)?;
            at = next.unwrap_or(at);
        }
        self.store_in_tables()?;
        Ok(next)
    }

    /// Sets the count of free clusters (FSINFO) to "unknown", as changes are not counted. FAT 1.03, "FAT32
    /// FSInfo Sector Structure": FSI_Free_Count, all ones.
    pub fn forget_free_count(&mut self) -> Result<(), Error<B::Error>> {
        const COUNT: usize = 488;
        let (Some(info), false) = (self.volume.info, self.volume.count_forgotten) else { return Ok(()) };
        let block = self.load(info)?;
        let is_info =
            word(block, 0) == 0x4161_5252 && word(block, 484) == 0x6141_7272 && word(block, 508) == 0xAA55_0000;
        if is_info && word(block, COUNT) != u32::MAX {
            put(block, COUNT, &u32::MAX.to_le_bytes());
            self.store()?;
        }
        self.volume.count_forgotten = true;
        Ok(())
    }
}

//! A walk over the slots of a directory.

use super::disk::Disk;
use super::geometry::Directory;
use super::slot::{Place, SLOTS_PER_BLOCK, Slot};
use super::table::Chain;
use super::{Blocks, Error};

/// Most slots of a directory: FAT 1.03 allows 2 MiB.
const MAX_SLOTS: u32 = 65_536;

/// A slot of a directory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cursor {
    /// Chain of clusters with the slot; `None` in the root of FAT16.
    chain: Option<Chain>,
    /// The present stretch of consecutive blocks: a cluster, or the root of FAT16.
    first_block: u32,
    blocks: u32,
    /// Number of the block within that stretch, and of the slot in the block.
    block: u32,
    slot: u8,
    /// Slots passed since the directory's first.
    passed: u32,
}

impl Cursor {
    /// Creates a cursor at the first slot.
    pub fn start<B: Blocks>(disk: &Disk<'_, B>, directory: Directory) -> Result<Self, Error<B::Error>> {
        let at = |chain, first_block, blocks| Self { chain, first_block, blocks, block: 0, slot: 0, passed: 0 };
        match directory {
            Directory::FixedRoot => {
                let (first, blocks) = disk.volume.fixed_root;
                Ok(at(None, first, blocks))
            }
            Directory::Chain(cluster) => {
                let chain = Chain::new(disk.volume, cluster)?;
                Ok(at(Some(chain), disk.volume.block_of(cluster), disk.volume.blocks_per_cluster))
            }
        }
    }

    /// The slot's place on the card.
    pub const fn place(&self) -> Place {
        Place { block: self.first_block + self.block, slot: self.slot }
    }

    /// Reads the contents of the slot.
    pub fn read<B: Blocks>(&self, disk: &mut Disk<'_, B>) -> Result<Slot, Error<B::Error>> {
        disk.slot(self.place())
    }

    /// Whether the next slot is in another block.
    pub const fn is_last_of_block(&self) -> bool {
        self.slot + 1 == SLOTS_PER_BLOCK
    }

    /// The cluster the slot is in.
    pub fn cluster(&self) -> Option<u32> {
        self.chain.map(|chain| chain.at)
    }

    /// Whether the directory may not have more slots than up to here.
    pub const fn is_at_limit(&self) -> bool {
        self.passed + 1 >= MAX_SLOTS
    }

    /// The next slot; `None` behind the last.
    pub fn next<B: Blocks>(mut self, disk: &mut Disk<'_, B>) -> Result<Option<Self>, Error<B::Error>> {
        self.passed += 1;
        if self.passed >= MAX_SLOTS {
            let goes_on = match &mut self.chain {
                Some(chain) => chain.advance(disk)?,
                None => false,
            };
            return if goes_on { Err(Error::Damaged) } else { Ok(None) };
        }
        self.slot += 1;
        if self.slot < SLOTS_PER_BLOCK {
            return Ok(Some(self));
        }
        (self.slot, self.block) = (0, self.block + 1);
        if self.block < self.blocks {
            return Ok(Some(self));
        }
        let Some(chain) = &mut self.chain else { return Ok(None) };
        if !chain.advance(disk)? {
            return Ok(None);
        }
        (self.block, self.first_block) = (0, disk.volume.block_of(chain.at));
        Ok(Some(self))
    }
}

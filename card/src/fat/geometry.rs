//! Layout of a volume, by the parameters in its boot sector.

use super::{Block, Blocks, Error, half, word};

/// Message that refuses a volume with more blocks than its partition.
pub(crate) const LARGER_THAN_PARTITION: &str = "the volume is larger than its partition";

/// Kind of allocation table, by the width of its entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Entries of two bytes.
    Fat16,
    /// Entries of four bytes, of which the upper four bits are left alone.
    Fat32,
}

impl Kind {
    /// Bytes of an entry.
    pub(super) const fn entry_bytes(self) -> u32 {
        match self {
            Self::Fat16 => 2,
            Self::Fat32 => 4,
        }
    }
}

/// Directory of a volume, by its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Directory {
    /// The root of a FAT16 volume, between tables and clusters.
    FixedRoot,
    /// The chain of clusters that begins with this one.
    Chain(u32),
}

/// A volume: its layout, and where to look for free clusters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Volume {
    pub(super) kind: Kind,
    first_block: u32,
    blocks: u32,
    pub(super) blocks_per_cluster: u32,
    /// First block of the first allocation table.
    pub(super) table: u32,
    pub(super) table_blocks: u32,
    /// Whether a second table follows the first.
    pub(super) mirrored: bool,
    pub(super) root: Directory,
    /// First block of a FAT16 volume's root directory, and its number of blocks.
    pub(super) fixed_root: (u32, u32),
    /// First block of cluster 2.
    data: u32,
    pub(super) clusters: u32,
    /// The block with the count of free clusters (FSINFO).
    pub(super) info: Option<u32>,
    /// The count in that block has been set to "unknown".
    pub(super) count_forgotten: bool,
    /// The search for a free cluster begins here.
    pub(super) next_free: u32,
}

impl Volume {
    /// Reads the boot sector of the partition of `blocks` blocks from `first_block` on.
    ///
    /// # Errors
    /// [`Error::NotFat`] when this is no volume that can be used, or the device's.
    pub fn open<B: Blocks>(device: &mut B, first_block: u32, blocks: u32) -> Result<Self, Error<B::Error>> {
        let mut boot = [0; super::BLOCK_BYTES];
        device.read(first_block, &mut boot).map_err(Error::Device)?;
        Self::of_boot_sector(&boot, first_block, blocks).map_err(Error::NotFat)
    }

    /// FAT 1.03, "Boot Sector and BPB" and "FAT Type Determination".
    fn of_boot_sector(boot: &Block, first_block: u32, partition_blocks: u32) -> Result<Self, &'static str> {
        let byte = |at: usize| boot.get(at).copied().unwrap_or(0);
        let short_or_long = |short, long| match half(boot, short) {
            0 => word(boot, long),
            blocks => u32::from(blocks),
        };
        if half(boot, 510) != 0xAA55 || half(boot, 11) != 512 || !byte(13).is_power_of_two() || half(boot, 14) == 0 {
            return Err("no FAT boot sector with blocks of 512 bytes");
        }
        let (tables, root_entries) = (byte(16), u32::from(half(boot, 17)));
        if !matches!(tables, 1 | 2) {
            return Err("neither one nor two allocation tables");
        }
        let (blocks, table_blocks) = (short_or_long(19, 32), short_or_long(22, 36));
        let root_blocks = (root_entries * 32).div_ceil(512);
        let before_data =
            u64::from(half(boot, 14)) + u64::from(table_blocks) * u64::from(tables) + u64::from(root_blocks);
        let data_blocks = u64::from(blocks).checked_sub(before_data).ok_or("the volume is smaller than its tables")?;
        let fits = blocks <= partition_blocks && first_block.checked_add(partition_blocks).is_some();
        if !fits {
            return Err(LARGER_THAN_PARTITION);
        }
        let blocks_per_cluster = u32::from(byte(13));
        // All of them are less than `blocks`.
        let (before_data, clusters) = (before_data as u32, data_blocks as u32 / blocks_per_cluster);
        let kind = match clusters {
            0..4_085 => return Err("FAT12"),
            4_085..65_525 => Kind::Fat16,
            65_525..0x0FFF_FFF5 => Kind::Fat32,
            _ => return Err("more clusters than FAT32 can have"),
        };
        if u64::from(clusters + 2) * u64::from(kind.entry_bytes()) > u64::from(table_blocks) * 512 {
            return Err("the allocation table is too short");
        }
        let table = first_block + u32::from(half(boot, 14));
        let mut volume = Self {
            kind,
            first_block,
            blocks,
            blocks_per_cluster,
            table,
            table_blocks,
            mirrored: tables == 2,
            root: Directory::FixedRoot,
            fixed_root: (table + table_blocks * u32::from(tables), root_blocks),
            data: first_block + before_data,
            clusters,
            info: None,
            count_forgotten: false,
            next_free: 2,
        };
        match kind {
            Kind::Fat16 if root_entries == 0 || half(boot, 22) == 0 => return Err("FAT32 with too few clusters"),
            Kind::Fat16 => {}
            Kind::Fat32 => volume.take_extended_parameters(boot)?,
        }
        Ok(volume)
    }

    /// Reads the parameters of FAT32 alone, from offset 36 on.
    fn take_extended_parameters(&mut self, boot: &Block) -> Result<(), &'static str> {
        const MIRRORING_OFF: u16 = 0x80;
        const ACTIVE_TABLE: u16 = 0x0F;
        let (flags, version, root) = (half(boot, 40), half(boot, 42), word(boot, 44));
        if half(boot, 17) != 0 || half(boot, 22) != 0 || version != 0 {
            return Err("another version of FAT32");
        }
        if flags & MIRRORING_OFF != 0 && flags & ACTIVE_TABLE != 0 {
            return Err("the second allocation table is the one in use");
        }
        if !self.has_cluster(root) {
            return Err("the root directory is outside the volume");
        }
        self.root = Directory::Chain(root);
        self.info = match half(boot, 48) {
            0 | 0xFFFF => None,
            offset => Some(self.first_block + u32::from(offset)).filter(|info| *info < self.table),
        };
        Ok(())
    }

    /// Reads the volume again from the card, dropping the present state.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn again<B: Blocks>(&self, device: &mut B) -> Result<Self, Error<B::Error>> {
        Self::open(device, self.first_block, self.blocks)
    }

    /// Returns the volume's first block on the card, and its number of blocks.
    #[must_use]
    pub const fn extent(&self) -> (u32, u32) {
        (self.first_block, self.blocks)
    }

    /// Width of the table's entries.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        self.kind
    }

    /// Bytes of a cluster.
    #[must_use]
    pub const fn cluster_bytes(&self) -> u32 {
        self.blocks_per_cluster * 512
    }

    /// Whether this block is part of the volume.
    #[must_use]
    pub const fn contains_block(&self, number: u32) -> bool {
        number >= self.first_block && number - self.first_block < self.blocks
    }

    /// The block with the count of free clusters, if the volume keeps one.
    #[must_use]
    pub const fn info_block(&self) -> Option<u32> {
        self.info
    }

    /// Returns the first byte of this block of a card that lies in the allocation table but beyond the
    /// entries of the volume's clusters. The last block of a table is rarely full.
    #[must_use]
    pub fn unused_table_bytes_from(&self, number: u32) -> Option<usize> {
        let used_bytes = (self.clusters + 2) * self.kind.entry_bytes();
        let copies = if self.mirrored { 2 } else { 1 };
        let within = number.checked_sub(self.table).filter(|block| *block < self.table_blocks * copies)?;
        let begins = (within % self.table_blocks) * 512;
        (used_bytes < begins + 512).then(|| used_bytes.saturating_sub(begins) as usize)
    }

    /// Returns whether a file or directory can have this cluster.
    pub(super) const fn has_cluster(&self, cluster: u32) -> bool {
        cluster >= 2 && cluster - 2 < self.clusters
    }

    /// First block of a cluster that the volume has.
    pub(super) const fn block_of(&self, cluster: u32) -> u32 {
        self.data + cluster.saturating_sub(2) * self.blocks_per_cluster
    }

    /// Returns whether a directory can have this block.
    pub(super) const fn may_hold_entries(&self, number: u32) -> bool {
        let (root, blocks) = self.fixed_root;
        let in_root = number >= root && number - root < blocks;
        let in_data = number >= self.data && (number - self.data) / self.blocks_per_cluster < self.clusters;
        in_root || in_data
    }
}

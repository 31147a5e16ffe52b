//! Layout of an exFAT volume (section 3), and the chains of its clusters (section 4).

use super::{read, small};
use crate::fat::{Block, Blocks, Error, half, word};

/// Number of the block with the checksum, and of blocks before it, in a boot region (section 3.4).
const CHECKED: u32 = 11;
/// Blocks of a boot region; the backup follows.
const REGION: u32 = 12;

/// Layout of a volume.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Volume {
    fat: u32,
    heap: u32,
    clusters: u32,
    blocks_per_cluster: u32,
    pub(super) root: u32,
}

impl Volume {
    /// Reads the boot regions of the volume that begins at this block.
    ///
    /// # Errors
    /// [`Error::NotFat`] when this is no volume that can be read, [`Error::Damaged`] when neither boot
    /// region is whole, or the device's.
    pub fn open<B: Blocks>(device: &mut B, first: u32) -> Result<Self, Error<B::Error>> {
        let mut boot = [0; 512];
        for region in [first, first.saturating_add(REGION)] {
            read(device, region, &mut boot)?;
            if boot.get(3..11) != Some(b"EXFAT   ") || half(&boot, 510) != 0xAA55 {
                continue;
            }
            if is_whole(device, region)? {
                return Self::of_boot_sector(&boot, first).map_err(Error::NotFat);
            }
        }
        Err(Error::Damaged)
    }

    fn of_boot_sector(boot: &Block, first: u32) -> Result<Self, &'static str> {
        let [sector_shift, cluster_shift, fats] = [108, 109, 110].map(|at| boot.get(at).copied().unwrap_or(0));
        if sector_shift != 9 {
            return Err("exFAT with blocks other than 512 bytes");
        }
        if half(boot, 104) >> 8 != 1 {
            return Err("another version of exFAT");
        }
        // Up to 32 MB in a cluster (section 3.1.15); with TexFAT there are two FATs, of which one is in use.
        if cluster_shift > 16 || !matches!(fats, 1 | 2) || half(boot, 106) & 1 != 0 {
            return Err("exFAT whose parameters are none");
        }
        let (length, clusters, root) = (small(boot, 72), word(boot, 92), word(boot, 96));
        let blocks_per_cluster = 1 << cluster_shift;
        let (fat, fat_blocks, heap) = (word(boot, 80), word(boot, 84), word(boot, 88));
        let end = u64::from(heap) + u64::from(clusters) * u64::from(blocks_per_cluster);
        let holds = u64::from(fat_blocks) * 128 >= u64::from(clusters) + 2;
        let fits = end <= u64::from(length) && u64::from(first) + end <= u64::from(u32::MAX);
        if !holds || !fits || fat < 2 * REGION || u64::from(fat) + u64::from(fat_blocks) > u64::from(heap) {
            return Err("exFAT whose parts do not fit");
        }
        let volume = Self { fat: first + fat, heap: first + heap, clusters, blocks_per_cluster, root };
        if volume.has_cluster(root) { Ok(volume) } else { Err("exFAT without a root directory") }
    }

    /// Bytes of a cluster.
    #[must_use]
    pub const fn cluster_bytes(&self) -> u32 {
        self.blocks_per_cluster * 512
    }

    pub(super) const fn blocks_per_cluster(&self) -> u32 {
        self.blocks_per_cluster
    }

    /// Returns the number of clusters; no chain is longer.
    pub(super) const fn clusters(&self) -> u32 {
        self.clusters
    }

    pub(super) const fn has_cluster(&self, cluster: u32) -> bool {
        cluster >= 2 && cluster - 2 < self.clusters
    }

    /// First block of a cluster that the volume has.
    pub(super) const fn block_of(&self, cluster: u32) -> u32 {
        self.heap + cluster.saturating_sub(2) * self.blocks_per_cluster
    }

    /// Returns the cluster behind this one by the FAT; `None` behind the last.
    pub(super) fn next<B: Blocks>(&self, device: &mut B, cluster: u32) -> Result<Option<u32>, Error<B::Error>> {
        let mut block = [0; 512];
        read(device, self.fat + cluster / 128, &mut block)?;
        match word(&block, (cluster % 128) as usize * 4) {
            u32::MAX => Ok(None),
            next if self.has_cluster(next) => Ok(Some(next)),
            _ => Err(Error::Damaged),
        }
    }
}

/// Returns whether the checksum of a boot region is right (section 3.4).
fn is_whole<B: Blocks>(device: &mut B, region: u32) -> Result<bool, Error<B::Error>> {
    let (mut sum, mut block) = (0_u32, [0; 512]);
    for number in 0..CHECKED {
        read(device, region + number, &mut block)?;
        for (at, byte) in block.iter().enumerate() {
            // VolumeFlags and PercentInUse change without a new checksum.
            if number > 0 || !matches!(at, 106 | 107 | 112) {
                sum = sum.rotate_right(1).wrapping_add(u32::from(*byte));
            }
        }
    }
    read(device, region + CHECKED, &mut block)?;
    Ok((0..128).all(|place| word(&block, place * 4) == sum))
}

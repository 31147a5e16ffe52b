//! Reading the contents of files and directories along their clusters.

use super::{Volume, read};
use crate::fat::{BLOCK_BYTES, Blocks, Error};

/// Position along the clusters of a file or a directory.
#[derive(Clone, Copy, Debug)]
pub struct Reader {
    first: u32,
    /// Length in bytes, and number of bytes that were written.
    size: u32,
    valid: u32,
    /// The clusters are consecutive, without entries in the FAT.
    is_contiguous: bool,
    /// Cluster read last, and its index within the file.
    at: (u32, u32),
    /// The length is given by the chain alone: the root directory.
    ends_with_chain: bool,
}

impl Reader {
    pub(super) const fn new(first: u32, size: u32, valid: u32, is_contiguous: bool) -> Self {
        Self { first, size, valid, is_contiguous, at: (first, 0), ends_with_chain: false }
    }

    /// Creates the reader of the root directory, which is as long as its chain, but at most `most`.
    pub(super) const fn of_root(first: u32, most: u32) -> Self {
        Self { ends_with_chain: true, ..Self::new(first, most, most, false) }
    }

    /// Bytes of the file.
    #[must_use]
    pub const fn size_bytes(&self) -> u32 {
        self.size
    }

    /// Reads from this offset to the end of its block, as much as fits; 0 at the end of the file.
    ///
    /// # Errors
    /// [`Error::Damaged`] when its clusters end before, or the device's.
    pub fn read<B: Blocks>(
        &mut self,
        volume: &Volume,
        device: &mut B,
        offset_bytes: u32,
        buffer: &mut [u8],
    ) -> Result<usize, Error<B::Error>> {
        let Some((number, _)) = self.stretch(volume, device, offset_bytes)? else { return Ok(0) };
        let mut block = [0; BLOCK_BYTES];
        read(device, number, &mut block)?;
        let within = offset_bytes % BLOCK_BYTES as u32;
        let left = (self.size - offset_bytes).min(BLOCK_BYTES as u32 - within) as usize;
        let count = left.min(buffer.len());
        let written = self.valid.saturating_sub(offset_bytes) as usize;
        for (place, (to, from)) in buffer.iter_mut().zip(block.iter().skip(within as usize)).take(count).enumerate() {
            *to = if place < written { *from } else { 0 };
        }
        Ok(count)
    }

    /// Returns the blocks of the file's cluster at this offset, from there on, and their number. `None` at
    /// the end of the file.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn stretch<B: Blocks>(
        &mut self,
        volume: &Volume,
        device: &mut B,
        offset_bytes: u32,
    ) -> Result<Option<(u32, u32)>, Error<B::Error>> {
        let Some(left) = self.size.checked_sub(offset_bytes).filter(|left| *left > 0) else { return Ok(None) };
        let Some(cluster) = self.cluster(volume, device, offset_bytes / volume.cluster_bytes())? else {
            return Ok(None);
        };
        let passed = offset_bytes % volume.cluster_bytes() / BLOCK_BYTES as u32;
        let left = (left + offset_bytes % BLOCK_BYTES as u32).div_ceil(BLOCK_BYTES as u32);
        Ok(Some((volume.block_of(cluster) + passed, (volume.blocks_per_cluster() - passed).min(left))))
    }

    /// Returns the cluster of this index; `None` behind the last of the root directory.
    fn cluster<B: Blocks>(
        &mut self,
        volume: &Volume,
        device: &mut B,
        wanted: u32,
    ) -> Result<Option<u32>, Error<B::Error>> {
        if wanted >= volume.clusters() || !volume.has_cluster(self.first) {
            return Err(Error::Damaged);
        }
        if self.is_contiguous {
            let cluster = self.first.saturating_add(wanted);
            return if volume.has_cluster(cluster) { Ok(Some(cluster)) } else { Err(Error::Damaged) };
        }
        if self.at.1 > wanted {
            self.at = (self.first, 0);
        }
        while self.at.1 < wanted {
            // The position is kept after a failure of the device, so the way need not be repeated.
            match volume.next(device, self.at.0)? {
                Some(next) => self.at = (next, self.at.1 + 1),
                None if self.ends_with_chain => return Ok(None),
                None => return Err(Error::Damaged),
            }
        }
        Ok(Some(self.at.0))
    }
}

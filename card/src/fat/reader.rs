//! Reading of a file's contents, by any number of readers at once.
//!
//! Nothing is kept of the volume but the way along the file's clusters, so any number of readers can be at
//! work. No reader notices a change of the file: the code that changes a file must drop its readers.

use super::disk::Disk;
use super::entry::Entry;
use super::table::Chain;
use super::{BLOCK_BYTES, Blocks, Error, Volume};

/// Open file with its position.
#[derive(Clone, Copy, Debug)]
pub struct Reader {
    first: u32,
    size: u32,
    /// Cluster read last, and its index in the file; `None` at the beginning.
    chain: Option<(Chain, u32)>,
}

impl Reader {
    /// Creates a reader of this file.
    #[must_use]
    pub fn new(file: &Entry) -> Self {
        Self { first: file.cluster(), size: file.size_bytes(), chain: None }
    }

    /// Bytes of the file.
    #[must_use]
    pub const fn size_bytes(&self) -> u32 {
        self.size
    }

    /// Reads from this offset to the end of its block, as much as fits; 0 at the end of the file. Reading on
    /// from the last place costs one block, or two where a new cluster begins; going back costs the way from
    /// the file's beginning.
    ///
    /// # Errors
    /// [`Error::Damaged`] when its chain of clusters ends before, or the device's.
    pub fn read<B: Blocks>(
        &mut self,
        volume: &mut Volume,
        device: &mut B,
        offset_bytes: u32,
        buffer: &mut [u8],
    ) -> Result<usize, Error<B::Error>> {
        let Some(left) = self.size.checked_sub(offset_bytes).filter(|left| *left > 0) else { return Ok(0) };
        let disk = &mut Disk::new(volume, device);
        let wanted = offset_bytes / disk.volume.cluster_bytes();
        let chain = self.go_to(disk, wanted)?;
        let in_cluster = offset_bytes % disk.volume.cluster_bytes();
        let number = disk.volume.block_of(chain.at) + in_cluster / BLOCK_BYTES as u32;
        let rest = disk.load(number)?.get(in_cluster as usize % BLOCK_BYTES..).unwrap_or(&[]);
        let count = rest.len().min(buffer.len()).min(left as usize);
        if let (Some(to), Some(from)) = (buffer.get_mut(..count), rest.get(..count)) {
            to.copy_from_slice(from);
        }
        Ok(count)
    }

    /// Returns the blocks of the file's cluster at this offset, from there on, and their number. `None` at
    /// the end of the file. For reading ahead.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn stretch<B: Blocks>(
        &mut self,
        volume: &mut Volume,
        device: &mut B,
        offset_bytes: u32,
    ) -> Result<Option<(u32, u32)>, Error<B::Error>> {
        let Some(left) = self.size.checked_sub(offset_bytes).filter(|left| *left > 0) else { return Ok(None) };
        let disk = &mut Disk::new(volume, device);
        let chain = self.go_to(disk, offset_bytes / disk.volume.cluster_bytes())?;
        let passed = offset_bytes % disk.volume.cluster_bytes() / BLOCK_BYTES as u32;
        let left = (left + offset_bytes % BLOCK_BYTES as u32).div_ceil(BLOCK_BYTES as u32);
        let count = (disk.volume.blocks_per_cluster - passed).min(left);
        Ok(Some((disk.volume.block_of(chain.at) + passed, count)))
    }

    /// Goes to one of the file's clusters. The position is kept after a failure of the device.
    fn go_to<B: Blocks>(&mut self, disk: &mut Disk<'_, B>, wanted: u32) -> Result<Chain, Error<B::Error>> {
        let (mut chain, mut index) = match self.chain.filter(|(_, index)| *index <= wanted) {
            Some(chain) => chain,
            None => (Chain::new(disk.volume, self.first)?, 0),
        };
        while index < wanted {
            if !chain.advance(disk)? {
                return Err(Error::Damaged);
            }
            index += 1;
            self.chain = Some((chain, index));
        }
        self.chain = Some((chain, index));
        Ok(chain)
    }
}

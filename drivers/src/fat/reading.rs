//! Reading what a file contains, beside whoever else has it open.
//!
//! Nothing is kept of the volume but the way along the file's clusters, so any number of readers can be at
//! work. None of them sees that the file is changed: whoever changes files has to forget its readers.

use super::disk::Disk;
use super::record::Entry;
use super::table::Chain;
use super::{BLOCK_BYTES, Blocks, Error, Volume};

/// A file that is read.
#[derive(Clone, Copy, Debug)]
pub struct Reader {
    first: u32,
    size: u32,
    /// The cluster that was read last, and which one of the file it is; none at the beginning.
    chain: Option<(Chain, u32)>,
}

impl Reader {
    /// Of this file.
    #[must_use]
    pub fn new(file: &Entry) -> Self {
        Self { first: file.cluster(), size: file.size_bytes(), chain: None }
    }

    /// Bytes of the file.
    #[must_use]
    pub const fn size_bytes(&self) -> u32 {
        self.size
    }

    /// Reads from this offset to the end of its block, as much as fits; 0 at the end of the file. Going on
    /// from where it was read last costs one block, or two where a new cluster begins; going back is as dear
    /// as the way from the file's beginning.
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
        let (mut chain, mut index) = match self.chain.filter(|(_, index)| *index <= wanted) {
            Some(chain) => chain,
            None => (Chain::new(disk.volume, self.first)?, 0),
        };
        while index < wanted {
            if !chain.advance(disk)? {
                return Err(Error::Damaged);
            }
            index += 1;
        }
        self.chain = Some((chain, index));
        let in_cluster = offset_bytes % disk.volume.cluster_bytes();
        let number = disk.volume.block_of(chain.at) + in_cluster / BLOCK_BYTES as u32;
        let rest = disk.load(number)?.get(in_cluster as usize % BLOCK_BYTES..).unwrap_or(&[]);
        let count = rest.len().min(buffer.len()).min(left as usize);
        for (to, from) in buffer.iter_mut().zip(rest.iter().take(count)) {
            *to = *from;
        }
        Ok(count)
    }
}

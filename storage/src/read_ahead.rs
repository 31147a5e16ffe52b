//! Reading ahead along the clusters of the file that is played, as far as the card has memory for it.

use base::ports::FileHandle;
use card::sd::{AHEAD_BLOCKS, Run};
use card::volume::FileReader;

use crate::device::Card;
use crate::sdmmc_device::SdmmcDevice;

/// Reading ahead of a file's reader.
pub(crate) struct Ahead {
    pub file: FileHandle,
    reader: FileReader,
    /// First byte that the card has not been asked to read ahead.
    next: u32,
}

/// Most clusters looked up in one go: then the reader goes on first.
const CLUSTERS: u32 = 16;

impl Ahead {
    /// Reads ahead from this offset on.
    pub fn new(file: FileHandle, reader: FileReader, offset: u32) -> Self {
        Self { file, reader, next: offset / 512 * 512 }
    }

    /// Whether it leads on from here, where the reader is.
    pub fn leads_from(&self, offset: u32) -> bool {
        offset <= self.next && self.next - offset <= 2 * FAR
    }

    /// Looks where the file goes on, and has that read, as far as it takes no waiting.
    pub fn go_on<C: Card>(&mut self, offset: u32, sdmmc: &mut SdmmcDevice<C>) {
        for _ in 0..CLUSTERS {
            if self.next.saturating_sub(offset) > FAR {
                return;
            }
            // The reader itself will find an error and report it.
            let Some((first, count)) =
                sdmmc.at_hand(|volume, device| self.reader.stretch(volume, device, self.next).ok().flatten())
            else {
                return;
            };
            if !sdmmc.card().follow(Run { first, count }) {
                return;
            }
            self.next = self.next.saturating_add(count * 512);
        }
    }
}

/// Greatest distance ahead of the reader, in bytes, up to which more is looked for: more than there is memory
/// for.
const FAR: u32 = 2 * AHEAD_BLOCKS as u32 * 512;

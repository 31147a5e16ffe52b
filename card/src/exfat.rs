//! Reading of exFAT volumes: directories, names and contents of files. Nothing is written, ever.
//!
//! Everything works on blocks of 512 bytes through [`Blocks`], allocates nothing, and believes nothing: a
//! damaged volume gives [`Error::Damaged`], never a hang or a panic.
//!
//! Source: Microsoft, exFAT file system specification, revision 1.00 (2019). Left out, as nothing needs it:
//! the allocation bitmap, the volume's label and GUID, vendor extensions. Letters are folded as on FAT
//! volumes ([`crate::fat::same_name`]) rather than by the volume's own up-case table: for names in the
//! letters of one alphabet both find the same.
//!
//! | behaviour | where it is written |
//! |---|---|
//! | the main boot region counts if its checksum is right, else the backup | 3.1, 3.4 |
//! | a file may lie in consecutive clusters, for which the FAT says nothing | 6.3.4.2, NoFatChain |
//! | bytes behind the valid data are zeros | 7.6.5, ValidDataLength |
//! | an entry set whose checksum is wrong is no file | 6.3.3, SetChecksum |

mod directory;
mod reader;
mod volume;

#[cfg(test)]
mod tests;

pub use directory::{Entry, Listing};
pub use reader::Reader;
pub use volume::Volume;

use crate::fat::{Block, Blocks, Error, word};

/// Bytes of a directory's entry.
const ENTRY_BYTES: usize = 32;

/// Returns a number of eight bytes, or `u32::MAX` if it does not fit into four.
fn small(bytes: &[u8], at: usize) -> u32 {
    if word(bytes, at + 4) == 0 { word(bytes, at) } else { u32::MAX }
}

fn read<B: Blocks>(device: &mut B, number: u32, block: &mut Block) -> Result<(), Error<B::Error>> {
    device.read(number, block).map_err(Error::Device)
}

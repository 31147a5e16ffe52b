//! Access to a volume through a buffer of one block.

use super::slot::{Place, SLOT_BYTES, Slot};
use super::{BLOCK_BYTES, Block, Blocks, Error, Volume};

/// A volume on its device, with the block that was used last. A change of the block goes to the card with
/// [`store`](Self::store) or not at all.
pub(super) struct Disk<'a, B> {
    device: &'a mut B,
    pub volume: &'a mut Volume,
    number: Option<u32>,
    /// Valid after [`load`](Self::load) or [`blank`](Self::blank).
    pub block: Block,
}

impl<'a, B: Blocks> Disk<'a, B> {
    /// Creates a view of a volume with an empty buffer.
    pub fn new(volume: &'a mut Volume, device: &'a mut B) -> Self {
        Self { device, volume, number: None, block: [0; BLOCK_BYTES] }
    }

    /// Loads this block as it is on the card.
    pub fn load(&mut self, number: u32) -> Result<&mut Block, Error<B::Error>> {
        if self.number != Some(number) {
            self.number = None;
            self.device.read(number, &mut self.block).map_err(Error::Device)?;
            self.number = Some(number);
        }
        Ok(&mut self.block)
    }

    /// Replaces this block by zeros, whatever is on the card.
    pub fn blank(&mut self, number: u32) -> &mut Block {
        self.number = Some(number);
        self.block = [0; BLOCK_BYTES];
        &mut self.block
    }

    /// Writes the block at hand.
    pub fn store(&mut self) -> Result<(), Error<B::Error>> {
        self.store_at(0)
    }

    /// Writes the block at hand, which is one of the allocation table, to every copy of the table. The first
    /// copy first.
    pub fn store_in_tables(&mut self) -> Result<(), Error<B::Error>> {
        self.store_at(0)?;
        if self.volume.mirrored { self.store_at(self.volume.table_blocks) } else { Ok(()) }
    }

    fn store_at(&mut self, blocks_further: u32) -> Result<(), Error<B::Error>> {
        let Some(number) = self.number else { return Ok(()) };
        let written = self.device.write(number + blocks_further, &self.block);
        if written.is_err() {
            // After a failed write, the block's content on the card is unknown.
            self.number = None;
        }
        written.map_err(Error::Device)
    }

    /// The slot at this place.
    pub fn slot(&mut self, place: Place) -> Result<Slot, Error<B::Error>> {
        let (slots, _) = self.load(place.block)?.as_chunks::<SLOT_BYTES>();
        slots.get(usize::from(place.slot)).copied().ok_or(Error::Damaged)
    }

    /// Changes the slot at this place, not yet on the card.
    pub fn change(&mut self, place: Place, change: impl FnOnce(&mut Slot)) -> Result<(), Error<B::Error>> {
        let (slots, _) = self.load(place.block)?.as_chunks_mut::<SLOT_BYTES>();
        slots.get_mut(usize::from(place.slot)).map(change).ok_or(Error::Damaged)
    }
}

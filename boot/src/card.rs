//! Files in the root of the card, read-only.

use core::cell::RefCell;

use bsp_prime::sd::SdCard;
use drivers::sd::SdError;
use embedded_sdmmc::{
    Block, BlockCount, BlockDevice, BlockIdx, Mode, RawDirectory, RawFile, RawVolume, TimeSource, Timestamp, VolumeIdx,
    VolumeManager,
};
use update::{Bytes, Card, Flaw};

/// The card, looked at when somebody asks for a file: an ordinary start does not.
pub struct CardFiles {
    volumes: VolumeManager<Slot, NoTime, 1, 1, 1>,
    root: Option<(RawVolume, RawDirectory)>,
}

/// An open file.
pub struct OpenFile<'c> {
    card: &'c CardFiles,
    file: RawFile,
    length: u32,
}

impl CardFiles {
    /// Nothing is known of the card yet.
    pub fn new(sd: SdCard) -> Self {
        Self { volumes: VolumeManager::new_with_limits(Slot(RefCell::new(sd)), NoTime, 0), root: None }
    }

    /// Another card may be in the slot.
    pub fn forget(&mut self) {
        if let Some((volume, root)) = self.root.take() {
            // Nothing was written, so nothing can be lost by closing.
            let _ = self.volumes.close_dir(root);
            let _ = self.volumes.close_volume(volume);
        }
    }

    fn mount(&mut self) -> Option<RawDirectory> {
        if let Some((_, root)) = self.root {
            return Some(root);
        }
        self.volumes.device(|slot| slot.0.borrow_mut().identify()).ok()?;
        let volume = self.volumes.open_raw_volume(VolumeIdx(0)).ok()?;
        match self.volumes.open_root_dir(volume) {
            Ok(root) => {
                self.root = Some((volume, root));
                Some(root)
            }
            Err(_) => {
                let _ = self.volumes.close_volume(volume);
                None
            }
        }
    }
}

impl Card for CardFiles {
    type File<'c> = OpenFile<'c>;

    fn open(&mut self, name: &str) -> Option<OpenFile<'_>> {
        let root = self.mount()?;
        let file = self.volumes.open_long_name_file_in_dir(root, name, Mode::ReadOnly).ok()?;
        let length = self.volumes.file_length(file).unwrap_or(0);
        Some(OpenFile { card: self, file, length })
    }
}

impl Bytes for OpenFile<'_> {
    fn length(&self) -> u32 {
        self.length
    }

    fn read(&mut self, at: u32, into: &mut [u8]) -> Result<(), Flaw> {
        let volumes = &self.card.volumes;
        volumes.file_seek_from_start(self.file, at).map_err(|_| Flaw::Unreadable)?;
        let mut rest = into;
        while !rest.is_empty() {
            match volumes.read(self.file, rest) {
                Ok(0) | Err(_) => return Err(Flaw::Unreadable),
                Ok(count) => rest = rest.get_mut(count..).unwrap_or_default(),
            }
        }
        Ok(())
    }
}

impl Drop for OpenFile<'_> {
    fn drop(&mut self) {
        // It was only read.
        let _ = self.card.volumes.close_file(self.file);
    }
}

/// The card in its slot, which nothing is written to. The cell is for the file system's shared reference.
struct Slot(RefCell<SdCard>);

impl BlockDevice for Slot {
    type Error = SdError;

    fn read(&self, blocks: &mut [Block], start: BlockIdx) -> Result<(), SdError> {
        let mut card = self.0.try_borrow_mut().map_err(|_| SdError::Lent)?;
        (start.0..).zip(blocks).try_for_each(|(number, block)| card.read(number, &mut block.contents))
    }

    fn write(&self, _: &[Block], _: BlockIdx) -> Result<(), SdError> {
        Err(SdError::Protected)
    }

    fn num_blocks(&self) -> Result<BlockCount, SdError> {
        let card = self.0.try_borrow().map_err(|_| SdError::Lent)?;
        card.blocks().map(BlockCount).ok_or(SdError::NoCard)
    }
}

/// Nothing is written, so nothing is dated.
struct NoTime;

impl TimeSource for NoTime {
    fn get_timestamp(&self) -> Timestamp {
        Timestamp { year_since_1970: 10, zero_indexed_month: 0, zero_indexed_day: 0, hours: 0, minutes: 0, seconds: 0 }
    }
}

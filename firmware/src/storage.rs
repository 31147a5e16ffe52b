//! The SD card as the machine's storage.

use bsp_prime::rtc;
use bsp_prime::sd::{SdCard, SdError};
use embedded_sdmmc::{Block, BlockCount, BlockDevice, BlockIdx, TimeSource, Timestamp};
use machine::ports::{DateTime, FileTime, StorageError};
use storage::Card;

/// The card with its file system.
pub type CardStorage = storage::CardStorage<Slot, Dated>;

/// Not mounted.
pub fn card_storage(card: SdCard) -> CardStorage {
    CardStorage::new(Slot(card), Dated)
}

/// The card in its slot.
pub struct Slot(SdCard);

impl BlockDevice for Slot {
    type Error = SdError;

    fn read(&self, blocks: &mut [Block], start: BlockIdx) -> Result<(), SdError> {
        self.0.read(blocks, start)
    }

    fn write(&self, blocks: &[Block], start: BlockIdx) -> Result<(), SdError> {
        self.0.write(blocks, start)
    }

    fn num_blocks(&self) -> Result<BlockCount, SdError> {
        self.0.num_blocks()
    }
}

impl Card for Slot {
    fn identify(&mut self) -> Result<(), SdError> {
        self.0.identify().map(drop)
    }

    fn reason(error: &SdError) -> StorageError {
        match error {
            SdError::NoCard | SdError::NotIdentified => StorageError::NoCard,
            SdError::NotResponding(_) => StorageError::NotResponding,
            _ => StorageError::Device,
        }
    }
}

/// Files are dated by the clock, once somebody has set it.
#[derive(Clone, Copy)]
pub struct Dated;

/// What the clock says.
pub fn date() -> DateTime {
    let rtc::Reading { year, month, day, hour, minute, second } = rtc::now();
    DateTime { year, month, day, hour, minute, second }
}

impl TimeSource for Dated {
    fn get_timestamp(&self) -> Timestamp {
        let FileTime { year, month, day, hour, minute } = date().for_files();
        Timestamp {
            // Not before 1980, and months and days are counted from one.
            year_since_1970: (year - 1970) as u8,
            zero_indexed_month: month.saturating_sub(1),
            zero_indexed_day: day.saturating_sub(1),
            hours: hour,
            minutes: minute,
            seconds: 0,
        }
    }
}

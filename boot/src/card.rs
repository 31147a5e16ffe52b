//! Files in the root of the card. Nothing is written. The controller's image has this file as well.

use bsp_prime::sd::SdCard;
use card::volume::{self, FileReader, Volume};
use update::{Bytes, Card, Flaw};

/// Access to the card, which is mounted on demand: an ordinary start does not read it.
pub struct CardFiles {
    card: SdCard,
    volume: Option<Volume>,
}

/// File open for reading on the card.
pub struct OpenFile<'c> {
    card: &'c mut SdCard,
    volume: &'c mut Volume,
    reader: FileReader,
}

impl CardFiles {
    /// Creates the access without mounting the card.
    pub fn new(card: SdCard) -> Self {
        Self { card, volume: None }
    }

    /// Forgets the volume, as another card may be in the slot.
    pub fn forget(&mut self) {
        self.volume = None;
    }

    fn mount(&mut self) -> Option<Volume> {
        let blocks = self.card.identify().ok()?.blocks;
        volume::find(&mut self.card, blocks).ok()
    }
}

impl Card for CardFiles {
    type File<'c> = OpenFile<'c>;

    fn open(&mut self, name: &str) -> Option<OpenFile<'_>> {
        if self.volume.is_none() {
            self.volume = self.mount();
        }
        let Self { card, volume } = self;
        let volume = volume.as_mut()?;
        let (reader, _) = volume::find_file(volume, card, name).ok()?;
        Some(OpenFile { card, volume, reader })
    }
}

impl Bytes for OpenFile<'_> {
    fn length(&self) -> u32 {
        self.reader.size_bytes()
    }

    fn read(&mut self, at: u32, into: &mut [u8]) -> Result<(), Flaw> {
        let (mut at, mut rest) = (at, into);
        while !rest.is_empty() {
            match self.reader.read(self.volume, self.card, at, rest) {
                Ok(0) | Err(_) => return Err(Flaw::Unreadable),
                Ok(count) => {
                    at += count as u32;
                    rest = rest.get_mut(count..).unwrap_or_default();
                }
            }
        }
        Ok(())
    }
}

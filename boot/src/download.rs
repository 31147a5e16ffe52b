//! Firmware download over USB into the flash.

use update::{Bytes, Flaw, Image, Manifest, NotInstalled, PRIME, Policy, Receiving, check_flash};
use usb::{Firmware, Refused, TRANSFER_BYTES};

use crate::card::CardFiles;
use crate::patience::Patience;

/// Time after which a host asks again while a sector is erased: about the length of an erase (DS12923, "flash
/// memory programming", parallelism x64). A longer erase keeps the host's next question waiting, which has
/// five seconds.
const ERASE_MS: u32 = 1_000;
/// Time to look for a copy of the present image on the card before the first sector is erased, if the copy is
/// good and the first that is found.
const LOOK_MS: u32 = 1_500;
/// Time to write the words of a block, 0.1 ms each.
const WRITE_MS: u32 = 1;
/// Time to compute the digest of the longest image.
const CHECK_MS: u32 = 300;

/// The flash as a host sees it: an image, to be replaced or read.
pub struct Incoming<'f> {
    flash: &'f mut Patience,
    card: &'f mut CardFiles,
    file: Option<Receiving<'static>>,
    /// Manifest of the present image, once it was looked at.
    there: Option<Manifest>,
    lacks_copy: bool,
}

impl<'f> Incoming<'f> {
    /// Creates a download without data so far.
    pub fn new(flash: &'f mut Patience, card: &'f mut CardFiles) -> Self {
        Self { flash, card, file: None, there: None, lacks_copy: false }
    }

    /// Returns the flash, for the code that feeds its watchdog meanwhile.
    pub fn flash(&mut self) -> &mut Patience {
        self.flash
    }

    /// Returns the flash and the card, between two downloads.
    pub fn flash_and_card(&mut self) -> (&mut Patience, &mut CardFiles) {
        (self.flash, self.card)
    }

    /// Returns whether a download was refused since the last call, for want of a copy of the present image.
    pub fn take_lacks_copy(&mut self) -> bool {
        core::mem::take(&mut self.lacks_copy)
    }
}

impl Firmware for Incoming<'_> {
    fn write(&mut self, at: u32, piece: &[u8]) -> Result<(), Refused> {
        if at == 0 {
            self.there = None;
            self.card.forget();
            self.file = Some(Receiving::new(&PRIME));
        }
        let file = self.file.as_mut().ok_or(Refused::Unknown)?;
        let taken = file.take(self.flash, self.card, piece);
        self.lacks_copy |= taken == Err(NotInstalled::NoCopy);
        taken.map_err(refused)
    }

    fn write_ms(&self, at: u32, bytes: usize) -> u32 {
        let sector = |at: u32| at / PRIME.sector_bytes;
        // Checked at the first piece of an image, which in a file for the whole flash is the first behind the
        // boot stage.
        if at == 0 || at == PRIME.image() {
            LOOK_MS + ERASE_MS
        } else if sector(at) != sector(at + bytes as u32) {
            ERASE_MS
        } else {
            WRITE_MS
        }
    }

    fn finish(&mut self) -> Result<(), Refused> {
        let file = self.file.take().ok_or(Refused::NotDone)?;
        file.finish(self.flash).map(|_| ()).map_err(refused)
    }

    fn finish_ms(&self) -> u32 {
        CHECK_MS
    }

    fn read(&mut self, at: u32, into: &mut [u8]) -> Result<usize, Refused> {
        if at == 0 {
            self.there = check_flash(self.flash, &PRIME, &Policy::default()).ok();
        }
        let length = self.there.as_ref().ok_or(Refused::Firmware)?.length;
        let count = length.saturating_sub(at).min(into.len() as u32).min(u32::from(TRANSFER_BYTES)) as usize;
        let into = into.get_mut(..count).unwrap_or_default();
        Image::new(self.flash, &PRIME).read(at, into).map_err(|_| Refused::Firmware)?;
        Ok(count)
    }
}

/// Converts a flaw to an error of the DFU protocol.
const fn refused(why: NotInstalled) -> Refused {
    match why {
        NotInstalled::Flash => Refused::Write,
        NotInstalled::NoCopy => Refused::NoCopy,
        NotInstalled::Flawed(Flaw::OtherBoard | Flaw::OtherAddress(_)) => Refused::Target,
        NotInstalled::Flawed(Flaw::Length(_)) => Refused::Address,
        NotInstalled::Flawed(Flaw::Truncated { .. }) => Refused::NotDone,
        NotInstalled::Flawed(Flaw::Unreadable) => Refused::Verify,
        NotInstalled::Flawed(_) => Refused::File,
    }
}

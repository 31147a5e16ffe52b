//! Firmware over USB, on its way into flash.

use update::{Bytes, Flaw, Image, Manifest, NotInstalled, PRIME, Policy, Receiving, check_flash};
use usb::{Firmware, Refused, TRANSFER_BYTES};

use crate::patience::Patience;

/// A host asks again after this while a sector is erased: about as long as it takes (DS12923, "flash memory
/// programming", parallelism x64). What takes longer keeps the host's next question waiting, which has five
/// seconds.
const ERASE_MS: u32 = 1_000;
/// The words of a block, 0.1 ms each.
const WRITE_MS: u32 = 1;
/// The digest of the longest image.
const CHECK_MS: u32 = 300;

/// The flash as a host sees it: an image, to be replaced or read.
pub struct Incoming<'f> {
    flash: &'f mut Patience,
    file: Option<Receiving<'static>>,
    /// What can be read, when that has been looked at.
    there: Option<Manifest>,
}

impl<'f> Incoming<'f> {
    /// Nothing has come.
    pub fn new(flash: &'f mut Patience) -> Self {
        Self { flash, file: None, there: None }
    }

    /// The flash, for whoever looks after it meanwhile.
    pub fn flash(&mut self) -> &mut Patience {
        self.flash
    }
}

impl Firmware for Incoming<'_> {
    fn write(&mut self, at: u32, piece: &[u8]) -> Result<(), Refused> {
        if at == 0 {
            self.there = None;
            self.file = Some(Receiving::new(&PRIME));
        }
        let file = self.file.as_mut().ok_or(Refused::Unknown)?;
        file.take(self.flash, piece).map_err(refused)
    }

    fn write_ms(&self, at: u32, bytes: usize) -> u32 {
        let sector = |at: u32| at / PRIME.sector_bytes;
        // The first piece of an image erases; of a file for the whole flash, the first behind the boot stage.
        let erases = at == 0 || at == PRIME.image() || sector(at) != sector(at + bytes as u32);
        if erases { ERASE_MS } else { WRITE_MS }
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

/// A flaw in the words of DFU.
const fn refused(why: NotInstalled) -> Refused {
    match why {
        NotInstalled::Flash => Refused::Write,
        NotInstalled::Flawed(Flaw::OtherBoard | Flaw::OtherAddress(_)) => Refused::Target,
        NotInstalled::Flawed(Flaw::Length(_)) => Refused::Address,
        NotInstalled::Flawed(Flaw::Truncated { .. }) => Refused::NotDone,
        NotInstalled::Flawed(Flaw::Unreadable) => Refused::Verify,
        NotInstalled::Flawed(_) => Refused::File,
    }
}

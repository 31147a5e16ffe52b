//! Putting an image into flash. The image's first word, which holds the manifest's mark, is written last:
//! until then nothing takes what is in flash for an image, whenever the power fails.

use crate::flash::{Failed, Flash, Layout, WORD, Word};
use crate::manifest::{Flaw, Manifest};
use crate::policy::Policy;
use crate::verify::{Bytes, check_flash, locate};

/// Reason for which an image could not be put into flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotInstalled {
    /// The file could not be read, or what came by USB may not run here.
    Flawed(Flaw),
    /// The new image would take the place of one that may run, and the card has none to come back to.
    NoCopy,
    /// The flash did not take it.
    Flash,
}

impl From<Failed> for NotInstalled {
    fn from(_: Failed) -> Self {
        Self::Flash
    }
}

impl From<Flaw> for NotInstalled {
    fn from(flaw: Flaw) -> Self {
        Self::Flawed(flaw)
    }
}

/// Copies an image that [`crate::check_file`] has found good from a file to flash.
///
/// # Errors
/// The file or the flash fails, or what is in flash afterwards is no image that may run.
pub fn install<F: Flash>(
    flash: &mut F,
    layout: &Layout,
    policy: &Policy,
    file: &mut impl Bytes,
    manifest: &Manifest,
) -> Result<(), NotInstalled> {
    let (begin, _) = locate(file, layout)?;
    let mut download = Download::new();
    let mut chunk = [0; 512];
    let mut at = 0;
    while at < manifest.length {
        let chunk = chunk.get_mut(..(manifest.length - at).min(512) as usize).unwrap_or_default();
        file.read(begin + at, chunk)?;
        download.take(flash, layout, chunk)?;
        at += chunk.len() as u32;
    }
    download.finish(flash, layout, policy).map(|_| ())
}

/// An image that comes piece after piece.
pub struct Download {
    /// Bytes that have come.
    length: u32,
    first: Word,
    /// The word that is not complete yet.
    word: Word,
}

impl Default for Download {
    fn default() -> Self {
        Self::new()
    }
}

impl Download {
    /// Begins a download of which nothing has come yet.
    #[must_use]
    pub fn new() -> Self {
        Self { length: 0, first: [0xff; WORD], word: [0xff; WORD] }
    }

    /// Takes the next piece; each sector is erased when the first byte for it comes.
    ///
    /// # Errors
    /// More than there is room for, or the flash fails.
    pub fn take<F: Flash>(&mut self, flash: &mut F, layout: &Layout, piece: &[u8]) -> Result<(), NotInstalled> {
        for byte in piece {
            if self.length >= layout.image_bytes() {
                return Err(Flaw::Length(self.length + 1).into());
            }
            if self.length.is_multiple_of(layout.sector_bytes) {
                flash.erase(crate::flash::Sector(layout.first.0 + self.length / layout.sector_bytes))?;
            }
            let within = self.length as usize % WORD;
            if let Some(place) = self.word.get_mut(within) {
                *place = *byte;
            }
            self.length += 1;
            if within == WORD - 1 {
                self.write_word(flash, layout)?;
            }
        }
        Ok(())
    }

    /// Writes what is left and the first word, and looks at what is in flash now. An image that may not run
    /// is made none again.
    ///
    /// # Errors
    /// The image may not run, or the flash fails.
    pub fn finish<F: Flash>(
        mut self,
        flash: &mut F,
        layout: &Layout,
        policy: &Policy,
    ) -> Result<Manifest, NotInstalled> {
        if !self.length.is_multiple_of(WORD as u32) {
            self.length = self.length.next_multiple_of(WORD as u32);
            self.write_word(flash, layout)?;
        }
        flash.program(layout.image(), &self.first)?;
        match check_flash(flash, layout, policy) {
            Ok(manifest) => Ok(manifest),
            Err(flaw) => {
                flash.erase(layout.first)?;
                Err(flaw.into())
            }
        }
    }

    /// The word that ends with the last byte that has come.
    fn write_word<F: Flash>(&mut self, flash: &mut F, layout: &Layout) -> Result<(), Failed> {
        let word = core::mem::replace(&mut self.word, [0xff; WORD]);
        match self.length - WORD as u32 {
            0 => {
                self.first = word;
                Ok(())
            }
            at => flash.program(layout.image() + at, &word),
        }
    }
}

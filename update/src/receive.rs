//! Receiving an image as a file in pieces, which go to flash as they come: a download over USB.
//!
//! The new image takes the place of the one in flash, as there is room for one. So an image that may run is
//! given up only where the card has one to come back to, should the new one not come whole.

use crate::boot::{Card, TRIALS, may_recover};
use crate::flash::{Flash, Layout};
use crate::install::{Download, NotInstalled};
use crate::log::{Entry, Known, Log, Origin};
use crate::manifest::{Flaw, MANIFEST_BYTES, Manifest};
use crate::verify::{FileCheck, check_flash};

/// A file on its way. Files are as for [`crate::check_file`].
pub struct Receiving<'l> {
    layout: &'l Layout,
    check: FileCheck<'l>,
    /// Bytes that have come.
    length: u32,
    /// Download of the image into flash; none before its manifest has come and been found good.
    download: Option<Download>,
}

impl<'l> Receiving<'l> {
    /// Begins a file of which nothing has come.
    #[must_use]
    pub fn new(layout: &'l Layout) -> Self {
        Self { layout, check: FileCheck::new(layout), length: 0, download: None }
    }

    /// Takes the next piece. Flash is touched from the moment on when an image has begun that may run here,
    /// if it is whole, and when there is one to come back to.
    ///
    /// # Errors
    /// The image may not run, or the card has none to come back to, or the flash fails.
    pub fn take<F, C>(&mut self, flash: &mut F, card: &mut C, piece: &[u8]) -> Result<(), NotInstalled>
    where
        F: Flash,
        C: Card,
    {
        let from = self.length;
        self.check.take(piece);
        self.length += piece.len() as u32;
        let Some((at, manifest)) = self.check.manifest() else { return Ok(()) };
        let manifest = manifest?;
        let end = at + manifest.length;
        if let Some(download) = &mut self.download {
            // Bytes behind the image are for the check alone.
            let rest = piece.get(..end.saturating_sub(from).min(piece.len() as u32) as usize).unwrap_or_default();
            return download.take(flash, self.layout, rest);
        }
        self.begin(flash, card, &manifest)?;
        let mut download = Download::new();
        download.take(flash, self.layout, self.check.head())?;
        let head_end = at + MANIFEST_BYTES as u32;
        let behind = piece.get((head_end - from) as usize..).unwrap_or_default();
        let behind = behind.get(..(manifest.length as usize - MANIFEST_BYTES).min(behind.len())).unwrap_or_default();
        download.take(flash, self.layout, behind)?;
        self.download = Some(download);
        Ok(())
    }

    fn begin<F, C>(&self, flash: &mut F, card: &mut C, manifest: &Manifest) -> Result<(), NotInstalled>
    where
        F: Flash,
        C: Card,
    {
        let mut log = Log::read(flash, self.layout);
        // The signature covers the digest alone, so it is known by now whose image this is.
        log.state.policy.allows(manifest)?;
        // An image that has failed its trial is nothing to lose.
        let there = check_flash(flash, self.layout, &log.state.policy);
        let does_well =
            there.is_ok_and(|image| log.state.trial_of(Known::of(&image)).is_none_or(|starts| starts < TRIALS));
        if does_well && !may_recover(flash, card, self.layout) {
            return Err(NotInstalled::NoCopy);
        }
        log.tidy(flash)?;
        Ok(log.append(flash, Entry::Began(Origin::Usb, Known::of(manifest)))?)
    }

    /// Ends the file: the image is put to use, on trial.
    ///
    /// # Errors
    /// The image is not whole, or not as its manifest says, or the flash fails. The flash may hold no image
    /// then.
    pub fn finish<F: Flash>(self, flash: &mut F) -> Result<Manifest, NotInstalled> {
        let mut log = Log::read(flash, self.layout);
        let policy = log.state.policy;
        let manifest = self.check.finish(&policy)?;
        let download = self.download.ok_or(Flaw::NoManifest)?;
        download.finish(flash, self.layout, &policy)?;
        log.append(flash, Entry::Installed(Origin::Usb, Known::of(&manifest)))?;
        Ok(manifest)
    }
}

//! Boot stage: at each start finishes an install that was asked for or begun, goes back from an image that
//! does not confirm itself, and starts the image if it may run.
//!
//! The boot stage only reads the card. Before the application asks for an image, the application has copied
//! itself to `firmware.previous`.

use crate::flash::{Failed, Flash, Layout};
use crate::install::{NotInstalled, install};
use crate::log::{Ended, Entry, Known, Log, Origin, Pending, Refusal};
use crate::manifest::{Flaw, Manifest};
use crate::verify::{Bytes, check_file, check_flash};

/// Starts of an image on trial before the previous one is put back.
pub const TRIALS: u8 = 3;

/// The image that was asked for.
pub const REQUESTED_FILE: &str = "flashme.bin";

/// The image that ran before, and the name it has until it is complete.
pub const PREVIOUS_FILES: [&str; 2] = ["firmware.previous", "firmware.tmp"];

/// The files that are looked for when no image in flash may run, in this order.
pub const RECOVERY_FILES: [(&str, Origin); 4] = [
    ("flashme.bin", Origin::File),
    ("velvet.bin", Origin::File),
    ("firmware.previous", Origin::Previous),
    ("firmware.tmp", Origin::Previous),
];

/// Files in the root of the card.
pub trait Card {
    /// An open file of the card.
    type File<'c>: Bytes
    where
        Self: 'c;

    /// Opens a file; `None` where there is no such file, no card, or one that cannot be read.
    fn open(&mut self, name: &str) -> Option<Self::File<'_>>;
}

/// Next step of the boot stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Start the image with this manifest.
    Start(Manifest),
    /// Nothing may run: wait for an image by USB or on a card.
    Recover(Flaw),
}

/// Brings flash in order and returns the next step. `ended`: the end of the last run.
pub fn settle<F: Flash, C: Card>(flash: &mut F, card: &mut C, layout: &Layout, ended: Ended) -> Next {
    let mut log = Log::read(flash, layout);
    // The policy comes before anything is installed: an install may erase the only copy.
    let _ = log.restore_policy(flash);
    let mut boot = Boot { flash, card, layout };
    // An install that fails in flash is tried again at the next start; meanwhile any image that may run is
    // started.
    if let Some(pending) = log.state.pending {
        let _ = boot.finish(&mut log, pending);
    }
    let mut found = boot.check(&log);
    if let Ok(manifest) = &found
        && log.state.trial_of(Known::of(manifest)).is_some_and(|starts| starts >= TRIALS)
        && boot.go_back(&mut log, ended, Known::of(manifest))
    {
        found = boot.check(&log);
    }
    match found.or_else(|flaw| boot.recover(&mut log, flaw)) {
        Ok(manifest) => {
            let _ = log.tidy(boot.flash);
            if log.state.trial_of(Known::of(&manifest)).is_some() {
                let _ = log.append(boot.flash, Entry::Tried);
            }
            Next::Start(manifest)
        }
        Err(flaw) => Next::Recover(flaw),
    }
}

/// Whether the card has an image that may run; nothing is written.
pub fn may_recover<F: Flash, C: Card>(flash: &mut F, card: &mut C, layout: &Layout) -> bool {
    let log = Log::read(flash, layout);
    let mut boot = Boot { flash, card, layout };
    RECOVERY_FILES.iter().any(|(name, _)| matches!(boot.look(&log, name), Some(Ok(_))))
}

struct Boot<'b, F, C> {
    flash: &'b mut F,
    card: &'b mut C,
    layout: &'b Layout,
}

impl<F: Flash, C: Card> Boot<'_, F, C> {
    /// The image in flash, if it may run.
    fn check(&mut self, log: &Log<'_>) -> Result<Manifest, Flaw> {
        check_flash(self.flash, self.layout, &log.state.policy)
    }

    /// Installs what was asked for, or what was begun. An install that was begun, and whose file is gone, is
    /// left to `recover`.
    fn finish(&mut self, log: &mut Log<'_>, pending: Pending) -> Result<(), Failed> {
        // The whole image was written, but for the word in the log that says so.
        if pending.has_begun && self.check(log).is_ok_and(|there| Known::of(&there) == pending.image) {
            return log.append(self.flash, Entry::Installed(pending.origin, pending.image));
        }
        let names: &[&str] = match pending.origin {
            Origin::File => &[REQUESTED_FILE],
            Origin::Previous => &PREVIOUS_FILES,
            Origin::Usb | Origin::Probe => &[],
        };
        let mut refusal = Refusal::NoFile;
        for name in names {
            let Some(manifest) = self.look(log, name) else { continue };
            match manifest {
                Ok(manifest) if Known::of(&manifest) == pending.image => {
                    match self.install(log, name, pending.origin, &manifest) {
                        Ok(()) => return Ok(()),
                        Err(NotInstalled::Flash) => return Err(Failed),
                        Err(NotInstalled::Flawed(_) | NotInstalled::NoCopy) => {}
                    }
                }
                _ => refusal = Refusal::Flawed,
            }
        }
        if log.state.pending.is_some_and(|pending| pending.has_begun) {
            return Ok(());
        }
        log.append(self.flash, Entry::Refused(refusal, pending.image))
    }

    /// Puts the previous image back, if it is there and another one; otherwise the one on trial goes on.
    /// Returns whether the image in flash may have changed.
    fn go_back(&mut self, log: &mut Log<'_>, ended: Ended, failed: Known) -> bool {
        for name in PREVIOUS_FILES {
            let Some(Ok(manifest)) = self.look(log, name) else { continue };
            if failed == Known::of(&manifest) {
                continue;
            }
            if log.append(self.flash, Entry::Failed(ended, failed)).is_err() {
                return false;
            }
            if self.install(log, name, Origin::Previous, &manifest).is_ok() {
                return true;
            }
        }
        // A file that could not be read to its end has cost the one on trial as well.
        true
    }

    /// The first image on the card that may run; one that has failed a trial comes last.
    fn recover(&mut self, log: &mut Log<'_>, flaw: Flaw) -> Result<Manifest, Flaw> {
        let failed = log.state.failed.map(|(_, image)| image);
        let passes = [false, true].into_iter().flat_map(|takes_failed| RECOVERY_FILES.map(|file| (takes_failed, file)));
        for (takes_failed, (name, origin)) in passes {
            let Some(Ok(manifest)) = self.look(log, name) else { continue };
            if !takes_failed && failed == Some(Known::of(&manifest)) {
                continue;
            }
            if self.install(log, name, origin, &manifest).is_ok() {
                return self.check(log);
            }
        }
        Err(flaw)
    }

    /// Reads the manifest of a file's image; `None` where there is no such file.
    fn look(&mut self, log: &Log<'_>, name: &str) -> Option<Result<Manifest, Flaw>> {
        self.flash.feed_watchdog();
        let mut file = self.card.open(name)?;
        Some(check_file(&mut file, self.layout, &log.state.policy))
    }

    fn install(
        &mut self,
        log: &mut Log<'_>,
        name: &str,
        origin: Origin,
        manifest: &Manifest,
    ) -> Result<(), NotInstalled> {
        self.flash.feed_watchdog();
        let mut file = self.card.open(name).ok_or(Flaw::Unreadable)?;
        let image = Known::of(manifest);
        log.append(self.flash, Entry::Began(origin, image))?;
        install(self.flash, self.layout, &log.state.policy, &mut file, manifest)?;
        log.append(self.flash, Entry::Installed(origin, image))?;
        Ok(())
    }
}

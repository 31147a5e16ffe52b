//! What the boot stage does at each start: finish what was asked for or begun, go back from an image that
//! does not confirm itself, and start the image if it may run.
//!
//! It only reads the card. Before the application asks for an image, it has copied itself to
//! `firmware.previous`.

use crate::flash::{Failed, Flash, Layout};
use crate::install::{NotInstalled, install};
use crate::log::{Entry, Known, Log, Origin, Pending, Refusal};
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
    /// A file, open.
    type File<'c>: Bytes
    where
        Self: 'c;

    /// Opens a file; `None` where there is no such file, no card, or one that cannot be read.
    fn open(&mut self, name: &str) -> Option<Self::File<'_>>;
}

/// What follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Start this image.
    Start(Manifest),
    /// Nothing may run: wait for an image by USB or on a card.
    Recover(Flaw),
}

/// Brings flash in order and says what to start.
pub fn settle<F: Flash, C: Card>(flash: &mut F, card: &mut C, layout: &Layout) -> Next {
    let mut log = Log::read(flash, layout);
    let mut boot = Boot { flash, card, layout };
    // What the flash does not take is tried again at the next start; what may run by then, runs.
    if let Some(pending) = log.state.pending {
        let _ = boot.finish(&mut log, pending);
    }
    if log.state.trial.is_some_and(|starts| starts >= TRIALS) {
        let _ = boot.go_back(&mut log);
    }
    let next = boot.check(&log).or_else(|flaw| boot.recover(&mut log, flaw));
    match next {
        Ok(manifest) => {
            if log.state.trial.is_some() {
                let _ = log.append(boot.flash, Entry::Tried);
            } else {
                let _ = log.tidy(boot.flash);
            }
            Next::Start(manifest)
        }
        Err(flaw) => Next::Recover(flaw),
    }
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

    /// Installs what was asked for, or what was begun. What was begun and is nowhere any more is left to
    /// `recover`.
    fn finish(&mut self, log: &mut Log<'_>, pending: Pending) -> Result<(), Failed> {
        let names: &[&str] = match pending.origin {
            Origin::File => &[REQUESTED_FILE],
            Origin::Previous => &PREVIOUS_FILES,
            Origin::Usb => &[],
        };
        let mut refusal = Refusal::NoFile;
        for name in names {
            let Some(manifest) = self.look(log, name) else { continue };
            match manifest {
                Ok(manifest) if Known::of(&manifest) == pending.image => {
                    match self.install(log, name, pending.origin, &manifest) {
                        Ok(()) => return Ok(()),
                        Err(NotInstalled::Flash) => return Err(Failed),
                        Err(NotInstalled::Flawed(_)) => {}
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

    /// Puts the previous image back, if it is there and another one; the one on trial goes on otherwise.
    fn go_back(&mut self, log: &mut Log<'_>) -> Result<(), Failed> {
        let failed = self.check(log).map(|manifest| Known::of(&manifest)).ok();
        for name in PREVIOUS_FILES {
            let Some(Ok(manifest)) = self.look(log, name) else { continue };
            if failed == Some(Known::of(&manifest)) {
                continue;
            }
            if let Some(failed) = failed {
                log.append(self.flash, Entry::Failed(failed))?;
            }
            if self.install(log, name, Origin::Previous, &manifest).is_ok() {
                return Ok(());
            }
        }
        Ok(())
    }

    /// The first image on the card that may run.
    fn recover(&mut self, log: &mut Log<'_>, flaw: Flaw) -> Result<Manifest, Flaw> {
        for (name, origin) in RECOVERY_FILES {
            let Some(Ok(manifest)) = self.look(log, name) else { continue };
            if self.install(log, name, origin, &manifest).is_ok() {
                return self.check(log);
            }
        }
        Err(flaw)
    }

    /// What a file's image is; `None` where there is no such file.
    fn look(&mut self, log: &Log<'_>, name: &str) -> Option<Result<Manifest, Flaw>> {
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
        let mut file = self.card.open(name).ok_or(Flaw::Unreadable)?;
        let image = Known::of(manifest);
        log.append(self.flash, Entry::Began(origin, image))?;
        install(self.flash, self.layout, &log.state.policy, &mut file, manifest)?;
        log.append(self.flash, Entry::Installed(origin, image))?;
        Ok(())
    }
}

//! Updates: the log that the boot stage reads, the image in flash, and a host's way into the download.

use core::fmt::Write;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};

use base::ports::{Arrival, FailedBy, Firmware, FirmwareId, Flaw, Running};
use bsp_prime::flash::BoardFlash;
use bsp_prime::{boot_request, time};
use units::Micros;
use update::{
    Bytes, Ended, Entry, FileCheck, Image, Known, Log, MANIFEST_BYTES, Manifest, Origin, PRIME, Policy, Refusal, TRIALS,
};

use crate::executor;

/// Time after the start in which a second press of RESET requests the download.
const SECOND_PRESS: Micros = Micros::from_seconds(1);

/// A host has asked for the firmware download.
static ASKED: AtomicBool = AtomicBool::new(false);
/// Whether the machine may be left now: nothing moves, heats or plays.
static MAY_LEAVE: AtomicBool = AtomicBool::new(false);

/// Asks for the firmware download, from any task: the executor does the same as for the command `dfu`, and
/// the board is reset into the boot stage. Returns false, and does nothing, while the machine works.
pub fn ask_for_download() -> bool {
    if !MAY_LEAVE.load(Ordering::Relaxed) {
        return false;
    }
    ASKED.store(true, Ordering::Relaxed);
    executor::wake();
    true
}

#[unsafe(link_section = ".d2ram")]
static mut PLACE: MaybeUninit<Updates> = MaybeUninit::uninit();

/// Data of updates, for the executor.
pub struct Updates {
    flash: BoardFlash,
    log: Log<'static>,
    /// Image that runs; `None` if its manifest cannot be read, with which no boot stage would have started
    /// it.
    image: Option<Known>,
    /// State of the update at the start of the image.
    running: Running,
    look: FileCheck<'static>,
    has_run: bool,
}

/// Creates the data in place, from the log. Call once, as the owner of the flash.
pub fn start(mut flash: BoardFlash) -> &'static mut Updates {
    let log = Log::read(&mut flash, &PRIME);
    let image = manifest(&mut flash).as_ref().map(Known::of);
    let arrival = image.map_or(Arrival::Probe, |image| arrival(log.state.arrival(image)));
    let refused = log.state.refused.map(|(why, _)| match why {
        Refusal::NoFile => "flashme.bin was not there any more",
        Refusal::Flawed => "flashme.bin was another file by then, or could not be read",
    });
    let look = FileCheck::new(&PRIME);
    let place = &raw mut PLACE;
    // SAFETY: there is one flash, so this comes here once, and this is the only reference there ever is; the
    // board is up, so the memory is there.
    unsafe {
        (*place).write(Updates { flash, log, image, running: Running { arrival, refused }, look, has_run: false })
    }
}

fn manifest(flash: &mut BoardFlash) -> Option<Manifest> {
    let mut bytes = [0; MANIFEST_BYTES];
    Image::new(flash, &PRIME).read(0, &mut bytes).ok()?;
    Manifest::parse(&bytes, &PRIME).ok()
}

const fn arrival(arrival: update::Arrival) -> Arrival {
    match arrival {
        update::Arrival::Known => Arrival::Known,
        update::Arrival::Probe => Arrival::Probe,
        update::Arrival::Trial(origin, start) => {
            Arrival::Trial { by_usb: matches!(origin, Origin::Usb), start, of: TRIALS }
        }
        update::Arrival::FellBack(ended) => Arrival::FellBack(match ended {
            Ended::Watchdog => FailedBy::Watchdog,
            Ended::Itself => FailedBy::Itself,
            Ended::Early => FailedBy::Early,
        }),
    }
}

/// Returns the message of a flaw.
fn words(flaw: update::Flaw) -> Flaw {
    let mut why = Flaw::new();
    // The message always fits its buffer.
    let _ = write!(why, "{flaw}");
    why
}

impl Updates {
    /// Returns the update state at the start of the image.
    pub const fn running(&self) -> Running {
        self.running
    }

    /// Confirms that the image works.
    pub fn confirm(&mut self) {
        if let Some(image) = self.image {
            // A failed write to the flash is tried again at the next start.
            if self.log.confirm(&mut self.flash, image).is_ok() {
                self.running.arrival = Arrival::Known;
            }
        }
    }

    /// Records the owner's policy, if it has changed.
    pub fn set_policy(&mut self, key: Option<[u8; 32]>, is_locked: bool) -> Result<(), Flaw> {
        if key.as_ref().is_some_and(|key| !Policy::is_key(key)) {
            return Err(text("this is no Ed25519 public key: write what velvet key says"));
        }
        let policy = Policy { key, is_locked };
        // The boot stage would not start the present image under that policy.
        if manifest(&mut self.flash).is_none_or(|manifest| policy.allows(&manifest).is_err()) {
            return Err(text("the firmware that runs is not signed with it: install one that is first"));
        }
        if self.log.set_policy(&mut self.flash, &policy).is_err() {
            return Err(text("the log of updates in flash does not take it"));
        }
        Ok(())
    }

    /// Returns the size of the image in bytes.
    pub fn image_bytes(&self) -> u32 {
        self.image.map_or(0, |image| image.length)
    }

    /// Reads bytes of the running image.
    pub fn read_image(&mut self, at: u32, into: &mut [u8]) -> bool {
        Image::new(&mut self.flash, &PRIME).read(at, into).is_ok()
    }

    /// Begins the check of a firmware file.
    pub fn begin_look(&mut self) {
        self.look = FileCheck::new(&PRIME);
    }

    /// Checks the next bytes of the file.
    pub fn look(&mut self, piece: &[u8]) {
        self.look.take(piece);
    }

    /// Ends the check and returns the firmware in the file.
    pub fn end_look(&mut self) -> Result<Firmware, Flaw> {
        let check = core::mem::replace(&mut self.look, FileCheck::new(&PRIME));
        let manifest = check.finish(&self.log.state.policy).map_err(words)?;
        let found = Known::of(&manifest);
        Ok(Firmware {
            id: FirmwareId { length: found.length, digest: found.digest },
            version: heapless::String::try_from(manifest.version()).unwrap_or_default(),
            runs: self.image == Some(found),
            has_failed: self.log.state.failed.is_some_and(|(_, failed)| failed == found),
            was_refused: self.log.state.refused.is_some_and(|(_, refused)| refused == found),
        })
    }

    /// Asks for the installation of this image.
    pub fn ask_for_install(&mut self, image: FirmwareId) -> bool {
        let image = Known { length: image.length, digest: image.digest };
        self.log.append(&mut self.flash, Entry::Requested(Origin::File, image)).is_ok()
    }

    /// Returns whether a host has asked for the download, and stores whether the next may. Called at each
    /// turn of the executor.
    pub fn take_download_request(&mut self, may: bool) -> bool {
        if !self.has_run && time::now() > SECOND_PRESS {
            self.has_run = true;
            boot_request::forget_button();
        }
        MAY_LEAVE.store(may, Ordering::Relaxed);
        ASKED.swap(false, Ordering::Relaxed)
    }
}

fn text(words: &str) -> Flaw {
    Flaw::try_from(words).unwrap_or_default()
}

//! Updates: this image's confirmation in the log that the boot stage reads, and the ways to other firmware.

use core::sync::atomic::{AtomicBool, Ordering};

use bsp_prime::flash::BoardFlash;
use bsp_prime::identity::Cause;
use bsp_prime::sd::SdCard;
use bsp_prime::{boot_request, time};
use units::Micros;
use update::{Bytes, Image, Known, Log, MANIFEST_BYTES, Manifest, PRIME};

use crate::{rescue, wake};

/// Time after the start in which a second press of RESET requests the download.
const SECOND_PRESS: Micros = Micros::from_seconds(1);
/// Time after which an image that is on trial has served well.
const TRIAL: Micros = Micros::from_seconds(10);

/// A computer has asked for the firmware download.
static ASKED: AtomicBool = AtomicBool::new(false);
/// Whether the board may be left now: no host speaks to it.
static MAY_LEAVE: AtomicBool = AtomicBool::new(false);

/// Asks for the firmware download, from any task. Returns false, and does nothing, while a host speaks to the
/// board.
pub fn ask_for_download() -> bool {
    if !MAY_LEAVE.load(Ordering::Relaxed) {
        return false;
    }
    ASKED.store(true, Ordering::Relaxed);
    wake::wake();
    true
}

/// Work for the boot stage that remains to be done.
pub struct Updates {
    flash: BoardFlash,
    /// Card and cause of the start, until the card has been looked at.
    card: Option<(SdCard, Cause)>,
    has_run: bool,
    has_served: bool,
}

impl Updates {
    /// Takes the flash, whose log nobody else writes.
    pub const fn new(flash: BoardFlash, card: SdCard, cause: Cause) -> Self {
        Self { flash, card: Some((card, cause)), has_run: false, has_served: false }
    }

    /// Looks once whether there is other firmware on the card. Returns true if a reset installs it.
    pub fn look_at_card(&mut self) -> bool {
        let (Some((card, cause)), Some(running)) = (self.card.take(), self.running()) else { return false };
        rescue::look(card, &mut self.flash, running, cause)
    }

    /// Whether this image is to be confirmed, as soon as no motor moves: while the flash is written, no
    /// interrupt can be fetched from it.
    pub fn wants_rest(&self) -> bool {
        !self.has_served && time::now() > TRIAL
    }

    /// Does what is due. Returns whether the firmware download was asked for, of which the boot stage knows
    /// then: a reset leads there.
    pub fn look(&mut self, may_leave: bool) -> bool {
        let now = time::now();
        if !self.has_run && now > SECOND_PRESS {
            self.has_run = true;
            boot_request::forget_button();
        }
        MAY_LEAVE.store(may_leave, Ordering::Relaxed);
        let asked = ASKED.swap(false, Ordering::Relaxed);
        if asked {
            boot_request::ask_for_download();
        }
        asked
    }

    /// Confirms that this image works, once: it has served for long enough, or a host has asked it for a
    /// reset. A failed write to the flash is tried again at the next start.
    pub fn confirm(&mut self) {
        if self.has_served {
            return;
        }
        self.has_served = true;
        let Some(running) = self.running() else { return };
        let mut log = Log::read(&mut self.flash, &PRIME);
        if log.confirm(&mut self.flash, running).is_err() {
            defmt::warn!("the log of updates does not take that this image works");
        }
    }

    /// The manifest of this image.
    fn running(&mut self) -> Option<Known> {
        let mut bytes = [0; MANIFEST_BYTES];
        Image::new(&mut self.flash, &PRIME).read(0, &mut bytes).ok()?;
        Manifest::parse(&bytes, &PRIME).ok().as_ref().map(Known::of)
    }
}

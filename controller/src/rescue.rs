//! Other firmware on the card: where this image starts and finds `flashme.bin`, it asks the boot stage for
//! it.
//!
//! No host is needed for that, so a person gets back to the firmware that knows a machine by a card alone.
//! After a reset that a host asked for, nothing is looked for: it would wait.

use core::sync::atomic::{AtomicBool, Ordering};

use bsp_prime::flash::BoardFlash;
use bsp_prime::identity::Cause;
use bsp_prime::sd::SdCard;
use bsp_prime::time;
use units::Micros;
use update::{Card, Entry, Known, Log, Origin, PRIME, REQUESTED_FILE, check_file};

#[path = "../../boot/src/card.rs"]
#[allow(dead_code, reason = "the boot stage looks at more than one card")]
mod card;

use card::CardFiles;

/// Longest look at a card: one that is silent takes a second and a half, and the largest image a second.
const LONGEST_LOOK: Micros = Micros::from_seconds(10);

/// Whether idle looks at the card, which takes longer than the watchdog waits.
static LOOKS: AtomicBool = AtomicBool::new(false);

/// Whether idle may be away now: it looks at the card, and not for too long.
pub fn is_looking() -> bool {
    LOOKS.load(Ordering::Relaxed) && time::now() < LONGEST_LOOK
}

/// Looks for an image on the card that is not this one, and asks the boot stage for it. Returns whether there
/// is one, so that a reset installs it.
pub fn look(card: SdCard, flash: &mut BoardFlash, running: Known, cause: Cause) -> bool {
    if !matches!(cause, Cause::PowerOn | Cause::BrownOut | Cause::Pin) {
        return false;
    }
    LOOKS.store(true, Ordering::Relaxed);
    let found = ask_for_other(card, flash, running);
    LOOKS.store(false, Ordering::Relaxed);
    found
}

fn ask_for_other(card: SdCard, flash: &mut BoardFlash, running: Known) -> bool {
    let mut log = Log::read(flash, &PRIME);
    let mut card = CardFiles::new(card);
    let Some(mut file) = card.open(REQUESTED_FILE) else { return false };
    let image = match check_file(&mut file, &PRIME, &log.state.policy) {
        Ok(manifest) => Known::of(&manifest),
        Err(flaw) => {
            defmt::warn!("{=str} on the card: {}", REQUESTED_FILE, defmt::Display2Format(&flaw));
            return false;
        }
    };
    // An image that has failed once, or was refused, is not tried at each start.
    let state = &log.state;
    let is_known = state.failed.is_some_and(|(_, failed)| failed == image)
        || state.refused.is_some_and(|(_, refused)| refused == image);
    image != running && !is_known && log.append(flash, Entry::Requested(Origin::File, image)).is_ok()
}
